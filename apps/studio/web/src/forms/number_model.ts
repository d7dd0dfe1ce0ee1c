// The contents of the boxes of a number, a list or a range, and the text made from them.
import type { AttributeSchema } from "./schema";
import {
  check_entry, convert, factor_of, is_expression, parse_numbers, parse_range, print_numbers, print_range, units_of,
  type Entry, type ValueParts,
} from "./values";

// Longer lists (heights of a ground) are better typed as text.
const kMostBoxes = 8;

export interface Boxes {
  /** what each box shows; "" in all: the attribute is not there */
  boxes: string[];
  placeholders: string[];
  /** chosen unit of all; null: entries have units of their own, written in the boxes; "": none */
  unit: string | null;
  /** units that can be chosen; empty: no choice */
  units: string[];
}

export function dimension_of(spec: AttributeSchema, entry: number): string {
  if (spec.per_entry) return spec.units[entry] ?? "";
  return spec.units.length === 1 ? spec.units[0]! : "";
}

function parts_of(spec: AttributeSchema, text: string): ValueParts | null {
  return spec.kind === "range" ? parse_range(text) : parse_numbers(text);
}

/** Units of different dimensions in one list are written beside their numbers. */
function own_units(spec: AttributeSchema): boolean {
  return spec.per_entry && spec.units.some((unit) => unit !== spec.units[0]);
}

function entry_text(entry: Entry | undefined, with_unit: boolean): string {
  if (!entry) return "";
  return with_unit && entry.unit !== "" && entry.text !== "none" ? `${entry.text} ${entry.unit}` : entry.text;
}

/** null: the text is no list of numbers that boxes could hold (an expression, a long list). */
export function boxes_of(spec: AttributeSchema, text: string): Boxes | null {
  if (spec.max_count > kMostBoxes || is_expression(text)) return null;
  const parts = text === "" ? null : parts_of(spec, text);
  if (text !== "" && !parts) return null;
  const shown = parts_of(spec, spec.default);
  const count = spec.kind === "range" ? 2 : Math.max(spec.min_count, spec.max_count, parts?.entries.length ?? 0);
  const separate = own_units(spec) || (parts !== null && parts.unit === null);
  const offered = [...new Set(spec.units.flatMap(units_of))];
  const unit = separate ? null : unit_for(spec, parts, shown, offered);
  const in_unit = (entry: Entry | undefined, i: number): string => {
    if (!entry || unit === null) return entry_text(entry, true);
    return entry_text(convert(entry, dimension_of(spec, i), unit) ?? entry, false);
  };
  return {
    boxes: Array.from({ length: count }, (_, i) => entry_text(parts?.entries[i], separate)),
    placeholders: Array.from({ length: count }, (_, i) => in_unit(shown?.entries[i], i)),
    unit,
    units: unit === null ? [] : offered.includes(unit) || offered.length === 0 ? offered : [unit, ...offered],
  };
}

function unit_for(spec: AttributeSchema, parts: ValueParts | null, shown: ValueParts | null, offered: string[]): string {
  const dimension = dimension_of(spec, 0);
  // A plain number is SI; a plain angle can only be 0, so any unit may follow.
  const plain = dimension === "rad" ? "" : dimension;
  const written = parts ? parts.unit || plain : "";
  if (written !== "") return written;
  return (!parts && shown?.unit) || (dimension === "rad" ? "deg" : dimension || (offered[0] ?? ""));
}

export type FromBoxes = { text: string | null } | { error: string; box: number };

/** The text for what stands in the boxes; null: all are empty, the attribute goes. Boxes left empty among others take
 *  the default's entry, or 0. */
export function text_from(spec: AttributeSchema, boxes: readonly string[], unit: string | null): FromBoxes {
  const typed = boxes.map((b) => b.trim());
  if (typed.every((b) => b === "")) return { text: null };
  if (typed.some(is_expression)) {
    const filled = typed.map((b) => (b === "" ? "0" : b));
    return { text: filled.join(spec.kind === "range" ? " .. " : " ") + (unit && !typed.every(is_expression) ? ` ${unit}` : "") };
  }
  const shown = spec.default === "" ? null : parts_of(spec, spec.default);
  const entries: Entry[] = [];
  for (let i = 0; i < typed.length; ++i) {
    const dimension = dimension_of(spec, i);
    if (typed[i] === "") {
      // a list that may be shorter ends here
      if (spec.kind !== "range" && i >= spec.min_count && typed.slice(i).every((b) => b === "")) break;
      const fallback = shown?.entries[i] ?? { text: "0", unit: unit ?? "" };
      entries.push(unit === null ? fallback : (convert(fallback, dimension, unit) ?? fallback));
      continue;
    }
    const parsed = parse_numbers(typed[i]!);
    if (!parsed || parsed.entries.length !== 1) return { error: `'${typed[i]}' is no number`, box: i };
    let entry = parsed.entries[0]!;
    if (entry.text === "none") entry = { text: "none", unit: "" };
    else if (entry.unit === "" && unit) entry = { text: entry.text, unit };
    else if (unit && entry.unit !== unit) entry = convert(entry, dimension, unit) ?? entry;
    const bounds = { ...spec, integer: spec.kind === "integer" };
    const error = check_entry(entry, dimension, bounds);
    if (error !== "") return { error, box: i };
    entries.push(entry);
  }
  // 1 m is written 1, as scenes do; angles keep their unit.
  if (spec.kind === "range") return { text: print_range(entries) };
  return { text: print_numbers(entries.map((e, i) => without_si(e, dimension_of(spec, i)))) };
}

function without_si(entry: Entry, dimension: string): Entry {
  return dimension === "m" && entry.unit === "m" ? { text: entry.text, unit: "" } : entry;
}

/** The same value in another unit; null if it cannot be converted. */
export function with_unit(spec: AttributeSchema, text: string, unit: string): string | null {
  const parts = parts_of(spec, text);
  if (!parts) return null;
  const entries: Entry[] = [];
  for (let i = 0; i < parts.entries.length; ++i) {
    const entry = parts.entries[i]!;
    const dimension = spec.units.find((d) => factor_of(d, entry.unit) !== undefined && factor_of(d, unit) !== undefined);
    const converted = dimension === undefined ? null : convert(entry, dimension, unit);
    if (!converted) return null;
    entries.push(converted);
  }
  return spec.kind === "range" ? print_range(entries) : print_numbers(entries);
}
