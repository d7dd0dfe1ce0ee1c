import assert from "node:assert/strict";
import { test } from "node:test";
import type { Scene } from "../core/protocol";
import {
  carriedBy,
  commandersOf,
  inputsByKey,
  jointRange,
  motorRange,
  movedBy,
  positionText,
  shortNumber,
} from "./mechanism";

const body = (name: string, x: number) => ({ name, kind: "dynamic", pose: [x, 0, 0, 1, 0, 0, 0], assembly: 0 });
const hinge = (parent: number, child: number, at: [number, number], more = {}) => ({
  name: `j${child}`,
  type: "hinge",
  parent,
  child,
  parent_pose: [at[0], 0, 0, 1, 0, 0, 0],
  child_pose: [at[1], 0, 0, 1, 0, 0, 0],
  limits: [[-1, 1]],
  element: 1,
  own: true,
  ...more,
});

/** A base at 0 and two links of 1 m along x behind it; each turns about z at its near end. */
const arm = {
  bodies: [body("base", 0), body("upper", 0.5), body("lower", 1.5)],
  joints: [hinge(0, 1, [0, -0.5]), hinge(1, 2, [0.5, -0.5])],
  assemblies: [{ parent: -1 }],
  controllers: [{ name: "bot.pilot", assembly: 0 }],
} as unknown as Scene;
const poses = arm.bodies.flatMap((b) => b.pose);
const near = (a: readonly number[], b: readonly number[]) =>
  a.forEach((v, i) => assert.ok(Math.abs(v - b[i]!) < 1e-12, `${a.join()} is not ${b.join()}`));

test("a joint carries what hangs on its child", () => {
  assert.deepEqual(carriedBy(arm, 0), [1, 2]);
  assert.deepEqual(carriedBy(arm, 1), [2]);
  const ring = { ...arm, joints: [...arm.joints, hinge(2, 0, [0.5, 1])] } as Scene;
  assert.equal(carriedBy(ring, 0), null);
  const closed = { ...arm, joints: [...arm.joints, hinge(2, 0, [0.5, 1], { closes_loop: true })] } as Scene;
  assert.deepEqual(carriedBy(closed, 0), [1, 2]);
});

test("bodies are where the joint takes them", () => {
  const quarter = movedBy(arm, poses, 0, Math.PI / 2);
  near(quarter.get(1)!.slice(0, 3), [0, 0.5, 0]);
  near(quarter.get(2)!.slice(0, 3), [0, 1.5, 0]);
  near(quarter.get(2)!.slice(3), [Math.SQRT1_2, 0, 0, Math.SQRT1_2]);
  near(movedBy(arm, poses, 1, Math.PI).get(2)!.slice(0, 3), [0.5, 0, 0]);
  const lift = { ...arm, joints: [{ ...arm.joints[0]!, type: "slider" }, arm.joints[1]!] } as Scene;
  near(movedBy(lift, poses, 0, 0.25).get(2)!.slice(0, 3), [1.5, 0, 0.25]);
  assert.equal(movedBy({ ...arm, joints: [] } as unknown as Scene, poses, 0, 1).size, 0);
});

test("ranges are those of the scene, or wide enough", () => {
  assert.deepEqual(jointRange(arm.joints[0]!), { low: -1, high: 1, stated: true });
  const free = jointRange({ ...arm.joints[0]!, limits: [[null, null]] });
  assert.deepEqual(free, { low: -Math.PI, high: Math.PI, stated: false });
  const upwards = jointRange({ ...arm.joints[0]!, type: "slider", limits: [[2, null]] });
  assert.ok(upwards.low === 2 && upwards.high > 2 && !upwards.stated);
  const motor = { name: "m", joint: 0, element: 1, unit: "V", low: -6, high: 6 };
  assert.deepEqual(motorRange(motor), { low: -6, high: 6, stated: true });
  assert.deepEqual(commandersOf(arm, motor), ["bot.pilot"]);
});

test("keys raise and lower inputs, within their limits", () => {
  const inputs = [
    { name: "forward", unit: "m/s", lower: -1, upper: 1, value: 0 },
    { name: "height", unit: "m", lower: 0.5, upper: 2.5, value: 1 },
  ];
  near(inputsByKey("KeyW", inputs, [0, 1]), [0.1, 1]);
  near(inputsByKey("KeyS", inputs, [-0.95, 1]), [-1, 1]);
  near(inputsByKey("KeyD", inputs, [0, 1]), [0, 0.9]);
  near(inputsByKey("KeyX", inputs, [0.7, 1]), [0, 0.5]);
  assert.deepEqual(inputsByKey("KeyQ", inputs, [0, 1]), [], "there is no third one");
  assert.deepEqual(inputsByKey("KeyP", inputs, [0, 1]), []);
});

test("numbers as one writes and reads them", () => {
  assert.equal(positionText(arm.joints[0]!, Math.PI / 3), "60 deg");
  assert.equal(positionText({ ...arm.joints[0]!, type: "slider" }, 0.123456), "0.12346 m");
  assert.equal(shortNumber(-0.0001), "0.000");
  assert.equal(shortNumber(1234.56), "1235");
  assert.equal(shortNumber(NaN), "–");
});
