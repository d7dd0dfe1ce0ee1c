// Shapes as triangles, as plain numbers.
import type { Scene, SceneShape, Vec3 } from "../core/protocol";
import { textureUv } from "./texture_uv";

export interface Triangles {
  /** x y z each [m] */
  positions: number[];
  /** outward, unit */
  normals: number[];
  /** counter-clockwise seen from outside */
  indices: number[];
  uvs?: number[];
}

const empty = (): Triangles => ({ positions: [], normals: [], indices: [] });

function add(out: Triangles, position: Vec3, normal: Vec3): number {
  out.positions.push(...position);
  out.normals.push(...normal);
  return out.positions.length / 3 - 1;
}

/** Radius of the regular polygon whose area is the unit circle's. */
function equalAreaRadius(segments: number): number {
  const angle = (2 * Math.PI) / segments;
  return Math.sqrt(angle / Math.sin(angle));
}

export function box(size: Vec3): Triangles {
  const out = empty();
  for (const axis of [0, 1, 2] as const) {
    for (const side of [-1, 1]) {
      const at = (u: number, v: number): Vec3 => {
        const p: Vec3 = [0, 0, 0];
        p[axis] = (side * size[axis]) / 2;
        p[((axis + 1) % 3) as 0 | 1 | 2] = (u * size[((axis + 1) % 3) as 0 | 1 | 2]) / 2;
        p[((axis + 2) % 3) as 0 | 1 | 2] = (side * v * size[((axis + 2) % 3) as 0 | 1 | 2]) / 2;
        return p;
      };
      const normal: Vec3 = [0, 0, 0];
      normal[axis] = side;
      const first = add(out, at(-1, -1), normal);
      add(out, at(1, -1), normal);
      add(out, at(1, 1), normal);
      add(out, at(-1, 1), normal);
      out.indices.push(first, first + 1, first + 2, first, first + 2, first + 3);
    }
  }
  return out;
}

/** A rectangle in z = 0 that looks to +z. */
export function rectangle(width: number, depth: number): Triangles {
  const x = width / 2;
  const y = depth / 2;
  return {
    positions: [-x, -y, 0, x, -y, 0, x, y, 0, -x, y, 0],
    normals: [0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1],
    indices: [0, 1, 2, 0, 2, 3],
  };
}

/** Two rows of `segments` + 1 vertices, the upper above the lower, counter-clockwise seen from +z. */
function strip(out: Triangles, lower: number, upper: number, segments: number): void {
  for (let i = 0; i < segments; i++) {
    out.indices.push(lower + i, lower + i + 1, upper + i + 1, lower + i, upper + i + 1, upper + i);
  }
}

/** A sphere, or with `half` > 0 [m] a capsule along z whose straight part is twice as long. */
export function round(radius: number, half: number, segments: number): Triangles {
  const out = empty();
  const wide = radius * equalAreaRadius(segments);
  const rows = Math.max(2, Math.ceil(segments / 4));
  let previous = -1;
  const row = (latitude: number, end: number) => {
    const angle = (Math.PI / 2) * (latitude / rows);
    let start = 0;
    for (let i = 0; i <= segments; i++) {
      const turn = 2 * Math.PI * (i / segments - 0.5);
      const n: Vec3 = [Math.cos(angle) * Math.cos(turn), Math.cos(angle) * Math.sin(turn), Math.sin(angle)];
      const index = add(out, [wide * n[0], wide * n[1], radius * n[2] + end], n);
      if (i === 0) start = index;
    }
    if (previous >= 0) strip(out, previous, start, segments);
    previous = start;
  };
  for (let i = -rows; i <= 0; i++) row(i, -half);
  for (let i = half > 0 ? 0 : 1; i <= rows; i++) row(i, half);
  return out;
}

