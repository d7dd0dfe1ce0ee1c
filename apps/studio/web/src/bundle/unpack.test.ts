import assert from "node:assert/strict";
import { test } from "node:test";
import { MemoryLink } from "../core/memory_link";
import type { Picture } from "../core/frame";
import type { Paths } from "../core/protocol";
import { byRows, packedMatrix, unpack } from "./unpack";

/** As the program packs: see packed_columns(). */
function pack(rows: number[][]): Uint8Array {
  const width = rows[0]?.length ?? 0;
  const count = rows.length * width;
  const out = new Uint8Array(4 * count);
  let k = 0;
  for (let c = 0; c < width; ++c) {
    let before = 0;
    for (const row of rows) {
      const bits = new Uint32Array(Float32Array.of(row[c]!).buffer)[0]!;
      const change = (bits - before) >>> 0;
      before = bits;
      for (let plane = 0; plane < 4; ++plane) out[plane * count + k] = (change >>> (8 * plane)) & 255;
      ++k;
    }
  }
  return out;
}

test("numbers that were packed come back", () => {
  const rows = [
    [1, -2.5, 3e38],
    [1.5, Infinity, -3e38],
    [-0, 0.1, 1e-42],
    [0, -Infinity, 7],
  ];
  const single = rows.map((row) => row.map(Math.fround));
  const columns = packedMatrix(pack(rows), 4);
  assert.deepEqual(
    Array.from(columns),
    [0, 1, 2].flatMap((c) => single.map((row) => row[c]!)),
  );
  assert.deepEqual(Array.from(byRows(columns, 4)), single.flat());
  assert.equal(packedMatrix(new Uint8Array(0), 0).length, 0);
  assert.equal(byRows(new Float32Array(0), 0).length, 0);
});

/** Two scenes: one body for two frames, then two bodies for one. */
function data(version = 1): ArrayBuffer {
  const blocks: number[] = [];
  const add = (bytes: ArrayLike<number>) => {
    while (blocks.length % 8 !== 0) blocks.push(0);
    const at = blocks.length;
    blocks.push(...Array.from(bytes));
    return { at, bytes: bytes.length };
  };
  const doubles = (...values: number[]) => add(new Uint8Array(Float64Array.from(values).buffer));
  const whole = (...values: number[]) => add(new Uint8Array(Int32Array.from(values).buffer));
  const body = (name: string) => ({ name, kind: "dynamic", removed: false, element: -1 });
  const pose = (x: number) => [x, 0, 0, 1, 0, 0, 0];
  const head = {
    format: "cogrsim-bundle",
    version,
    made_by: "1.2.3",
    file: "x.scene.xml",
    backend: "bullet",
    engine_version: "3",
    ending: "completed",
    state_hash: "0123456789abcdef",
    dt: 0.5,
    time: doubles(0, 0.5, 1),
    step: doubles(0, 1, 2),
    contacts: {
      counts: whole(0, 1, 1),
      bodies: whole(0, -1, 1, 0),
      numbers: add(
        pack([
          [1, 2, 3, 0, 0, 1, 0.25, 8],
          [4, 5, 6, 0, 1, 0, 0.5, 16],
        ]),
      ),
    },
    scenes: [
      { scene: 1, step: 0.5, bodies: [body("a")], sensors: [{}] },
      { scene: 2, step: 0.5, bodies: [body("a"), body("b")], sensors: [{}] },
    ],
    parts: [
      {
        scene: 1,
        count: 2,
        bodies: 1,
        poses: add(pack([pose(1), pose(2)])),
        signals: [{ name: "s.d", unit: "m", owner: "s" }],
        values: add(pack([[NaN], [7]])),
        readings: [[0]],
      },
      {
        scene: 2,
        count: 1,
        bodies: 2,
        poses: add(pack([[...pose(3), ...pose(4)]])),
        signals: [
          { name: "b.speed", unit: "m/s", owner: "b" },
          { name: "s.d", unit: "m", owner: "s" },
        ],
        values: add(pack([[0.5, 8]])),
        readings: [[1, -1]],
      },
    ],
    paths: [
      {
        label: "robot",
        body: "a",
        times: doubles(0, 0.25, 1),
        points: add(
          pack([
            [1, 0, 0],
            [1.5, 2, 0],
            [3, 0, 0],
          ]),
        ),
      },
    ],
    messages: [],
    events: [],
    plots: [{ name: "p" }],
    figures: {
      p: { kind: "curve", series: [{ label: "l", x: doubles(0, 1), y: add(pack([[2], [NaN]])), z: add([]) }] },
    },
    textures: {},
    pictures: [{ ...add([9, 9]), name: "eye", time: 0.5, width: 2, height: 1 }],
    left_out: ["much"],
  };
  const text = new TextEncoder().encode(JSON.stringify(head));
  const first = Math.ceil((4 + text.length) / 8) * 8;
  const out = new Uint8Array(first + blocks.length);
  new DataView(out.buffer).setUint32(0, text.length, true);
  out.set(text, 4);
  out.set(blocks, first);
  return out.buffer;
}

