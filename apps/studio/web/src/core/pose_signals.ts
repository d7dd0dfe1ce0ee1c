// What can be drawn of a run in memory without its simulator: where bodies are and how they are turned, and how far two runs
// diverge.
import type { MemoryRun, MemorySignal } from "./memory_run";

/** Radians about the world's x, then y, then z axis, of the rotation w x y z. */
export function rollPitchYaw(w: number, x: number, y: number, z: number): [number, number, number] {
  const sine = Math.min(Math.max(2 * (w * y - z * x), -1), 1);
  return [
    Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
    Math.asin(sine),
    Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
  ];
}

const kParts: { name: string; unit: string; of(poses: Float32Array, at: number): number }[] = [
  ...["x", "y", "z"].map((name, k) => ({
    name,
    unit: "m",
    of: (poses: Float32Array, at: number) => poses[at + k] ?? NaN,
  })),
  ...["roll", "pitch", "yaw"].map((name, k) => ({
    name,
    unit: "rad",
    of: (p: Float32Array, at: number) =>
      at + 6 < p.length ? rollPitchYaw(p[at + 3]!, p[at + 4]!, p[at + 5]!, p[at + 6]!)[k]! : NaN,
  })),
];

/** x, y, z, roll, pitch and yaw of every body of the newest scene, under the names that a server has for them. Values are
 *  read from the frames when they are asked for; of frames that belong to a scene without that body there are none. */
export function poseSignals(run: MemoryRun): MemorySignal[] {
  const newest = run.scenes[run.scenes.length - 1];
  if (!newest) return [];
  const indices = new Map<number, Map<string, number>>();
  for (const scene of run.scenes) indices.set(scene.scene, new Map(scene.bodies.map((b, i) => [b.name, i])));
  const read = (body: string, of: (poses: Float32Array, at: number) => number, ghost: boolean): Float64Array => {
    const values = new Float64Array(run.count);
    for (let i = 0; i < run.count; ++i) {
      const frame = run.frame(i);
      const index = indices.get(frame.scene)?.get(body);
      values[i] = index === undefined ? NaN : of(ghost ? frame.ghost : frame.poses, 7 * index);
    }
    return values;
  };
  return newest.bodies
    .filter((body) => body.kind !== "fixed" && !body.removed)
    .flatMap((body) =>
      kParts.map(({ name, unit, of }): MemorySignal => {
        // a run that grows is read again
        let cached: { values: Float64Array; ghost: Float64Array | undefined } | null = null;
        const all = () => {
          if (cached?.values.length !== run.count) {
            const ghost = run.count > 0 && run.frame(run.count - 1).ghost.length > 0;
            cached = { values: read(body.name, of, false), ghost: ghost ? read(body.name, of, true) : undefined };
          }
          return cached;
        };
        return {
          name: `${body.name}.${name}`,
          unit,
          owner: body.name,
          get values() {
            return all().values;
          },
          get ghost() {
            return all().ghost;
          },
        };
      }),
    );
}

/** The answer to `divergence`, of frames with ghosts; null without. Bodies count as diverged from 1 cm or 1° on, as elsewhere. */
export function divergenceOf(run: MemoryRun, labels: [string, string]): Record<string, unknown> | null {
  const scene = run.scenes[run.scenes.length - 1];
  if (!scene || run.count === 0 || run.frame(run.count - 1).ghost.length === 0) return null;
  const time: number[] = [];
  const worst: number[] = [];
  const worstAngle: number[] = [];
  const distances = scene.bodies.map(() => [] as (number | null)[]);
  const most = scene.bodies.map(() => 0);
  let first: { time: number; name: string } | null = null;
  for (let i = 0; i < run.count; ++i) {
    const { poses: a, ghost: b, time: at } = run.frame(i);
    let far = 0;
    let turned = 0;
    scene.bodies.forEach((body, k) => {
      const p = 7 * k;
      if (p + 6 >= Math.min(a.length, b.length)) return void distances[k]!.push(null);
      const distance = Math.hypot(a[p]! - b[p]!, a[p + 1]! - b[p + 1]!, a[p + 2]! - b[p + 2]!);
      // poses are of single precision: near 1 the cosine cannot resolve angles below 1e-3 rad, so the sine of half of it is
      // taken, from the product with the inverse
      const angle = 2 * Math.asin(Math.min(halfSine(a, b, p + 3), 1));
      distances[k]!.push(distance);
      most[k] = Math.max(most[k]!, distance);
      far = Math.max(far, distance);
      turned = Math.max(turned, angle);
      if (!first && (distance > 0.01 || angle > Math.PI / 180)) first = { time: at, name: body.name };
    });
    time.push(at);
    worst.push(far);
    worstAngle.push(turned);
  }
  const bodies = scene.bodies
    .map((body, k) => ({ name: body.name, distance: distances[k]!, most: most[k]! }))
    .sort((x, y) => y.most - x.most)
    .slice(0, 10)
    .map(({ name, distance }) => ({ name, distance }));
  return { time, worst, worst_angle: worstAngle, bodies, first, labels };
}

/** Sine of half the angle between two rotations: length of the vector part of a* b. */
function halfSine(a: Float32Array, b: Float32Array, at: number): number {
  const [aw, ax, ay, az] = [a[at]!, a[at + 1]!, a[at + 2]!, a[at + 3]!];
  const [bw, bx, by, bz] = [b[at]!, b[at + 1]!, b[at + 2]!, b[at + 3]!];
  return Math.hypot(
    aw * bx - ax * bw - ay * bz + az * by,
    aw * by - ay * bw - az * bx + ax * bz,
    aw * bz - az * bw - ax * by + ay * bx,
  );
}
