import assert from "node:assert/strict";
import { test } from "node:test";
import type { Scene } from "../core/protocol";
import type { Bounds } from "./bounds";
import { followed, Framing } from "./framing";

/** Balls of 10 cm radius that may move. */
const balls = (count: number): Scene =>
  ({
    meshes: [],
    heightmaps: [],
    bodies: Array.from({ length: count }, () => ({
      kind: "dynamic",
      removed: false,
      pose: [0, 0, 0, 1, 0, 0, 0],
      shapes: [{ type: "sphere", size: [0.1], visual: true, pose: [0, 0, 0, 1, 0, 0, 0] }],
    })),
  }) as unknown as Scene;
const at = (...xs: number[]): number[] => xs.flatMap((x) => [x, 0, 0, 1, 0, 0, 0]);
const unit: Bounds = { low: [0, 0, 0], high: [1, 1, 1] };

test("what stays inside, and what rests at an edge, moves nothing", () => {
  const inside: Bounds = { low: [0.3, 0.3, 0.3], high: [0.5, 0.5, 0.5] };
  assert.deepEqual(followed(unit, inside, { low: [0.31, 0.3, 0.3], high: [0.51, 0.5, 0.5] }), unit);
  assert.deepEqual(followed(unit, unit, unit), unit);
});

test("the box goes along at its size, and grows only where it is too small", () => {
  const beside: Bounds = { low: [1.5, 0.2, 0.2], high: [1.7, 0.4, 0.4] };
  const along = followed(unit, beside, null);
  assert.ok(Math.abs(along.low[0] - 0.7) < 1e-12 && along.high[0] === 1.7);
  assert.deepEqual(followed(unit, { low: [-1, 0.2, 0.2], high: [2, 0.4, 0.4] }, null).low[0], -1);
});

test("a body that goes away at a steady speed is never left, and the view starts softly", () => {
  const scene = balls(1);
  const framing = new Framing();
  framing.adopt({ low: [-1, -1, -1], high: [1, 1, 1] });
  let last = 1;
  let fastest = 0;
  for (let i = 1; i <= 500; ++i) {
    const x = 0.02 * i;
    framing.follow(scene, at(x), 0.01 * i);
    const { low, high } = framing.shown!;
    assert.ok(high[0] >= x + 0.1 - 1e-9 && low[0] <= x - 0.1 + 1e-9);
    assert.ok(Math.abs(high[0] - low[0] - 2) < 1e-9);
    const step = high[0] - last;
    last = high[0];
    // from no movement to all of it within a fifth of the box: no jerk
    assert.ok(step - fastest < 0.2 * 0.02, `from ${fastest} to ${step} at ${x}`);
    fastest = Math.max(fastest, step);
  }
  assert.ok(Math.abs(fastest - 0.02) < 1e-3);
});

test("one of many that flies off is given up, a single one is not", () => {
  const framing = new Framing();
  framing.adopt({ low: [-1, -1, -1], high: [1, 1, 1] });
  framing.follow(balls(3), at(0, 0.5, 1000), 1);
  assert.ok(framing.shown!.high[0] < 20);
  const alone = new Framing();
  alone.adopt({ low: [-1, -1, -1], high: [1, 1, 1] });
  alone.follow(balls(1), at(1000), 1);
  assert.ok(alone.shown!.high[0] > 1000);
});

test("back at the start the view is that of the start", () => {
  const framing = new Framing();
  framing.adopt({ low: [-0.1, -0.1, -0.1], high: [0.1, 0.1, 0.1] });
  framing.follow(balls(1), at(7), 1);
  framing.follow(balls(1), at(0), 0);
  assert.ok(Math.abs(framing.shown!.high[0] - 0.1) < 1e-12);
});
