import assert from "node:assert/strict";
import { test } from "node:test";
import { apply } from "./diff";
import { kTypingMost, TextSync, type SyncAnswer, type SyncSetText } from "./sync";

/** A server with one text, whose answers and topics come when the test says so. */
class Bench {
  server = { text: "one\ntwo\nthree\n", version: 1 };
  history: { text: string; group: string }[] = [];
  editor = "";
  refusals: string[] = [];
  calm = 0;
  private now = 0;
  private timers: { what: () => void; due: number; gone: boolean }[] = [];
  private requests: (() => void)[] = [];
  broken = false;
  readonly sync = new TextSync({
    send: (fields) => new Promise((resolve) => this.requests.push(() => resolve(this.set(fields)))),
    text: () => this.editor,
    change: (changes) => (this.editor = apply(this.editor, changes)),
    later: (ms, what) => {
      const timer = { what, due: this.now + ms, gone: false };
      this.timers.push(timer);
      return () => (timer.gone = true);
    },
    refused: (message) => this.refusals.push(message),
    settled: () => (this.calm += this.sync.settled ? 1 : NaN),
  });

  constructor() {
    this.publish();
  }
  private set({ version, text, group }: SyncSetText): SyncAnswer {
    if (this.broken) return { ok: false, stale: false, message: "the connection is broken" };
    if (version !== this.server.version) return { ok: false, stale: true, message: "stale" };
    this.server = { text, version: version + 1 };
    this.history.push({ text, group });
    return { ok: true, version: version + 1 };
  }
  publish(): void {
    this.sync.arrived(this.server.text, this.server.version);
  }
  type(text: string, group = "g1"): void {
    const before = this.editor;
    this.editor = text;
    this.sync.typed(() => before, group);
  }
  rest(): void {
    const timers = this.timers.splice(0);
    for (const timer of timers) if (!timer.gone) timer.what();
  }
  /** Time goes by [ms]. */
  pass(ms: number): void {
    this.now += ms;
    const due = this.timers.filter((timer) => timer.due <= this.now);
    this.timers = this.timers.filter((timer) => timer.due > this.now);
    for (const timer of due) if (!timer.gone) timer.what();
  }
  async answer(): Promise<void> {
    for (const request of this.requests.splice(0)) request();
    await new Promise((resolve) => setImmediate(resolve));
  }
  get pending(): number {
    return this.requests.length;
  }
  other(text: string): void {
    this.server = { text, version: this.server.version + 1 };
  }
}

test("the server's text comes into the editor", () => {
  const bench = new Bench();
  assert.equal(bench.editor, bench.server.text);
  assert.ok(bench.sync.settled);
});

test("typing is sent once when it rests, and its own echo changes nothing", async () => {
  const bench = new Bench();
  bench.type("one!\ntwo\nthree\n");
  bench.type("one!!\ntwo\nthree\n");
  assert.equal(bench.pending, 0);
  bench.rest();
  assert.equal(bench.pending, 1);
  assert.equal(bench.calm, 0);
  await bench.answer();
  bench.publish();
  assert.equal(bench.calm, 1);
  assert.deepEqual(bench.history, [{ text: "one!!\ntwo\nthree\n", group: "g1" }]);
  assert.equal(bench.editor, "one!!\ntwo\nthree\n");
  assert.ok(bench.sync.settled);
});

test("typing without a pause is sent nevertheless", async () => {
  const bench = new Bench();
  for (let i = 0, text = "one"; i < 9; ++i) {
    text += "!";
    bench.type(text);
    bench.pass(kTypingMost / 10);
    assert.equal(bench.pending, 0);
  }
  bench.type("one!!!!!!!!!!");
  bench.pass(kTypingMost / 10);
  assert.equal(bench.pending, 1);
  await bench.answer();
  assert.equal(bench.server.text, "one!!!!!!!!!!");
  // From then on the count restarts.
  bench.type("two");
  bench.pass(kTypingMost / 10);
  assert.equal(bench.pending, 0);
});