test("frames, readings and contacts are those of their scene", () => {
  const run = unpack(data(), () => "");
  assert.equal(run.count, 3);
  const [, second, third] = [0, 1, 2].map((i) => run.frame(i));
  assert.deepEqual([second!.scene, second!.time, Array.from(second!.poses)], [1, 0.5, [2, 0, 0, 1, 0, 0, 0]]);
  assert.deepEqual([third!.scene, third!.step, third!.poses[0], third!.poses[7]], [2, 2, 3, 4]);
  assert.deepEqual(run.frame(0).tail, { readings: [], contacts: [] });
  assert.deepEqual(second!.tail, {
    readings: [{ sensor: 0, values: [7] }],
    contacts: [{ a: 0, b: -1, point: [1, 2, 3], normal: [0, 0, 1], depth: 0.25, force: 8 }],
  });
  assert.deepEqual(third!.tail.readings, [{ sensor: 0, values: [8, null] }]);
  assert.deepEqual(third!.tail.contacts, [{ a: 1, b: 0, point: [4, 5, 6], normal: [0, 1, 0], depth: 0.5, force: 16 }]);
  assert.throws(() => unpack(data(2), () => ""), /version 2/);
});

test("the page is answered as by a server", async () => {
  const link = new MemoryLink(unpack(data(), () => ""));
  const hello = await link.request("hello");
  assert.equal(hello.kind, "bundle");
  const series = await link.request<{ time: number[]; series: { low: (number | null)[] }[] }>("series", {
    signals: ["s.d", "b.speed", "a.x"],
  });
  assert.deepEqual(series.time, [0, 0.5, 1]);
  assert.deepEqual(
    series.series.map((s) => s.low),
    [
      [null, 7, 8],
      [null, null, 0.5],
      [1, 2, 3],
    ],
  );
  const figure = await link.request<{ series: unknown[] }>("figure", { plot: "p" });
  assert.deepEqual(figure.series, [{ label: "l", x: [0, 1], y: [2, null], z: [] }]);
  const { revision, until, paths } = await link.request<Paths>("paths", { revision: 0, counts: [] });
  assert.equal(until, 1);
  assert.deepEqual(paths, [
    { label: "robot", body: "a", from: 0, times: [0, 0.25, 1], points: [1, 0, 0, 1.5, 2, 0, 3, 0, 0], last: [] },
  ]);
  const again = await link.request<Paths>("paths", { revision, counts: [3] });
  assert.deepEqual(again.paths, [{ label: "robot", body: "a", from: 3, times: [], points: [], last: [] }]);
  await assert.rejects(link.request("play"), /needs a server/);
});

test("pictures come as far as the run has got", async () => {
  const link = new MemoryLink(unpack(data(), () => ""));
  const seen: Picture[] = [];
  link.onPicture((picture) => seen.push(picture));
  await assert.rejects(
    link.request("cameras", { show: [{ name: "eye", kind: "depth" }] }),
    /no pictures of 'eye' \(depth\)/,
  );
  await link.request("cameras", {
    show: [
      { name: "eye", kind: "color" },
      { name: "ear", kind: "color" },
    ],
  });
  const shown = () => new Promise((resolve) => setTimeout(resolve, 50));
  await shown();
  assert.equal(seen.length, 0, "it was taken later");
  await link.request("seek", { time: 1 });
  await shown();
  assert.deepEqual(
    seen.map((p) => [p.name, p.time, p.file.size]),
    [["eye", 0.5, 2]],
  );
});
