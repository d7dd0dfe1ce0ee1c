import assert from "node:assert/strict";
import { test } from "node:test";
import type { Pose, Scene } from "../core/protocol";
import { kTolerance, momentOf, runsOf, seenOf, testXml, type TestResult } from "./write";

const scene = {
  bodies: [
    { name: "floor", kind: "fixed" },
    { name: "bot.crate", kind: "dynamic" },
  ],
  joints: [
    { name: "bot.knee", type: "hinge", element: 5, child: 1, parent: -1 },
    { name: "bot.ball", type: "ball", element: 6, child: 1, parent: -1 },
  ],
} as unknown as Scene;
const pose: Pose = [1.23456789, -0.5, 0, 1, 0, 0, 0];
const seen = (selected: number[], bodies: number[]) =>
  seenOf(
    scene,
    selected,
    bodies,
    () => pose,
    (joint) => (joint === 0 ? Math.PI / 6 : null),
  );

test("a body is seen where it is, a joint at its coordinate, a fixed body not at all", () => {
  assert.deepEqual(
    seen([3], [0, 1]).map((s) => s.that),
    ["bot.crate.x", "bot.crate.y", "bot.crate.z"],
  );
  assert.deepEqual(seen([5], [1]), [{ that: "bot.knee.position", value: Math.PI / 6, unit: "rad" }]);
  assert.deepEqual(seen([], []), []);
});

test("the test says it with units, and hostile names stay text", () => {
  assert.equal(
    testXml('a "b" <c>', 1.2000000000000002, seen([5], []), kTolerance),
    '<test name="a &quot;b&quot; &lt;c>" duration="1.2 s">\n  <expect that="bot.knee.position" equals="30 deg" tolerance="1 deg"/>\n</test>',
  );
  assert.match(
    testXml("t", 1, seen([], [1]), kTolerance),
    /that="bot\.crate\.x" equals="1\.23457 m" tolerance="0\.01 m"/,
  );
});

test("each engine alone, and together what compares them", () => {
  const one = { name: "t", line: 1, expectations: 2, agrees: 1, backends: [] };
  assert.deepEqual(runsOf(one, ["a", "b"]), [["a"], ["b"], ["a", "b"]]);
  assert.deepEqual(runsOf(one, ["a"]), [["a"]]);
  assert.deepEqual(runsOf({ ...one, expectations: 0 }, ["a", "b"]), [["a", "b"]]);
  assert.deepEqual(runsOf({ ...one, agrees: 0, backends: ["b", "c"] }, ["a", "b"]), [["b"]]);
});

test("the moment is that of the first failure", () => {
  const verdict = { expectation: "always x", message: "", line: 3, column: 5 };
  const result = {
    status: "failed",
    message: "",
    errors: [],
    verdicts: [
      { ...verdict, passed: true, time: 0.1 },
      { ...verdict, passed: false, time: 0.7 },
    ],
  } as TestResult;
  assert.equal(momentOf(result), 0.7);
  assert.equal(momentOf({ ...result, verdicts: [] }), null);
});
