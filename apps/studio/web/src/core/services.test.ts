import assert from "node:assert/strict";
import { test } from "node:test";
import { Services } from "./services";

class Ended {
  constructor(readonly owner: string[]) {}
  dispose(): void {
    this.owner.push(this.constructor.name);
  }
}
class First extends Ended {}
class Second extends Ended {}
class Endless {}

test("an owner has one service of each class, made at the first request", () => {
  const owner: string[] = [];
  const services = new Services(owner);
  const first = services.get(First);
  assert.equal(services.get(First), first);
  assert.equal(first.owner, owner);
  assert.notEqual(services.get(Second), first);
  assert.notEqual(new Services(owner).get(First), first);
});

test("services end once, the newest first; those without an end are left alone", () => {
  const ended: string[] = [];
  const services = new Services(ended);
  services.get(First);
  services.get(Endless);
  services.get(Second);
  services.dispose();
  services.dispose();
  assert.deepEqual(ended, ["Second", "First"]);
});
