// The numbers behind box plots, histograms and surfaces. Methods and results are those of the SDK
// (cogrsim/figures/statistics.h), so that a figure is the same on the page and on paper.

export type Sample = number | null;

const finite = (samples: readonly Sample[]): number[] =>
  samples.filter((v): v is number => v !== null && Number.isFinite(v));
const sortedFinite = (samples: readonly Sample[]): number[] => finite(samples).sort((a, b) => a - b);

/** The `p` quantile of ascending numbers, 0 <= p <= 1, as Matlab's quantile() (Hyndman and Fan 1996, definition 5): the k-th of n
 *  is the (k - 0.5)/n quantile, linear between, constant outside. NaN of none. */
export function quantile(sorted: readonly number[], p: number): number {
  if (sorted.length === 0) return NaN;
  const at = p * sorted.length - 0.5;
  if (at <= 0) return sorted[0]!;
  const below = Math.floor(at);
  if (below + 1 >= sorted.length) return sorted[sorted.length - 1]!;
  const part = at - below;
  return sorted[below]! * (1 - part) + sorted[below + 1]! * part;
}

export interface BoxNumbers {
  count: number;
  /** samples that were not finite */
  omitted: number;
  q1: number;
  median: number;
  q3: number;
  whiskerLow: number;
  whiskerHigh: number;
  mean: number;
  /** ascending */
  outliers: number[];
}

/** What a box plot draws: whiskers reach to the most extreme samples within `whisker` interquartile ranges of the box, and
 *  never inside it. All NaN without samples. */
export function boxNumbers(samples: readonly Sample[], whisker = 1.5): BoxNumbers {
  const sorted = sortedFinite(samples);
  const [q1, median, q3] = [quantile(sorted, 0.25), quantile(sorted, 0.5), quantile(sorted, 0.75)];
  const whiskerLength = whisker * (q3 - q1);
  const box: BoxNumbers = {
    count: sorted.length,
    omitted: samples.length - sorted.length,
    q1,
    median,
    q3,
    whiskerLow: q1,
    whiskerHigh: q3,
    mean: moments(sorted).mean,
    outliers: [],
  };
  for (const value of sorted) {
    if (value < q1 - whiskerLength || value > q3 + whiskerLength) {
      box.outliers.push(value);
    } else {
      box.whiskerLow = Math.min(box.whiskerLow, value);
      box.whiskerHigh = Math.max(box.whiskerHigh, value);
    }
  }
  return box;
}

function moments(samples: readonly number[]): { mean: number; deviation: number } {
  const n = samples.length;
  if (n === 0) return { mean: NaN, deviation: NaN };
  const mean = samples.reduce((sum, v) => sum + v, 0) / n;
  const squares = samples.reduce((sum, v) => sum + (v - mean) ** 2, 0);
  return { mean, deviation: n < 2 ? 0 : Math.sqrt(squares / (n - 1)) };
}

/** 1, 2 or 5 times a power of ten: the one nearest to `width` > 0, by ratio. */
export function roundedStep(width: number): number {
  const power = 10 ** Math.floor(Math.log10(width));
  const digits = width / power;
  return power * (digits < Math.SQRT2 ? 1 : digits < Math.sqrt(10) ? 2 : digits < Math.sqrt(50) ? 5 : 10);
}

const kMostBins = 1000;

/** Edges of bins for all finite samples, ascending, one more than bins: one per whole number where these are few, else by Scott's
 *  rule, width 3.5 s / n^(1/3) rounded to 1, 2 or 5 times a power of ten. Empty without samples. */
export function binEdges(samples: readonly Sample[]): number[] {
  const sorted = sortedFinite(samples);
  if (sorted.length === 0) return [];
  const low = sorted[0]!;
  const high = sorted[sorted.length - 1]!;
  if (high - low <= 50 && Math.max(Math.abs(low), Math.abs(high)) < 1e15 && sorted.every(Number.isInteger))
    return Array.from({ length: high - low + 2 }, (_, i) => low - 0.5 + i);
  // what differs by rounding only counts as constant
  const digit = Math.max(Math.abs(low), Math.abs(high)) * 1e-14;
  if (!(high - low > digit)) {
    const width = low === 0 ? 1 : 0.1 * Math.abs(low);
    return [low - width / 2, low + width / 2];
  }
  let width = (3.5 * moments(sorted).deviation) / Math.cbrt(sorted.length);
  if (width > digit) width = roundedStep(width);
  const count = Math.ceil(high / width) - Math.floor(low / width);
  if (!(width > digit) || !(count <= kMostBins)) {
    const even = Array.from({ length: kMostBins + 1 }, (_, i) => low + ((high - low) * i) / kMostBins);
    even[kMostBins] = high;
    return even;
  }
  const first = Math.floor(low / width);
  const edges = Array.from({ length: Math.max(1, count) + 1 }, (_, i) => (first + i) * width);
  // rounding must not leave a sample outside
  edges[0] = Math.min(edges[0]!, low);
  edges[edges.length - 1] = Math.max(edges[edges.length - 1]!, high);
  return edges;
}

