import assert from "node:assert/strict";
import { test } from "node:test";
import type { Problem } from "../core/protocol";
import { countWrong, linesOf, passing } from "./lines";

const problem: Problem = {
  severity: "error",
  code: "unknown-attribute",
  message: "no attribute 'siez'",
  help: "did you mean 'size'?",
  file: "a.scene.xml",
  line: 3,
  column: 9,
  length: 4,
  notes: [{ message: "declared here", file: "b.xml", line: 1, column: 2 }],
};
const messages = [
  { time: 2, severity: "error" as const, source: "pid", message: "saturated" },
  { time: 0.5, severity: "warning" as const, source: "pid", message: "slow" },
];
const events = [{ index: 0, time: 1, kind: "enter", source: "region", subject: "bot", message: "" }];
const every = { problem: true, message: true, event: true };

test("problems come first with their notes, then the run in the order of time", () => {
  const lines = linesOf([problem], messages, events);
  assert.deepEqual(
    lines.map((l) => l.text),
    ["no attribute 'siez'", "declared here", "slow", "enter bot", "saturated"],
  );
  assert.deepEqual(lines[0]!.location, { file: "a.scene.xml", line: 3, column: 9 });
  assert.deepEqual(lines[1]!.location, { file: "b.xml", line: 1, column: 2 });
  assert.equal(lines[2]!.location, null);
});

test("a problem without a source location has none", () => {
  assert.equal(linesOf([{ ...problem, file: "", line: 0, notes: [] }], [], [])[0]!.location, null);
});

test("filters leave out kinds, and lines without all search words", () => {
  const lines = linesOf([problem], messages, events);
  assert.equal(passing(lines, { kinds: { ...every, problem: false }, search: "" }).length, 3);
  assert.deepEqual(
    passing(lines, { kinds: every, search: "PID slow" }).map((l) => l.text),
    ["slow"],
  );
  assert.deepEqual(
    passing(lines, { kinds: every, search: "mean 'size'" }).map((l) => l.text),
    ["no attribute 'siez'"],
  );
});

test("a warning is not counted as wrong", () => {
  assert.equal(countWrong([problem, { ...problem, severity: "warning" }], messages), 2);
});
