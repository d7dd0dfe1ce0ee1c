import assert from "node:assert/strict";
import { test } from "node:test";
import { command_of, kKeys, may_fire, names_of } from "./keys";

const key = (k: string, more: Partial<KeyboardEvent> = {}) =>
  ({ key: k, ctrlKey: false, metaKey: false, shiftKey: false, altKey: false, ...more }) as KeyboardEvent;

test("no key is given twice", () => {
  const keys = kKeys.map(([k]) => k);
  assert.equal(new Set(keys).size, keys.length);
});

test("keys find their commands on keyboards of several countries", () => {
  assert.equal(command_of(key(" ")), "run:toggle");
  assert.equal(command_of(key("f")), "view:focus");
  assert.equal(command_of(key("F", { shiftKey: true })), undefined);
  assert.equal(command_of(key("?", { shiftKey: true })), "help:shortcuts");
  assert.equal(command_of(key("+")), undefined);
  assert.equal(command_of(key("+", { shiftKey: true })), "run:faster");
  assert.equal(command_of(key("=", { shiftKey: true })), "run:faster", "German: = is Shift 0");
  assert.equal(command_of(key("z", { ctrlKey: true })), "edit:undo");
  assert.equal(command_of(key("Z", { ctrlKey: true, shiftKey: true })), "edit:redo");
  assert.equal(command_of(key("z", { metaKey: true })), "edit:undo");
  assert.equal(command_of(key("1", { ctrlKey: true })), undefined);
  assert.deepEqual(names_of(key("ArrowLeft", { altKey: true })), [], "the browser's own key for going back");
});

test("in a text field only saving and the palette act, in the scene's editor the history too", () => {
  for (const [name, command] of kKeys) {
    const k = name === "Space" ? " " : name;
    assert.equal(may_fire(command, k, "text"), ["edit:save", "help:palette"].includes(command), command);
    assert.equal(
      may_fire(command, k, "code"),
      ["edit:save", "help:palette", "edit:undo", "edit:redo"].includes(command),
      command,
    );
    assert.equal(may_fire(command, k, "page"), true);
  }
  assert.equal(may_fire("run:toggle", " ", "control"), false, "Space presses the button that has the focus");
  assert.equal(may_fire("edit:delete", "Delete", "control"), true, "in the tree");
  assert.equal(may_fire("edit:delete", "Delete", "tab"), false);
  assert.equal(may_fire("view:top", "5", "control"), true);
});
