import assert from "node:assert/strict";
import { test } from "node:test";
import type { Problem, TreeElement } from "../core/protocol";
import { elementAt, problemRange, sameFile, tagAround, writtenSelection } from "./spans";

const problem = (line: number, column: number, length: number): Problem => ({
  severity: "error",
  code: "x",
  message: "m",
  help: "",
  file: "a.scene.xml",
  line,
  column,
  length,
  notes: [],
});

test("the cursor goes between the first quotes that were written, to rewrite what stands there", () => {
  assert.deepEqual(writtenSelection('mass=""', 10), { anchor: 16, head: 16 });
  assert.deepEqual(writtenSelection('box name="" size=""', 5), { anchor: 15, head: 15 });
  assert.deepEqual(writtenSelection('speed="0.3 m/s"', 0), { anchor: 7, head: 14 });
  assert.deepEqual(writtenSelection("true", 3), { anchor: 7, head: 7 });
});

test("a problem is underlined at its exact position, behind characters of two units too", () => {
  const text = '<scene>\n  <box name="🤖" size="oops"/>\n</scene>\n';
  // code points before "oops" in its line: 2 + len('<box name="') + 1 robot + len('" size="')
  const column = 2 + 11 + 1 + 8 + 1;
  const range = problemRange(text, problem(2, column, 4));
  assert.equal(text.slice(range.from, range.to), "oops");
});

test("a problem without length is still seen", () => {
  const text = "<a>\n<b";
  assert.deepEqual(problemRange(text, problem(1, 1, 0)), { from: 0, to: 1 });
  // behind the last character: the last one is marked
  assert.deepEqual(problemRange(text, problem(2, 3, 0)), { from: 5, to: 6 });
});

const element = (id: number, parent: number, line: number, column: number, endLine: number): TreeElement => ({
  id,
  parent,
  tag: "box",
  name: "",
  path: "",
  line,
  column,
  end_line: endLine,
  attributes: {},
});

test("the innermost element around a position", () => {
  const elements = [element(0, -1, 1, 1, 9), element(1, 0, 2, 3, 5), element(2, 1, 3, 5, 3), element(3, 0, 6, 3, 6)];
  assert.equal(elementAt(elements, 1, 1), 0);
  assert.equal(elementAt(elements, 3, 8), 2);
  assert.equal(elementAt(elements, 4, 1), 1);
  assert.equal(elementAt(elements, 6, 1), 0);
  assert.equal(elementAt(elements, 6, 4), 3);
  assert.equal(elementAt(elements, 12, 1), -1);
});

test("the tag around a position, not the text between tags", () => {
  const text = '<a b="1 > 0"> text <c/></a>';
  assert.equal(tagAround(text, 8)?.tag, "a");
  assert.equal(tagAround(text, 15), null);
  assert.equal(tagAround(text, 20)?.tag, "c");
});

test("files are the same by their last name", () => {
  assert.ok(sameFile("/home/x/a.scene.xml", "a.scene.xml"));
  assert.ok(!sameFile("b.scene.xml", "a.scene.xml"));
});
