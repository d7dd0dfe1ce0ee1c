import assert from "node:assert/strict";
import { test } from "node:test";
import { decodeFrame, decodePicture } from "./decode";
import { MemoryLink } from "./memory_link";
import type { MemoryRun } from "./memory_run";
import { kProtocol, type RunEvent, type Scene } from "./protocol";
import { indexAt, lowHigh } from "./series";
import { State } from "./state";
import { append, appendEvents, sameProtocol, wire } from "./wire";

test("a frame is read as it is laid down", () => {
  const tail = new TextEncoder().encode('{"readings":[{"sensor":2,"values":[1,null]}]}');
  const data = new ArrayBuffer(40 + 28 * 3 + tail.length);
  const view = new DataView(data);
  view.setUint8(0, 1);
  view.setUint8(1, 3);
  view.setUint32(4, 7, true);
  view.setFloat64(8, 1.25, true);
  view.setFloat64(16, 1250, true);
  view.setUint32(24, 2, true);
  view.setUint32(28, 1, true);
  view.setUint32(32, tail.length, true);
  for (let i = 0; i < 21; ++i) view.setFloat32(40 + 4 * i, i + 0.5, true);
  new Uint8Array(data, 40 + 84).set(tail);
  const frame = decodeFrame(data);
  assert.deepEqual(
    { ...frame, poses: Array.from(frame.poses), ghost: Array.from(frame.ghost) },
    {
      live: true,
      scene: 7,
      time: 1.25,
      step: 1250,
      poses: Array.from({ length: 14 }, (_, i) => i + 0.5),
      ghost: Array.from({ length: 7 }, (_, i) => i + 14.5),
      tail: { readings: [{ sensor: 2, values: [1, null] }] },
    },
  );
  assert.equal(frame.poses.buffer, data, "not copied");
  assert.throws(() => decodeFrame(data.slice(0, -1)));
  assert.throws(() => decodeFrame(new ArrayBuffer(3)));
});

test("a picture is read as it is laid down", async () => {
  const name = new TextEncoder().encode("Auge");
  const data = new Uint8Array(20 + 4 + 3);
  const view = new DataView(data.buffer);
  view.setUint8(0, 2);
  view.setUint8(1, 1);
  view.setUint16(2, 4, true);
  view.setUint32(4, 320, true);
  view.setUint32(8, 240, true);
  view.setFloat64(12, 0.5, true);
  data.set(name, 20);
  data.set([9, 8, 7], 24);
  const { file, ...rest } = decodePicture(data.buffer);
  assert.deepEqual(rest, { kind: "depth", name: "Auge", width: 320, height: 240, time: 0.5 });
  assert.equal(file.type, "image/png");
  assert.deepEqual([...new Uint8Array(await file.arrayBuffer())], [9, 8, 7]);
  assert.throws(() => decodePicture(data.buffer.slice(0, 22)));
  view.setUint8(1, 3);
  assert.throws(() => decodePicture(data.buffer));
});

test("the last frame at or before a time", () => {
  const times = [0, 1, 1, 2];
  const at = (t: number) => indexAt(4, (i) => times[i]!, t);
  assert.deepEqual([-1, 0, 0.5, 1, 1.5, 2, 9].map(at), [0, 0, 0, 2, 2, 3, 3]);
  assert.equal(at(2 - 1e-13), 3, "a time that went through text");
});

test("intervals keep the lowest and the highest, and have null where there is no number", () => {
  const values = [1, 5, NaN, 2, NaN, NaN, 7];
  assert.deepEqual(lowHigh(values, 0, 7, 100), {
    picks: [0, 1, 2, 3, 4, 5, 6],
    low: [1, 5, null, 2, null, null, 7],
    high: [1, 5, null, 2, null, null, 7],
  });
  const few = lowHigh(values, 0, 6, 3);
  assert.deepEqual(few, { picks: [0, 2, 4], low: [1, 2, null], high: [5, 2, null] });
  assert.deepEqual(lowHigh(values, 3, 3, 10), { picks: [], low: [], high: [] });
});

const event = (index: number): RunEvent => ({ index, time: index, kind: "k", source: "s", subject: "", message: "" });

test("lists are bounded, and events of a new run replace the old ones", () => {
  assert.deepEqual(append([1, 2, 3], [4, 5], 3), [3, 4, 5]);
  const all = appendEvents([], [event(0), event(1), event(2)]);
  assert.deepEqual(
    appendEvents(all, [event(3)]).map((e) => e.index),
    [0, 1, 2, 3],
  );
  assert.deepEqual(
    appendEvents(all, [event(0)]).map((e) => e.index),
    [0],
  );
  assert.deepEqual(
    appendEvents(all, []).map((e) => e.index),
    [0, 1, 2],
  );
});

