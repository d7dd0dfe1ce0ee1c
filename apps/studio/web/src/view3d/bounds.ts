// Boxes that enclose the visible bodies.
import type { Pose, Scene, SceneShape, Vec3 } from "../core/protocol";
import { compose, isFinite, poseAt, rotate, transform } from "./pose";

/** Corners, world [m]. */
export interface Bounds {
  low: Vec3;
  high: Vec3;
}

/** The visible range of an empty scene: 2 m around the origin. */
export const kNothing: Bounds = { low: [-1, -1, -1], high: [1, 1, 1] };

export function joined(a: Bounds, b: Bounds): Bounds {
  const pick = (f: (a: number, b: number) => number, u: Vec3, v: Vec3): Vec3 => [
    f(u[0], v[0]),
    f(u[1], v[1]),
    f(u[2], v[2]),
  ];
  return { low: pick(Math.min, a.low, b.low), high: pick(Math.max, a.high, b.high) };
}

export function middleOf(b: Bounds): Vec3 {
  return [(b.low[0] + b.high[0]) / 2, (b.low[1] + b.high[1]) / 2, (b.low[2] + b.high[2]) / 2];
}

/** Half the diagonal [m]. */
export function radiusOf(b: Bounds): number {
  return Math.hypot(b.high[0] - b.low[0], b.high[1] - b.low[1], b.high[2] - b.low[2]) / 2;
}

export function cornersOf(b: Bounds): Vec3[] {
  return [0, 1, 2, 3, 4, 5, 6, 7].map((i): Vec3 => [
    i & 1 ? b.high[0] : b.low[0],
    i & 2 ? b.high[1] : b.low[1],
    i & 4 ? b.high[2] : b.low[2],
  ]);
}

const meshBounds = new WeakMap<object, Bounds>();

/** In the shape's own frame. Of a plane: a point. */
export function shapeBounds(scene: Scene, shape: SceneShape): Bounds {
  const half = (x: number, y: number, z: number): Bounds => ({ low: [-x, -y, -z], high: [x, y, z] });
  const [a = 0, b = 0, c = 0] = shape.size;
  switch (shape.type) {
    case "box":
      return half(a / 2, b / 2, c / 2);
    case "sphere":
      return half(a, a, a);
    case "cylinder":
      return half(a, a, b / 2);
    case "capsule":
      return half(a, a, b / 2 + a);
    case "plane":
      return half(0, 0, 0);
    case "mesh": {
      const mesh = scene.meshes[shape.mesh ?? -1];
      if (!mesh || mesh.positions.length < 3) return half(0, 0, 0);
      let known = meshBounds.get(mesh);
      if (!known) {
        const low: Vec3 = [Infinity, Infinity, Infinity];
        const high: Vec3 = [-Infinity, -Infinity, -Infinity];
        mesh.positions.forEach((v, i) => {
          const k = (i % 3) as 0 | 1 | 2;
          low[k] = Math.min(low[k], v);
          high[k] = Math.max(high[k], v);
        });
        meshBounds.set(mesh, (known = { low, high }));
      }
      return known;
    }
    case "heightmap": {
      const map = scene.heightmaps[shape.heightmap ?? -1];
      if (!map || map.heights.length === 0) return half(0, 0, 0);
      let known = meshBounds.get(map);
      if (!known) {
        const low = map.heights.reduce((x, y) => Math.min(x, y), Infinity);
        const high = map.heights.reduce((x, y) => Math.max(x, y), -Infinity);
        known = { low: [-map.size[0] / 2, -map.size[1] / 2, low], high: [map.size[0] / 2, map.size[1] / 2, high] };
        meshBounds.set(map, known);
      }
      return known;
    }
  }
}

/** Of the visible shapes but planes of the bodies named by index (all without), at the poses of a frame; null: nothing. */
export function visibleBounds(scene: Scene, poses: ArrayLike<number>, bodies?: Iterable<number>): Bounds | null {
  let all: Bounds | null = null;
  for (const i of bodies ?? scene.bodies.keys()) {
    const body = scene.bodies[i];
    if (!body || body.removed) continue;
    const pose: Pose = 7 * i + 6 < poses.length ? poseAt(poses, i) : body.pose;
    if (!isFinite(pose)) continue;
    for (const shape of body.shapes) {
      if (!shape.visual || shape.type === "plane") continue;
      const here = compose(pose, shape.pose);
      for (const corner of cornersOf(shapeBounds(scene, shape))) {
        const p = transform(here, corner);
        const point = { low: p, high: p };
        all = all ? joined(all, point) : point;
      }
    }
  }
  return all;
}

/** Height of the scene's horizontal floor [m]: of several the lowest; null: there is none. */
export function floorOf(scene: Scene): number | null {
  const heights = scene.bodies.flatMap((body) =>
    body.removed || body.kind !== "fixed"
      ? []
      : body.shapes.flatMap((shape) => {
          const pose = compose(body.pose, shape.pose);
          return shape.visual && shape.type === "plane" && rotate(pose, [0, 0, 1])[2] > 0.999 ? [pose[2]] : [];
        }),
  );
  return heights.length > 0 ? Math.min(...heights) : null;
}