/** How many finite samples lie in each bin; a bin owns its lower edge, the last one both. */
export function binCounts(samples: readonly Sample[], edges: readonly number[]): number[] {
  if (edges.length < 2) return [];
  const counts = new Array<number>(edges.length - 1).fill(0);
  for (const value of finite(samples)) {
    if (value < edges[0]! || value > edges[edges.length - 1]!) continue;
    let low = 0;
    let high = counts.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (edges[middle]! <= value) low = middle;
      else high = middle - 1;
    }
    counts[low]! += 1;
  }
  return counts;
}

export interface Cells {
  /** centres of columns and rows, ascending */
  x: number[];
  y: number[];
  /** mean per cell, a list per row; null: no samples there */
  z: (number | null)[][];
  counts: number[][];
}

interface Lines {
  low: number;
  cell: number;
  count: number;
}

/** Scattered samples gathered in equal cells, about four samples each, 4 to 40 a side; samples that stand again and again on at
 *  most 40 equally spaced lines get a line of cells for each. */
export function cellMeans(x: readonly Sample[], y: readonly Sample[], z: readonly Sample[]): Cells {
  const xs: number[] = [];
  const ys: number[] = [];
  const zs: number[] = [];
  for (let i = 0; i < Math.min(x.length, y.length, z.length); ++i) {
    const [a, b, c] = [x[i], y[i], z[i]];
    if (typeof a !== "number" || typeof b !== "number" || typeof c !== "number") continue;
    if (!Number.isFinite(a) || !Number.isFinite(b) || !Number.isFinite(c)) continue;
    xs.push(a);
    ys.push(b);
    zs.push(c);
  }
  if (xs.length === 0) return { x: [], y: [], z: [], counts: [] };
  const usual = Math.min(Math.max(Math.floor(Math.sqrt(xs.length / 4)), 4), 40);
  const across = standingLines(xs) ?? evenLines(xs, usual);
  const along = standingLines(ys) ?? evenLines(ys, usual);
  const sums = Array.from({ length: along.count }, () => new Array<number>(across.count).fill(0));
  const counts = sums.map((row) => row.slice());
  for (let i = 0; i < xs.length; ++i) {
    const [row, column] = [lineOf(along, ys[i]!), lineOf(across, xs[i]!)];
    sums[row]![column]! += zs[i]!;
    counts[row]![column]! += 1;
  }
  const means = sums.map((row, r) => row.map((s, c) => (counts[r]![c]! > 0 ? s / counts[r]![c]! : null)));
  return { x: centres(across), y: centres(along), z: means, counts };
}

const lineOf = (lines: Lines, value: number): number =>
  Math.min(Math.max(Math.floor((value - lines.low) / lines.cell), 0), lines.count - 1);
const centres = (lines: Lines): number[] =>
  Array.from({ length: lines.count }, (_, i) => lines.low + (i + 0.5) * lines.cell);

function evenLines(values: readonly number[], count: number): Lines {
  const [low, high] = rangeOf(values);
  const cell = (high - low) / count;
  if (cell > 1e-14 * Math.max(Math.abs(low), Math.abs(high))) return { low, cell, count };
  const wide = low === 0 ? 1 : 0.1 * Math.abs(low);
  return { low: low - wide / 2, cell: wide, count: 1 };
}

function standingLines(values: readonly number[]): Lines | null {
  const lines = [...new Set(values)].sort((a, b) => a - b);
  const count = lines.length;
  if (count < 2 || count > 40 || values.length < 4 * count) return null;
  const pitch = (lines[count - 1]! - lines[0]!) / (count - 1);
  if (lines.some((v, i) => Math.abs(v - lines[0]! - i * pitch) >= 1e-6 * pitch)) return null;
  return { low: lines[0]! - pitch / 2, cell: pitch, count };
}

/** Lowest and highest finite number; [NaN, NaN] of none. No spreading of arguments: lists may be long. */
export function rangeOf(values: Iterable<Sample | undefined>): [number, number] {
  let low = Infinity;
  let high = -Infinity;
  for (const value of values) {
    if (typeof value !== "number" || !Number.isFinite(value)) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return low <= high ? [low, high] : [NaN, NaN];
}