export function cylinder(radius: number, half: number, segments: number): Triangles {
  const out = empty();
  const wide = radius * equalAreaRadius(segments);
  const ring = (z: number, normal?: Vec3): number => {
    let start = 0;
    for (let i = 0; i <= segments; i++) {
      const turn = 2 * Math.PI * (i / segments - 0.5);
      const side: Vec3 = [Math.cos(turn), Math.sin(turn), 0];
      const index = add(out, [wide * side[0], wide * side[1], z], normal ?? side);
      if (i === 0) start = index;
    }
    return start;
  };
  strip(out, ring(-half), ring(half), segments);
  for (const side of [-1, 1]) {
    const rim = ring(side * half, [0, 0, side]);
    for (let i = 1; i + 1 < segments; i++) {
      out.indices.push(rim, ...(side > 0 ? [rim + i, rim + i + 1] : [rim + i + 1, rim + i]));
    }
  }
  return out;
}

const kCrease = Math.cos((30 * Math.PI) / 180);

/** A vertex for each corner, its normal the mean over the faces around that lie within 30 degrees of this one, weighted
 *  by area; vertices at one position count as one. */
export function smooth(positions: ArrayLike<number>, indices: ArrayLike<number>): Triangles {
  const out = empty();
  const faces = Math.floor(indices.length / 3);
  const corners = new Map<string, number>();
  const cornerOf = new Int32Array(positions.length / 3);
  for (let i = 0; i < cornerOf.length; i++) {
    const key = `${positions[3 * i]} ${positions[3 * i + 1]} ${positions[3 * i + 2]}`;
    if (!corners.has(key)) corners.set(key, corners.size);
    cornerOf[i] = corners.get(key)!;
  }
  const around: number[][] = Array.from({ length: corners.size }, () => []);
  const vertex = (i: number): Vec3 => [positions[3 * i]!, positions[3 * i + 1]!, positions[3 * i + 2]!];
  const areas: Vec3[] = [];
  for (let f = 0; f < faces; f++) {
    const [a, b, c] = [vertex(indices[3 * f]!), vertex(indices[3 * f + 1]!), vertex(indices[3 * f + 2]!)];
    const u: Vec3 = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    const v: Vec3 = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
    areas.push([u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]);
    for (let k = 0; k < 3; k++) around[cornerOf[indices[3 * f + k]!]!]!.push(f);
  }
  const lengths = areas.map((n) => Math.hypot(...n));
  for (let f = 0; f < faces; f++) {
    const n = areas[f]!;
    const l = lengths[f]!;
    const own: Vec3 = l > 0 ? [n[0] / l, n[1] / l, n[2] / l] : [0, 0, 1];
    for (let k = 0; k < 3; k++) {
      const index = indices[3 * f + k]!;
      const sum: Vec3 = [0, 0, 0];
      for (const other of around[cornerOf[index]!]!) {
        const m = areas[other]!;
        if (m[0] * own[0] + m[1] * own[1] + m[2] * own[2] < kCrease * lengths[other]!) continue;
        for (const axis of [0, 1, 2] as const) sum[axis] += m[axis];
      }
      const s = Math.hypot(...sum);
      out.indices.push(add(out, vertex(index), s > 0 ? [sum[0] / s, sum[1] / s, sum[2] / s] : own));
    }
  }
  return out;
}

const kShadingJump = Math.cos((15 * Math.PI) / 180);

/** Pairs of vertices between which the surface has a visible edge: where shading jumps from one triangle to the next, and
 *  where a surface ends. */
export function edgesOf({ positions, normals, indices }: Triangles): number[] {
  const extent = positions.reduce((most, x) => Math.max(most, Math.abs(x)), 0);
  const cell = Math.max(1e-6 * extent, 1e-30);
  const places = new Map<string, number>();
  const placeOf = new Uint32Array(positions.length / 3);
  for (let i = 0; i < placeOf.length; i++) {
    const key = [0, 1, 2].map((k) => Math.round(positions[3 * i + k]! / cell) + 0).join(" ");
    if (!places.has(key)) places.set(key, places.size);
    placeOf[i] = places.get(key)!;
  }
  const differ = (a: number, b: number) =>
    normals[3 * a]! * normals[3 * b]! +
      normals[3 * a + 1]! * normals[3 * b + 1]! +
      normals[3 * a + 2]! * normals[3 * b + 2]! <
    kShadingJump;
  // by the two places: the vertices of the first triangle, and whether it is the only one, or shading jumps
  const edges = new Map<number, { a: number; b: number; seen: boolean }>();
  for (let i = 0; i + 2 < indices.length; i += 3) {
    for (let k = 0; k < 3; k++) {
      let a = indices[i + k]!;
      let b = indices[i + ((k + 1) % 3)]!;
      if (placeOf[a] === placeOf[b]) continue;
      if (placeOf[a]! > placeOf[b]!) [a, b] = [b, a];
      const key = placeOf[a]! * places.size + placeOf[b]!;
      const known = edges.get(key);
      if (!known) edges.set(key, { a, b, seen: true });
      else known.seen = differ(a, known.a) && differ(b, known.b);
    }
  }
  return [...edges.values()].flatMap(({ a, b, seen }) => (seen ? [a, b] : []));
}