test("the echo may come before the answer, with more typed meanwhile", async () => {
  const bench = new Bench();
  bench.type("one!\ntwo\nthree\n");
  bench.rest();
  bench.type("one!?\ntwo\nthree\n");
  const sent = bench.answer();
  bench.publish();
  await sent;
  bench.publish();
  assert.equal(bench.editor, "one!?\ntwo\nthree\n");
  bench.rest();
  await bench.answer();
  assert.equal(bench.server.text, "one!?\ntwo\nthree\n");
});

test("two bursts are two steps even when they are sent together", async () => {
  const bench = new Bench();
  bench.type("one A\ntwo\nthree\n", "g1");
  bench.type("one A\ntwo B\nthree\n", "g2");
  await bench.answer();
  bench.rest();
  await bench.answer();
  assert.deepEqual(
    bench.history.map((h) => [h.group, h.text]),
    [
      ["g1", "one A\ntwo\nthree\n"],
      ["g2", "one A\ntwo B\nthree\n"],
    ],
  );
});

test("a stale version is merged and tried again", async () => {
  const bench = new Bench();
  bench.type("one!\ntwo\nthree\n");
  bench.rest();
  bench.other("one\ntwo\nTHREE\n");
  bench.publish();
  await bench.answer();
  assert.equal(bench.editor, "one!\ntwo\nTHREE\n");
  await bench.answer();
  assert.equal(bench.server.text, "one!\ntwo\nTHREE\n");
  assert.ok(bench.sync.settled);
});

test("stale before the newer text has come: waits for it", async () => {
  const bench = new Bench();
  bench.type("one!\ntwo\nthree\n");
  bench.rest();
  bench.other("one\ntwo\nTHREE\n");
  await bench.answer();
  assert.equal(bench.pending, 0);
  assert.equal(bench.editor, "one!\ntwo\nthree\n");
  bench.publish();
  await bench.answer();
  assert.equal(bench.server.text, "one!\ntwo\nTHREE\n");
});

test("a change of others that came with mine is not taken in twice", async () => {
  const bench = new Bench();
  bench.type("one!\ntwo\nthree\n");
  bench.rest();
  const sent = bench.answer(); // accepted as version 2
  bench.other("one!\ntwo\nTHREE\n"); // version 3, made of version 2
  bench.publish(); // comes before the answer does
  await sent;
  assert.equal(bench.editor, "one!\ntwo\nTHREE\n");
  assert.ok(bench.sync.settled);
});

test("flush sends at once and is done when the server knows", async () => {
  const bench = new Bench();
  bench.type("x\n");
  let done = false;
  const flushed = bench.sync.flush().then(() => (done = true));
  assert.equal(bench.pending, 1);
  assert.equal(done, false);
  await bench.answer();
  await flushed;
  assert.equal(bench.server.text, "x\n");
});

test("what could not be sent is kept, and goes along when the server is back", async () => {
  const bench = new Bench();
  bench.broken = true;
  bench.type("one!\ntwo\nthree\n");
  bench.rest();
  await bench.answer();
  assert.deepEqual(bench.refusals, ["the connection is broken"]);
  bench.broken = false;
  bench.sync.reset();
  bench.server = { text: "one\ntwo\nthree\nfour\n", version: 1 };
  bench.publish();
  assert.equal(bench.editor, "one!\ntwo\nthree\nfour\n");
  await bench.answer();
  assert.equal(bench.server.text, "one!\ntwo\nthree\nfour\n");
});

test("an undo on the server comes back as it is", async () => {
  const bench = new Bench();
  bench.type("one!\ntwo\nthree\n");
  bench.rest();
  await bench.answer();
  bench.other("one\ntwo\nthree\n");
  bench.publish();
  assert.equal(bench.editor, "one\ntwo\nthree\n");
  assert.equal(bench.pending, 0);
});
