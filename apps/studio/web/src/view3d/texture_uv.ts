// How a texture lies on a shape: the rule of the SDK (cogrsim/model/surface.h), which all pictures follow.
// u to the right, v upwards on the surface seen from outside; the picture repeats beyond 0 to 1.
import type { Scene, SceneShape, Vec3 } from "../core/protocol";

type Uv = [number, number];

/** Extent of one copy of the picture on the surface [m]; null: one copy over the whole face. */
type Tile = Uv | null;

function tileOf(shape: SceneShape): Tile {
  const [u, v] = shape.tile ?? [0, 0];
  return u > 0 && v > 0 ? [u, v] : null;
}

/** The point and the extents along u and v of the face that the normal's largest component picks. */
function onFace(p: Vec3, normal: Vec3, extents: Vec3): { at: Uv; extent: Uv } {
  const [x, y, z] = normal.map(Math.abs) as Vec3;
  if (z >= x && z >= y) return { at: [p[0], normal[2] < 0 ? -p[1] : p[1]], extent: [extents[0], extents[1]] };
  if (y >= x) return { at: [normal[1] < 0 ? p[0] : -p[0], p[2]], extent: [extents[0], extents[2]] };
  return { at: [normal[0] < 0 ? -p[1] : p[1], p[2]], extent: [extents[1], extents[2]] };
}

function laid({ at, extent }: { at: Uv; extent: Uv }, tile: Tile): Uv {
  return tile ? [at[0] / tile[0], at[1] / tile[1]] : [at[0] / extent[0] + 0.5, at[1] / extent[1] + 0.5];
}

function around(p: Vec3, radius: number, tile: Tile): number {
  const phi = Math.atan2(p[1], p[0]);
  return (tile ? (radius * phi) / tile[0] : phi / (2 * Math.PI)) + 0.5;
}

/** Height above the middle along a capsule's outline. */
function outline(z: number, radius: number, half: number): number {
  const beyond = Math.abs(z) - half;
  if (beyond <= 0) return z;
  return Math.sign(z) * (half + radius * Math.asin(Math.min(beyond / radius, 1)));
}

/** (u, v) at a point of the surface, in the shape's frame, where the outward unit normal is `normal`. Of a mesh: of its
 *  flat triangle; coordinates that its file has are not known here. */
export function textureUv(scene: Scene, shape: SceneShape, p: Vec3, normal: Vec3): Uv {
  const tile = tileOf(shape);
  const [a = 1, b = 1, c = 1] = shape.size;
  switch (shape.type) {
    case "box":
      return laid(onFace(p, normal, [a, b, c]), tile);
    case "sphere": {
      const latitude = Math.asin(Math.max(-1, Math.min(1, p[2] / a)));
      return [around(p, a, tile), (tile ? (a * latitude) / tile[1] : latitude / Math.PI) + 0.5];
    }
    case "cylinder":
      if (Math.abs(normal[2]) * Math.SQRT2 >= 1) {
        return laid(onFace(p, [0, 0, normal[2]], [2 * a, 2 * a, 2 * a]), tile);
      }
      return [around(p, a, tile), tile ? (p[2] + b / 2) / tile[1] : p[2] / b + 0.5];
    case "capsule": {
      const s = outline(p[2], a, b / 2);
      return [around(p, a, tile), tile ? (s + b / 2) / tile[1] : s / b + 0.5];
    }
    case "plane":
      return [p[0] / (tile?.[0] ?? 1), p[1] / (tile?.[1] ?? 1)];
    case "heightmap": {
      const size = scene.heightmaps[shape.heightmap ?? -1]?.size ?? [1, 1, 1];
      return laid({ at: [p[0], p[1]], extent: [size[0], size[1]] }, tile);
    }
    case "mesh": {
      const { at } = onFace(p, normal, [1, 1, 1]);
      return [at[0] / (tile?.[0] ?? 1), at[1] / (tile?.[1] ?? 1)];
    }
  }
}
