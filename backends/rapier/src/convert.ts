// Vectors and quaternions as Rapier has them, {x, y, z, w}.

export interface Xyz {
  x: number;
  y: number;
  z: number;
}
export interface Xyzw extends Xyz {
  w: number;
}

export const xyz = (v: ArrayLike<number>, at = 0): Xyz => ({ x: v[at], y: v[at + 1], z: v[at + 2] });
export const xyzw = (q: ArrayLike<number>, at = 0): Xyzw => ({
  w: q[at],
  x: q[at + 1],
  y: q[at + 2],
  z: q[at + 3],
});
