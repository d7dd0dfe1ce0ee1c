import assert from "node:assert/strict";
import { test } from "node:test";
import { kBurstPause, TypingGroups } from "./groups";

/** Types text one character at a time from a position on; returns the groups. */
function type(groups: TypingGroups, text: string, at: number, time: number): string[] {
  return [...text].map((c, i) => groups.next([{ time: time + 50 * i, from: at + i, to: at + i, insert: c }]));
}

test("one burst of typing is one group", () => {
  const found = new Set(type(new TypingGroups("g"), "size", 10, 0));
  assert.equal(found.size, 1);
});

test("a quote that the editor closes by itself belongs to the burst around it", () => {
  const groups = new TypingGroups("g");
  const seen = [
    ...type(groups, "a=", 0, 0),
    groups.next([{ time: 100, from: 2, to: 2, insert: '""' }]),
    ...type(groups, "12", 3, 150),
    // typing over the closing quote replaces it
    groups.next([{ time: 300, from: 5, to: 6, insert: '"' }]),
    ...type(groups, " b", 6, 350),
  ];
  assert.equal(new Set(seen).size, 1);
});

test("a pause ends a burst", () => {
  const groups = new TypingGroups("g");
  const a = type(groups, "ab", 0, 0)[1];
  const [b] = type(groups, "c", 2, 50 + kBurstPause + 1);
  const [c] = type(groups, "d", 3, 50 + kBurstPause + 1 + kBurstPause);
  assert.notEqual(a, b);
  assert.equal(b, c);
});

test("another position, deleting, a line end and pasting begin another group", () => {
  const groups = new TypingGroups("g");
  const seen = [
    type(groups, "a", 0, 0)[0], // typing
    type(groups, "b", 50, 10)[0], // elsewhere
    groups.next([{ time: 20, from: 50, to: 51, insert: "" }]), // deletes what was typed
    groups.next([{ time: 30, from: 49, to: 50, insert: "" }]), // and continues deleting backwards
    type(groups, "c", 49, 40)[0], // types again
    groups.next([{ time: 50, from: 50, to: 50, insert: "\n" }]), // continues, and ends with the line
    type(groups, "d", 51, 60)[0],
    groups.next([{ time: 70, from: 52, to: 52, insert: "<box/> pasted" }]),
    groups.next([{ time: 80, from: 65, to: 65, insert: "e" }]),
  ];
  const same = seen.map((group, i) => i > 0 && group === seen[i - 1]);
  assert.deepEqual(same, [false, false, false, true, false, true, false, false, false]);
});

test("several cursors and what comes after end() are groups of their own", () => {
  const groups = new TypingGroups("g");
  const [a] = type(groups, "a", 0, 0);
  const both = groups.next([
    { time: 10, from: 1, to: 1, insert: "b" },
    { time: 10, from: 9, to: 9, insert: "b" },
  ]);
  const [c] = type(groups, "c", 2, 20);
  groups.end();
  const [d] = type(groups, "d", 3, 30);
  assert.equal(new Set([a, both, c, d]).size, 4);
});
