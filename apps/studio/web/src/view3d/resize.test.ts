import assert from "node:assert/strict";
import { test } from "node:test";
import type { Scene, TreeElement } from "../core/protocol";
import { resized, whyNotResized } from "./resize";

const element = (tag: string, attributes: Record<string, string>) =>
  ({ id: 1, tag, attributes }) as unknown as TreeElement;

test("each axis changes its own size, in the unit that it has", () => {
  const box = element("box", { size: "40 20 10 cm" });
  assert.deepEqual(resized(box, [1, 1.5, 1], null)!.attributes, [["size", "40 30 10 cm"]]);
  assert.equal(resized(box, [1.26, 1, 1], 0.01)!.text, "size 50 20 10 cm");
  const mixed = element("box", { size: "0.4 m 20 cm 1 m" });
  assert.deepEqual(resized(mixed, [2, 1, 1], null)!.attributes, [["size", "0.8 m 20 cm 1 m"]]);
});

test("round things keep round", () => {
  const can = element("cylinder", { radius: "10 cm", length: "0.5" });
  const wide = resized(can, [1, 2, 1], null)!;
  assert.deepEqual(wide.attributes, [
    ["radius", "20 cm"],
    ["length", "0.5"],
  ]);
  assert.deepEqual(wide.scale, [2, 2, 1]);
  assert.deepEqual(resized(element("sphere", { radius: "1 m" }), [1, 1, 0.5], null)!.scale, [0.5, 0.5, 0.5]);
});

test("nothing vanishes or turns inside out, and nothing else is guessed", () => {
  const ball = element("sphere", { radius: "1 cm" });
  assert.deepEqual(resized(ball, [-3, 1, 1], null)!.attributes, [["radius", "3 cm"]]);
  assert.deepEqual(resized(ball, [0, 1, 1], null)!.attributes, [["radius", "0.01 cm"]]);
  assert.equal(resized(element("box", { size: "${a} 1 1" }), [2, 1, 1], null), null);
  const scene = { bodies: [{ name: "b", element: 1, shapes: [{}] }] } as unknown as Scene;
  assert.equal(whyNotResized(scene, 0, ball), "");
  assert.match(whyNotResized(scene, 0, element("mesh", {})), /only a box/);
  assert.match(whyNotResized(scene, 0, element("box", { size: "${a} 1 1" })), /not a list of numbers/);
});
