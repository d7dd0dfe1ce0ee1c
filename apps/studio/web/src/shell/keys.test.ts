import assert from "node:assert/strict";
import { test } from "node:test";
import { commandOf, kKeys, mayFire, namesOf } from "./keys";

const key = (k: string, more: Partial<KeyboardEvent> = {}) =>
  ({ key: k, ctrlKey: false, metaKey: false, shiftKey: false, altKey: false, ...more }) as KeyboardEvent;

test("no key is given twice", () => {
  const keys = kKeys.map(([k]) => k);
  assert.equal(new Set(keys).size, keys.length);
});

test("keys find their commands on keyboards of several countries", () => {
  assert.equal(commandOf(key(" ")), "run:toggle");
  assert.equal(commandOf(key("f")), "view:focus");
  assert.equal(commandOf(key("F", { shiftKey: true })), undefined);
  assert.equal(commandOf(key("?", { shiftKey: true })), "help:shortcuts");
  assert.equal(commandOf(key("+")), undefined);
  assert.equal(commandOf(key("+", { shiftKey: true })), "run:faster");
  assert.equal(commandOf(key("=", { shiftKey: true })), "run:faster", "German: = is Shift 0");
  assert.equal(commandOf(key("z", { ctrlKey: true })), "edit:undo");
  assert.equal(commandOf(key("Z", { ctrlKey: true, shiftKey: true })), "edit:redo");
  assert.equal(commandOf(key("z", { metaKey: true })), "edit:undo");
  assert.equal(commandOf(key("1", { ctrlKey: true })), undefined);
  assert.deepEqual(namesOf(key("ArrowLeft", { altKey: true })), [], "the browser's own key for going back");
});

test("in a text field only saving, the palette and the debugger act, in the scene's editor the history too", () => {
  const text = ["edit:save", "help:palette", "debug:continue", "debug:over", "debug:into", "debug:out"];
  for (const [name, command] of kKeys) {
    const k = name === "Space" ? " " : name;
    assert.equal(mayFire(command, k, "text"), text.includes(command), command);
    assert.equal(mayFire(command, k, "choice"), [...text, "run:toggle"].includes(command), command);
    assert.equal(mayFire(command, k, "code"), [...text, "edit:undo", "edit:redo"].includes(command), command);
    assert.equal(mayFire(command, k, "page"), true);
  }
  for (const where of ["control", "tab", "tree"] as const)
    assert.equal(mayFire("run:toggle", " ", where), true, "Space plays whatever has the focus");
  assert.equal(mayFire("run:toggle", " ", "switch"), false, "Space is the only key of a check box");
  assert.equal(mayFire("edit:delete", "Delete", "tree"), true);
  assert.equal(mayFire("view:deselect", "Escape", "tree"), true);
  assert.equal(mayFire("view:deselect", "Escape", "switch"), false, "it closes the menu");
  assert.equal(mayFire("run:step", "ArrowRight", "tree"), false);
  assert.equal(mayFire("edit:delete", "Delete", "tab"), false);
  assert.equal(mayFire("view:top", "5", "control"), true);
});
