import assert from "node:assert/strict";
import { test } from "node:test";
import { RequestError, type Link } from "../core/link";
import type { Op, TreeElement } from "../core/protocol";
import { State } from "../core/state";
import { edit, elementsOf, sameElements } from "./editing";

const tree = (...rows: [tag: string, name: string, parent: number][]) =>
  rows.map(([tag, name, parent], id) => ({ id, tag, name, parent }) as TreeElement);
const first = tree(["scene", "s", -1], ["box", "a", 0], ["assembly", "r", 0], ["box", "b", 2]);

test("elements mean the same if they and all around them are called the same", () => {
  assert.ok(
    sameElements(
      [1, 3],
      first,
      tree(["scene", "s", -1], ["box", "a", 0], ["assembly", "r", 0], ["box", "b", 2], ["box", "c", 2]),
    ),
  );
  assert.ok(
    !sameElements([3], first, tree(["scene", "s", -1], ["box", "a", 0], ["assembly", "x", 0], ["box", "b", 2])),
  );
  assert.ok(!sameElements([3], first, tree(["scene", "s", -1], ["box", "a", 0], ["assembly", "r", 0])));
  assert.ok(!sameElements([1], first, tree(["scene", "s", -1], ["box", "z", 0], ["box", "a", 0])));
});

test("all elements an operation is about are found", () => {
  const ops: Op[] = [
    { op: "move", element: 4, parent: 2, before: 3 },
    { op: "remove", elements: [7, 8] },
    { op: "insert", parent: 1, xml: "<box/>", before: null },
    { op: "set", element: 9, attribute: "x", value: null },
  ];
  assert.deepEqual(elementsOf(ops), [4, 2, 3, 7, 8, 1, 9]);
});

function stage(refusals: number, after: TreeElement[]) {
  const state = new State();
  state.tree.value = { version: 1, elements: first };
  const asked: number[] = [];
  const link = {
    async request(_: string, fields: { version: number }) {
      asked.push(fields.version);
      if (asked.length <= refusals) {
        setTimeout(() => (state.tree.value = { version: 2, elements: after }), 5);
        throw new RequestError({ message: "old", code: "stale" });
      }
      setTimeout(() => (state.tree.value = { version: fields.version + 1, elements: after }), 5);
      return { version: fields.version + 1, created: [5] };
    },
  } as unknown as Link;
  return { state, asked, link };
}
const ops: Op[] = [{ op: "set", element: 3, attribute: "size", value: "1" }];

test("an edit is done when the tree has come that it led to", async () => {
  const { state, link } = stage(0, first);
  assert.deepEqual(await edit(link, state, "x", ops), [5]);
  assert.equal(state.tree.value.version, 2);
});

test("an edit that came too late is tried again once, if it means the same", async () => {
  const { state, link, asked } = stage(1, first);
  assert.deepEqual(await edit(link, state, "x", ops), [5]);
  assert.deepEqual(asked, [1, 2]);
});

test("an edit that came too late is not done to something else", async () => {
  const { state, link, asked } = stage(1, tree(["scene", "s", -1], ["box", "b", 0]));
  await assert.rejects(edit(link, state, "x", ops), /changed at the same time/);
  assert.deepEqual(asked, [1]);
});

test("refused twice is refused", async () => {
  const { state, link, asked } = stage(2, first);
  await assert.rejects(edit(link, state, "x", ops), /old/);
  assert.equal(asked.length, 2);
});
