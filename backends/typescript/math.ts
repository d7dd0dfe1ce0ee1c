// Vectors and quaternions (w x y z), as scenes have them.

export type V3 = [number, number, number];
export type Q4 = [number, number, number, number];
export interface Pose {
  p: V3;
  q: Q4;
}

export const v3 = (a: ArrayLike<number>, at = 0): V3 => [a[at], a[at + 1], a[at + 2]];
export const q4 = (a: ArrayLike<number>, at = 0): Q4 => [a[at], a[at + 1], a[at + 2], a[at + 3]];
export const kHere: Pose = { p: [0, 0, 0], q: [1, 0, 0, 0] };
export const poseOf = (a: ArrayLike<number>, at = 0): Pose => ({ p: v3(a, at), q: q4(a, at + 3) });

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

export function multiply(a: Q4, b: Q4): Q4 {
  return [
    a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
    a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
    a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
    a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
  ];
}
export const conjugate = (q: Q4): Q4 => [q[0], -q[1], -q[2], -q[3]];
export function normalized(q: Q4): Q4 {
  const length = Math.hypot(...q);
  return q.map((x) => x / length) as Q4;
}

/** Vector v turned by the unit quaternion q. */
export function turn(q: Q4, v: V3): V3 {
  const u: V3 = [q[1], q[2], q[3]];
  const t = scale(2, cross(u, v));
  return plus(plus(v, t, q[0]), cross(u, t));
}

export const turnBack = (q: Q4, v: V3): V3 => turn(conjugate(q), v);

export function inverse({ p, q }: Pose): Pose {
  return { p: scale(-1, turnBack(q, p)), q: conjugate(q) };
}

/** Principal moments of a symmetric matrix, and their axes as a rotation, by Jacobi's method. */
export function principal(matrix: number[]): { moments: V3; axes: Q4 } {
  const a = [matrix.slice(0, 3), matrix.slice(3, 6), matrix.slice(6, 9)];
  let axes: Q4 = [1, 0, 0, 0];
  for (let sweep = 0; sweep < 30; ++sweep) {
    const scale = Math.abs(a[0][0]) + Math.abs(a[1][1]) + Math.abs(a[2][2]);
    if (Math.abs(a[0][1]) + Math.abs(a[0][2]) + Math.abs(a[1][2]) <= 1e-16 * scale) break;
    for (const [i, j, k] of [
      [0, 1, 2],
      [1, 2, 0],
      [2, 0, 1],
    ]) {
      // The turn about axis k, of an eighth of a circle at most, that makes a[i][j] zero.
      const difference = a[i][i] - a[j][j];
      const sign = difference < 0 ? -1 : 1;
      const angle = 0.5 * Math.atan2(sign * 2 * a[i][j], Math.abs(difference));
      const [c, s] = [Math.cos(angle), Math.sin(angle)];
      for (const row of a) [row[i], row[j]] = [c * row[i] + s * row[j], c * row[j] - s * row[i]];
      for (let n = 0; n < 3; ++n) {
        [a[i][n], a[j][n]] = [c * a[i][n] + s * a[j][n], c * a[j][n] - s * a[i][n]];
      }
      const step: Q4 = [Math.cos(angle / 2), 0, 0, 0];
      step[k + 1] = Math.sin(angle / 2);
      axes = multiply(axes, step);
    }
  }
  return { moments: [a[0][0], a[1][1], a[2][2]], axes };
}
