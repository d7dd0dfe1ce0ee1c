import assert from "node:assert/strict";
import { test } from "node:test";
import type { TreeElement } from "../core/protocol";
import type { State } from "../core/state";
import { restHeight, restOp } from "./rest";

test("shapes stand on their lowest point", () => {
  assert.equal(restHeight("box", { size: "24 14 4 cm" }), 0.02);
  assert.equal(restHeight("sphere", { radius: "10 cm" }), 0.1);
  assert.equal(restHeight("capsule", { radius: "6 cm", length: "0.2" }), 0.16);
  assert.equal(restHeight("ellipsoid", { radii: "10 10 15 cm" }), 0.15);
  assert.equal(restHeight("box", { size: "${a} 1 1" }), null);
  assert.equal(restHeight("mesh", {}), null);
});

const element = { id: 4, tag: "box", attributes: { size: "20 20 20 cm" } } as unknown as TreeElement;
const standing = (z: number, tilt = 0): State =>
  ({
    scene: {
      peek: () => ({
        bodies: [
          {
            kind: "fixed",
            element: 1,
            own: true,
            removed: false,
            pose: [0, 0, 0.5, 1, 0, 0, 0],
            shapes: [{ type: "plane" }],
          },
          { kind: "dynamic", element: 4, own: true, removed: false, pose: [1, 2, z, 1, tilt, 0, 0], shapes: [] },
        ],
      }),
    },
  }) as unknown as State;

test("what stands on the floor still does when its size changes", () => {
  assert.deepEqual(restOp(standing(0.6), element, "size", "24 14 4 cm"), {
    op: "place",
    element: 4,
    pose: [1, 2, 0.52, 1, 0, 0, 0],
  });
});

test("what hangs, is tilted, or keeps its height stays where it is", () => {
  assert.equal(restOp(standing(0.7), element, "size", "24 14 4 cm"), null);
  assert.equal(restOp(standing(0.6, 0.1), element, "size", "24 14 4 cm"), null);
  assert.equal(restOp(standing(0.6), element, "size", "24 14 20 cm"), null);
  assert.equal(restOp(standing(0.6), element, "mass", "1 kg"), null);
});
