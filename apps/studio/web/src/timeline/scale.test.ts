import assert from "node:assert/strict";
import { test } from "node:test";
import { groups, neighbour, extent, share, shift, ticks, timeAt, timeText, zoom } from "./scale";

const whole = { from: 0, to: 10 };

test("zooming keeps the time under the pointer", () => {
  let span = whole;
  for (let i = 0; i < 8; ++i) {
    const before = timeAt(span, 0.3);
    span = zoom(span, 0.3, 1.5, whole)!;
    assert.ok(Math.abs(timeAt(span, 0.3) - before) < 1e-12);
  }
});

test("zooming out ends at the whole and stays inside", () => {
  assert.equal(zoom({ from: 2, to: 8 }, 0.5, 0.5, whole), null);
  assert.deepEqual(zoom({ from: 0, to: 2 }, 1, 0.5, whole), { from: 0, to: 4 });
  const least = zoom({ from: 5, to: 5.001 }, 0.5, 1e9, whole)!;
  assert.ok(least.to - least.from >= 0.999e-3);
});

test("a span is not moved out of the whole", () => {
  assert.deepEqual(shift({ from: 8, to: 9 }, 5, whole), { from: 9, to: 10 });
  assert.deepEqual(shift({ from: 1, to: 2 }, -5, whole), { from: 0, to: 1 });
  assert.deepEqual(shift({ from: 1, to: 2 }, 3, whole), { from: 4, to: 5 });
});

test("ticks are round, in order, inside and not too many", () => {
  for (const span of [whole, { from: 0.0123, to: 0.0199 }, { from: 99.5, to: 4000 }]) {
    const all = ticks(span);
    assert.ok(all.length >= 3 && all.length <= 10, `${all.length} ticks`);
    assert.ok(all.every((t) => share(span, t) > -1e-6 && share(span, t) < 1 + 1e-6));
  }
  assert.deepEqual(ticks(whole), [0, 2, 4, 6, 8, 10]);
  assert.deepEqual(ticks({ from: 1, to: 1 }), []);
});

test("times are written as exactly as they differ", () => {
  assert.equal(timeText(2, 2), "2 s");
  assert.equal(timeText(0.3, 0.1), "0.3 s");
  assert.equal(timeText(0.0125, 0.0005), "0.0125 s");
});

test("marks that overlap are gathered, marks outside are not shown", () => {
  assert.deepEqual(
    groups([-1, 0, 0.01, 5, 5.001, 11], whole, 0.01).map(({ first, end }) => [first, end]),
    [
      [1, 3],
      [3, 5],
    ],
  );
});

test("the next and the previous are not the present one", () => {
  const times = [1, 2, 2, 3];
  assert.equal(neighbour(times, 2, 1), 3);
  assert.equal(neighbour(times, 2, -1), 1);
  assert.equal(neighbour(times, 3, 1), undefined);
  assert.equal(neighbour([], 3, -1), undefined);
});

test("the scale of a run that grows has space, changes seldom, and ends where the run will", () => {
  assert.deepEqual(
    [0, 10, 10.1, 21, 51, 150, 1001].map((t) => extent(t, null)),
    [10, 10, 20, 50, 100, 200, 2000],
  );
  assert.equal(extent(1, 3), 3);
  assert.equal(extent(1, 30), 10);
  assert.equal(extent(15, 12), 15, "a run that was continued");
});
