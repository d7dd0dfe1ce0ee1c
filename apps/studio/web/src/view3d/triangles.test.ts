import assert from "node:assert/strict";
import { test } from "node:test";
import type { Scene, SceneShape, Vec3 } from "../core/protocol";
import { textureUv } from "./texture_uv";
import { box, cylinder, gridFaces, rectangle, round, smooth, textured, trianglesOf, type Triangles } from "./triangles";

const at = (t: Triangles, i: number): Vec3 => [t.positions[3 * i]!, t.positions[3 * i + 1]!, t.positions[3 * i + 2]!];
/** Volume by the divergence theorem: positive when all triangles turn outwards. */
function volume(t: Triangles): number {
  let sum = 0;
  for (let i = 0; i < t.indices.length; i += 3) {
    const [a, b, c] = [at(t, t.indices[i]!), at(t, t.indices[i + 1]!), at(t, t.indices[i + 2]!)];
    sum += a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
  }
  return sum / 6;
}
/** Every triangle's own normal is on the side of its corners' normals. */
function outward(t: Triangles): void {
  for (let i = 0; i < t.indices.length; i += 3) {
    const [a, b, c] = [at(t, t.indices[i]!), at(t, t.indices[i + 1]!), at(t, t.indices[i + 2]!)];
    const u = b.map((v, k) => v - a[k]!) as Vec3;
    const v = c.map((w, k) => w - a[k]!) as Vec3;
    const n: Vec3 = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    for (let k = 0; k < 3; k++) {
      const j = 3 * t.indices[i + k]!;
      const side = n[0] * t.normals[j]! + n[1] * t.normals[j + 1]! + n[2] * t.normals[j + 2]!;
      assert.ok(side >= -1e-12, `triangle ${i / 3}`);
    }
  }
}

test("shapes are closed, turn outwards and hold what they should", () => {
  assert.ok(Math.abs(volume(box([1, 2, 3])) - 6) < 1e-12);
  // the polygon has the circle's area: a cylinder's volume is exact
  assert.ok(Math.abs(volume(cylinder(0.5, 1, 48)) - Math.PI * 0.25 * 2) < 1e-12);
  // chords of latitude lose less than (pi / 48)^2 of a ball, 0.43 %
  const ball = (4 / 3) * Math.PI * 0.125;
  assert.ok(Math.abs(volume(round(0.5, 0, 48)) - ball) < 0.0043 * ball);
  const capsule = ball + Math.PI * 0.25 * 0.8;
  assert.ok(Math.abs(volume(round(0.5, 0.4, 48)) - capsule) < 0.0043 * capsule);
  for (const t of [box([1, 2, 3]), cylinder(0.5, 1, 20), round(1, 0, 20), round(1, 0.5, 20), rectangle(2, 3)])
    outward(t);
});

test("a heightmap's cells share the diagonal from their lowest corner and look up", () => {
  const { positions, indices } = gridFaces({ rows: 2, columns: 3, size: [4, 2, 0], heights: [0, 1, 2, 3, 4, 5] });
  assert.deepEqual(positions.slice(0, 6), [-2, -1, 0, 0, -1, 1]);
  assert.deepEqual(indices.slice(0, 6), [0, 1, 4, 0, 4, 3]);
  outward(smooth(positions, indices));
});

test("normals are smooth over gentle folds and sharp over steep ones", () => {
  const roof = (h: number) =>
    smooth([0, 0, 0, 1, 0, h, 1, 1, h, 0, 1, 0, 2, 0, 0, 2, 1, 0], [0, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2]);
  // the ridge: second corner of the first triangle
  const gentle = roof(0.1).normals.slice(3, 6);
  assert.ok(Math.abs(gentle[0]!) < 0.06 && gentle[2]! > 0.99);
  const steep = roof(1).normals.slice(3, 6);
  assert.ok(Math.abs(steep[0]! + Math.SQRT1_2) < 1e-12);
});

const shape = (type: string, size: number[], tile: [number, number] = [0, 0]) =>
  ({
    type,
    size,
    tile,
    pose: [0, 0, 0, 1, 0, 0, 0],
    mesh: 0,
    color: [1, 1, 1, 1],
    texture: "0",
    visual: true,
  }) as unknown as SceneShape;
const none = { meshes: [], heightmaps: [] } as unknown as Scene;

test("textures lie as the SDK's table says", () => {
  const uv = (s: SceneShape, p: Vec3, n: Vec3) => textureUv(none, s, p, n).map((v) => +v.toFixed(9));
  const crate = shape("box", [2, 4, 6]);
  assert.deepEqual(uv(crate, [1, 2, 3], [1, 0, 0]), [1, 1]);
  assert.deepEqual(uv(crate, [-1, 2, 3], [-1, 0, 0]), [0, 1]);
  assert.deepEqual(uv(crate, [1, 2, 3], [0, 1, 0]), [0, 1]);
  assert.deepEqual(uv(crate, [1, 2, -3], [0, 0, -1]), [1, 0]);
  assert.deepEqual(uv(shape("box", [2, 4, 6], [0.5, 2]), [0.5, 1, 3], [0, 0, 1]), [1, 0.5]);
  assert.deepEqual(uv(shape("sphere", [2]), [0, 2, 0], [0, 1, 0]), [0.75, 0.5]);
  assert.deepEqual(uv(shape("cylinder", [1, 4]), [1, 0, 2], [1, 0, 0]), [0.5, 1]);
  assert.deepEqual(uv(shape("cylinder", [1, 4]), [1, 0, 2], [0, 0, 1]), [1, 0.5]);
  assert.deepEqual(uv(shape("cylinder", [1, 4], [1, 2]), [1, 0, -2], [1, 0, 0]), [0.5, 0]);
  // at the tip of a capsule: half the straight part and a quarter of the circle from the middle
  assert.deepEqual(uv(shape("capsule", [1, 2], [1, 1]), [0, 0, 2], [0, 0, 1])[1], +(2 + Math.PI / 2).toFixed(9));
  assert.deepEqual(uv(shape("plane", [9, 9], [2, 4]), [1, 1, 0], [0, 0, 1]), [0.5, 0.25]);
});

test("a mesh with coordinates of its own keeps them, corner by corner", () => {
  const scene = {
    meshes: [{ positions: [0, 0, 0, 1, 0, 0, 0, 1, 0], indices: [0, 1, 2], uv: [0.1, 0.2, 0.3, 0.4, 0.5, 0.6] }],
    heightmaps: [],
  } as unknown as Scene;
  const s = shape("mesh", []);
  assert.deepEqual(textured(scene, s, trianglesOf(scene, s, 8)).uvs, [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]);
});

test("around a seam no triangle has coordinates that go back", () => {
  const s = shape("cylinder", [1, 2]);
  const t = textured(none, s, trianglesOf(none, s, 24));
  for (let i = 0; i < t.indices.length; i += 3) {
    const u = [0, 1, 2].map((k) => t.uvs![2 * (i + k)]!);
    const normal = t.normals[3 * i + 2]!;
    if (Math.abs(normal) < 0.5) assert.ok(Math.max(...u) - Math.min(...u) < 2 / 24, `triangle ${i / 3}`);
  }
});
