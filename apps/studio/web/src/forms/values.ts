// Values as the scene language writes them: numbers, lists and ranges with units.

/** One number with its own unit; "": SI, or no unit at all. */
export interface Entry {
  /** as typed: a number or "none" */
  text: string;
  unit: string;
}

/** An attribute's text, parsed. `plain` is null when it is not a list of numbers: an expression, a text. */
export interface ValueParts {
  entries: Entry[];
  /** the unit of all, null if entries have units of their own */
  unit: string | null;
}

// SI value of one unit, by the dimension that the schema names with its SI unit.
const kDegree = Math.PI / 180;
const kUnits: Record<string, Record<string, number>> = {
  m: { m: 1, cm: 1e-2, mm: 1e-3, km: 1e3 },
  rad: { deg: kDegree, rad: 1 },
  kg: { kg: 1, g: 1e-3, t: 1e3 },
  s: { s: 1, ms: 1e-3, us: 1e-6, min: 60, h: 3600 },
  "m/s": { "m/s": 1, "cm/s": 1e-2, "mm/s": 1e-3, "km/h": 1 / 3.6 },
  "rad/s": { "rad/s": 1, "deg/s": kDegree, rpm: Math.PI / 30 },
  Hz: { Hz: 1, kHz: 1e3 },
  "kg/m^3": { "kg/m^3": 1, "g/cm^3": 1e3 },
  "kg*m^2": { "kg*m^2": 1, "g*cm^2": 1e-7 },
  N: { N: 1, kN: 1e3, mN: 1e-3 },
  "N*m": { "N*m": 1, "N*cm": 1e-2, "mN*m": 1e-3 },
  "N/m": { "N/m": 1, "N/mm": 1e3 },
  "N*m/rad": { "N*m/rad": 1, "N*m/deg": 1 / kDegree },
  V: { V: 1, mV: 1e-3 },
  A: { A: 1, mA: 1e-3 },
};

/** Units offered for a dimension; the SI one is among them. An angle's are without "": it must be written. */
export function unitsOf(dimension: string): string[] {
  if (dimension === "" || dimension === "1") return [];
  return Object.keys(kUnits[dimension] ?? { [dimension]: 1 });
}

/** SI value of one `unit`; undefined: not known here (the compiler knows more). "" is SI. */
export function factorOf(dimension: string, unit: string): number | undefined {
  if (unit === "" || unit === dimension) return 1;
  return kUnits[dimension]?.[unit];
}

