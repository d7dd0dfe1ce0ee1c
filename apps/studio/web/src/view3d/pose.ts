// Arithmetic of poses: x y z [m], then the unit quaternion w x y z, as in PROTOCOL.md.
import type { Pose, Vec3 } from "../core/protocol";

export const kIdentity: Pose = [0, 0, 0, 1, 0, 0, 0];

/** Rows of a rotation matrix, nine numbers. */
export type Rotation = [number, number, number, number, number, number, number, number, number];

/** Pose number `i` of those of a frame. */
export function poseAt(poses: ArrayLike<number>, i: number): Pose {
  const at = 7 * i;
  return [poses[at]!, poses[at + 1]!, poses[at + 2]!, poses[at + 3]!, poses[at + 4]!, poses[at + 5]!, poses[at + 6]!];
}

export function isFinite(pose: ArrayLike<number>): boolean {
  for (let i = 0; i < pose.length; i++) if (!Number.isFinite(pose[i])) return false;
  return true;
}

/** Of a quaternion that need not be of unit length; one of length 0 means no rotation. */
function rotation(w: number, x: number, y: number, z: number): Rotation {
  const n = w * w + x * x + y * y + z * z;
  const s = n > 0 ? 2 / n : 0;
  return [
    1 - s * (y * y + z * z),
    s * (x * y - w * z),
    s * (x * z + w * y),
    s * (x * y + w * z),
    1 - s * (x * x + z * z),
    s * (y * z - w * x),
    s * (x * z - w * y),
    s * (y * z + w * x),
    1 - s * (x * x + y * y),
  ];
}

export function rotationOf(pose: Pose): Rotation {
  return rotation(pose[3], pose[4], pose[5], pose[6]);
}

export function rotate(pose: Pose, v: ArrayLike<number>): Vec3 {
  const r = rotationOf(pose);
  const x = v[0]!;
  const y = v[1]!;
  const z = v[2]!;
  return [r[0] * x + r[1] * y + r[2] * z, r[3] * x + r[4] * y + r[5] * z, r[6] * x + r[7] * y + r[8] * z];
}

/** A point of the pose's frame, in the frame the pose is given in. */
export function transform(pose: Pose, point: ArrayLike<number>): Vec3 {
  const v = rotate(pose, point);
  return [v[0] + pose[0], v[1] + pose[1], v[2] + pose[2]];
}

/** X_AC of X_AB and X_BC. */
export function compose(a: Pose, b: Pose): Pose {
  const p = transform(a, b);
  const [, , , aw, ax, ay, az] = a;
  const [, , , bw, bx, by, bz] = b;
  return [
    p[0],
    p[1],
    p[2],
    aw * bw - ax * bx - ay * by - az * bz,
    aw * bx + ax * bw + ay * bz - az * by,
    aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw,
  ];
}

export function inverse(pose: Pose): Pose {
  const turned: Pose = [0, 0, 0, pose[3], -pose[4], -pose[5], -pose[6]];
  const p = rotate(turned, pose);
  return [-p[0], -p[1], -p[2], turned[3], turned[4], turned[5], turned[6]];
}

/** Where a rigid group's frame is now, from where it and one of its bodies were at first and where that body is now. */
export function carried(frame: Pose, body: Pose, bodyNow: Pose): Pose {
  return compose(bodyNow, compose(inverse(body), frame));
}

/**
 * Writes the 4 x 4 matrix (column by column) of a body's pose times a shape's matrix in the body (the same layout; the
 * last row of both is 0 0 0 1) to `out` from `at` on. `poses` from `from` on: the body's seven numbers.
 */
export function writeMatrix(
  out: Float32Array,
  at: number,
  poses: ArrayLike<number>,
  from: number,
  local: Float32Array | Float64Array,
): void {
  const r = rotation(poses[from + 3]!, poses[from + 4]!, poses[from + 5]!, poses[from + 6]!);
  for (let column = 0; column < 4; column++) {
    const x = local[4 * column]!;
    const y = local[4 * column + 1]!;
    const z = local[4 * column + 2]!;
    const to = at + 4 * column;
    const w = column === 3 ? 1 : 0;
    out[to] = r[0] * x + r[1] * y + r[2] * z + w * poses[from]!;
    out[to + 1] = r[3] * x + r[4] * y + r[5] * z + w * poses[from + 1]!;
    out[to + 2] = r[6] * x + r[7] * y + r[8] * z + w * poses[from + 2]!;
    out[to + 3] = w;
  }
}

/** The 4 x 4 matrix, column by column, of a pose after a scale along its axes. */
export function scaledMatrix(pose: Pose, scale: Vec3): Float64Array {
  const r = rotationOf(pose);
  const [a, b, c] = scale;
  // prettier-ignore
  return new Float64Array([
    r[0] * a, r[3] * a, r[6] * a, 0,
    r[1] * b, r[4] * b, r[7] * b, 0,
    r[2] * c, r[5] * c, r[8] * c, 0,
    pose[0], pose[1], pose[2], 1,
  ]);
}

/** The pose with short numbers: lengths to a tenth of a micrometre, quaternion normalised. For what goes into a text. */
export function tidy(pose: Pose): Pose {
  const n = Math.hypot(pose[3], pose[4], pose[5], pose[6]) || 1;
  const length = (v: number) => Math.round(v * 1e7) / 1e7;
  const part = (v: number) => v / n;
  return [
    length(pose[0]),
    length(pose[1]),
    length(pose[2]),
    part(pose[3]),
    part(pose[4]),
    part(pose[5]),
    part(pose[6]),
  ];
}
