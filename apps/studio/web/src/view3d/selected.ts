// What is selected shows what it is: a joint its axis and how far it goes, a motor its axle, a camera what it sees, a ranging
// sensor its beam, a body its mass and its frame.
import type { Pose, Scene, SceneJoint, Vec3 } from "../core/protocol";
import { radiusOf, visibleBounds } from "./bounds";
import { jointAxes } from "./joint_axes";
import { linearColor, type Dots, type Lines, type Rgb } from "./lines";
import { compose, isFinite, kIdentity, poseAt, rotate, transform } from "./pose";
import { bodiesIn } from "./selecting";
import { cross, unit } from "./views";

const kAxis = linearColor("#d81b9a");
const kLimit = linearColor("#7d3fc8");
const kSight = linearColor("#0b7fc4");
const kCentre = linearColor("#e0a800");
const kFrame: Rgb[] = [linearColor("#d83030"), linearColor("#2a9d3a"), linearColor("#2f62e0")];
/** A rotation without limits is shown as this much of a circle, as an arrow [rad]. */
const kTurn = 1.5 * Math.PI;
/** How far a camera's corners are drawn, as a share of the scene's size. */
const kFrustum = 0.2;

interface Pen {
  lines: Lines;
  dots: Dots;
}
type PoseOf = (body: number) => Pose;

const along = (from: ArrayLike<number>, d: Vec3, s: number): Vec3 => [
  from[0]! + s * d[0],
  from[1]! + s * d[1],
  from[2]! + s * d[2],
];

/** Points of an arc around `axis` from angle to angle, where 0 is along `zero`, which is at right angles to it. */
export function arc(
  middle: ArrayLike<number>,
  axis: Vec3,
  zero: Vec3,
  radius: number,
  from: number,
  to: number,
): Vec3[] {
  const side = cross(axis, zero);
  const steps = Math.max(2, Math.ceil(Math.abs(to - from) / 0.12));
  return Array.from({ length: steps + 1 }, (_, i) => {
    const angle = from + ((to - from) * i) / steps;
    return along(along(middle, zero, radius * Math.cos(angle)), side, radius * Math.sin(angle));
  });
}

function polyline(pen: Pen, points: Vec3[], color: Rgb): void {
  for (let i = 1; i < points.length; i++) pen.lines.add(points[i - 1]!, points[i]!, color);
}

