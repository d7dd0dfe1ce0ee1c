import assert from "node:assert/strict";
import { test } from "node:test";
import type { TreeElement } from "../core/protocol";
import { Schema } from "../forms/schema";
import { elementKeys, topMost, treeRows, typeAhead, visibleRows, type RowOptions } from "./model";
import { dropOps, dropTarget, dropZone, refuseDrop } from "./rules";

// scene > (floor, robot > (deck, wheel), crate, repeat > stone)
const specs: [number, string, string][] = [
  [-1, "scene", ""],
  [0, "plane", "floor"],
  [0, "assembly", "robot"],
  [2, "box", "deck"],
  [2, "cylinder", "wheel"],
  [0, "box", "crate"],
  [0, "repeat", ""],
  [6, "box", "stone"],
];
const elements = specs.map(([parent, tag, name], id): TreeElement => ({
  id,
  parent,
  tag,
  name,
  path: name,
  line: id + 1,
  column: 1,
  end_line: id + 1,
  attributes: name ? { name } : {},
}));
const keys = elementKeys(elements);
const options = (other: Partial<RowOptions> = {}): RowOptions => ({
  closed: new Set(),
  keys,
  search: "",
  signals: new Map(),
  ...other,
});
const schema = new Schema({
  elements: [
    { name: "scene", children: ["plane", "assembly", "box", "cylinder", "repeat"] },
    { name: "assembly", children: ["box", "cylinder", "assembly", "repeat"] },
    { name: "box" },
    { name: "plane" },
    { name: "cylinder" },
    { name: "repeat", flow: true },
  ],
});

test("rows go down the tree with their depth and index among siblings", () => {
  const rows = treeRows(elements, options());
  assert.deepEqual(
    rows.map((r) => [r.id, r.depth]),
    [
      [0, 0],
      [1, 1],
      [2, 1],
      [3, 2],
      [4, 2],
      [5, 1],
      [6, 1],
      [7, 2],
    ],
  );
  assert.deepEqual([rows[2]!.position, rows[2]!.siblings, rows[2]!.expanded], [2, 4, true]);
  assert.equal(rows[1]!.expanded, null);
});

test("closed elements hide what is inside", () => {
  const rows = treeRows(elements, options({ closed: new Set([keys[2]!]) }));
  assert.deepEqual(
    rows.map((r) => r.id),
    [0, 1, 2, 5, 6, 7],
  );
  assert.equal(rows[2]!.expanded, false);
});

test("a search keeps what is found and what is around it, though it was closed", () => {
  const rows = treeRows(elements, options({ search: "WHEEL", closed: new Set([keys[2]!]) }));
  assert.deepEqual(
    rows.map((r) => [r.id, r.found]),
    [
      [0, false],
      [2, false],
      [4, true],
    ],
  );
  // all words must be there; tags count as well
  assert.deepEqual(
    treeRows(elements, options({ search: "box st" })).map((r) => r.id),
    [0, 6, 7],
  );
  assert.deepEqual(treeRows(elements, options({ search: "nowhere" })), []);
});

test("signals stand below their owner, before what is inside it", () => {
  const signal = { name: "robot.x", unit: "m", owner: "robot" };
  const rows = treeRows(elements, options({ signals: new Map([[2, [signal]]]) }));
  assert.deepEqual(
    rows.slice(2, 5).map((r) => [r.id, r.signal?.name, r.position, r.siblings]),
    [
      [2, undefined, 2, 4],
      [2, "robot.x", 1, 3],
      [3, undefined, 2, 3],
    ],
  );
});

test("keys outlive other elements' coming and going", () => {
  const fewer = elements
    .filter((e) => e.id !== 1)
    .map((e, id) => ({ ...e, id, parent: e.parent > 1 ? e.parent - 1 : e.parent }));
  assert.equal(elementKeys(fewer)[1], keys[2]);
  assert.equal(new Set(keys).size, keys.length);
});

test("of ten thousand rows only those in sight are drawn", () => {
  assert.deepEqual(visibleRows(10000, 24, 0, 480), { first: 0, last: 28 });
  assert.deepEqual(visibleRows(10000, 24, 24 * 5000, 480), { first: 4992, last: 5028 });
  assert.deepEqual(visibleRows(10000, 24, 24 * 9980, 480), { first: 9972, last: 10000 });
  assert.deepEqual(visibleRows(3, 24, 9999, 480), { first: 3, last: 3 });
});

test("type-ahead goes round", () => {
  const labels = ["deck", "wheel", "crate", "world"];
  assert.equal(typeAhead(labels, 2, "W"), 3);
  assert.equal(typeAhead(labels, 3, "whe"), 1);
  assert.equal(typeAhead(labels, 0, "z"), -1);
});

test("what stands in something chosen goes with it", () => {
  assert.deepEqual(topMost(elements, [4, 2, 5, 0]), []); // all stand in the scene
  assert.deepEqual(topMost(elements, [5, 4, 2]), [2, 5]);
});

test("drop targets", () => {
  assert.deepEqual(
    [0.1, 0.5, 0.9].map((y) => dropZone(y, true)),
    ["before", "into", "after"],
  );
  assert.deepEqual(
    [0.4, 0.6].map((y) => dropZone(y, false)),
    ["before", "after"],
  );
  assert.deepEqual(dropTarget(elements, 2, "into"), { parent: 2, before: null });
  assert.deepEqual(dropTarget(elements, 2, "after"), { parent: 0, before: 5 });
  assert.deepEqual(dropTarget(elements, 6, "after"), { parent: 0, before: null });
  assert.equal(dropTarget(elements, 0, "before"), null);
});

test("what may go where", () => {
  assert.equal(refuseDrop(schema, elements, [5], { parent: 2, before: null }), "");
  assert.match(refuseDrop(schema, elements, [2], { parent: 2, before: null }), /into itself/);
  assert.match(refuseDrop(schema, elements, [1], { parent: 2, before: null }), /<assembly> holds no <plane>/);
  assert.match(refuseDrop(schema, elements, [5], { parent: 3, before: null }), /<box> holds no <box>/);
  assert.match(refuseDrop(schema, elements, [0], { parent: 2, before: null }), /stays where it is/);
  // repeat holds what the scene around it holds
  assert.equal(refuseDrop(schema, elements, [1], { parent: 6, before: null }), "");
});

test("dropping where it is changes nothing, several keep their order", () => {
  assert.deepEqual(dropOps(elements, [2], { parent: 0, before: 5 }), []);
  assert.deepEqual(dropOps(elements, [2], { parent: 0, before: 2 }), []);
  const ops = dropOps(elements, [5, 1], { parent: 2, before: 3 });
  assert.deepEqual(
    ops.map((op) => op.op === "move" && [op.element, op.parent, op.before]),
    [
      [1, 2, 3],
      [5, 2, 3],
    ],
  );
});
