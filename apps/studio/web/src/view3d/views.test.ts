import assert from "node:assert/strict";
import { test } from "node:test";
import type { Vec3 } from "../core/protocol";
import { cornersOf, middleOf, type Bounds } from "./bounds";
import { rotate } from "./pose";
import { axesOf, cameraPose, directionOf, distanceFor, horizontalFov, verticalFov, kViews } from "./views";

// An eye that looks straight down is 1e-4 aside; everything else is a few operations on doubles.
const kAside = 2e-4;
const dot = (a: Vec3, b: Vec3) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const near = (a: Vec3, b: Vec3, tolerance: number) =>
  a.forEach((v, i) => assert.ok(Math.abs(v - b[i]!) <= tolerance, `${a} and ${b}`));

test("views look where the command line's do, and have the same side up", () => {
  const expected: Record<string, [forward: Vec3, up: Vec3]> = {
    front: [
      [-1, 0, 0],
      [0, 0, 1],
    ],
    back: [
      [1, 0, 0],
      [0, 0, 1],
    ],
    left: [
      [0, -1, 0],
      [0, 0, 1],
    ],
    right: [
      [0, 1, 0],
      [0, 0, 1],
    ],
    top: [
      [0, 0, -1],
      [0, 1, 0],
    ],
    bottom: [
      [0, 0, 1],
      [0, 1, 0],
    ],
  };
  for (const [view, [forward, up]] of Object.entries(expected)) {
    const [f, , u] = axesOf(directionOf(view as "front"));
    near(f, forward, kAside);
    near(u, up, kAside);
  }
  const n = Math.hypot(1, 0.7, 0.8);
  near(axesOf(directionOf("iso"))[0], [-1 / n, -0.7 / n, -0.8 / n], 1e-12);
});

test("all of the bounds is seen, and not from farther than needed", () => {
  const bounds: Bounds = { low: [-1, 0, 2], high: [3, 0.5, 2.2] };
  const middle = middleOf(bounds);
  for (const view of kViews) {
    for (const aspect of [0.5, 1, 2.5]) {
      const direction = directionOf(view);
      const d = distanceFor(bounds, direction, aspect);
      const [f, l, u] = axesOf(direction);
      let fullest = 0;
      for (const corner of cornersOf(bounds)) {
        const p = corner.map((v, i) => v - middle[i]! - d * direction[i]!) as Vec3;
        const x = Math.abs(dot(p, l) / dot(p, f)) / Math.tan(horizontalFov(aspect) / 2);
        const y = Math.abs(dot(p, u) / dot(p, f)) / Math.tan(verticalFov(aspect) / 2);
        fullest = Math.max(fullest, x, y);
      }
      // the margin of 5 % is what is left at the tightest corner
      assert.ok(Math.abs(fullest - 1 / 1.05) < 1e-9, `${view} ${aspect}: ${fullest}`);
    }
  }
});

test("the server's camera looks along its x at the target, z up", () => {
  for (const eye of [
    [3, 1, 2],
    [-3, 1, -2],
    [0, -4, 1],
    [-5, 1e-3, 0],
    [1e-4, 0, 3],
  ] as Vec3[]) {
    const target: Vec3 = [0.5, 0.25, 0];
    const pose = cameraPose(eye, target);
    const n = Math.hypot(...eye.map((v, i) => v - target[i]!));
    near(rotate(pose, [1, 0, 0]), eye.map((v, i) => (target[i]! - v) / n) as Vec3, 1e-12);
    assert.ok(Math.abs(rotate(pose, [0, 1, 0])[2]) < 1e-12, "level");
    assert.ok(rotate(pose, [0, 0, 1])[2] > 0, "upright");
  }
});
