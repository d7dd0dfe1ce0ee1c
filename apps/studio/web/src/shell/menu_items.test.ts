import assert from "node:assert/strict";
import { test } from "node:test";
import { items_of, menu_of } from "./menu_items";

const all = ["edit:undo", "edit:more", "insert:box", "figures:new", "tools:grid", "figures:old", "overlay:rays", "edit:save"];

test("known commands come first, then the others of the kind", () => {
  assert.deepEqual(items_of("edit", ["edit:undo", "edit:redo", null], all), ["edit:undo", null, "edit:more"]);
  assert.deepEqual(items_of("insert", [], all), ["insert:box"]);
});

test("a command that another menu claims is there alone", () => {
  assert.equal(menu_of("edit:save"), "file");
  assert.deepEqual(items_of("file", ["edit:save"], all), ["edit:save"]);
});

test("what has no menu of its own is under Tools, grouped by kind", () => {
  assert.deepEqual(items_of("tools", [], all), ["figures:new", "figures:old", null, "tools:grid"]);
  assert.deepEqual(items_of("view", [], all), ["overlay:rays"]);
});

test("no line stands at an end or beside another", () => {
  assert.deepEqual(items_of("run", [null, "run:a", null, "run:b", null], ["run:c"]), ["run:c"]);
  assert.deepEqual(items_of("run", ["run:a", null, "run:b", null, "run:d", null], ["run:a", "run:d"]), [
    "run:a",
    null,
    "run:d",
  ]);
});
