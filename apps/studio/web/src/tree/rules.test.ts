import assert from "node:assert/strict";
import { test } from "node:test";
import type { TreeElement } from "../core/protocol";
import { pastePosition } from "./rules";

const element = (id: number, parent: number, tag: string, name = ""): TreeElement => ({
  id,
  parent,
  tag,
  name,
  path: name,
  line: 1,
  column: 1,
  end_line: 1,
  attributes: {},
});
const elements = [
  element(0, -1, "scene"),
  element(1, 0, "plane", "floor"),
  element(2, 0, "assembly", "robot"),
  element(3, 2, "box", "deck"),
  element(4, 0, "box", "crate"),
  element(5, 0, "assembly", "group"),
];
const all = () => true;

test("what was copied is pasted beside itself, and its copy beside that", () => {
  assert.deepEqual(pastePosition(elements, 2, all, new Set([2])), { parent: 0, before: 4 });
  assert.deepEqual(pastePosition(elements, 5, all, new Set([2, 5])), { parent: 0, before: null });
  assert.deepEqual(pastePosition(elements, 3, all, new Set([3])), { parent: 2, before: null });
});

test("anything else goes into the group that is selected, or beside what is no group", () => {
  assert.deepEqual(pastePosition(elements, 5, all, new Set([2])), { parent: 5, before: null });
  assert.deepEqual(pastePosition(elements, 0, all, new Set([2])), { parent: 0, before: null });
  assert.deepEqual(pastePosition(elements, 3, all, new Set([4])), { parent: 2, before: null });
  assert.deepEqual(pastePosition(elements, 4, all, new Set()), { parent: 0, before: 5 });
});

test("what cannot hold it is left for what is around it", () => {
  const sceneOnly = (id: number) => id === 0;
  assert.deepEqual(pastePosition(elements, 3, sceneOnly, new Set()), { parent: 0, before: 4 });
  assert.deepEqual(pastePosition(elements, 5, sceneOnly, new Set()), { parent: 0, before: null });
});