function runOf(count: number): MemoryRun {
  return {
    hello: {
      protocol: kProtocol,
      role: "viewer",
      client: 1,
      version: "1",
      kind: "bundle",
      file: "a",
      allow_build: false,
      backends: [],
    },
    scenes: [
      { scene: 1, name: "one", step: 0.1, bodies: [] as Scene["bodies"] } as Scene,
      { scene: 2, name: "two", step: 0.1, bodies: [] as Scene["bodies"] } as Scene,
    ],
    count,
    timeOf: (i) => i / 10,
    frame: (i) => ({
      live: true,
      scene: i < 5 ? 1 : 2,
      time: i / 10,
      step: i,
      poses: new Float32Array([i]),
      ghost: new Float32Array(0),
      tail: { contacts: [], readings: [{ sensor: 0, values: [i] }] },
    }),
    backend: "bullet",
    engineVersion: "1",
    ending: "",
    dt: 0.1,
    signals: [{ name: "x", unit: "m", owner: "b", values: Array.from({ length: count }, (_, i) => i) }],
    events: [event(0), event(1)],
    messages: [{ time: 0, severity: "warning", source: "s", message: "m" }],
  };
}
const soon = () => new Promise((r) => setTimeout(r, 40));

test("a run in memory answers as a server does", async () => {
  const link = new MemoryLink(runOf(11));
  const state = new State();
  wire(link, state, (message) => assert.fail(message));
  await soon();
  assert.equal(state.open.value, true);
  assert.equal(state.status.value?.last, 1);
  assert.equal(state.scene.value?.name, "one");
  assert.equal(state.frame.value?.time, 0);
  assert.equal(state.frame.value?.live, false);
  assert.equal(state.messages.value.length, 1);
  assert.equal(state.mayEdit.value, false);

  assert.deepEqual(await link.request("seek", { time: 0.77 }), { time: 0.7 });
  await soon();
  assert.equal(state.frame.value?.time, 0.7);
  assert.equal(state.scene.value?.name, "two", "the frame's scene comes with it");
  assert.deepEqual(state.frame.value?.tail, {});
  await link.request("subscribe", { readings: true, contacts: false });
  await soon();
  assert.deepEqual(state.frame.value?.tail, { readings: [{ sensor: 0, values: [7] }] });
  assert.deepEqual(await link.request("step-back"), { time: 0.6 });

  assert.deepEqual(await link.request("series", { signals: ["x"], from: 0.2, to: 0.55, points: 100 }), {
    time: [0.2, 0.3, 0.4, 0.5],
    series: [{ signal: "x", unit: "m", low: [2, 3, 4, 5], high: [2, 3, 4, 5] }],
  });
  assert.deepEqual(await link.request("series", { signals: ["x"], from: 5, to: null }), {
    time: [],
    series: [{ signal: "x", unit: "m", low: [], high: [] }],
  });
  await assert.rejects(link.request("series", { signals: ["y"] }), /no signal 'y'/);
  await assert.rejects(link.request("edit", {}), /needs a server/);
});

test("a page that meets a server of another protocol is reloaded once", (t) => {
  const stored = new Map<string, string>();
  const storage = {
    getItem: (key: string) => stored.get(key) ?? null,
    setItem: (key: string, value: string) => void stored.set(key, value),
    removeItem: (key: string) => void stored.delete(key),
  };
  const page = globalThis as { sessionStorage?: unknown };
  const before = page.sessionStorage;
  t.after(() => (page.sessionStorage = before));
  const done: string[] = [];
  const meet = (protocol: number) =>
    sameProtocol(
      protocol,
      () => done.push("reload"),
      (message) => done.push(message),
    );

  // Where nothing is kept, it could not be distinguished from the first time.
  page.sessionStorage = undefined;
  assert.equal(meet(kProtocol + 1), true);
  assert.match(done.join(), /different versions/);
  done.length = 0;

  page.sessionStorage = storage;
  assert.equal(meet(kProtocol), true);
  assert.deepEqual(done, []);
  assert.equal(meet(kProtocol + 1), false);
  assert.deepEqual(done, ["reload"]);
  assert.equal(meet(kProtocol + 1), true, "the same page came again");
  assert.match(done[1] ?? "", /different versions/);
  assert.equal(meet(kProtocol), true);
  done.length = 0;
  assert.equal(meet(kProtocol + 1), false, "another start of another server");
  assert.deepEqual(done, ["reload"]);
});
