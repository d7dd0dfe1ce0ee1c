import assert from "node:assert/strict";
import { test } from "node:test";
import { codePoints, lineSpan, offsetAt, utf16Offset } from "./columns";

// "a", a robot face (two UTF-16 units), an e with accent (one), "b"
const text = "a🤖éb";

test("columns count code points, offsets UTF-16 units", () => {
  assert.deepEqual(
    [0, 1, 2, 3, 4].map((n) => utf16Offset(text, n)),
    [0, 1, 3, 4, 5],
  );
  assert.deepEqual(
    [0, 1, 3, 4, 5].map((n) => codePoints(text, n)),
    [0, 1, 2, 3, 4],
  );
  assert.equal(utf16Offset(text, 99), text.length);
});

test("a line ends before its line end, whichever it is", () => {
  const lines = "one\r\ntwo\nthree";
  assert.deepEqual(lineSpan(lines, 1), { from: 0, to: 3 });
  assert.deepEqual(lineSpan(lines, 2), { from: 5, to: 8 });
  assert.deepEqual(lineSpan(lines, 3), { from: 9, to: 14 });
  assert.deepEqual(lineSpan(lines, 9), { from: 14, to: 14 });
});

test("a column beyond the line is its end", () => {
  assert.equal(offsetAt("🤖x\nyz", 1, 2), 2);
  assert.equal(offsetAt("🤖x\nyz", 1, 50), 3);
  assert.equal(offsetAt("🤖x\nyz", 2, 2), 5);
});
