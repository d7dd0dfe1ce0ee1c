import assert from "node:assert/strict";
import { test } from "node:test";
import { springLine } from "./springs";

test("a spring winds about its line, a cable is straight", () => {
  const line = springLine([0, 0, 0], [0, 0, 2], 0.1, false);
  assert.deepEqual(line[0], [0, 0, 0]);
  assert.deepEqual(line[line.length - 1], [0, 0, 2]);
  for (const p of line.slice(1, -1)) assert.ok(Math.abs(Math.hypot(p[0], p[1]) - 0.1) < 1e-12);
  for (let i = 1; i < line.length; i++) assert.ok(line[i]![2] > line[i - 1]![2]);
  assert.equal(springLine([0, 0, 0], [1, 0, 0], 0.1, true).length, 2);
  assert.equal(springLine([1, 1, 1], [1, 1, 1], 0.1, false).length, 2);
  // Every corner of a slanting one has the radius, too: the distance to the line.
  for (const p of springLine([0, 0, 0], [3, 4, 12], 0.1, false).slice(1, -1)) {
    const along = (3 * p[0] + 4 * p[1] + 12 * p[2]) / 13;
    assert.ok(Math.abs(Math.sqrt(p[0] ** 2 + p[1] ** 2 + p[2] ** 2 - along ** 2) - 0.1) < 1e-9);
  }
});
