// Where the marks of an axis stand, and how numbers are written.
import { roundedStep } from "./statistics";

/** A range that can be drawn: constant values get a margin on both sides, none get 0 to 1. */
export function drawableRange(low: number, high: number, pad = 0): [number, number] {
  if (!Number.isFinite(low) || !Number.isFinite(high)) return [0, 1];
  if (high - low <= 1e-12 * Math.max(Math.abs(low), Math.abs(high))) {
    const margin = low === 0 ? 1 : 0.1 * Math.abs(low);
    return [low - margin, high + margin];
  }
  const margin = pad * (high - low);
  return [low - margin, high + margin];
}

/** Multiples of 1, 2 or 5 times a power of ten within [low, high], about `count` of them. */
export function ticks(low: number, high: number, count: number): number[] {
  if (!(high > low) || !(count >= 1)) return [];
  const step = roundedStep((high - low) / count);
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  const all: number[] = [];
  // k * step, not a running sum: no error that grows; + 0 makes no -0
  for (let k = first; k <= last; ++k) all.push(Number((k * step).toPrecision(12)) + 0);
  return all;
}

/** Powers of ten within [low, high], 0 < low < high; every second, third, … where they are many. */
export function logTicks(low: number, high: number, count: number): number[] {
  if (!(low > 0) || !(high > low)) return [];
  const first = Math.ceil(Math.log10(low) - 1e-9);
  const last = Math.floor(Math.log10(high) + 1e-9);
  const step = Math.max(1, Math.ceil((last - first) / Math.max(count, 1)));
  const all: number[] = [];
  for (let k = first; k <= last; k += step) all.push(Number(`1e${k}`));
  return all;
}

/** The marks of one axis as text, all with enough digits to differ. */
export function tickLabels(marks: readonly number[]): string[] {
  if (marks.length === 0) return [];
  const most = Math.max(...marks.map(Math.abs));
  if (most === 0) return marks.map(() => "0");
  const gaps = marks.slice(1).map((m, i) => Math.abs(m - marks[i]!));
  const step = gaps.length > 0 ? Math.min(...gaps) : most;
  if (most >= 1e5 || most < 1e-3) {
    const digits = Math.max(0, Math.floor(Math.log10(most)) - Math.floor(Math.log10(step) + 1e-9));
    return marks.map((m) => (m === 0 ? "0" : m.toExponential(Math.min(digits, 12)).replace("e+", "e")));
  }
  let decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  // a step of 2.5 needs one digit more than its size suggests
  if (Math.abs(step * 10 ** decimals - Math.round(step * 10 ** decimals)) > 1e-6) decimals += 1;
  return marks.map((m) => m.toFixed(Math.min(decimals, 12)));
}

/** A number for people, `digits` significant ones; "–" for none. */
export function shortNumber(value: number | null | undefined, digits = 5): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size !== 0 && (size >= 1e6 || size < 1e-4)) {
    return value.toExponential(Math.max(digits - 2, 0)).replace(/\.?0*e\+?/, "e");
  }
  return String(Number(value.toPrecision(digits)));
}

/** "speed [m/s]"; units "" and "1" are not written. */
export function withUnit(label: string, unit: string): string {
  return unit === "" || unit === "1" ? label : `${label} [${unit}]`;
}
