import assert from "node:assert/strict";
import { test } from "node:test";
import { kProtocol, type Hello, type Status } from "../core/protocol";
import {
  nextSpeed,
  playMeans,
  readStep,
  reloadText,
  stepHint,
  stepText,
  whyNot,
  type Action,
  type Situation,
} from "./rules";

const hello: Hello = {
  role: "operator",
  client: 1,
  version: "1",
  kind: "scene",
  file: "a",
  allow_build: false,
  protocol: kProtocol,
  backends: [],
};
const status = { state: "paused", frames: 20, ending: "" } as Status;
const now = (more: Partial<Situation> = {}): Situation => ({
  hello,
  open: true,
  status,
  live: true,
  replaying: false,
  ...more,
});
const can = (action: Action, more: Partial<Situation>) => whyNot(action, now(more)) === null;

test("the ladder of speeds ends at as fast as possible, and for recordings at ten", () => {
  let speed: number | null = 0.01;
  const climbed: (number | null)[] = [];
  for (let i = 0; i < 9; ++i) climbed.push((speed = nextSpeed(speed, 1, true)));
  assert.deepEqual(climbed, [0.1, 0.25, 0.5, 1, 2, 4, 10, null, null]);
  assert.equal(nextSpeed(null, -1, true), 10);
  assert.equal(nextSpeed(0.1, -1, true), 0.1);
  assert.equal(nextSpeed(3, -1, true), 2);
  assert.equal(nextSpeed(3, 1, true), 4);
  assert.equal(nextSpeed(10, 1, false), 10);
});

test("play in the past plays recorded frames, at the end it runs", () => {
  assert.equal(playMeans(now()), "run");
  assert.equal(playMeans(now({ live: false })), "replay");
  assert.equal(playMeans(now({ hello: { ...hello, kind: "recording" } })), "replay");
});

test("a viewer may look, not steer", () => {
  const viewer = { hello: { ...hello, role: "viewer" as const } };
  for (const action of ["play", "stop", "restart", "step", "speed", "dt", "backend", "record", "reload"] as Action[]) {
    assert.match(whyNot(action, now(viewer)) ?? "", /operator/, action);
  }
  assert.ok(can("step-back", viewer));
  assert.ok(can("play", { ...viewer, live: false }));
  assert.ok(can("step", { ...viewer, live: false }));
  assert.ok(can("live", { ...viewer, live: false }));
});

test("controllers are reloaded while the run is paused", () => {
  assert.ok(can("reload", {}));
  assert.equal(whyNot("reload", now({ status: { ...status, state: "playing" } })), "pause the run first");
  const answer = {
    reloaded: [{ controller: "bot.driver", version: "2.0.0", memory_kept: false, note: "it restarted" }],
    kept: [{ controller: "other.driver", message: "controller 'other.driver' was not reloaded" }],
  };
  assert.equal(
    reloadText(answer),
    "bot.driver reloaded (2.0.0): it restarted; controller 'other.driver' was not reloaded",
  );
});

test("a recording is played, not changed", () => {
  const past = { hello: { ...hello, kind: "recording" as const }, live: false };
  for (const action of ["play", "step", "step-back", "speed", "stop", "restart"] as Action[])
    assert.ok(can(action, past));
  for (const action of ["dt", "backend", "record", "live", "pause", "reload"] as Action[])
    assert.ok(!can(action, past), action);
  assert.ok(can("pause", { ...past, replaying: true }));
});

test("an ended run shows how it ended", () => {
  const ended = { status: { ...status, state: "ended" as const, ending: "its duration is over" } };
  assert.match(whyNot("play", now(ended)) ?? "", /duration is over/);
  assert.ok(can("restart", ended));
  assert.ok(can("play", { ...ended, live: false }));
});

test("without a connection nothing can be done", () => {
  for (const action of ["play", "stop", "live", "step-back"] as Action[]) {
    assert.equal(whyNot(action, now({ open: false })), "no connection");
  }
});

test("time steps are read in milliseconds and written without noise", () => {
  assert.equal(readStep(" 0,5 "), 0.0005);
  assert.equal(readStep("2"), 0.002);
  for (const bad of ["", "x", "0", "-1", "1001", "Infinity"]) assert.equal(typeof readStep(bad), "string", bad);
  assert.equal(stepText(0.001), "1");
  assert.equal(stepText(1 / 240), "4.16667");
  assert.match(stepHint(0.001, 0.001), /as the scene says/);
  assert.match(stepHint(0.0005, 0.001), /about 2 times as accurate/);
  assert.match(stepHint(0.004, 0.001), /about 4 times the error of the scene's 1 ms/);
});
