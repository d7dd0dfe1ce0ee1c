// The contents of the boxes of a number, a list or a range, and the text made from them.
import type { AttributeSchema } from "./schema";
import {
  checkEntry,
  convert,
  factorOf,
  isExpression,
  parseNumbers,
  parseRange,
  printNumbers,
  printRange,
  unitsOf,
  type Entry,
  type ValueParts,
} from "./values";

// Longer lists (heights of a ground) are better typed as text.
const kMostBoxes = 8;

interface Boxes {
  /** what each box shows; "" in all: the attribute is not there */
  boxes: string[];
  placeholders: string[];
  /** chosen unit of all; null: entries have units of their own, written in the boxes; "": none */
  unit: string | null;
  /** units that can be chosen; empty: no choice */
  units: string[];
}

function dimensionOf(spec: AttributeSchema, entry: number): string {
  if (spec.perEntry) return spec.units[entry] ?? "";
  return spec.units.length === 1 ? spec.units[0]! : "";
}

function partsOf(spec: AttributeSchema, text: string): ValueParts | null {
  return spec.kind === "range" ? parseRange(text) : parseNumbers(text);
}

/** Units of different dimensions in one list are written beside their numbers. */
function ownUnits(spec: AttributeSchema): boolean {
  return spec.perEntry && spec.units.some((unit) => unit !== spec.units[0]);
}

function entryText(entry: Entry | undefined, withUnit: boolean): string {
  if (!entry) return "";
  return withUnit && entry.unit !== "" && entry.text !== "none" ? `${entry.text} ${entry.unit}` : entry.text;
}

/** Whether all its numbers are lengths. */
export function isLength(spec: AttributeSchema): boolean {
  return spec.units.length > 0 && spec.units.every((unit) => unit === "m");
}

/** The one unit in which a form shows its lengths, by the size of the thing: of what is not a position, else of that. */
export function lengthUnit(fields: readonly { spec: AttributeSchema; text: string }[]): string {
  const largest = (of: readonly { spec: AttributeSchema; text: string }[]): number =>
    Math.max(
      0,
      ...of.flatMap(({ spec, text }) => {
        const entries = isExpression(text) ? [] : (partsOf(spec, text)?.entries ?? []);
        return entries.map((entry) => Math.abs(Number(convert(entry, "m", "m")?.text ?? 0)) || 0);
      }),
    );
  const all = fields.filter(({ spec }) => isLength(spec));
  const own = all.filter(({ spec }) => !kPositions.includes(spec.name));
  const size = largest(own) || largest(all) || largest(all.map(({ spec }) => ({ spec, text: spec.default })));
  return size === 0 || size >= 1 ? "m" : size < 0.01 ? "mm" : "cm";
}
const kPositions = ["xyz", "at", "look-at", "com"];

/** null: the text is not a list of numbers that boxes could hold (an expression, a long list). */
export function boxesOf(spec: AttributeSchema, text: string, length = ""): Boxes | null {
  if (spec.maxCount > kMostBoxes || isExpression(text)) return null;
  const parts = text === "" ? null : partsOf(spec, text);
  if (text !== "" && !parts) return null;
  const shown = partsOf(spec, spec.default);
  const count = spec.kind === "range" ? 2 : Math.max(spec.minCount, spec.maxCount, parts?.entries.length ?? 0);
  const separate = ownUnits(spec) || (parts !== null && parts.unit === null);
  const offered = [...new Set(spec.units.flatMap(unitsOf))];
  const preferred = isLength(spec) && offered.includes(length) ? length : "";
  const unit = separate ? null : preferred || unitFor(spec, parts, shown, offered);
  const inUnit = (entry: Entry | undefined, i: number): string => {
    if (!entry || unit === null) return entryText(entry, true);
    if (entry.text === "none") return entry.text;
    return entryText(convert(entry, dimensionOf(spec, i), unit) ?? entry, false);
  };
  return {
    boxes: Array.from({ length: count }, (_, i) =>
      preferred ? inUnit(parts?.entries[i], i) : entryText(parts?.entries[i], separate),
    ),
    placeholders: Array.from({ length: count }, (_, i) => inUnit(shown?.entries[i], i)),
    unit,
    units: unit === null ? [] : offered.includes(unit) || offered.length === 0 ? offered : [unit, ...offered],
  };
}

