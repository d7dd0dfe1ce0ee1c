import assert from "node:assert/strict";
import { test } from "node:test";
import { boxesOf, inUnitOf, lengthUnit, textFrom, withUnit } from "./number_model";
import { Schema, type AttributeSchema } from "./schema";
import {
  checkEntry,
  convert,
  hexColor,
  parseNumbers,
  parseRange,
  printNumbers,
  printRange,
  shortNumber,
} from "./values";

function spec(raw: Record<string, unknown>): AttributeSchema {
  return new Schema({ elements: [{ name: "e", attributes: [{ name: "a", ...raw }] }] }).attribute("e", "a")!;
}
const size = spec({
  kind: "numbers",
  units: ["m"],
  min_count: 3,
  max_count: 3,
  min: 0,
  above_min: true,
  required: true,
});
const xyz = spec({ kind: "numbers", units: ["m"], min_count: 3, max_count: 3, default: "0 0 0" });
const rpy = spec({ kind: "numbers", units: ["rad"], min_count: 3, max_count: 3, default: "0 0 0" });
const range = spec({ kind: "range", units: ["m"], min: 0, default: "0 .. 10 m" });
const limits = spec({
  kind: "numbers",
  units: ["rad", "m"],
  per_entry: true,
  min_count: 2,
  max_count: 2,
  none_allowed: true,
});

test("lists are read with one unit behind, or one each", () => {
  assert.deepEqual(
    parseNumbers("24 14 4 cm")?.entries.map((e) => e.text + e.unit),
    ["24cm", "14cm", "4cm"],
  );
  assert.equal(parseNumbers("24 14 4 cm")?.unit, "cm");
  assert.deepEqual(parseNumbers("24 cm 14 cm 40 mm")?.unit, null);
  assert.deepEqual(
    parseNumbers("-1e-3 .5 2.")?.entries.map((e) => e.text),
    ["-1e-3", ".5", "2."],
  );
  assert.deepEqual(parseNumbers("3cm")?.entries, [{ text: "3", unit: "cm" }]);
  assert.equal(parseNumbers("none -10 cm")?.entries[0]!.text, "none");
  for (const bad of ["", "abc", "1 cm cm", "cm 1", "${a}", "1..2"]) assert.equal(parseNumbers(bad), null, bad);
});

test("lists come out as they came in", () => {
  for (const text of ["24 14 4 cm", "24 cm 14 cm 40 mm", "0 0 1", "none -10 cm", "5 N*m", "1 2 kg/m^3"]) {
    assert.equal(printNumbers(parseNumbers(text)!.entries), text);
  }
  // a unit behind "none" would be wrong
  assert.equal(printNumbers(parseNumbers("-10 cm none")!.entries), "-10 cm none");
});

test("ranges", () => {
  for (const text of ["2 .. 80 cm", "0.1 .. 10", "5 mm .. 2 m"])
    assert.equal(printRange(parseRange(text)!.entries), text);
  assert.equal(parseRange("2 80 cm"), null);
});

test("units are converted without changing the value", () => {
  assert.deepEqual(convert({ text: "40", unit: "cm" }, "m", "m"), { text: "0.4", unit: "m" });
  assert.deepEqual(convert({ text: "0.1", unit: "" }, "m", "mm"), { text: "100", unit: "mm" });
  assert.deepEqual(convert({ text: "180", unit: "deg" }, "rad", "rad"), { text: "3.14159265", unit: "rad" });
  assert.equal(convert({ text: "1", unit: "inch" }, "m", "cm"), null);
  assert.equal(withUnit(size, "40 40 40 cm", "m"), "0.4 0.4 0.4 m");
  assert.equal(withUnit(range, "2 .. 80 cm", "m"), "0.02 .. 0.8 m");
  assert.equal(shortNumber(0.1 + 0.2), "0.3");
});

test("entries are checked in SI, whatever their unit", () => {
  const bounds = { min: 0, max: 1, aboveMin: true, noneAllowed: false };
  assert.equal(checkEntry({ text: "100", unit: "cm" }, "m", bounds), "");
  assert.match(checkEntry({ text: "101", unit: "cm" }, "m", bounds), /at most 1 m/);
  assert.match(checkEntry({ text: "0", unit: "cm" }, "m", bounds), /above 0 m/);
  assert.match(checkEntry({ text: "none", unit: "" }, "m", bounds), /not allowed/);
  assert.match(checkEntry({ text: "1", unit: "" }, "rad", { ...bounds, max: null }), /unit/);
  assert.equal(checkEntry({ text: "0", unit: "" }, "rad", { ...bounds, aboveMin: false }), "");
  assert.match(checkEntry({ text: "1.5", unit: "" }, "", { ...bounds, max: null, integer: true }), /whole/);
});

