// A made-up run, for working on the page without a server: a robot drives a circle, its arm swings, a ball bounces.
import type { Frame } from "../core/frame";
import type { FrameTail, Pose, Scene, SceneBody, SceneShape, Vec3 } from "../core/protocol";
import { tokens } from "./tokens";

export const kText = `<?xml version="1.0" encoding="UTF-8"?>
<!-- A robot with two driven wheels goes round a crate. -->
<scene name="demo" version="1">
  <physics backend="bullet" step="1 ms" duration="10 s"/>
  <material name="floor" friction="0.8" color="#d8d8d0"/>
  <material name="ply" friction="0.4" density="600 kg/m^3" color="#b58863"/>
  <light name="sun" type="directional" direction="-0.7 0.3 -1"/>
  <view name="corner" xyz="1.5 -1.5 1.2" look-at="0 0 0.1"/>

  <plane name="ground" material="floor"/>
  <box name="crate" size="16 16 16 cm" mass="500 g" xyz="0 0 0.08" material="ply"/>
  <sphere name="ball" radius="6 cm" mass="100 g" xyz="-0.5 0.5 0.5" color="#b03a2e"/>

  <assembly name="robot">
    <!-- x points forward -->
    <box name="deck" size="24 14 4 cm" mass="900 g" xyz="0 0 6 cm" material="ply"/>
    <cylinder name="left" radius="5 cm" length="2 cm" mass="150 g" xyz="0 9 5 cm" rpy="90 0 0 deg"/>
    <cylinder name="right" radius="5 cm" length="2 cm" mass="150 g" xyz="0 -9 5 cm" rpy="90 0 0 deg"/>
    <capsule name="arm" radius="1 cm" length="16 cm" mass="100 g" xyz="0 0 16 cm" color="#4060a0"/>
    <hinge name="axle_left" parent="deck" child="left" axis="0 0 -1"/>
    <hinge name="axle_right" parent="deck" child="right" axis="0 0 -1"/>
    <hinge name="shoulder" parent="deck" child="arm" axis="0 1 0" xyz="0 0 8 cm"/>
    <motor name="drive_left" joint="axle_left" mode="velocity"/>
    <motor name="drive_right" joint="axle_right" mode="velocity"/>
    <infrared name="eye" on="deck" xyz="12 0 2 cm" range="0.8 m"/>
    <camera name="front" on="deck" xyz="12 0 4 cm"/>
    <controller plugin="diff_drive" rate="100 Hz"/>
  </assembly>
</scene>
`;

const kRays = 5;
const kRange = 0.8;

const grey: [number, number, number, number] = [0.85, 0.85, 0.82, 1];
const ply: [number, number, number, number] = [0.71, 0.53, 0.39, 1];
const none: Pose = [0, 0, 0, 1, 0, 0, 0];
/** z of a cylinder along y */
const lying: Pose = [0, 0, 0, Math.SQRT1_2, Math.SQRT1_2, 0, 0];

function shape(type: SceneShape["type"], size: number[], color: SceneShape["color"]): SceneShape {
  return { type, pose: none, size, color, texture: "", tile: [1, 1], visual: true };
}

/** Height of a ball let go at `top`, of radius 6 cm, that keeps 64 % of its energy at each bounce. */
function ballHeight(t: number): number {
  const g = 9.81;
  let speed = Math.sqrt(2 * g * 0.44);
  let since = t - speed / g;
  if (since < 0) return 0.5 - 0.5 * g * t * t;
  for (let k = 0; k < 40; ++k) {
    speed *= 0.8;
    const flight = (2 * speed) / g;
    if (since < flight) return 0.06 + speed * since - 0.5 * g * since * since;
    since -= flight;
  }
  return 0.06;
}

