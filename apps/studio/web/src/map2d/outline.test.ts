import assert from "node:assert/strict";
import { test } from "node:test";
import type { Pose, Scene, SceneShape, Vec3 } from "../core/protocol";
import { rotate } from "../view3d/pose";
import { convexHull, level, planOutline, upwardExtent, turnOf, upIn, type Polygon } from "./outline";
import { lengthText, roundLength, Sheet } from "./sheet";

const scene = {
  meshes: [{ positions: [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1], indices: [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3] }],
  heightmaps: [{ rows: 2, columns: 2, size: [2, 3, 0], heights: [0, 0.1, 0.2, 0.3] }],
} as unknown as Scene;
const shape = (type: string, size: number[]) => ({ type, size, mesh: 0, heightmap: 0 }) as unknown as SceneShape;
const turned = (axis: Vec3, angle: number): Pose => {
  const s = Math.sin(angle / 2) / Math.hypot(...axis);
  return [0, 0, 0, Math.cos(angle / 2), s * axis[0], s * axis[1], s * axis[2]];
};
const area = (p: Polygon): number =>
  p.reduce((sum, [x, y], i) => {
    const [u, v] = p[(i + 1) % p.length]!;
    return sum + (x * v - u * y) / 2;
  }, 0);

test("a pose is its tilt and then a turn about the vertical", () => {
  for (const [axis, angle] of [
    [[0, 0, 1], 2],
    [[1, 2, 3], 1.1],
    [[1, 0, 0], Math.PI],
    [[1, -1, 0.2], 3],
    [[0, 1, 0], 1e-9],
  ] as [Vec3, number][]) {
    const pose = turned(axis, angle);
    const tilt = level(upIn(pose));
    const turn = turnOf(pose, tilt);
    for (const v of [
      [1, 0, 0],
      [0, 1, 0],
      [0.3, -0.2, 0.9],
    ] as Vec3[]) {
      const x = tilt[0] * v[0] + tilt[1] * v[1] + tilt[2] * v[2];
      const y = tilt[3] * v[0] + tilt[4] * v[1] + tilt[5] * v[2];
      const expected = rotate(pose, v);
      const got = [Math.cos(turn) * x - Math.sin(turn) * y, Math.sin(turn) * x + Math.cos(turn) * y];
      assert.ok(Math.hypot(got[0]! - expected[0], got[1]! - expected[1]) < 1e-9, `${axis} ${angle}`);
    }
  }
});

test("outlines have the area of the shadow", () => {
  const outline = (s: SceneShape, pose: Pose) => planOutline(scene, s, level(upIn(pose)));
  const flat = turned([0, 0, 1], 0.3);
  // polygons with 102 corners on a circle lack 2/3 (pi / 102)^2 of its area, 0.063 %
  const round = 7e-4;
  assert.ok(Math.abs(area(outline(shape("box", [1, 2, 3]), flat)[0]!) - 2) < 1e-12);
  // a face of 1 x 3 seen when lying on its side
  assert.ok(Math.abs(area(outline(shape("box", [1, 2, 3]), turned([1, 0, 0], Math.PI / 2))[0]!) - 3) < 1e-12);
  // of a box: the sum of its faces' shadows
  const tilted = turned([1, 2, 0], 0.8);
  const up = upIn(tilted).map(Math.abs) as Vec3;
  const expected = up[0] * 6 + up[1] * 3 + up[2] * 2;
  assert.ok(Math.abs(area(outline(shape("box", [1, 2, 3]), tilted)[0]!) - expected) < 1e-9);
  assert.ok(Math.abs(area(outline(shape("sphere", [2]), tilted)[0]!) / (4 * Math.PI) - 1) < round);
  const lying = turned([1, 0, 0], Math.PI / 2);
  assert.ok(Math.abs(area(outline(shape("cylinder", [0.5, 2]), lying)[0]!) - 2) < 2 * round);
  assert.ok(Math.abs(area(outline(shape("cylinder", [0.5, 2]), flat)[0]!) / (Math.PI / 4) - 1) < round);
  const pill = 2 + Math.PI / 4;
  assert.ok(Math.abs(area(outline(shape("capsule", [0.5, 2]), lying)[0]!) / pill - 1) < round);
  assert.ok(Math.abs(area(outline(shape("heightmap", []), flat)[0]!) - 6) < 1e-12);
  assert.deepEqual(outline(shape("plane", [1, 1]), flat), []);
  // triangles of a mesh all turn in the same direction, those on edge are left out
  const triangles = outline(shape("mesh", []), flat);
  assert.equal(triangles.length, 2);
  for (const t of triangles) assert.ok(area(t) > 0);
});

test("a hull leaves out what is inside, twice there or on an edge", () => {
  const hull = convexHull([
    [0, 0],
    [1, 0],
    [1, 1],
    [0, 1],
    [0.5, 0.5],
    [1, 1],
    [0.5, 0],
  ]);
  assert.equal(hull.length, 4);
  assert.equal(area(hull), 1);
});

test("things lie over each other by their highest point", () => {
  const up: Vec3 = [0, Math.sin(0.3), Math.cos(0.3)];
  assert.ok(Math.abs(upwardExtent(scene, shape("box", [1, 2, 3]), up) - (Math.sin(0.3) + 1.5 * Math.cos(0.3))) < 1e-12);
  assert.ok(
    Math.abs(upwardExtent(scene, shape("cylinder", [0.5, 2]), up) - (0.5 * Math.sin(0.3) + Math.cos(0.3))) < 1e-12,
  );
  assert.equal(upwardExtent(scene, shape("capsule", [0.5, 2]), [0, 0, -1]), 1.5);
  assert.equal(upwardExtent(scene, shape("mesh", []), [0, 0, 1]), 1);
  assert.equal(upwardExtent(scene, shape("plane", []), [0, 0, 1]), -Infinity);
});

test("the sheet: a position and its pixel, zooming keeps what is under the pointer", () => {
  const sheet = new Sheet();
  sheet.width = 400;
  sheet.height = 200;
  sheet.fit([-1, -1], [3, 1]);
  assert.deepEqual([sheet.column(1), sheet.row(0)], [200, 100]);
  assert.ok(Math.abs(sheet.scale - 400 / 4.4) < 1e-9, "the width decides here");
  assert.ok(sheet.row(1) < sheet.row(-1), "y is up");
  const before = sheet.position(37, 150);
  sheet.zoom(1.7, 37, 150);
  const after = sheet.position(37, 150);
  assert.ok(Math.hypot(before[0] - after[0], before[1] - after[1]) < 1e-12);
  sheet.pan(10, -20);
  const panned = sheet.position(47, 130);
  assert.ok(Math.hypot(before[0] - panned[0], before[1] - panned[1]) < 1e-12);
});

test("lengths of grids and bars are round", () => {
  assert.deepEqual([0.9, 1, 1.99, 2, 4.9, 5, 12, 0.03].map(roundLength), [0.5, 1, 1, 2, 2, 5, 10, 0.02]);
  assert.deepEqual([10, 0.5, 0.02, 0.005].map(lengthText), ["10 m", "50 cm", "2 cm", "5 mm"]);
});