/** Row 0 at the lowest y; every cell is two triangles that share the diagonal from its lowest x and y. */
export function gridFaces(map: Scene["heightmaps"][number]): { positions: number[]; indices: number[] } {
  const positions: number[] = [];
  const indices: number[] = [];
  for (let row = 0; row < map.rows; row++) {
    for (let column = 0; column < map.columns; column++) {
      positions.push(
        map.size[0] * (column / (map.columns - 1) - 0.5),
        map.size[1] * (row / (map.rows - 1) - 0.5),
        map.heights[row * map.columns + column] ?? 0,
      );
      if (row + 1 === map.rows || column + 1 === map.columns) continue;
      const i = row * map.columns + column;
      const above = i + map.columns;
      indices.push(i, i + 1, above + 1, i, above + 1, above);
    }
  }
  return { positions, indices };
}

/** A shape in its full size. `segments`: corners of round ones. */
export function trianglesOf(scene: Scene, shape: SceneShape, segments: number): Triangles {
  const [a = 0, b = 0, c = 0] = shape.size;
  switch (shape.type) {
    case "box":
      return box([a, b, c]);
    case "sphere":
      return round(a, 0, segments);
    case "cylinder":
      return cylinder(a, b / 2, segments);
    case "capsule":
      return round(a, b / 2, segments);
    case "plane":
      return rectangle(a, b);
    case "mesh": {
      const mesh = scene.meshes[shape.mesh ?? -1];
      return mesh ? smooth(mesh.positions, mesh.indices) : empty();
    }
    case "heightmap": {
      const map = scene.heightmaps[shape.heightmap ?? -1];
      if (!map || map.rows < 2 || map.columns < 2) return empty();
      const faces = gridFaces(map);
      return smooth(faces.positions, faces.indices);
    }
  }
}

/** The same with texture coordinates; every triangle has corners of its own, since coordinates jump at seams. */
export function textured(scene: Scene, shape: SceneShape, plain: Triangles): Triangles {
  const out: Triangles = { positions: [], normals: [], indices: [], uvs: [] };
  const at = (from: number[], i: number): Vec3 => [from[3 * i]!, from[3 * i + 1]!, from[3 * i + 2]!];
  const given = shape.type === "mesh" ? (scene.meshes[shape.mesh ?? -1]?.uv ?? []) : [];
  const own = given.length >= 2 * plain.indices.length ? given : null;
  for (let i = 0; i + 2 < plain.indices.length; i += 3) {
    const corners = plain.indices.slice(i, i + 3);
    const [a, b, c] = corners.map((k) => at(plain.positions, k)) as [Vec3, Vec3, Vec3];
    const middle: Vec3 = [(a[0] + b[0] + c[0]) / 3, (a[1] + b[1] + c[1]) / 3, (a[2] + b[2] + c[2]) / 3];
    const u: Vec3 = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    const v: Vec3 = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
    const flat: Vec3 = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    for (const [k, corner] of corners.entries()) {
      const p = at(plain.positions, corner);
      const n = at(plain.normals, corner);
      // a little inside the triangle, on its own side of any seam
      const inside = p.map((x, axis) => x + 1e-5 * (middle[axis]! - x)) as Vec3;
      out.indices.push(add(out, p, n));
      if (own) out.uvs!.push(own[2 * (i + k)]!, own[2 * (i + k) + 1]!);
      else out.uvs!.push(...textureUv(scene, shape, inside, shape.type === "mesh" ? flat : n));
    }
  }
  return out;
}
