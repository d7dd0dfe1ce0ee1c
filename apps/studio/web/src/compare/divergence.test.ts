import assert from "node:assert/strict";
import { test } from "node:test";
import { around, differenceOf, divergenceFigure, explanation, lengthText, rowsOf, type Divergence } from "./divergence";

const data: Divergence = {
  time: [0, 0.1, 0.2],
  worst: [0, 0.02, 0.5],
  worst_angle: [0, 0.001, 0.2],
  bodies: [
    { name: "near", distance: [0, 0.001, 0.009] },
    { name: "far", distance: [0, 0.02, 0.5] },
    { name: "gone", distance: [null, null, null] },
  ],
  first: { time: 0.1, name: "far" },
  labels: ["bullet", "cogrsim"],
};

test("rows: the worst first, diverged from 1 cm on", () => {
  assert.deepEqual(rowsOf(data, 1), [
    { name: "far", now: 0.02, most: 0.5, since: 0.1 },
    { name: "near", now: 0.001, most: 0.009, since: null },
    { name: "gone", now: null, most: null, since: null },
  ]);
});

test("the figure has the worst bodies on the left, the turn on the right, and the threshold", () => {
  const figure = divergenceFigure(data, true, 2);
  assert.deepEqual(
    figure.series.map((s) => [s.label, s.axis, s.y]),
    [
      ["far", 0, [0, 0.02, 0.5]],
      ["near", 0, [0, 0.001, 0.009]],
      ["largest turn", 1, [0, 0.001, 0.2]],
    ],
  );
  assert.deepEqual(figure.levels, [{ value: 0.01, label: "1 cm" }]);
});

test("what differs is read from the labels", () => {
  const backends = ["bullet", "cogrsim"];
  assert.equal(differenceOf(["bullet", "cogrsim"], backends), "backend");
  assert.equal(differenceOf(["bullet, 1 ms", "bullet, 0.5 ms"], backends), "step");
  assert.match(explanation("step", ["a", "b"]).join(" "), /Solid is a, the ghost is b/);
});

test("events just before the divergence", () => {
  const event = (index: number, time: number) => ({
    index,
    time,
    kind: "contact",
    source: "",
    subject: "",
    message: "",
  });
  const events = [event(0, 0.1), event(1, 0.9), event(2, 1.01), event(3, 1.5)];
  assert.deepEqual(
    around(events, 1).map((e) => e.index),
    [1, 2],
  );
});

test("lengths for people", () => {
  assert.equal(lengthText(null), "–");
  assert.equal(lengthText(0), "0");
  assert.equal(lengthText(3e-9), "3.0e-9 m");
  assert.equal(lengthText(0.0000321), "32.1 µm");
  assert.equal(lengthText(0.00321), "3.21 mm");
  assert.equal(lengthText(0.0321), "3.21 cm");
  assert.equal(lengthText(1.254), "1.25 m");
});