function posesAt(t: number, slip = 0): Float32Array {
  const turn = 0.6 * t * (1 - slip);
  const radius = 0.6;
  const [c, s] = [Math.cos(turn), Math.sin(turn)];
  const heading = turn + Math.PI / 2;
  const x = radius * c;
  const y = radius * s;
  const yaw = (angle: number): number[] => [Math.cos(angle / 2), 0, 0, Math.sin(angle / 2)];
  const times = (a: number[], b: number[]): number[] => [
    a[0]! * b[0]! - a[1]! * b[1]! - a[2]! * b[2]! - a[3]! * b[3]!,
    a[0]! * b[1]! + a[1]! * b[0]! + a[2]! * b[3]! - a[3]! * b[2]!,
    a[0]! * b[2]! - a[1]! * b[3]! + a[2]! * b[0]! + a[3]! * b[1]!,
    a[0]! * b[3]! + a[1]! * b[2]! - a[2]! * b[1]! + a[3]! * b[0]!,
  ];
  const at = (forward: number, left: number): [number, number] => [
    x + forward * Math.cos(heading) - left * Math.sin(heading),
    y + forward * Math.sin(heading) + left * Math.cos(heading),
  ];
  const rolled = (distance: number): number[] => times(times(yaw(heading), lying.slice(3)), yaw(-distance / 0.05));
  const lean = 0.6 * Math.sin(2 * t);
  const arm = times(yaw(heading), [Math.cos(lean / 2), 0, Math.sin(lean / 2), 0]);
  const offset = at(0.08 * Math.sin(lean), 0);
  return Float32Array.from([
    ...none,
    ...[0, 0, 0.08, 1, 0, 0, 0],
    ...[-0.5, 0.5, ballHeight(t), 1, 0, 0, 0],
    ...[x, y, 0.06, ...yaw(heading)],
    ...[...at(0, 0.09), 0.05, ...rolled(turn * (radius - 0.09))],
    ...[...at(0, -0.09), 0.05, ...rolled(turn * (radius + 0.09))],
    ...[...offset, 0.08 + 0.08 * Math.cos(lean), ...arm],
  ]);
}

/** Reading of each ray [m], of the crate taken as a disc; null: nothing in range. */
function readings(poses: Float32Array): (number | null)[] {
  const heading = 2 * Math.atan2(poses[27]!, poses[24]!);
  const ox = poses[21]! + 0.12 * Math.cos(heading);
  const oy = poses[22]! + 0.12 * Math.sin(heading);
  return directions().map(([dx, dy]) => {
    const x = dx * Math.cos(heading) - dy * Math.sin(heading);
    const y = dx * Math.sin(heading) + dy * Math.cos(heading);
    const along = -(ox * x + oy * y);
    const off = ox * ox + oy * oy - along * along;
    const half = 0.09 * 0.09 - off;
    if (along < 0 || half < 0) return null;
    const range = along - Math.sqrt(half);
    return range < kRange ? range : null;
  });
}

function directions(): Vec3[] {
  return Array.from({ length: kRays }, (_, i) => {
    const angle = ((i - (kRays - 1) / 2) * 25 * Math.PI) / 180 + Math.PI / 3;
    return [Math.cos(angle), Math.sin(angle), 0];
  });
}

export function frameAt(scene: number, step: number, dt: number, ghost: boolean): Frame {
  const time = step * dt;
  const poses = posesAt(time);
  const tail: FrameTail = { readings: [{ sensor: 0, values: readings(poses) }] };
  if (poses[16]! < 0.0605) {
    tail.contacts = [{ a: 2, b: 0, point: [-0.5, 0.5, 0], normal: [0, 0, 1], depth: 0.001, force: 12 }];
  } else {
    tail.contacts = [];
  }
  tail.contacts.push({ a: 1, b: 0, point: [0, 0, 0], normal: [0, 0, 1], depth: 0, force: 4.9 });
  return { live: true, scene, time, step, poses, ghost: ghost ? posesAt(time, 0.02) : new Float32Array(0), tail };
}