/** A line with a head at its end. */
function arrow(pen: Pen, from: Vec3, to: Vec3, color: Rgb): void {
  pen.lines.add(from, to, color);
  const d: Vec3 = [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
  head(pen, to, d, color, 0.12 * Math.hypot(...d));
}
function head(pen: Pen, at: Vec3, direction: Vec3, color: Rgb, size: number): void {
  if (Math.hypot(...direction) < 1e-12) return;
  const d = unit(direction);
  const aside = unit(cross(d, Math.abs(d[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
  for (const s of [-0.5, 0.5]) pen.lines.add(at, along(along(at, d, -size), aside, s * size), color);
}

function drawJoint(pen: Pen, joint: SceneJoint, poseOf: PoseOf, size: number, driven: boolean): void {
  const parent = compose(poseOf(joint.parent), joint.parent_pose);
  const child = compose(poseOf(joint.child), joint.child_pose);
  if (!isFinite(parent) || !isFinite(child)) return;
  const reach = 0.6 * size;
  const axes = jointAxes(joint.type, parent, child);
  for (const a of axes) arrow(pen, along(parent, a, -reach), along(parent, a, reach), kAxis);
  pen.dots.add(parent, kAxis);
  const axis = axes[0];
  if (!axis) return;
  const [low = null, high = null] = joint.limits?.[0] ?? [];
  if (joint.type === "slider") {
    // the way, with what is at its ends across it
    const ends = [low ?? -reach, high ?? reach].map((at) => along(parent, axis, at));
    polyline(pen, ends, kLimit);
    const across = rotate(parent, [1, 0, 0]);
    [low, high].forEach((limit, i) => {
      if (limit !== null)
        pen.lines.add(along(ends[i]!, across, -0.2 * size), along(ends[i]!, across, 0.2 * size), kLimit);
    });
  } else if (["hinge", "screw", "cylindrical"].includes(joint.type)) {
    const zero = rotate(parent, [1, 0, 0]);
    const limited = low !== null && high !== null && high - low < 2 * Math.PI;
    const [from, to] = limited ? [low, high] : [0, kTurn];
    const points = arc(parent, axis, zero, 0.45 * size, from, to);
    polyline(pen, points, limited ? kLimit : kAxis);
    if (limited) for (const end of [points[0]!, points.at(-1)!]) pen.lines.add([...parent].slice(0, 3), end, kLimit);
    // where it is now
    const now = rotate(child, [1, 0, 0]);
    pen.lines.add([...parent].slice(0, 3), along(parent, now, 0.45 * size), kAxis);
    if (!limited || driven) {
      const [a, b] = [points.at(-2)!, points.at(-1)!];
      head(pen, b, [b[0] - a[0], b[1] - a[1], b[2] - a[2]], kAxis, 0.12 * size);
    }
  }
}

/** Size of what a joint or sensor belongs to [m]. */
function sizeOf(scene: Scene, poses: ArrayLike<number>, bodies: number[]): number {
  const box = visibleBounds(scene, poses, bodies);
  return box ? Math.max(radiusOf(box), 0.02) : 0.1;
}

/** A sentence on what is selected: masses. "" : nothing that has one. */
export function massText(scene: Scene, bodies: Iterable<number>): string {
  const all = [...bodies].map((b) => scene.bodies[b]!).filter((b) => b && b.kind === "dynamic");
  if (all.length === 0) return "";
  const mass = all.reduce((sum, b) => sum + b.mass, 0);
  const shown = mass >= 1 ? `${Number(mass.toPrecision(4))} kg` : `${Number((1000 * mass).toPrecision(4))} g`;
  return all.length === 1 ? `${all[0]!.name}: ${shown}` : `${all.length} bodies: ${shown}`;
}

/** Draws what the selected elements are. `size`: of the scene [m]. */
export function drawSelected(pen: Pen, scene: Scene, poses: ArrayLike<number>, selected: number[], size: number): void {
  const poseOf = (body: number): Pose =>
    body < 0 ? kIdentity : 7 * body + 6 < poses.length ? poseAt(poses, body) : scene.bodies[body]!.pose;
  const chosen = new Set(selected);
  const motors = scene.motors.filter((m) => chosen.has(m.element) && !m.removed);
  const driven = new Set(motors.map((m) => m.joint));
  scene.joints.forEach((joint, i) => {
    if (joint.removed || !(chosen.has(joint.element) || driven.has(i))) return;
    const local = sizeOf(scene, poses, joint.child >= 0 ? [joint.child] : []);
    drawJoint(pen, joint, poseOf, local, driven.has(i));
  });
  for (const sensor of scene.sensors) {
    if (!chosen.has(sensor.element) || sensor.removed) continue;
    const pose = compose(poseOf(sensor.body), sensor.pose);
    if (!isFinite(pose)) continue;
    const ends = sensor.rays.map((ray) => {
      const [ox = 0, oy = 0, oz = 0, dx = 1, dy = 0, dz = 0, range = 0] = ray;
      const far = sensor.type === "camera" ? (kFrustum * size) / Math.max(dx, 0.05) : range;
      return transform(pose, [ox + far * dx, oy + far * dy, oz + far * dz]);
    });
    pen.dots.add(pose, kSight);
    const few = ends.filter(
      (_, i) => ends.length <= 32 || i % Math.ceil(ends.length / 32) === 0 || i === ends.length - 1,
    );
    for (const end of few) pen.lines.add(pose, end, kSight);
    if (sensor.type === "camera") polyline(pen, [...ends, ends[0]!], kSight);
    if (ends.length === 0) drawFrame(pen, pose, 0.1 * size);
  }
  scene.assemblies.forEach((assembly, i) => {
    if (!chosen.has(assembly.element)) return;
    const bodies = bodiesIn(scene, i).filter((b) => scene.bodies[b]!.kind === "dynamic");
    const centre = centreOf(scene, poseOf, bodies);
    if (centre) pen.dots.add(centre, kCentre);
  });
  scene.bodies.forEach((body, i) => {
    if (body.removed || !chosen.has(body.element)) return;
    const pose = poseOf(i);
    if (!isFinite(pose)) return;
    drawFrame(pen, pose, 0.7 * sizeOf(scene, poses, [i]));
    if (body.kind === "dynamic") pen.dots.add(transform(pose, body.com), kCentre);
  });
}

function drawFrame(pen: Pen, pose: Pose, length: number): void {
  kFrame.forEach((color, k) => {
    const tip: Vec3 = [0, 0, 0];
    tip[k] = length;
    arrow(pen, [pose[0], pose[1], pose[2]], transform(pose, tip), color);
  });
}

/** Centre of mass of several bodies, world [m]; null: they have no mass. */
export function centreOf(scene: Scene, poseOf: PoseOf, bodies: number[]): Vec3 | null {
  const sum: Vec3 = [0, 0, 0];
  let mass = 0;
  for (const b of bodies) {
    const body = scene.bodies[b]!;
    const at = transform(poseOf(b), body.com);
    mass += body.mass;
    for (const k of [0, 1, 2] as const) sum[k] += body.mass * at[k];
  }
  return mass > 0 && sum.every(Number.isFinite) ? [sum[0] / mass, sum[1] / mass, sum[2] / mass] : null;
}
