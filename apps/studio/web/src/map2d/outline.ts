// Shapes seen from above. A shape that is turned about the vertical only keeps its outline, so outlines are made for a tilt and
// turned when drawn.
import type { Pose, Scene, SceneShape, Vec3 } from "../core/protocol";
import { rotationOf, type Rotation } from "../view3d/pose";
import { cornersOf, shapeBounds } from "../view3d/bounds";

type Point = [number, number];
export type Polygon = Point[];

/** A polygon of n corners around a circle leaves it by 1 - cos(pi / n) of the radius: 0.05 % here. */
const kCorners = 102;

/** Where "up" of the world points in the shape's frame. */
export function upIn(pose: Pose): Vec3 {
  const r = rotationOf(pose);
  return [r[6], r[7], r[8]];
}

/** The least rotation that takes `up` (unit) to z; half a turn about x from straight down. Rows. */
export function level(up: Vec3): Rotation {
  const [x, y, z] = up;
  if (z < -1 + 1e-9) return [1, 0, 0, 0, -1, 0, 0, 0, -1];
  const k = 1 / (1 + z);
  return [1 - k * x * x, -k * x * y, -x, -k * x * y, 1 - k * y * y, -y, x, y, z];
}

/** The angle about the vertical [rad] that is left of a pose once its tilt is taken away: pose = turn * level(upIn(pose)). */
export function turnOf(pose: Pose, tilt: Rotation): number {
  const r = rotationOf(pose);
  // first column of r * transpose(tilt)
  const c = r[0] * tilt[0] + r[1] * tilt[1] + r[2] * tilt[2];
  const s = r[3] * tilt[0] + r[4] * tilt[1] + r[5] * tilt[2];
  return Math.atan2(s, c);
}

const cross = (o: Point, a: Point, b: Point): number => (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);

/** Counter-clockwise (Andrew's monotone chain). */
export function convexHull(points: Polygon): Polygon {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const p = sorted.filter((q, i) => i === 0 || q[0] !== sorted[i - 1]![0] || q[1] !== sorted[i - 1]![1]);
  if (p.length < 3) return p;
  const half = (from: Polygon): Polygon => {
    const out: Polygon = [];
    for (const q of from) {
      while (out.length >= 2 && cross(out[out.length - 2]!, out[out.length - 1]!, q) <= 0) out.pop();
      out.push(q);
    }
    out.pop();
    return out;
  };
  return [...half(p), ...half(p.reverse())];
}

function project(tilt: Rotation, p: ArrayLike<number>, at = 0): Point {
  const x = p[at]!;
  const y = p[at + 1]!;
  const z = p[at + 2]!;
  return [tilt[0] * x + tilt[1] * y + tilt[2] * z, tilt[3] * x + tilt[4] * y + tilt[5] * z];
}

function ring(out: Polygon, tilt: Rotation, radius: number, z: number): void {
  for (let i = 0; i < kCorners; i++) {
    const angle = (2 * Math.PI * i) / kCorners;
    out.push(project(tilt, [radius * Math.cos(angle), radius * Math.sin(angle), z]));
  }
}

/** A ball's shadow is a circle however it is turned. */
function ball(out: Polygon, middle: Point, radius: number): void {
  for (let i = 0; i < kCorners; i++) {
    const angle = (2 * Math.PI * i) / kCorners;
    out.push([middle[0] + radius * Math.cos(angle), middle[1] + radius * Math.sin(angle)]);
  }
}

/**
 * Closed polygons [m] around the shape's origin, turned by `tilt` but not about the vertical, whose union is the shape's shadow
 * at noon. A plane has none.
 */
export function planOutline(scene: Scene, shape: SceneShape, tilt: Rotation): Polygon[] {
  const points: Polygon = [];
  const [a = 0, b = 0] = shape.size;
  switch (shape.type) {
    case "plane":
      return [];
    case "sphere":
      ball(points, [0, 0], a);
      return [points];
    case "cylinder":
      ring(points, tilt, a, -b / 2);
      ring(points, tilt, a, b / 2);
      break;
    case "capsule":
      ball(points, project(tilt, [0, 0, -b / 2]), a);
      ball(points, project(tilt, [0, 0, b / 2]), a);
      break;
    case "mesh": {
      const mesh = scene.meshes[shape.mesh ?? -1];
      if (!mesh) return [];
      const triangles: Polygon[] = [];
      for (let i = 0; i + 2 < mesh.indices.length; i += 3) {
        const t = [0, 1, 2].map((k) => project(tilt, mesh.positions, 3 * mesh.indices[i + k]!)) as [
          Point,
          Point,
          Point,
        ];
        // all turn in the same direction, so that a non-zero fill is their union; edge-on ones add nothing
        const area = cross(t[0], t[1], t[2]);
        if (area > 0) triangles.push(t);
        else if (area < 0) triangles.push([t[0], t[2], t[1]]);
      }
      return triangles;
    }
    case "box":
    case "heightmap":
      for (const corner of cornersOf(shapeBounds(scene, shape))) points.push(project(tilt, corner));
      break;
  }
  return [convexHull(points)];
}

/** How far above its origin a shape reaches [m]; things lie over each other by it. A plane is under everything. */
export function upwardExtent(scene: Scene, shape: SceneShape, up: Vec3): number {
  const [a = 0, b = 0, c = 0] = shape.size;
  switch (shape.type) {
    case "plane":
      return -Infinity;
    case "box":
      return (Math.abs(up[0]) * a + Math.abs(up[1]) * b + Math.abs(up[2]) * c) / 2;
    case "sphere":
      return a;
    case "cylinder":
      return a * Math.hypot(up[0], up[1]) + (b / 2) * Math.abs(up[2]);
    case "capsule":
      return a + (b / 2) * Math.abs(up[2]);
    case "mesh": {
      const { positions } = scene.meshes[shape.mesh ?? -1] ?? { positions: [] };
      let most = -Infinity;
      for (let i = 0; i + 2 < positions.length; i += 3) {
        most = Math.max(most, up[0] * positions[i]! + up[1] * positions[i + 1]! + up[2] * positions[i + 2]!);
      }
      return most;
    }
    case "heightmap":
      // what stands on it is seen
      return shapeBounds(scene, shape).low[2];
  }
}
