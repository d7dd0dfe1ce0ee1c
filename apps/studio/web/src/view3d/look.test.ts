import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import * as look from "./look";

test("pictures here and those of the command line are lit alike", () => {
  const header = readFileSync("../../../renderers/osmesa/src/look.h", "utf8");
  const flat = (value: unknown): number[] =>
    typeof value === "number" ? [value] : Object.values(value as object).flatMap(flat);
  const { kSkies, ...rest } = look;
  const { zenith, horizon, nadir } = kSkies.light;
  const ours = { ...rest, kZenith: zenith, kHorizon: horizon, kNadir: nadir };
  for (const [name, value] of Object.entries(ours)) {
    const written = new RegExp(`\\b${name}(?: = ([^;]+)|\\(([^;]+)\\));`).exec(header);
    assert.ok(written, `${name} is not in look.h`);
    assert.deepEqual((written[1] ?? written[2]!).split(",").map(Number), flat(value), name);
  }
});
