// How springs are drawn.
import type { Vec3 } from "../core/protocol";

const kTurns = 8;
const kPerTurn = 8;

/** Corners of a coil of radius `radius` from a to b, its ends straight; of a cable a straight line. */
export function springLine(a: Vec3, b: Vec3, radius: number, cable: boolean): Vec3[] {
  const d: Vec3 = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
  const length = Math.hypot(...d);
  if (cable || !(length > 0)) return [a, b];
  // Two directions at right angles to it and to each other; u is level where d is not upright.
  const level = Math.hypot(d[0], d[1]);
  const u: Vec3 = level > 1e-6 * length ? [d[1] / level, -d[0] / level, 0] : [1, 0, 0];
  const w = [0, 1, 2].map((i) => {
    const [j, k] = [(i + 1) % 3, (i + 2) % 3];
    return (d[j]! * u[k]! - d[k]! * u[j]!) / length;
  });
  const corners: Vec3[] = [a];
  for (let i = 0; i <= kTurns * kPerTurn; i++) {
    const t = 0.1 + (0.8 * i) / (kTurns * kPerTurn);
    const angle = (2 * Math.PI * i) / kPerTurn;
    const [c, s] = [radius * Math.cos(angle), radius * Math.sin(angle)];
    corners.push([0, 1, 2].map((k) => a[k]! + t * d[k]! + c * u[k]! + s * w[k]!) as unknown as Vec3);
  }
  corners.push(b);
  return corners;
}
