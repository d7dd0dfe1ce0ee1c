import assert from "node:assert/strict";
import { test } from "node:test";
import { signal } from "@preact/signals-core";
import { RequestError } from "../core/link";
import type { Studio } from "../core/studio";
import { Feed, fromPlot, overTime, withGhost } from "./feed";
import { found } from "./signal_list";
import type { FigureSpec } from "./figure";
import { FiguresStore, withSignal } from "./store";

interface Asked {
  signals: string[];
  from: number | null;
  to: number | null;
  points: number;
}

/** A run of frames each 0.1 s in which every signal is its number of the frame; "bad" is unknown. */
function runOf(frames: number) {
  const asked: Asked[] = [];
  const run = { frames };
  const status = signal<unknown>(null);
  const publish = (): void => {
    const last = (run.frames - 1) / 10;
    status.value = { last, frames: run.frames, scene: 1, compare: null };
  };
  publish();
  const studio = {
    link: {
      request: async (_what: string, fields: Asked) => {
        asked.push(fields);
        if (fields.signals.includes("bad")) throw new RequestError({ message: "no signal 'bad'" });
        const all = Array.from({ length: run.frames }, (_, i) => i);
        const there = all.filter((i) => i / 10 >= (fields.from ?? -1) && i / 10 <= (fields.to ?? Infinity));
        return {
          time: there.map((i) => i / 10),
          series: fields.signals.map((s) => ({ signal: s, unit: s === "turn" ? "rad" : "m", low: there, high: there })),
        };
      },
    },
    state: { status, open: signal(true), scene: signal(null), hello: signal(null), frame: signal(null) },
  } as unknown as Studio;
  return { asked, run, publish, studio };
}

const spec = (fields: Partial<FigureSpec>): FigureSpec => ({
  id: 1,
  kind: "curve",
  title: "",
  signals: ["a.x"],
  plot: "",
  ...fields,
});

test("only the new part is requested, nothing while nothing changes, all after going back", async () => {
  const { asked, run, publish, studio } = runOf(3);
  const feed = new Feed(studio, () => spec({}));
  await feed.tick(0);
  assert.deepEqual(asked.pop(), { signals: ["a.x"], from: null, to: null, points: 2000 });
  await feed.tick(1000);
  assert.equal(asked.length, 0);
  run.frames = 6;
  publish();
  await feed.tick(2000);
  assert.equal(asked.pop()!.from, 0.2);
  assert.deepEqual(feed.data.value!.series[0]!.y, [0, 1, 2, 3, 4, 5]);
  // five times a second is enough
  run.frames = 7;
  publish();
  await feed.tick(2100);
  assert.equal(asked.length, 0);
  run.frames = 2;
  publish();
  await feed.tick(3000);
  assert.equal(asked.pop()!.from, null);
  assert.deepEqual(feed.data.value!.series[0]!.y, [0, 1]);
});

test("a part of the time axis is requested in full, and not again while the run continues behind it", async () => {
  const { asked, run, publish, studio } = runOf(50);
  const feed = new Feed(studio, () => spec({}));
  await feed.tick(0);
  feed.zoom([1, 2]);
  await feed.tick(500);
  assert.deepEqual([asked[1]!.from, asked[1]!.to], [1, 2]);
  run.frames = 60;
  publish();
  await feed.tick(1000);
  assert.equal(asked.length, 2);
  feed.zoom(null);
  await feed.tick(1500);
  assert.equal(feed.data.value!.series[0]!.y.length, 60);
});

test("a signal that is no longer there does not take the others with it", async () => {
  const { asked, run, publish, studio } = runOf(3);
  const feed = new Feed(studio, () => spec({ signals: ["a.x", "bad", "turn"] }));
  await feed.tick(0);
  assert.deepEqual(
    feed.data.value!.series.map((s) => [s.label, s.axis]),
    [
      ["a.x", 0],
      ["turn", 1],
    ],
  );
  assert.equal(feed.error.value, "no signal 'bad'");
  asked.length = 0;
  run.frames = 4;
  publish();
  await feed.tick(1000);
  assert.deepEqual(
    asked.map((a) => a.signals),
    [["a.x", "turn"]],
  );
});

test("box plots get all samples, and say units that differ", async () => {
  const { asked, studio } = runOf(5000);
  const feed = new Feed(studio, () => spec({ kind: "box", signals: ["a.x", "turn"] }));
  await feed.tick(0);
  assert.equal(asked[0]!.points, 5000);
  assert.deepEqual(
    feed.data.value!.series.map((s) => [s.label, s.y.length]),
    [
      ["a.x [m]", 5000],
      ["turn [rad]", 5000],
    ],
  );
});