const kNumber = /^[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?/;

export function isExpression(text: string): boolean {
  return text.includes("${");
}

/** "40 40 40 cm", "24 cm 14 cm 40 mm", "none -10 cm"; null if it is anything else. */
export function parseNumbers(text: string): ValueParts | null {
  const items = text
    .trim()
    .split(/[\s,]+/)
    .filter((w) => w !== "");
  const entries: Entry[] = [];
  let units = 0;
  let lastHasUnit = false;
  for (const item of items) {
    if (item === "none") {
      entries.push({ text: item, unit: "" });
      lastHasUnit = false;
      continue;
    }
    const number = kNumber.exec(item);
    if (number) {
      const unit = item.slice(number[0].length);
      if (unit !== "" && !/^[A-Za-zµ%°]/.test(unit)) return null;
      entries.push({ text: number[0], unit });
      lastHasUnit = unit !== "";
      if (unit !== "") ++units;
      continue;
    }
    // a unit: of the number before it
    const entry = entries[entries.length - 1];
    if (!entry || lastHasUnit || entry.text === "none" || !/^[A-Za-zµ%°1][\w*/^()µ°.-]*$/.test(item)) return null;
    entry.unit = item;
    lastHasUnit = true;
    ++units;
  }
  if (entries.length === 0) return null;
  const numbers = entries.filter((e) => e.text !== "none");
  const last = numbers[numbers.length - 1];
  if (units === 0) return { entries, unit: "" };
  if (units === 1 && last && last.unit !== "" && entries[entries.length - 1] === last) {
    for (const entry of numbers) entry.unit = last.unit;
    return { entries, unit: last.unit };
  }
  const same = numbers.every((e) => e.unit === numbers[0]!.unit);
  return { entries, unit: same ? numbers[0]!.unit : null };
}

/** Its shortest notation: one unit behind the list if all have the same. */
export function printNumbers(entries: readonly Entry[]): string {
  const numbers = entries.filter((e) => e.text !== "none");
  const unit = numbers[0]?.unit ?? "";
  // A unit goes for the list only from its end, and "none" takes none.
  const one = numbers.every((e) => e.unit === unit) && entries[entries.length - 1]?.text !== "none";
  if (one) return entries.map((e) => e.text).join(" ") + (unit === "" ? "" : ` ${unit}`);
  return entries.map((e) => (e.unit === "" || e.text === "none" ? e.text : `${e.text} ${e.unit}`)).join(" ");
}

/** "2 .. 80 cm" as two entries. */
export function parseRange(text: string): ValueParts | null {
  const halves = text.split("..");
  if (halves.length !== 2) return null;
  const low = parseNumbers(halves[0]!);
  const high = parseNumbers(halves[1]!);
  if (!low || !high || low.entries.length !== 1 || high.entries.length !== 1) return null;
  const [a, b] = [low.entries[0]!, high.entries[0]!];
  if (a.unit === "") a.unit = b.unit;
  return { entries: [a, b], unit: a.unit === b.unit ? a.unit : null };
}

export function printRange(entries: readonly Entry[]): string {
  const [low, high] = entries;
  if (!low || !high) return "";
  const own = low.unit === high.unit ? "" : low.unit;
  return `${low.text}${own === "" ? "" : ` ${own}`} .. ${high.text}${high.unit === "" ? "" : ` ${high.unit}`}`;
}

/** At most 9 significant digits, without trailing zeros. */
export function shortNumber(value: number): string {
  if (!isFinite(value)) return String(value);
  const rounded = Number(value.toPrecision(9));
  return String(Object.is(rounded, -0) ? 0 : rounded);
}

/** The same value in another unit; null if either unit is not known here. */
export function convert(entry: Entry, dimension: string, unit: string): Entry | null {
  if (entry.text === "none") return entry;
  const from = factorOf(dimension, entry.unit);
  const to = factorOf(dimension, unit);
  const value = Number(entry.text);
  if (from === undefined || to === undefined || !isFinite(value)) return null;
  return { text: shortNumber((value * from) / to), unit };
}

interface Bounds {
  min: number | null;
  max: number | null;
  aboveMin: boolean;
  noneAllowed: boolean;
  integer?: boolean;
}

/** The error of one entry; "" if none is known here. */
export function checkEntry(entry: Entry, dimension: string, bounds: Bounds): string {
  if (entry.text === "none") return bounds.noneAllowed ? "" : "none is not allowed here";
  if (!kNumber.test(entry.text) || !isFinite(Number(entry.text))) return `'${entry.text}' is not a number`;
  if (dimension === "rad" && entry.unit === "" && Number(entry.text) !== 0)
    return "an angle needs its unit: deg or rad";
  const factor = factorOf(dimension, entry.unit);
  if (factor === undefined) return "";
  const value = Number(entry.text) * factor;
  if (bounds.integer && !Number.isInteger(value)) return "needs a whole number";
  const unit = dimension === "" || dimension === "1" ? "" : ` ${dimension}`;
  if (bounds.min !== null && (bounds.aboveMin ? value <= bounds.min : value < bounds.min)) {
    return `must be ${bounds.aboveMin ? "above" : "at least"} ${shortNumber(bounds.min)}${unit}`;
  }
  if (bounds.max !== null && value > bounds.max * (1 + 1e-12))
    return `must be at most ${shortNumber(bounds.max)}${unit}`;
  return "";
}

/** "#a0b0c0" for colour inputs; null for names and for texts that are no colour. */
export function hexColor(text: string): string | null {
  const short = /^#([0-9a-f])([0-9a-f])([0-9a-f])$/i.exec(text);
  if (short) return `#${short[1]}${short[1]}${short[2]}${short[2]}${short[3]}${short[3]}`.toLowerCase();
  const long = /^#([0-9a-f]{6})([0-9a-f]{2})?$/i.exec(text);
  return long ? `#${long[1]!.toLowerCase()}` : null;
}
