import assert from "node:assert/strict";
import { test } from "node:test";
import { readAddress } from "./address";

test("an address names a time and a view", () => {
  assert.deepEqual(readAddress("#t=4.2&view=front"), { time: 4.2, view: "front", problems: [] });
  assert.deepEqual(readAddress("#view=top"), { view: "top", problems: [] });
  assert.deepEqual(readAddress(""), { problems: [] });
  assert.deepEqual(readAddress("#other=3"), { problems: [] });
});

test("what is no time and no view is said, and the rest holds", () => {
  for (const t of ["", "abc", "1e999", "4,2"]) {
    const wish = readAddress(`#t=${t}&view=iso`);
    assert.equal(wish.time, undefined, t);
    assert.equal(wish.view, "iso");
    assert.match(wish.problems.join(), /no number of seconds/);
  }
  assert.match(readAddress("#view=behind").problems.join(), /'behind'; there are front, back/);
});
