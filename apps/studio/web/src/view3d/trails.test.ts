import assert from "node:assert/strict";
import { test } from "node:test";
import type { Frame } from "../core/frame";
import type { Paths, Scene } from "../core/protocol";
import { dashes, Trails } from "./trails";

const body = (name: string) => ({ name, removed: false });
const scene = { bodies: [body("floor"), body("r.base")] } as unknown as Scene;
const frame = (time: number, x: number): Frame =>
  ({ time, live: true, poses: Float32Array.from({ length: 14 }, (_, i) => (i % 7 === 0 ? x : 0)) }) as unknown as Frame;
const answer = (revision: number, from: number, times: number[], until: number): Paths => ({
  revision,
  until,
  paths: [{ label: "r", body: "r.base", from, times, points: times.flatMap((t) => [t, 0, 0]), last: [until, 0, 0] }],
});
const xOf = (line: number[]): number[] => line.filter((_, i) => i % 3 === 0);

test("new points go behind the known ones; another revision replaces them", () => {
  const trails = new Trails();
  trails.adopt(scene);
  assert.deepEqual(trails.known, { revision: 0, counts: [] });
  trails.take(answer(4, 0, [0, 1], 2));
  assert.deepEqual(trails.known, { revision: 4, counts: [2] });
  trails.take(answer(4, 2, [3], 5));
  assert.deepEqual(trails.all[0]!.times, [0, 1, 3]);
  trails.take(answer(5, 0, [0], 0.5));
  assert.deepEqual(trails.known, { revision: 5, counts: [1] });
  assert.deepEqual(trails.all[0]!.points, [0, 0, 0]);
});

test("a path goes to where the body is, and never farther than is known", () => {
  const trails = new Trails();
  trails.adopt(scene);
  trails.take(answer(1, 0, [0, 1, 3], 5));
  const line = (time: number, x: number) => xOf(trails.line(trails.all[0]!, frame(time, x)));
  assert.deepEqual(line(0, 0), [0, 0]);
  assert.deepEqual(line(2, 2), [0, 1, 2]);
  assert.deepEqual(line(4, 4), [0, 1, 3, 4]);
  // A frame that is newer than the path: no line to where nothing is known of the path.
  assert.deepEqual(line(9, 90), [0, 1, 3, 5]);
});

test("a scene that changed finds the bodies by name", () => {
  const trails = new Trails();
  trails.adopt(scene);
  trails.take(answer(1, 0, [0], 5));
  assert.equal(trails.all[0]!.body, 1);
  trails.adopt({ bodies: [body("r.base"), body("floor")] } as unknown as Scene);
  assert.equal(trails.all[0]!.body, 0);
  trails.adopt({ bodies: [body("floor")] } as unknown as Scene);
  assert.equal(trails.all[0]!.body, -1);
  assert.deepEqual(xOf(trails.line(trails.all[0]!, frame(2, 7))), [0]);
});

test("dashes are as long as asked and lie on the line, across its corners", () => {
  // 1 m along x, then 1 m along y; dash and gap 0.3 m: 0 to 0.3, 0.6 to 0.9, 1.2 to 1.5, 1.8 to 2
  const drawn = dashes([0, 0, 0, 1, 0, 0, 1, 1, 0], 3, 0.3);
  const expected = [0, 0, 0, 0.3, 0, 0, 0.6, 0, 0, 0.9, 0, 0, 1, 0.2, 0, 1, 0.5, 0, 1, 0.8, 0, 1, 1, 0];
  assert.equal(drawn.length, expected.length);
  drawn.forEach((v, i) => assert.ok(Math.abs(v - expected[i]!) < 1e-12));
});
