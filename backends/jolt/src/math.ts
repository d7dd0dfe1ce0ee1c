// Vectors and quaternions (w x y z), as scenes have them.

export type V3 = [number, number, number];
export type Q4 = [number, number, number, number];

export const cross = (a: V3, b: V3): V3 => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
export const dot = (a: V3, b: V3): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const plus = (a: V3, b: V3, factor = 1): V3 => [
  a[0] + factor * b[0],
  a[1] + factor * b[1],
  a[2] + factor * b[2],
];

export const scale = (s: number, a: V3): V3 => [s * a[0], s * a[1], s * a[2]];

/** As Vec3::GetNormalizedPerpendicular of Jolt. */
export function perpendicular([x, y, z]: V3): V3 {
  if (Math.abs(x) > Math.abs(y)) return scale(1 / Math.hypot(x, z), [z, 0, -x]);
  return scale(1 / Math.hypot(y, z), [0, z, -y]);
}

export function multiply(a: Q4, b: Q4): Q4 {
  return [
    a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
    a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
    a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
    a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
  ];
}
export const conjugate = (q: Q4): Q4 => [q[0], -q[1], -q[2], -q[3]];

/** Vector v turned by the unit quaternion q. */
export function turn(q: Q4, v: V3): V3 {
  const u: V3 = [q[1], q[2], q[3]];
  const c = cross(u, v);
  const t: V3 = [2 * c[0], 2 * c[1], 2 * c[2]];
  return plus(plus(v, t, q[0]), cross(u, t));
}
