import assert from "node:assert/strict";
import { test } from "node:test";
import { itemsOf, menuOf } from "./menu_items";

const all = [
  "edit:undo",
  "edit:more",
  "insert:box",
  "figures:new",
  "tools:grid",
  "figures:old",
  "overlay:rays",
  "edit:save",
];

test("known commands come first, then the others of the kind", () => {
  assert.deepEqual(itemsOf("edit", ["edit:undo", "edit:redo", null], all), ["edit:undo", null, "edit:more"]);
  assert.deepEqual(itemsOf("insert", [], all), ["insert:box"]);
});

test("a command that another menu claims is there alone", () => {
  assert.equal(menuOf("edit:save"), "file");
  assert.deepEqual(itemsOf("file", ["edit:save"], all), ["edit:save"]);
});

test("what has no menu of its own is under Tools, grouped by kind", () => {
  assert.deepEqual(itemsOf("tools", [], all), ["figures:new", "figures:old", null, "tools:grid"]);
  assert.deepEqual(itemsOf("view", [], all), ["overlay:rays"]);
});

test("no line stands at an end or beside another", () => {
  assert.deepEqual(itemsOf("run", [null, "run:a", null, "run:b", null], ["run:c"]), ["run:c"]);
  assert.deepEqual(itemsOf("run", ["run:a", null, "run:b", null, "run:d", null], ["run:a", "run:d"]), [
    "run:a",
    null,
    "run:d",
  ]);
});
