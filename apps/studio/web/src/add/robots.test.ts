import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import type { TreeElement } from "../core/protocol";
import { kRobots, robotOps } from "./robots";

// test.mjs runs the tests in the folder of the page.
const library = join(process.cwd(), "../../../library/robots");

test("the robots are those of the library", () => {
  const folders = readdirSync(library)
    .filter((name) => !name.includes("."))
    .sort();
  assert.deepEqual(kRobots.map((r) => r.name).sort(), folders);
  for (const robot of kRobots) {
    const text = readFileSync(join(library, robot.name, `${robot.name}.scene.xml`), "utf8");
    assert.ok(text.includes(`<prototype name="${robot.prototype}">`), robot.name);
  }
});

test("a robot comes with its import, once, and its name is free", () => {
  const car = kRobots.find((r) => r.name === "car")!;
  const scene = { id: 0, parent: -1, tag: "scene", name: "", attributes: {} } as unknown as TreeElement;
  const [first, second] = robotOps([scene], car, [1, 2, 0]);
  assert.deepEqual(first, { op: "insert", parent: 0, xml: '<import href="robots/car/car.scene.xml"/>', before: null });
  assert.deepEqual(second, {
    op: "insert",
    parent: 0,
    xml: '<instance of="Car" name="car" xyz="1 2 0"/>',
    before: null,
  });
  const there = [
    scene,
    { id: 1, parent: 0, tag: "import", name: "", attributes: { href: "robots/car/car.scene.xml", as: "lib" } },
    { id: 2, parent: 0, tag: "instance", name: "car", attributes: {} },
  ] as unknown as TreeElement[];
  assert.deepEqual(robotOps(there, car, [0, 0, 0]), [
    { op: "insert", parent: 0, xml: '<instance of="lib.Car" name="car_2" xyz="0 0 0"/>', before: null },
  ]);
});
