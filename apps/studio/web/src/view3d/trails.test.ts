import assert from "node:assert/strict";
import { test } from "node:test";
import type { Frame, Scene } from "../core/protocol";
import { count_until, dashes, followed_bodies, Trails } from "./trails";

const body = (name: string, assembly = -1, kind = "dynamic") => ({ name, assembly, kind, removed: false });
const scene = {
  bodies: [body("floor", -1, "fixed"), body("r.base", 0), body("r.arm.tip", 1), body("ball")],
  assemblies: [
    { name: "r", parent: -1 },
    { name: "r.arm", parent: 0 },
  ],
  controllers: [],
} as unknown as Scene;
const frame = (time: number, x: number, live = true): Frame =>
  ({ time, live, poses: Float32Array.from({ length: 28 }, (_, i) => (i % 7 === 0 ? x : 0)) }) as unknown as Frame;

test("one trail for each top-level assembly and each lone body that moves", () => {
  assert.deepEqual(followed_bodies(scene), [
    { label: "r", body: 1 },
    { label: "ball", body: 3 },
  ]);
});

test("frames are put in their place in time; a run that began anew forgets what came later", () => {
  const trails = new Trails();
  trails.adopt(scene);
  for (const t of [0, 1, 3]) trails.add(frame(t, t));
  trails.add(frame(2, 2, false));
  assert.deepEqual(trails.all[0]!.times, [0, 1, 2, 3]);
  assert.deepEqual(trails.all[0]!.points.filter((_, i) => i % 3 === 0), [0, 1, 2, 3]);
  trails.add(frame(0.5, 9));
  assert.deepEqual(trails.all[0]!.times, [0, 0.5]);
  trails.add(frame(0.5, 7));
  assert.deepEqual(trails.all[0]!.points.filter((_, i) => i % 3 === 0), [0, 7]);
  assert.equal(count_until(trails.all[0]!.times, 0.4), 1);
});

test("a scene that changed keeps the trails of what kept its name", () => {
  const trails = new Trails();
  trails.adopt(scene);
  trails.add(frame(0, 1));
  trails.adopt({ ...scene, bodies: [...scene.bodies].reverse() } as Scene);
  assert.deepEqual(trails.all.map((t) => [t.label, t.times.length]), [["ball", 1], ["r", 0]]);
});

test("long runs are thinned, not cut", () => {
  const trails = new Trails();
  trails.adopt(scene);
  for (let i = 0; i < 9000; i++) trails.add(frame(i, i));
  const { times, points } = trails.all[0]!;
  assert.ok(times.length <= 4000 && points.length === 3 * times.length);
  assert.equal(times[0], 0);
  assert.ok(times.every((t, i) => points[3 * i] === t));
});

test("dashes are as long as asked and lie on the line, across its corners", () => {
  // 1 m along x, then 1 m along y; dash and gap 0.3 m: 0 to 0.3, 0.6 to 0.9, 1.2 to 1.5, 1.8 to 2
  const drawn = dashes([0, 0, 0, 1, 0, 0, 1, 1, 0], 3, 0.3);
  const expected = [0, 0, 0, 0.3, 0, 0, 0.6, 0, 0, 0.9, 0, 0, 1, 0.2, 0, 1, 0.5, 0, 1, 0.8, 0, 1, 1, 0];
  assert.equal(drawn.length, expected.length);
  drawn.forEach((v, i) => assert.ok(Math.abs(v - expected[i]!) < 1e-12));
});
