// How a joint moves what hangs on it, and what is shown of joints and motors: plain logic.
import type { ControllerInput, FrameJoint, Pose, Scene, SceneJoint, SceneMotor, TreeElement } from "../core/protocol";
import { compose, inverse, poseAt } from "../view3d/pose";

/** Joints of one coordinate: those with a slider. */
const kOneAxis = ["hinge", "slider", "screw"];

/** How far a joint without limits, or a motor without a stated range, goes here: [rad], [m], [rad/s], [m/s], [N m], [N], [V]. */
const kReach: Record<string, number> = { rad: Math.PI, m: 1, "rad/s": 10, "m/s": 1, "N m": 10, N: 10, V: 12 };

export interface Range {
  low: number;
  high: number;
  /** both ends are what the scene says */
  stated: boolean;
}

function rangeOf(low: number | null | undefined, high: number | null | undefined, unit: string): Range {
  const reach = kReach[unit] ?? 1;
  const stated = typeof low === "number" && typeof high === "number";
  const from = low ?? Math.min(-reach, (high ?? 0) - reach);
  const to = high ?? Math.max(reach, from + reach);
  return { low: from, high: Math.max(to, from + 1e-9), stated };
}

export const jointUnit = (joint: SceneJoint): "rad" | "m" => (joint.type === "slider" ? "m" : "rad");

export function jointRange(joint: SceneJoint): Range {
  const [low = null, high = null] = joint.limits?.[0] ?? [];
  return rangeOf(low, high, jointUnit(joint));
}

export function motorRange(motor: SceneMotor): Range {
  return rangeOf(motor.low, motor.high, motor.unit ?? "");
}

/** People read angles in degrees: what is shown is so many times what the program has. */
export function shownIn(unit: string): { unit: string; factor: number } {
  return unit === "rad" ? { unit: "°", factor: 180 / Math.PI } : { unit: unit === "N m" ? "N·m" : unit, factor: 1 };
}

/** A number as one reads it: four significant digits, no exponents for what is small. */
export function shortNumber(value: number): string {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  const digits = size >= 1000 ? 0 : size >= 100 ? 1 : size >= 1 ? 2 : 3;
  const text = value.toFixed(digits);
  return Number(text) === 0 ? (0).toFixed(digits) : text;
}

/** The value of the attribute `position`, with its unit. */
export function positionText(joint: SceneJoint, position: number): string {
  const short = (v: number, digits: number) => String(Number(v.toFixed(digits)));
  return jointUnit(joint) === "m" ? `${short(position, 5)} m` : `${short((position * 180) / Math.PI, 3)} deg`;
}

export interface JointRow {
  index: number;
  joint: SceneJoint;
}

export function jointRows(scene: Scene): JointRow[] {
  return scene.joints.flatMap((joint, index) =>
    joint.removed || joint.closes_loop || !kOneAxis.includes(joint.type) ? [] : [{ index, joint }],
  );
}

/** Why the start of a joint cannot be set; "": it can. */
export function whyFixed(joint: SceneJoint, element: TreeElement | undefined): string {
  if (joint.element < 0 || !joint.own || !element)
    return "an import, a prototype or a repetition made it, so this text does not say where it starts";
  if ((element.attributes.position ?? "").includes("${")) return "its start is an expression: change it in the code";
  return "";
}

/** Bodies that a joint carries: all that hang on its child. null: they are connected with its parent in another way, too. */
export function carriedBy(scene: Scene, index: number): number[] | null {
  const joint = scene.joints[index];
  if (!joint || joint.child < 0) return null;
  const found = new Set([joint.child]);
  const wanted = [joint.child];
  for (let at = wanted.pop(); at !== undefined; at = wanted.pop()) {
    scene.joints.forEach((other, i) => {
      if (i === index || other.removed || other.closes_loop) return;
      for (const [a, b] of [
        [other.parent, other.child],
        [other.child, other.parent],
      ] as const) {
        if (a !== at || b < 0 || found.has(b)) continue;
        found.add(b);
        wanted.push(b);
      }
    });
  }
  return joint.parent >= 0 && found.has(joint.parent) ? null : [...found];
}

/** Where what a joint carries is once the joint has turned or slid on by `by` [rad] or [m]. */
export function movedBy(scene: Scene, poses: ArrayLike<number>, index: number, by: number): Map<number, Pose> {
  const out = new Map<number, Pose>();
  const joint = scene.joints[index];
  const bodies = joint && joint.type !== "screw" ? carriedBy(scene, index) : null;
  if (!joint || !bodies) return out;
  const of = (body: number): Pose =>
    7 * body + 6 < poses.length ? poseAt(poses, body) : (scene.bodies[body]?.pose ?? [0, 0, 0, 1, 0, 0, 0]);
  // the joint's frame in the child: its z is the axis
  const frame = compose(of(joint.child), joint.child_pose);
  const step: Pose =
    joint.type === "slider" ? [0, 0, by, 1, 0, 0, 0] : [0, 0, 0, Math.cos(by / 2), 0, 0, Math.sin(by / 2)];
  const change = compose(compose(frame, step), inverse(frame));
  for (const body of bodies) out.set(body, compose(change, of(body)));
  return out;
}

/** What a motor drives now: a position where its target is one, else a speed. */
export function drivenValue(motor: SceneMotor, joint: FrameJoint | undefined): { value: number | null; unit: string } {
  const axis = motor.axis ?? 0;
  const places = motor.mode === "position" || motor.mode === "servo";
  const list = places ? joint?.position : joint?.speed;
  const unit = places ? (motor.turns ? "rad" : "m") : motor.turns ? "rad/s" : "m/s";
  return { value: list?.[axis] ?? null, unit };
}

/** Keys that raise and lower the inputs of a controller, in their order, as letters are on a keyboard: those of games. */
export const kInputKeys: readonly (readonly [string, string])[] = [
  ["KeyW", "KeyS"],
  ["KeyA", "KeyD"],
  ["KeyQ", "KeyE"],
];
/** Takes all of them to what is nearest to zero. */
export const kZeroKey = "KeyX";
/** So many presses go from one end to the other. */
const kPresses = 20;

/** What the inputs of a controller become by a key; empty: it is none of theirs. */
export function inputsByKey(code: string, inputs: readonly ControllerInput[], values: readonly number[]): number[] {
  const within = (input: ControllerInput, value: number) => Math.min(Math.max(value, input.lower), input.upper);
  if (code === kZeroKey) return inputs.map((input) => within(input, 0));
  const index = kInputKeys.findIndex((keys) => keys.includes(code));
  const input = inputs[index];
  if (!input) return [];
  const step = ((input.upper - input.lower) / kPresses) * (kInputKeys[index]![0] === code ? 1 : -1);
  return values.map((value, i) => (i === index ? within(input, value + step) : value));
}

/** Controllers that may command a motor: of an assembly that the joint's bodies are in. */
export function commandersOf(scene: Scene, motor: SceneMotor): string[] {
  const joint = scene.joints[motor.joint];
  const within = new Set<number>();
  for (const body of [joint?.child ?? -1, joint?.parent ?? -1])
    for (let at = scene.bodies[body]?.assembly ?? -1; at >= 0; at = scene.assemblies[at]?.parent ?? -1) within.add(at);
  return scene.controllers.filter((c) => !c.removed && within.has(c.assembly)).map((c) => c.name);
}
