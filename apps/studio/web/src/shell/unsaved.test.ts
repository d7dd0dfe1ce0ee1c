import assert from "node:assert/strict";
import { test } from "node:test";
import type { DocumentState } from "../core/protocol";
import { hasLess } from "./unsaved";

test("a page offers its changes only to a studio that does not have them", () => {
  const now = (text: string, dirty = false) => ({ text, dirty, file: "a.scene.xml" }) as DocumentState;
  const lost = { text: "edited", file: "a.scene.xml" };
  const offer = { number: 1, time: 0, changed: false, more: 0 };
  assert.ok(hasLess(lost, now("old"), null));
  assert.ok(!hasLess(null, now("old"), null), "all was saved");
  assert.ok(!hasLess(lost, now("edited"), null), "it has it");
  assert.ok(!hasLess(lost, now("old"), offer), "it offers it");
  assert.ok(!hasLess(lost, now("other", true), null), "the same studio is still running");
  assert.ok(!hasLess(lost, { ...now("old"), file: "b.scene.xml" }, null), "another scene");
});
