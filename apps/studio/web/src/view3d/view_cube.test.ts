import assert from "node:assert/strict";
import { test } from "node:test";
import { patchesOf, pictureAxes } from "./view_cube";

test("the picture's axes are those of the camera's rotation", () => {
  // turned by 90 degrees around z: right is y, up z is up the picture only after a turn around x
  const h = Math.SQRT1_2;
  const [right, up, back] = pictureAxes({ x: 0, y: 0, z: h, w: h });
  const near = (a: number[], b: number[]) => a.forEach((v, i) => assert.ok(Math.abs(v - b[i]!) < 1e-12, `${a} ${b}`));
  near(right, [0, 1, 0]);
  near(up, [-1, 0, 0]);
  near(back, [0, 0, 1]);
});

test("a face has its middle, four edges and four corners, each with where it looks from", () => {
  const patches = patchesOf([1, 0, 0]);
  assert.equal(patches.length, 9);
  const kinds = patches.map((p) => p.from.filter((v) => v !== 0).length).sort();
  assert.deepEqual(kinds, [1, 2, 2, 2, 2, 3, 3, 3, 3]);
  for (const { from, corners } of patches) {
    assert.equal(from[0], 1);
    for (const c of corners) assert.equal(c[0], 1);
    // a patch lies on the side from which it looks
    const middle = [1, 2].map((k) => corners.reduce((s, c) => s + c[k]! / 4, 0));
    [from[1], from[2]].forEach((v, k) => assert.equal(Math.sign(Math.round(middle[k]! * 10)), Math.sign(v)));
  }
});
