import assert from "node:assert/strict";
import { test } from "node:test";
import type { Debug } from "../core/protocol";
import { expressionAt, movedBreakpoints, stateText, toggledBreakpoint } from "./breakpoints";

const at = (line: number, file = "a.cpp", condition = "") => ({ file, line, condition });

test("a click sets a breakpoint, another takes it away", () => {
  const one = toggledBreakpoint([at(3, "b.cpp")], "a.cpp", 3);
  assert.deepEqual(one, [at(3, "b.cpp"), at(3)]);
  assert.deepEqual(toggledBreakpoint(one, "a.cpp", 3), [at(3, "b.cpp")]);
});

test("breakpoints move with the lines of their file alone, and keep their conditions", () => {
  const all = [at(3), at(7, "a.cpp", "x > 1"), at(7, "b.cpp")];
  const two = (line: number) => (line > 4 ? line + 2 : line);
  assert.deepEqual(movedBreakpoints(all, "a.cpp", two), [at(3), at(9, "a.cpp", "x > 1"), at(7, "b.cpp")]);
  assert.equal(
    movedBreakpoints(all, "a.cpp", (line) => line),
    null,
  );
  assert.deepEqual(
    movedBreakpoints([at(3), at(4)], "a.cpp", () => 3),
    [at(3)],
  );
});

test("the expression under the pointer ends at its word", () => {
  const line = "  drive.set(this->pose.x * 2.5);";
  assert.equal(expressionAt(line, line.indexOf("pose"))?.text, "this->pose");
  assert.equal(expressionAt(line, line.indexOf("x *"))?.text, "this->pose.x");
  assert.equal(expressionAt(line, line.indexOf("ive"))?.text, "drive");
  assert.equal(expressionAt(line, line.indexOf("*")), null);
  assert.equal(expressionAt(line, line.indexOf("2.5")), null);
  assert.equal(expressionAt("", 0), null);
});

test("the state names the line of the controller's own source", () => {
  const now = {
    state: "stopped",
    controller: "bot.driver",
    reason: "SIGSEGV: Segmentation fault",
    crashed: true,
    time: 0.25,
    frames: [
      { function: "memcpy", file: "", line: 0 },
      { function: "Driver::update", file: "driver.cpp", line: 9 },
    ],
  } as unknown as Debug;
  assert.equal(stateText(now), "Crashed: SIGSEGV: Segmentation fault at driver.cpp:9, t = 0.25 s");
  assert.equal(stateText({ ...now, state: "off" }), "No controller is in the debugger");
});
