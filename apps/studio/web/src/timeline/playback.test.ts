import assert from "node:assert/strict";
import { test } from "node:test";
import type { Link } from "../core/link";
import type { Frame } from "../core/frame";
import type { Hello, Status } from "../core/protocol";
import { State } from "../core/state";
import { Playback } from "./playback";

/** Frames at the times given; answers in the next turn. */
function stage(times: number[], kind: Hello["kind"], speed: number | null = 1) {
  const state = new State();
  state.hello.value = { kind, role: "operator" } as Hello;
  const status = { first: times[0], last: times[times.length - 1], frames: times.length, dt: 0.001, speed } as Status;
  state.status.value = status;
  const asked: { what: string; time?: number }[] = [];
  const look = (time: number) => {
    const found = times.filter((t) => t <= time + 1e-9).pop() ?? times[0]!;
    state.frame.value = { time: found } as Frame;
    return { time: found };
  };
  look(status.last);
  const link = {
    async request(what: string, fields: { time?: number } = {}) {
      asked.push({ what, ...fields });
      await Promise.resolve();
      return what === "seek" ? look(fields.time!) : {};
    },
  } as unknown as Link;
  let now = 0;
  let next: (() => void) | null = null;
  const clock = {
    now: () => now,
    next: (then: () => void) => {
      next = then;
      return () => (next = null);
    },
  };
  const errors: string[] = [];
  const playback = new Playback(link, state, clock, (e) => errors.push(e));
  const tick = async (seconds: number) => {
    now += seconds;
    const then = next;
    next = null;
    then?.();
    for (let i = 0; i < 10; ++i) await Promise.resolve();
  };
  return { state, status, asked, playback, tick, errors, pending: () => next !== null };
}
const settle = async () => {
  for (let i = 0; i < 60; ++i) await Promise.resolve();
};
const tenths = Array.from({ length: 101 }, (_, i) => i / 10);

test("many seeks at once ask only for the first and the last", async () => {
  const { playback, asked, state } = stage(tenths, "scene");
  for (let i = 0; i < 50; ++i) playback.seek(i / 10);
  await settle();
  assert.deepEqual(asked, [
    { what: "seek", time: 0 },
    { what: "seek", time: 4.9 },
  ]);
  assert.equal(state.frame.value?.time, 4.9);
  assert.equal(state.live.value, false);
  assert.equal(playback.wanted.value, null);
});

test("the cursor runs through the past at the run's speed, then reports its arrival", async () => {
  const { playback, tick, state } = stage(tenths, "scene", 2);
  playback.seek(9);
  await settle();
  let arrived = 0;
  playback.run(() => ++arrived);
  await tick(0.2);
  assert.ok(Math.abs(playback.time - 9.4) < 1e-9, String(playback.time));
  await tick(0.2);
  assert.equal(arrived, 0);
  assert.equal(playback.running.value, true);
  await tick(0.2);
  assert.equal(arrived, 1);
  assert.equal(playback.running.value, false);
  assert.equal(state.frame.value?.time, 10);
});

test("a recording that is at its end plays from its start, and its speed is the page's", async () => {
  const { playback, tick } = stage(tenths, "recording", null);
  playback.speed.value = 0.5;
  playback.run(() => {});
  await tick(0.2);
  assert.ok(Math.abs(playback.time - 0.1) < 1e-9, String(playback.time));
});

test("a page that slept continues where it was", async () => {
  const { playback, tick } = stage(tenths, "recording");
  playback.seek(1);
  await settle();
  playback.run(() => {});
  await tick(3600);
  assert.ok(playback.time <= 1.25 + 1e-9, String(playback.time));
});

test("seeking halts the cursor, and nothing is left that would wake it", async () => {
  const { playback, tick, pending } = stage(tenths, "recording");
  playback.run(() => assert.fail("arrived"));
  await tick(0.1);
  playback.seek(3);
  await settle();
  assert.equal(playback.running.value, false);
  assert.equal(pending(), false);
});

test("stepping forward finds the next frame, however far it is", async () => {
  for (const gap of [0.001, 0.0161, 0.7]) {
    const times = Array.from({ length: 10 }, (_, i) => i * gap);
    const { playback, state } = stage(times, "scene");
    playback.seek(3 * gap);
    await settle();
    await playback.stepForward();
    assert.ok(Math.abs(state.frame.value!.time - 4 * gap) < 1e-9, `gap ${gap}: ${state.frame.value!.time}`);
  }
});

test("stepping forward at the end stays there", async () => {
  const { playback, state } = stage(tenths, "recording");
  await playback.stepForward();
  assert.equal(state.frame.value?.time, 10);
});

test("another window's time is taken over and not sent on", async () => {
  const { playback, state } = stage(tenths, "scene");
  playback.moved = () => assert.fail("sent on");
  playback.follow(false, 2);
  await settle();
  assert.equal(state.frame.value?.time, 2);
  playback.follow(true, 0);
  assert.equal(state.live.value, true);
});
