import assert from "node:assert/strict";
import { test } from "node:test";
import type { Scene, Vec3 } from "../core/protocol";
import type { Dots, Lines } from "./lines";
import { arc, centreOf, drawSelected, massText } from "./selected";

const kHere = [0, 0, 0, 1, 0, 0, 0];
const body = (element: number, mass: number, x: number) => ({
  name: `b${element}`,
  kind: "dynamic",
  pose: [x, 0, 0, 1, 0, 0, 0],
  mass,
  com: [0, 0, 0],
  assembly: -1,
  element,
  shapes: [{ visual: true, type: "box", size: [1, 1, 1], pose: kHere, color: [1, 1, 1, 1] }],
});
const scene = {
  bodies: [body(1, 1, 0), body(2, 3, 4)],
  assemblies: [],
  joints: [
    { type: "hinge", parent: 0, child: 1, parent_pose: kHere, child_pose: kHere, limits: [[-1, 0.5]], element: 3 },
    { type: "slider", parent: -1, child: 0, parent_pose: kHere, child_pose: kHere, limits: [[-0.2, 0.7]], element: 4 },
  ],
  motors: [{ joint: 0, element: 5 }],
  sensors: [
    { type: "infrared", body: 0, pose: kHere, rays: [[0, 0, 0, 1, 0, 0, 2.5]], element: 6 },
    {
      type: "camera",
      body: 0,
      pose: kHere,
      rays: [1, -1].flatMap((y) =>
        [1, -1].map((z) => [0, 0, 0, 1 / Math.sqrt(1.5), (y * 0.5) / Math.sqrt(1.5), (z * 0.5) / Math.sqrt(1.5), 0]),
      ),
      element: 7,
    },
  ],
} as unknown as Scene;
const poses = Float32Array.from([...scene.bodies[0]!.pose, ...scene.bodies[1]!.pose]);

/** Ends of all lines that are drawn for an element. */
function drawn(element: number): { ends: number[][]; points: number[][] } {
  const ends: number[][] = [];
  const points: number[][] = [];
  const lines = {
    add: (a: ArrayLike<number>, b: ArrayLike<number>) =>
      ends.push([...Array.from(a).slice(0, 3)], [...Array.from(b).slice(0, 3)]),
  };
  const dots = { add: (p: ArrayLike<number>) => points.push(Array.from(p).slice(0, 3)) };
  drawSelected({ lines: lines as unknown as Lines, dots: dots as unknown as Dots }, scene, poses, [element], 10);
  return { ends, points };
}
const has = (all: number[][], want: Vec3) =>
  assert.ok(
    all.some((p) => p.every((v, i) => Math.abs(v - want[i]!) < 1e-5)),
    `${want.join()} is not among ${all.map((p) => p.map((v) => v.toFixed(2)).join()).join(" ")}`,
  );

test("an arc begins and ends at its angles", () => {
  const points = arc([0, 0, 0], [0, 0, 1], [1, 0, 0], 2, 0, Math.PI / 2);
  has([points[0]!], [2, 0, 0]);
  has([points.at(-1)!], [0, 2, 0]);
});

test("a hinge shows its axis and both ends of its range, and its motor the same", () => {
  for (const element of [3, 5]) {
    const { ends } = drawn(element);
    // half the diagonal of the child is its size
    const size = Math.sqrt(3) / 2;
    has(ends, [0, 0, 0.6 * size]);
    has(ends, [0.45 * size * Math.cos(-1), 0.45 * size * Math.sin(-1), 0]);
    has(ends, [0.45 * size * Math.cos(0.5), 0.45 * size * Math.sin(0.5), 0]);
  }
});

test("a slider shows its way, a beam its range, a camera its frustum", () => {
  has(drawn(4).ends, [0, 0, -0.2]);
  has(drawn(4).ends, [0, 0, 0.7]);
  has(drawn(6).ends, [2.5, 0, 0]);
  // a fifth of the scene's size ahead
  for (const y of [-1, 1]) for (const z of [-1, 1]) has(drawn(7).ends, [2, y, z]);
});

test("a body shows its frame and its mass", () => {
  const { ends, points } = drawn(2);
  has(points, [4, 0, 0]);
  has(ends, [4 + (0.7 * Math.sqrt(3)) / 2, 0, 0]);
  assert.equal(massText(scene, [1]), "b2: 3 kg");
  assert.equal(massText(scene, [0, 1]), "2 bodies: 4 kg");
  assert.equal(massText(scene, []), "");
  assert.deepEqual(
    centreOf(scene, (i) => scene.bodies[i]!.pose, [0, 1]),
    [3, 0, 0],
  );
  assert.equal(drawn(99).ends.length, 0);
});
