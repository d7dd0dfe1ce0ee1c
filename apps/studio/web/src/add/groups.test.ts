import assert from "node:assert/strict";
import { test } from "node:test";
import { insertMenus, kInsertGroups } from "./groups";

test("robots come first, what no group names comes last, and nothing is lost", () => {
  const ids = ["insert:box", "insert:measure", "robot:car", "insert:hinge", "robot:arm"];
  const menus = insertMenus(ids);
  assert.deepEqual(
    menus.map((m) => m.title),
    ["Robot", "Bodies", "Joints", "More"],
  );
  assert.deepEqual(menus.flatMap((m) => m.ids).sort(), [...ids].sort());
});

test("no element is in two groups", () => {
  const tags = kInsertGroups.flatMap((g) => g.of.map(([tag]) => tag));
  assert.equal(new Set(tags).size, tags.length);
});