test("a surface waits for its three signals", async () => {
  const { studio } = runOf(5);
  let signals = ["a.x", "b.x", ""];
  const feed = new Feed(studio, () => spec({ kind: "surface", signals }));
  await feed.tick(0);
  assert.equal(feed.data.value!.series.length, 0);
  signals = ["a.x", "b.x", "turn"];
  await feed.tick(5000);
  assert.deepEqual(feed.data.value!.z, { label: "turn", unit: "rad" });
  assert.equal(feed.data.value!.series[0]!.z.length, 5);
});

test("signals fill the free slots", () => {
  assert.deepEqual(withSignal(spec({}), "b.x"), ["a.x", "b.x"]);
  assert.deepEqual(withSignal(spec({}), "a.x"), ["a.x"]);
  assert.deepEqual(withSignal(spec({ kind: "surface", signals: ["a", "", "c"] }), "b"), ["a", "b", "c"]);
  assert.deepEqual(withSignal(spec({ kind: "surface", signals: ["a", "b", "c"] }), "d"), ["a", "b", "d"]);
});

test("drops: signals are drawn, of an element its signals are offered", () => {
  const { studio } = runOf(1);
  const store = new FiguresStore(studio);
  store.signals.value = [{ name: "robot.x", unit: "m", owner: "robot" }];
  store.drop(-1, "robot.x");
  assert.deepEqual(store.specs.value[0]!.signals, ["robot.x"]);
  store.drop(1, "distance(a, b)\n");
  assert.deepEqual(store.specs.value[0]!.signals, ["robot.x", "distance(a, b)"]);
  store.drop(1, "robot");
  assert.equal(store.choosing.value, 1);
  assert.equal(store.search.value, "robot.");
  store.removeSignal(1, 0);
  assert.deepEqual(store.specs.value[0]!.signals, ["distance(a, b)"]);
  store.remove(1);
  assert.deepEqual([store.specs.value.length, store.active.value, store.choosing.value], [0, -1, -1]);
});

test("searching signals: all words, beginnings first", () => {
  const signals = ["front.ball.x", "ball.x", "ball.y", "box.x"].map((name) => ({ name, unit: "m", owner: "" }));
  const names = (query: string): string[] => found(signals, query).map((s) => s.name);
  assert.deepEqual(names("ball"), ["ball.x", "ball.y", "front.ball.x"]);
  assert.deepEqual(names("X ball"), ["front.ball.x", "ball.x"]);
  assert.deepEqual(
    names(""),
    signals.map((s) => s.name),
  );
  assert.deepEqual(names("zz"), []);
});

test("the second run is requested by itself, up to the same time, and drawn dashed", async () => {
  const { asked, run, studio } = runOf(4);
  const status = studio.state.status as unknown as { value: object };
  status.value = { ...status.value, compare: { labels: ["bullet", "cogrsim"], first_over: null } };
  const feed = new Feed(studio, () => spec({}));
  // frames that came since are for the next time
  run.frames = 9;
  await feed.tick(0);
  assert.deepEqual(
    asked.map((a) => [a.to, (a as { run?: string }).run]),
    [
      [0.3, undefined],
      [0.3, "ghost"],
    ],
  );
  assert.deepEqual(
    feed.data.value!.series.map((s) => [s.label, s.dashed, s.y]),
    [
      ["a.x (bullet)", false, [0, 1, 2, 3]],
      ["a.x (cogrsim)", true, [0, 1, 2, 3]],
    ],
  );
  const part = (time: number[]) => ({ time, series: [{ signal: "a", unit: "m", low: time, high: time }] });
  const both = withGhost(part([0, 1, 2, 4]), part([0, 1, 3]));
  assert.deepEqual(both.time, [0, 1]);
  assert.deepEqual(
    both.series.map((s) => s.low),
    [
      [0, 1],
      [0, 1],
    ],
  );
});

test("a scene's plots: over time or not", () => {
  const plot = (unit: string, x: number[]) =>
    fromPlot({
      kind: "curve",
      title: "T",
      x: { label: "t", unit },
      y: { unit: "m" },
      series: [{ label: "a", x, y: x }],
    });
  assert.equal(overTime(plot("s", [0, 1, 2])), true);
  assert.equal(overTime(plot("m", [0, 1, 2])), false);
  assert.equal(overTime(plot("s", [0, 2, 1])), false);
  assert.equal(fromPlot({ kind: "nonsense", series: [] }).kind, "curve");
});
