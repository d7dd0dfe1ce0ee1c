import assert from "node:assert/strict";
import { test } from "node:test";
import { signal } from "@preact/signals-core";
import type { Studio } from "../core/studio";
import { CameraStore } from "./store";
import { firstRect, clampedTo, pictureWidth, raised } from "./windows";

test("a window that is raised is above all, the others keep their order", () => {
  assert.deepEqual(raised(["a", "b", "c"], "a"), ["b", "c", "a"]);
  assert.deepEqual(raised(["a"], "new"), ["a", "new"]);
  assert.deepEqual(raised(["a", "b"], "b"), ["a", "b"]);
});

test("a window can always be grasped", () => {
  const page = { width: 1000, height: 700 };
  assert.deepEqual(clampedTo({ x: 10, y: 20, width: 300, height: 200 }, page), {
    x: 10,
    y: 20,
    width: 300,
    height: 200,
  });
  assert.deepEqual(clampedTo({ x: -900, y: -5, width: 300, height: 200 }, page), {
    x: -252,
    y: 0,
    width: 300,
    height: 200,
  });
  assert.deepEqual(clampedTo({ x: 5000, y: 5000, width: 1, height: 1 }, page), {
    x: 952,
    y: 672,
    width: 140,
    height: 110,
  });
});

test("new windows lie beside each other", () => {
  const area = { x: 0, y: 0, width: 1000, height: 600 };
  const rects = [0, 1, 2, 3].map((i) => firstRect(i, area));
  for (const a of rects)
    for (const b of rects) assert.ok(a === b || Math.abs(a.x - b.x) >= a.width || Math.abs(a.y - b.y) >= a.height);
  for (const p of rects) assert.ok(p.x >= 0 && p.x + p.width <= 1000 && p.y + p.height <= 600);
});

test("pictures are asked for in steps of width", () => {
  assert.equal(pictureWidth(281, 1), 320);
  assert.equal(pictureWidth(319, 1), 320);
  assert.equal(pictureWidth(300, 2), 640);
  assert.equal(pictureWidth(5000, 2), 1280);
});

test("only what is shown and seen is asked for; the same is not asked for twice", async () => {
  const asked: unknown[] = [];
  const camera = (name: string) => ({ name, type: "camera", element: 1 });
  const studio = {
    link: {
      request: async (what: string, fields: unknown) => {
        asked.push([what, fields]);
        return {};
      },
    },
    state: {
      scene: signal({ sensors: [camera("eye"), { ...camera("ir"), type: "infrared" }, camera("back")], views: [] }),
      hello: signal(null),
      open: signal(true),
    },
  } as unknown as Studio;
  const store = new CameraStore(studio);
  const rest = (): Promise<void> => new Promise((done) => setTimeout(done, 80));
  assert.deepEqual(
    store.cameras.value.map((c) => c.name),
    ["eye", "back"],
  );
  store.show(["eye", "back"], true);
  await rest();
  assert.deepEqual(asked, []);
  store.seen.value = true;
  await rest();
  const one = (name: string, kind = "color") => ({ name, kind, width: 320 });
  assert.deepEqual(asked.pop(), ["cameras", { show: [one("eye"), one("back")] }]);
  // dragging and raising ask for nothing
  store.put("eye", { x: 5, y: 5, width: 280, height: 240 });
  store.raise("eye");
  await rest();
  assert.deepEqual(asked, []);
  store.choose("back", "depth");
  store.show(["eye"], false);
  await rest();
  assert.deepEqual(asked.pop(), ["cameras", { show: [one("back", "depth")] }]);
  // closed and opened within one turn, as when a panel is moved
  store.seen.value = false;
  store.seen.value = true;
  await rest();
  assert.deepEqual(asked, []);
  // another connection: everything is requested again
  studio.state.open.value = false;
  studio.state.open.value = true;
  await rest();
  assert.deepEqual(asked.pop(), ["cameras", { show: [one("back", "depth")] }]);
  store.seen.value = false;
  await rest();
  assert.deepEqual(asked, [["cameras", { show: [] }]]);
  assert.deepEqual(store.order.value, ["back", "eye"]);
});
