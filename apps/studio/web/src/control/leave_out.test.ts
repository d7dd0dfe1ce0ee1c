import assert from "node:assert/strict";
import { test } from "node:test";
import { leftOutText, offerOf } from "./leave_out";

const kCoupling = { feature: "joint.coupling", of: "coupling", count: 2 };
const kRotor = { feature: "joint.rotor-inertia.hinge", of: "joint", count: 12 };

test("what was left out is named with its number", () => {
  assert.equal(
    leftOutText([kCoupling, kRotor]),
    "joint.coupling (2 × coupling), joint.rotor-inertia.hinge (12 × joint)",
  );
  assert.equal(leftOutText([]), "");
});

test("leaving out is offered where it helps, and only there", () => {
  const offer = offerOf({ name: "mine", left_out: [kCoupling], needed: [] });
  assert.ok(
    offer !== null &&
      typeof offer === "object" &&
      offer.text.includes("joint.coupling (2 × coupling)") &&
      offer.title.startsWith("mine"),
  );
  assert.equal(
    offerOf({ name: "mine", left_out: [kCoupling], needed: ["it has no screw"] }),
    "mine cannot run this scene: it has no screw",
  );
  assert.equal(offerOf({ name: "mine", left_out: [], needed: [] }), null);
});
