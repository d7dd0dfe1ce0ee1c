import assert from "node:assert/strict";
import { test } from "node:test";
import { followElements } from "./follow";
import type { TreeElement } from "./protocol";

const tree = (...rows: [number, string, string][]): TreeElement[] =>
  rows.map(([parent, tag, name], id) => ({
    id,
    parent,
    tag,
    name,
    path: name,
    line: 1,
    column: 1,
    end_line: 1,
    attributes: {},
  }));
const before = tree([-1, "scene", ""], [0, "box", "a"], [0, "box", "b"], [0, "on", ""], [0, "on", ""]);

test("what comes in before them moves the ids of others", () => {
  const after = tree(
    [-1, "scene", ""],
    [0, "plane", "p"],
    [0, "box", "a"],
    [0, "box", "b"],
    [0, "on", ""],
    [0, "on", ""],
  );
  assert.deepEqual(followElements([2, 4], before, after), [3, 5]);
});

test("removed elements are not selected any more", () => {
  const after = tree([-1, "scene", ""], [0, "box", "b"], [0, "on", ""], [0, "on", ""]);
  assert.deepEqual(followElements([1, 2], before, after), [1]);
});

test("renamed and moved elements are followed", () => {
  const renamed = tree([-1, "scene", ""], [0, "box", "a"], [0, "box", "c"], [0, "on", ""], [0, "on", ""]);
  assert.deepEqual(followElements([2], before, renamed), [2]);
  const moved = tree([-1, "scene", ""], [0, "body", "g"], [1, "box", "a"], [0, "on", ""], [0, "box", "b"]);
  const inside = tree([-1, "scene", ""], [0, "body", "g"], [0, "box", "a"], [0, "on", ""], [0, "box", "b"]);
  assert.deepEqual(followElements([2], inside, moved), [2]);
  const last = tree([-1, "scene", ""], [0, "body", "g"], [1, "on", ""], [1, "box", "a"], [0, "box", "b"]);
  assert.deepEqual(followElements([2], inside, last), [3]);
});
