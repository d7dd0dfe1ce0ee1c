import assert from "node:assert/strict";
import { test } from "node:test";
import { panelsIn, phone, presets, readArea, sameOrder, without } from "./layouts";

const known = (p: string) =>
  [
    ...["view3d", "map", "tree", "properties", "joints", "code", "cameras", "figures", "compare", "tests", "debug"],
    "console",
  ].includes(p);

test("every preset is read back as it was written and names no panel twice", () => {
  for (const [name, area] of Object.entries({ ...presets, phone })) {
    assert.deepEqual(readArea(JSON.stringify(area), known), area, name);
    const panels = panelsIn(area);
    assert.equal(new Set(panels).size, panels.length, name);
    assert.ok(panels.includes("view3d"), name);
  }
});

test("an invalid arrangement is refused", () => {
  for (const text of [null, "", "{", "3", "null", "[]", '{"type":"tabs","panels":3}', '{"type":"tabs","panels":[]}']) {
    assert.equal(readArea(text, known), null, String(text));
  }
});

test("unknown and repeated panels are left out, and areas that are left empty too", () => {
  const text = JSON.stringify({
    type: "split",
    orientation: "vertical",
    sizes: [1, "x", -3, 2],
    children: [
      { type: "tabs", panels: ["gone", "map", "code"], current: 2 },
      { type: "tabs", panels: ["map"], current: 7 },
      { type: "tabs", panels: ["gone"] },
      { type: "tabs", panels: ["tree", 4], current: 1 },
    ],
  });
  assert.deepEqual(readArea(text, known), {
    type: "split",
    orientation: "vertical",
    sizes: [1, 2],
    children: [
      { type: "tabs", panels: ["map", "code"], current: 1 },
      { type: "tabs", panels: ["tree"], current: 0 },
    ],
  });
});

test("a split with one area left is that area; endless nesting is cut", () => {
  const inner = { type: "tabs", panels: ["map"], current: 0 };
  assert.deepEqual(readArea(JSON.stringify({ type: "split", children: [inner] }), known), inner);
  let deep: unknown = inner;
  for (let i = 0; i < 100; ++i) deep = { type: "split", children: [deep] };
  assert.equal(readArea(JSON.stringify(deep), known), null);
});

test("an arrangement without a panel is the rest after closing it", () => {
  const edit = presets.Edit!;
  const left = without(edit, "code")!;
  assert.deepEqual(
    panelsIn(left),
    panelsIn(edit).filter((p) => p !== "code"),
  );
  assert.ok(sameOrder(left, without(edit, "code")));
  assert.ok(!sameOrder(left, edit));
  assert.ok(!sameOrder(left, without(edit, "map")));
  const wider = JSON.parse(JSON.stringify(left)) as typeof left;
  if (wider.type === "split") wider.sizes[0] = 9;
  assert.ok(sameOrder(left, wider));
  assert.equal(without({ type: "tabs", panels: ["map"], current: 0 }, "map"), null);
});