function unitFor(spec: AttributeSchema, parts: ValueParts | null, shown: ValueParts | null, offered: string[]): string {
  const dimension = dimensionOf(spec, 0);
  // A plain number is SI; a plain angle can only be 0, so any unit may follow.
  const plain = dimension === "rad" ? "" : dimension;
  const written = parts ? parts.unit || plain : "";
  if (written !== "") return written;
  return (!parts && shown?.unit) || (dimension === "rad" ? "deg" : dimension || (offered[0] ?? ""));
}

type FromBoxes = { text: string | null } | { error: string; box: number };

/** The text for what stands in the boxes; null: all are empty, the attribute goes. Boxes left empty among others take
 *  the default's entry, or 0. */
export function textFrom(spec: AttributeSchema, boxes: readonly string[], unit: string | null): FromBoxes {
  const typed = boxes.map((b) => b.trim());
  if (typed.every((b) => b === "")) return { text: null };
  if (typed.some(isExpression)) {
    const filled = typed.map((b) => (b === "" ? "0" : b));
    return {
      text: filled.join(spec.kind === "range" ? " .. " : " ") + (unit && !typed.every(isExpression) ? ` ${unit}` : ""),
    };
  }
  const shown = spec.default === "" ? null : partsOf(spec, spec.default);
  const entries: Entry[] = [];
  for (let i = 0; i < typed.length; ++i) {
    const dimension = dimensionOf(spec, i);
    if (typed[i] === "") {
      // a list that may be shorter ends here
      if (spec.kind !== "range" && i >= spec.minCount && typed.slice(i).every((b) => b === "")) break;
      const fallback = shown?.entries[i] ?? { text: "0", unit: unit ?? "" };
      entries.push(unit === null ? fallback : (convert(fallback, dimension, unit) ?? fallback));
      continue;
    }
    const parsed = parseNumbers(typed[i]!);
    if (!parsed || parsed.entries.length !== 1) return { error: `'${typed[i]}' is not a number`, box: i };
    let entry = parsed.entries[0]!;
    if (entry.text === "none") entry = { text: "none", unit: "" };
    else if (entry.unit === "" && unit) entry = { text: entry.text, unit };
    else if (unit && entry.unit !== unit) entry = convert(entry, dimension, unit) ?? entry;
    const bounds = { ...spec, integer: spec.kind === "integer" };
    const error = checkEntry(entry, dimension, bounds);
    if (error !== "") return { error, box: i };
    entries.push(entry);
  }
  // 1 m is written 1, as scenes do; angles keep their unit.
  if (spec.kind === "range") return { text: printRange(entries) };
  return { text: printNumbers(entries.map((e, i) => withoutSi(e, dimensionOf(spec, i)))) };
}

function withoutSi(entry: Entry, dimension: string): Entry {
  return dimension === "m" && entry.unit === "m" ? { text: entry.text, unit: "" } : entry;
}

/** The same value in another unit; null if it cannot be converted. */
export function withUnit(spec: AttributeSchema, text: string, unit: string): string | null {
  const parts = partsOf(spec, text);
  if (!parts) return null;
  const entries: Entry[] = [];
  for (let i = 0; i < parts.entries.length; ++i) {
    const entry = parts.entries[i]!;
    const dimension = spec.units.find((d) => factorOf(d, entry.unit) !== undefined && factorOf(d, unit) !== undefined);
    const converted = dimension === undefined ? null : convert(entry, dimension, unit);
    if (!converted) return null;
    entries.push(converted);
  }
  return spec.kind === "range" ? printRange(entries) : printNumbers(entries);
}

/** A new value in the unit in which the old one is written: the form may show another. */
export function inUnitOf(spec: AttributeSchema, old: string, text: string): string {
  const unit = old === "" ? null : boxesOf(spec, old)?.unit;
  const now = boxesOf(spec, text)?.unit;
  if (!unit || !isLength(spec) || unit === now) return text;
  const converted = withUnit(spec, text, unit) ?? text;
  return unit === "m" ? converted.replaceAll(" m", "") : converted;
}
