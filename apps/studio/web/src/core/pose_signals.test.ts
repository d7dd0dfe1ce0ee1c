import assert from "node:assert/strict";
import { test } from "node:test";
import { MemoryLink } from "./memory_link";
import type { MemoryRun } from "./memory_run";
import { divergenceOf, rollPitchYaw } from "./pose_signals";
import type { Frame } from "./frame";
import type { Scene } from "./protocol";

const body = (name: string) => ({ name, kind: "dynamic", removed: false });
const turned = (angle: number): number[] => [Math.cos(angle / 2), 0, 0, Math.sin(angle / 2)];

/** Two bodies: a moves along x and turns about z; the ghost of b falls behind by 1 mm per frame. */
function runOf(count: number, ghost: boolean): MemoryRun {
  const frame = (i: number): Frame => ({
    live: false,
    scene: 1,
    time: i * 0.1,
    step: i,
    poses: Float32Array.from([i, 0, 0, ...turned(0.01 * i), 0, 2, 0, 1, 0, 0, 0]),
    ghost: ghost
      ? Float32Array.from([i, 0, 0, ...turned(0.01 * i), 0, 2 - 0.001 * i, 0, 1, 0, 0, 0])
      : new Float32Array(),
    tail: {},
  });
  return {
    hello: {} as MemoryRun["hello"],
    scenes: [{ scene: 1, bodies: [body("a"), body("b"), { ...body("floor"), kind: "fixed" }] } as unknown as Scene],
    count,
    timeOf: (i) => i * 0.1,
    frame,
    backend: "",
    engineVersion: "",
    ending: "",
    dt: 0.1,
  };
}

test("angles of a rotation, about x, then y, then z of the world", () => {
  // 0.3 about x, then -0.4 about y, then 1.2 about z: q = qz qy qx
  const [cx, sx, cy, sy, cz, sz] = [0.15, -0.2, 0.6].flatMap((a) => [Math.cos(a), Math.sin(a)]);
  const w = cx! * cy! * cz! + sx! * sy! * sz!;
  const x = sx! * cy! * cz! - cx! * sy! * sz!;
  const y = cx! * sy! * cz! + sx! * cy! * sz!;
  const z = cx! * cy! * sz! - sx! * sy! * cz!;
  const angles = rollPitchYaw(w, x, y, z);
  [0.3, -0.4, 1.2].forEach((angle, k) => assert.ok(Math.abs(angles[k]! - angle) < 1e-12));
});

interface Answer {
  time: number[];
  series: { signal: string; unit: string; low: (number | null)[] }[];
}

test("a run in memory has signals of its bodies, and both runs of a comparison", async () => {
  const link = new MemoryLink(runOf(6, true));
  const { signals } = await link.request<{ signals: { name: string; owner: string }[] }>("signals");
  assert.equal(signals.length, 12);
  assert.ok(!signals.some((s) => s.owner === "floor"));
  const answer = await link.request<Answer>("series", { signals: ["b.y", "a.yaw"], from: 0.15, to: null });
  assert.deepEqual(
    answer.time.map((t) => Math.round(t * 10)),
    [2, 3, 4, 5],
  );
  assert.deepEqual(
    answer.series.map((s) => [s.signal, s.unit]),
    [
      ["b.y", "m"],
      ["a.yaw", "rad"],
    ],
  );
  const ghost = await link.request<Answer>("series", { signals: ["b.y"], from: 0.15, to: null, run: "ghost" });
  // poses are of single precision: 2^-24 of 2
  assert.equal(answer.series[0]!.low[3], 2);
  assert.ok(Math.abs(ghost.series[0]!.low[3]! - 1.995) < 2e-7);
  assert.ok(Math.abs(answer.series[1]!.low[3]! - 0.05) < 2e-7);
  await assert.rejects(link.request("series", { signals: ["floor.x"], from: null, to: null }), /no signal 'floor.x'/);
});

test("how far two runs diverge, and which body is first", () => {
  assert.equal(divergenceOf(runOf(20, false), ["p", "q"]), null);
  const answer = divergenceOf(runOf(20, true), ["p", "q"]) as {
    worst: number[];
    worst_angle: number[];
    bodies: { name: string }[];
    first: { time: number; name: string };
  };
  assert.ok(Math.abs(answer.worst[19]! - 0.019) < 1e-6);
  assert.ok(answer.worst_angle.every((a) => a < 1e-6));
  assert.equal(answer.bodies[0]!.name, "b");
  // 1 mm a frame: more than 10 mm in the eleventh
  assert.equal(answer.first.name, "b");
  assert.ok(Math.abs(answer.first.time - 1.1) < 0.11);
});
