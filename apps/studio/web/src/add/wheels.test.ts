import assert from "node:assert/strict";
import { test } from "node:test";
import type { SceneBody, TreeElement } from "../core/protocol";
import { wheelOps } from "./wheels";

const element = {
  id: 3,
  parent: 0,
  tag: "box",
  name: "chassis",
  path: "chassis",
  attributes: {},
} as unknown as TreeElement;
const scene = { id: 0, parent: -1, tag: "scene", name: "", path: "", attributes: {} } as unknown as TreeElement;
const body = (pose = [1, 2, 0.02, 1, 0, 0, 0]): SceneBody =>
  ({
    pose,
    shapes: [{ type: "box", size: [0.24, 0.14, 0.04], pose: [0, 0, 0, 1, 0, 0, 0] }],
  }) as unknown as SceneBody;

test("wheels, axles, motors and a caster carry the body above the floor", () => {
  const planned = wheelOps([scene, element], element, body(), 0);
  assert.ok(typeof planned !== "string");
  assert.deepEqual(
    planned.made.map((part) => [part.tag, part.attributes.name]),
    [
      ["cylinder", "wheel_left"],
      ["hinge", "axle_left"],
      ["motor", "left"],
      ["cylinder", "wheel_right"],
      ["hinge", "axle_right"],
      ["motor", "right"],
      ["sphere", "caster"],
      ["fixed", "caster_mount"],
    ],
  );
  // the body's middle is at the height of the axle; wheels and caster touch the floor, and the caster the body
  assert.ok(Math.abs(planned.pose[2] - 0.05) < 1e-9);
  const [left, , , right, , , caster] = planned.made;
  for (const wheel of [left, right]) {
    assert.equal(wheel!.attributes.radius, "5 cm");
    assert.ok(Math.abs(planned.pose[2] + wheel!.at![2] - 0.05) < 1e-9);
  }
  assert.equal(caster!.attributes.radius, "1.5 cm");
  assert.ok(Math.abs(planned.pose[2] + caster!.at![2] - 0.015) < 1e-9);
  assert.ok(left!.at![1] > 0.07 && Math.abs(left!.at![1] + right!.at![1]) < 1e-12);
});

test("names that are taken get a number, together", () => {
  const taken = { ...element, id: 4, name: "axle_left" };
  const planned = wheelOps([scene, element, taken], element, body(), 0);
  assert.ok(typeof planned !== "string");
  assert.equal(planned.made[1]!.attributes.name, "axle_left_2");
  assert.equal(planned.made[1]!.attributes.child, "wheel_left_2");
  assert.equal(planned.made[2]!.attributes.joint, "axle_left_2");
});

test("what is tilted, or has no shape with an end, gets none", () => {
  assert.match(String(wheelOps([scene, element], element, body([0, 0, 0, 0.7, 0.7, 0, 0]), 0)), /tilted/);
  const plane = {
    ...body(),
    shapes: [{ type: "plane", size: [1, 1], pose: [0, 0, 0, 1, 0, 0, 0] }],
  } as unknown as SceneBody;
  assert.match(String(wheelOps([scene, element], element, plane, 0)), /wheels go on/);
});
