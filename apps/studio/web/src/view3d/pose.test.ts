import assert from "node:assert/strict";
import { test } from "node:test";
import type { Pose } from "../core/protocol";
import { carried, compose, inverse, writeMatrix, rotate, rotationOf, scaledMatrix, tidy, transform } from "./pose";

// Sums of a few dozen products of numbers of size 10 at most: doubles keep 1e-14 of them.
const kExact = 1e-13;
// The same in floats.
const kFloat = 1e-5;

const near = (a: ArrayLike<number>, b: ArrayLike<number>, tolerance = kExact) => {
  assert.equal(a.length, b.length);
  for (let i = 0; i < a.length; i++) assert.ok(Math.abs(a[i]! - b[i]!) <= tolerance, `${i}: ${a[i]} and ${b[i]}`);
};
const turned = (axis: [number, number, number], angle: number, at: [number, number, number]): Pose => {
  const n = Math.hypot(...axis);
  const s = Math.sin(angle / 2) / n;
  return [...at, Math.cos(angle / 2), s * axis[0], s * axis[1], s * axis[2]];
};
const poseA = turned([1, 2, 3], 0.7, [0.1, -2, 3]);
const poseB = turned([-2, 0.5, 1], -1.9, [5, 0.3, -0.2]);
const poseC = turned([0, 1, 0], 2.5, [-1, 1, 4]);

test("a quarter turn about z takes x to y", () => {
  near(rotate(turned([0, 0, 1], Math.PI / 2, [9, 9, 9]), [1, 0, 0]), [0, 1, 0]);
});

test("poses one after the other move a point as each in its turn", () => {
  const p = [0.3, -0.4, 1.2];
  near(transform(compose(poseA, poseB), p), transform(poseA, transform(poseB, p)));
  near(transform(compose(poseA, compose(poseB, poseC)), p), transform(compose(compose(poseA, poseB), poseC), p));
});

test("a pose and its inverse leave a point where it is", () => {
  near(transform(inverse(poseA), transform(poseA, [1, 2, 3])), [1, 2, 3]);
  near(transform(poseA, transform(inverse(poseA), [1, 2, 3])), [1, 2, 3]);
});

test("a quaternion that is not of unit length turns without scaling", () => {
  const long: Pose = [0, 0, 0, 2 * poseA[3], 2 * poseA[4], 2 * poseA[5], 2 * poseA[6]];
  near(rotationOf(long), rotationOf(poseA));
});

test("a rigid group is carried along by any of its bodies", () => {
  // body B in the world stands at C in the group's frame A; then all moves by the same motion
  const body = compose(poseA, poseC);
  const motion = poseB;
  near(carried(poseA, body, compose(motion, body)), compose(motion, poseA), 1e-12);
});

test("matrices of instances are the body's pose times the shape's scaled pose", () => {
  const local = scaledMatrix(poseB, [2, 3, 0.5]);
  const out = new Float32Array(32);
  writeMatrix(out, 16, [0, 0, 0, 0, 0, 0, 0, ...poseA], 7, local);
  for (const p of [
    [0, 0, 0],
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, -1, 2],
  ]) {
    const [x, y, z] = p as [number, number, number];
    const byMatrix = [0, 1, 2].map((i) => out[16 + i]! * x + out[20 + i]! * y + out[24 + i]! * z + out[28 + i]!);
    near(byMatrix, transform(poseA, transform(poseB, [2 * x, 3 * y, 0.5 * z])), kFloat);
  }
  near(out.slice(0, 16), new Float32Array(16));
  assert.equal(out[31], 1);
});

test("what goes into a text is short and a unit quaternion", () => {
  const pose = tidy([1.00000000001, -2.123456789, 0, 2, 0, 0, 0]);
  near(pose, [1, -2.1234568, 0, 1, 0, 0, 0], 0);
});
