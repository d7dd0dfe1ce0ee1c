import assert from "node:assert/strict";
import { test } from "node:test";
import type { Frame } from "../core/frame";
import type { Scene } from "../core/protocol";
import { rayEnds } from "./rays";

const scene = {
  sensors: [
    {
      name: "lidar",
      type: "lidar",
      body: 0,
      pose: [0, 0, 1, 1, 0, 0, 0],
      element: 0,
      rays: [
        [0, 0, 0, 1, 0, 0, 5],
        [0, 0, 0, 0, 1, 0, 5],
      ],
    },
    { name: "imu", type: "imu", body: 0, pose: [0, 0, 0, 1, 0, 0, 0], element: 1, rays: [] },
    {
      name: "cone",
      type: "infrared",
      body: -1,
      pose: [1, 0, 0, 1, 0, 0, 0],
      element: 2,
      rays: [
        [0, 0, 0, 0.96, 0.28, 0, 2],
        [0, 0, 0, 0.96, -0.28, 0, 2],
      ],
    },
  ],
} as unknown as Scene;
const h = Math.SQRT1_2;
const frame = (readings: unknown): Frame =>
  // the body stands at (2, 0, 0), turned by a quarter about z; its numbers are floats
  ({ poses: new Float32Array([2, 0, 0, h, 0, 0, h]), tail: { readings } }) as unknown as Frame;
const near = (a: number[], b: number[]) => a.forEach((v, i) => assert.ok(Math.abs(v - b[i]!) < 1e-6, `${a} and ${b}`));

test("rays end where readings say, in the world", () => {
  const rays = rayEnds(scene, frame([{ sensor: 0, values: [1.5, null] }]));
  assert.equal(rays.length, 2);
  near(rays[0]!.from, [2, 0, 1]);
  near(rays[0]!.to, [2, 1.5, 1]);
  assert.equal(rays[0]!.hit, true);
  near(rays[1]!.to, [-3, 0, 1]);
  assert.equal(rays[1]!.hit, false);
});

test("rays start where the sensor was when it measured", () => {
  const rays = rayEnds(scene, frame([{ sensor: 0, values: [1.5, null], pose: [1, 1, 1, 1, 0, 0, 0] }]));
  near(rays[0]!.from, [1, 1, 1]);
  near(rays[0]!.to, [2.5, 1, 1]);
});

test("a reading of the full range is a miss, one below zero ends at the sensor", () => {
  const rays = rayEnds(scene, frame([{ sensor: 0, values: [5, -0.1] }]));
  assert.deepEqual(
    rays.map((r) => r.hit),
    [false, true],
  );
  near(rays[1]!.to, rays[1]!.from);
});

test("a cone has one distance, drawn along its middle", () => {
  const rays = rayEnds(scene, frame([{ sensor: 2, values: [0.5] }]));
  assert.equal(rays.length, 1);
  near(rays[0]!.to, [1.5, 0, 0]);
});

test("sensors that measure no distance, and removed ones, have no rays", () => {
  assert.deepEqual(
    rayEnds(
      scene,
      frame([
        { sensor: 1, values: [1] },
        { sensor: 9, values: [1] },
        { sensor: 0, values: [] },
      ]),
    ),
    [],
  );
  assert.deepEqual(rayEnds(scene, { poses: new Float32Array(), tail: {} } as unknown as Frame), []);
});

test("where any ranging sensor asks to be seen, the others are not", () => {
  const some = { ...scene, sensors: scene.sensors.map((s, i) => ({ ...s, show: i === 2 })) } as Scene;
  assert.equal(
    rayEnds(
      some,
      frame([
        { sensor: 0, values: [1, 1] },
        { sensor: 2, values: [0.5] },
      ]),
    ).length,
    1,
  );
});