test("boxes show the list in its unit", () => {
  const shown = boxesOf(size, "24 14 4 cm")!;
  assert.deepEqual(shown.boxes, ["24", "14", "4"]);
  assert.equal(shown.unit, "cm");
  assert.ok(shown.units.includes("m") && shown.units.includes("mm"));
  assert.deepEqual(boxesOf(size, "24 cm 14 cm 40 mm")!.boxes, ["24 cm", "14 cm", "40 mm"]);
  assert.deepEqual(boxesOf(xyz, "")!.placeholders, ["0", "0", "0"]);
  assert.equal(boxesOf(rpy, "")!.unit, "deg");
  assert.equal(boxesOf(xyz, "0 0 ${h}"), null);
  assert.deepEqual(boxesOf(range, "")!.placeholders, ["0", "10"]);
});

test("what stands in boxes becomes the shortest text", () => {
  assert.deepEqual(textFrom(size, ["20", "20", "20"], "cm"), { text: "20 20 20 cm" });
  assert.deepEqual(textFrom(xyz, ["1", "", ""], "m"), { text: "1 0 0" });
  assert.deepEqual(textFrom(rpy, ["", "90", ""], "deg"), { text: "0 90 0 deg" });
  assert.deepEqual(textFrom(size, ["1 m", "20", "20"], "cm"), { text: "100 20 20 cm" });
  assert.deepEqual(textFrom(xyz, ["", " ", ""], "m"), { text: null });
  assert.deepEqual(textFrom(range, ["2", "80"], "cm"), { text: "2 .. 80 cm" });
  assert.deepEqual(textFrom(limits, ["-90 deg", "none"], null), { text: "-90 deg none" });
  assert.deepEqual(textFrom(xyz, ["${a}", "1", ""], "m"), { text: "${a} 1 0 m" });
});

test("the error of a box is reported with its number", () => {
  assert.deepEqual(textFrom(size, ["1", "x", "1"], "m"), { error: "'x' is not a number", box: 1 });
  const low = textFrom(size, ["1", "1", "-3"], "cm");
  assert.ok("error" in low && low.box === 2 && /above 0 m/.test(low.error));
});

test("colours for the chooser", () => {
  assert.equal(hexColor("#F80"), "#ff8800");
  assert.equal(hexColor("#12345678"), "#123456");
  assert.equal(hexColor("red"), null);
});

test("lists without a given length are text", () => {
  assert.equal(boxesOf(spec({ kind: "numbers", min_count: 1, max_count: 1000 }), "1 2 3"), null);
});

test("a form has one unit of lengths, by the size of the thing, and writes each attribute in its own", () => {
  const place = { ...xyz, name: "xyz" };
  const fields = [
    { spec: size, text: "24 14 4 cm" },
    { spec: place, text: "12 0 0.5" },
  ];
  assert.equal(lengthUnit(fields), "cm");
  assert.equal(lengthUnit([{ spec: size, text: "2 1 1" }]), "m");
  assert.equal(lengthUnit([{ spec: size, text: "2 4 4 mm" }]), "mm");
  assert.equal(lengthUnit([{ spec: place, text: "0 0 0.1" }]), "cm");
  assert.deepEqual(boxesOf(xyz, "12 0 0.5", "cm")!.boxes, ["1200", "0", "50"]);
  assert.equal(boxesOf(xyz, "12 0 0.5", "cm")!.unit, "cm");
  assert.deepEqual(textFrom(xyz, ["25", "0", "50"], "cm"), { text: "25 0 50 cm" });
  assert.equal(inUnitOf(xyz, "12 0 0.5", "25 0 50 cm"), "0.25 0 0.5");
  assert.equal(inUnitOf(size, "24 14 4 cm", "0.3 0.14 0.04"), "30 14 4 cm");
  assert.equal(inUnitOf(size, "", "30 14 4 cm"), "30 14 4 cm");
});
