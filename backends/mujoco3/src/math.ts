// Vectors and quaternions (w x y z) of poses, as they lie in arrays.

export type V3 = [number, number, number];
export type Q4 = [number, number, number, number];
export interface Pose {
  p: V3;
  q: Q4;
}

export const v3 = (a: ArrayLike<number>, at = 0): V3 => [a[at], a[at + 1], a[at + 2]];
export const q4 = (a: ArrayLike<number>, at = 0): Q4 => [a[at], a[at + 1], a[at + 2], a[at + 3]];
export const poseOf = (a: ArrayLike<number>, at = 0): Pose => ({ p: v3(a, at), q: q4(a, at + 3) });
export const kHere: Pose = { p: [0, 0, 0], q: [1, 0, 0, 0] };

export const add = (a: V3, b: V3): V3 => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const subtract = (a: V3, b: V3): V3 => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (s: number, a: V3): V3 => [s * a[0], s * a[1], s * a[2]];
export const cross = (a: V3, b: V3): V3 => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];

export const conjugate = ([w, x, y, z]: Q4): Q4 => [w, -x, -y, -z];
export function multiply([a, b, c, d]: Q4, [e, f, g, h]: Q4): Q4 {
  return [
    a * e - b * f - c * g - d * h,
    a * f + b * e + c * h - d * g,
    a * g - b * h + c * e + d * f,
    a * h + b * g - c * f + d * e,
  ];
}
export function normalized(q: Q4): Q4 {
  const length = Math.hypot(...q);
  return q.map(x => x / length) as Q4;
}

/** v turned by the unit quaternion q. */
export function turn(q: Q4, v: V3): V3 {
  const u: V3 = [q[1], q[2], q[3]];
  const t = scale(2, cross(u, v));
  return add(add(v, scale(q[0], t)), cross(u, t));
}
export const turnBack = (q: Q4, v: V3): V3 => turn(conjugate(q), v);

export function inverse({ p, q }: Pose): Pose {
  return { p: scale(-1, turnBack(q, p)), q: conjugate(q) };
}
