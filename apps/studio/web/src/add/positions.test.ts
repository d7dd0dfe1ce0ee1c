import assert from "node:assert/strict";
import { test } from "node:test";
import type { SceneBody, TreeElement } from "../core/protocol";
import { State } from "../core/state";
import { Schema } from "../forms/schema";
import { freePosition, frontPosition } from "./positions";
import { commonParent, insertOp, insertPlan, unassembledRobot, parentFor } from "./plan";

test("new elements do not overlap existing ones", () => {
  const others = [{ centre: [0, 0, 0.5] as [number, number, number], radius: 0.3 }];
  const found = freePosition(others, [0, 0, 0.5], 0.2);
  assert.ok(Math.hypot(found[0], found[1]) >= 0.5);
  assert.equal(found[2], 0.5);
  assert.deepEqual(freePosition(others, [2, 0, 0.5], 0.2), [2, 0, 0.5]);
});

const specs: [number, string, string, string][] = [
  [-1, "scene", "", ""],
  [0, "assembly", "robot", "robot"],
  [1, "box", "deck", "robot.deck"],
  [1, "cylinder", "wheel", "robot.wheel"],
  [1, "hinge", "axle", "robot.axle"],
  [0, "box", "crate", "crate"],
];
const elements = specs.map(([parent, tag, name, path], id): TreeElement => ({
  id,
  parent,
  tag,
  name,
  path,
  line: 1,
  column: 1,
  end_line: 1,
  attributes: {},
}));
const xyz = { name: "xyz", kind: "numbers" };
const reference = (name: string, required: boolean) => ({ name, kind: "reference", required });
const holds = ["assembly", "box", "hinge", "motor", "camera", "light"];
const schema = new Schema({
  elements: [
    { name: "scene", children: holds },
    { name: "assembly", children: holds.filter((h) => h !== "light"), attributes: [xyz] },
    { name: "box", attributes: [{ name: "name" }, { name: "size", required: true }, xyz] },
    { name: "hinge", attributes: [{ name: "name" }, reference("parent", false), reference("child", true), xyz] },
    {
      name: "motor",
      attributes: [{ name: "name" }, reference("joint", true), { name: "max-torque" }, { name: "max-force" }],
    },
    { name: "camera", attributes: [{ name: "name" }, reference("on", true), xyz] },
    { name: "light", attributes: [{ name: "name" }, { name: "type" }, xyz] },
  ],
});
function plan(tag: string, selection: number[]) {
  const state = new State();
  state.tree.value = { version: 1, elements };
  state.selection.value = selection;
  return insertPlan(state, schema, tag);
}

test("new elements go into the selected group, or beside the selection", () => {
  assert.equal(parentFor(schema, elements, 1, "box"), 1);
  assert.equal(parentFor(schema, elements, 2, "box"), 1);
  assert.equal(parentFor(schema, elements, 5, "box"), 0);
  assert.equal(parentFor(schema, elements, 1, "light"), 0);
  assert.equal(commonParent(elements, 2, 3), 1);
  assert.equal(commonParent(elements, 2, 5), 0);
});

test("a box has a size and stands on the ground", () => {
  const { attributes, missing } = plan("box", []);
  assert.deepEqual(attributes, { name: "box", size: "20 20 20 cm", xyz: "0 0 0.1" });
  assert.deepEqual(missing, []);
});

test("a joint takes the two selected bodies by names that are valid at its position", () => {
  const inside = plan("hinge", [2, 3]);
  assert.deepEqual(
    [inside.parent, inside.attributes.parent, inside.attributes.child, inside.missing],
    [1, "deck", "wheel", []],
  );
  const across = plan("hinge", [5, 3]);
  assert.deepEqual([across.parent, across.attributes.parent, across.attributes.child], [0, "crate", "robot.wheel"]);
  assert.deepEqual(plan("hinge", []).missing, ["parent", "child"]);
});

test("a motor takes the only joint and stands beside it", () => {
  const motor = plan("motor", [2]);
  assert.deepEqual([motor.parent, motor.attributes.joint, motor.attributes["max-torque"]], [1, "axle", "1 N*m"]);
});

test("a robot that is not one assembly is found by its motors", () => {
  const rows: [number, string, string, Record<string, string>][] = [
    [-1, "scene", "", {}],
    [0, "plane", "floor", {}],
    [0, "box", "deck", {}],
    [0, "cylinder", "wheel", {}],
    [0, "box", "other", {}],
    [0, "hinge", "axle", { parent: "deck", child: "wheel" }],
    [0, "motor", "left", { joint: "axle" }],
    [0, "camera", "eye", { on: "deck" }],
    [0, "camera", "room", { on: "other" }],
    [0, "slider", "rail", { parent: "floor", child: "deck" }],
  ];
  const unattached = (list: typeof rows) =>
    unassembledRobot(
      list.map(([parent, tag, name, attributes], id) => ({
        id,
        parent,
        tag,
        name,
        path: name,
        attributes,
        line: 1,
        column: 1,
        end_line: 1,
      })),
    );
  assert.deepEqual(unattached(rows), [2, 3, 5, 6, 7, 9]);
  assert.deepEqual(unattached(rows.filter(([, tag]) => tag !== "motor")), []);
});

test("sensors stand at the front of their body, one beside the other", () => {
  const deck = {
    pose: [0, 0, 0, 1, 0, 0, 0],
    shapes: [{ type: "box", pose: [0, 0, 0, 1, 0, 0, 0], size: [0.24, 0.12, 0.04] }],
  };
  const position = (count: number, high: boolean) => frontPosition(deck as unknown as SceneBody, count, high);
  assert.deepEqual(position(0, true), [0.12, 0, 0.02]);
  assert.deepEqual(
    [position(0, false), position(1, false), position(2, false)],
    [
      [0.12, 0.04, 0],
      [0.12, -0.04, 0],
      [0.12, 0, 0],
    ],
  );
  // A cylinder that lies across reaches as far to the sides as it is long.
  const lying = {
    shapes: [{ type: "cylinder", pose: [0, 0, 0, Math.SQRT1_2, Math.SQRT1_2, 0, 0], size: [0.05, 0.3] }],
  };
  assert.deepEqual(frontPosition(lying as unknown as SceneBody, 0, false), [0.05, 0.1, 0]);
  const ground = { shapes: [{ type: "plane", pose: [0, 0, 0, 1, 0, 0, 0], size: [4, 4] }] };
  assert.equal(frontPosition(ground as unknown as SceneBody, 0, false), null);
});

test("a sensor sits on the selected body", () => {
  const camera = plan("camera", [5]);
  assert.deepEqual([camera.parent, camera.attributes.on, camera.attributes.xyz], [0, "crate", undefined]);
  assert.deepEqual(plan("camera", []).missing, ["on"]);
});

test("parameters become a <set> inside", () => {
  const op = insertOp(
    { tag: "controller", parent: 1, attributes: { plugin: "drive", name: "" }, missing: [] },
    { speed: "1 m/s" },
  );
  assert.deepEqual(op, {
    op: "insert",
    parent: 1,
    xml: '<controller plugin="drive">\n  <set speed="1 m/s"/>\n</controller>',
    before: null,
  });
});