/** The scene of kText, whatever the text has become since: ids are looked up by name. */
export function demoScene(number: number, text: string): Scene {
  const elements = tokens(text).elements;
  const id = (name: string) => elements.findIndex((e) => e.name === name || e.tag === name);
  const poses = posesAt(0);
  const pose = (i: number) => Array.from(poses.subarray(7 * i, 7 * i + 7)) as Pose;
  const body = (i: number, name: string, kind: SceneBody["kind"], mass: number, of: SceneShape): SceneBody => ({
    name,
    kind,
    pose: pose(i),
    mass,
    com: [0, 0, 0],
    element: id(name.replace("robot.", "")),
    own: true,
    assembly: name.startsWith("robot.") ? 0 : -1,
    removed: id(name.replace("robot.", "")) < 0,
    shapes: [of],
  });
  const joint = (name: string, child: number, parentPose: Pose, childPose: Pose) => ({
    name: `robot.${name}`,
    type: "hinge",
    parent: 3,
    child,
    parent_pose: parentPose,
    child_pose: childPose,
    element: id(name),
  });
  const wheel = (y: number): Pose => [0, y, -0.01, Math.SQRT1_2, Math.SQRT1_2, 0, 0];
  return {
    scene: number,
    name: "demo",
    bodies: [
      body(0, "ground", "fixed", 0, shape("plane", [10, 10], grey)),
      body(1, "crate", "dynamic", 0.5, shape("box", [0.16, 0.16, 0.16], ply)),
      body(2, "ball", "dynamic", 0.1, shape("sphere", [0.06], [0.69, 0.23, 0.18, 1])),
      body(3, "robot.deck", "dynamic", 0.9, shape("box", [0.24, 0.14, 0.04], ply)),
      body(4, "robot.left", "dynamic", 0.15, shape("cylinder", [0.05, 0.02], [0.13, 0.13, 0.13, 1])),
      body(5, "robot.right", "dynamic", 0.15, shape("cylinder", [0.05, 0.02], [0.13, 0.13, 0.13, 1])),
      body(6, "robot.arm", "dynamic", 0.1, shape("capsule", [0.01, 0.16], [0.25, 0.38, 0.63, 1])),
    ],
    assemblies: [{ name: "robot", parent: -1, rigid: false, pose: none, element: id("robot") }],
    joints: [
      joint("axle_left", 4, wheel(0.09), none),
      joint("axle_right", 5, wheel(-0.09), none),
      joint("shoulder", 6, [0, 0, 0.02, 1, 0, 0, 0], [0, 0, -0.08, 1, 0, 0, 0]),
    ],
    motors: [
      { name: "robot.drive_left", joint: 0, element: id("drive_left") },
      { name: "robot.drive_right", joint: 1, element: id("drive_right") },
    ],
    sensors: [
      {
        name: "robot.eye",
        type: "infrared",
        body: 3,
        pose: [0.12, 0, 0.02, 1, 0, 0, 0],
        element: id("eye"),
        rays: directions().map((d) => [0, 0, 0, ...d, kRange]),
      },
      {
        name: "robot.front",
        type: "camera",
        body: 3,
        pose: [0.12, 0, 0.04, 1, 0, 0, 0],
        element: id("front"),
        rays: [],
      },
    ],
    lights: [
      {
        name: "sun",
        type: "directional",
        pose: [0, 0, 3, 0.98, 0.15, -0.11, 0],
        color: [1, 1, 1],
        intensity: 1,
        cone: 0,
        shadows: true,
        element: id("sun"),
      },
    ],
    views: [{ name: "corner", pose: [1.5, -1.5, 1.2, 0.36, -0.2, 0.08, 0.9], fov: 1, element: id("corner") }],
    regions: [],
    forces: [],
    controllers: [{ name: "robot.diff_drive", plugin: "diff_drive", assembly: 0, element: id("controller") }],
    supervisors: [],
    plots: [{ name: "heights", kind: "line", title: "Heights", element: -1 }],
    meshes: [],
    heightmaps: [],
    gravity: [0, 0, -9.81],
    step: 0.001,
    duration: 10,
  };
}
