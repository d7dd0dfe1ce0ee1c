// Curves that grow: the samples received so far, thinned where they are too many to draw.
import type { SeriesPart } from "../core/protocol";
import type { Sample } from "./statistics";

/** An answer to `series`, or two: those of `run` "ghost" are of the second run of a comparison. */
export interface SeriesAnswer {
  time: number[];
  series: (SeriesPart & { run?: string })[];
}

/** Times with the lowest and highest of every curve since the time before. */
export class Curves {
  time: number[] = [];
  series: SeriesAnswer["series"] = [];

  /** Points that are kept; beyond, neighbours are joined two by two. */
  constructor(private readonly most = 4000) {}

  /** The last time there is, -Infinity before the first. */
  get last(): number {
    return this.time.length > 0 ? this.time[this.time.length - 1]! : -Infinity;
  }

  clear(): void {
    this.time = [];
    this.series = [];
  }

  /** Replaces all samples by those of `answer`. */
  replace(answer: SeriesAnswer): void {
    this.time = answer.time.slice();
    this.series = answer.series.map((s) => ({ ...s, low: s.low.slice(), high: s.high.slice() }));
    this.thin();
  }

  /** Adds the part of `answer` that is newer. False, and nothing changes, when it is about other curves: all must be asked
   *  for again. */
  append(answer: SeriesAnswer): boolean {
    const same =
      answer.series.length === this.series.length &&
      answer.series.every((s, i) => s.signal === this.series[i]!.signal && s.run === this.series[i]!.run);
    if (!same) return false;
    const last = this.last;
    const begin = answer.time.findIndex((t) => t > last + 1e-9);
    if (begin < 0) return true;
    for (let i = begin; i < answer.time.length; ++i) this.time.push(answer.time[i]!);
    answer.series.forEach((part, k) => {
      const mine = this.series[k]!;
      for (let i = begin; i < answer.time.length; ++i) {
        mine.low.push(part.low[i] ?? null);
        mine.high.push(part.high[i] ?? null);
      }
    });
    this.thin();
    return true;
  }

  private thin(): void {
    while (this.time.length > this.most) {
      const pairs = Math.ceil(this.time.length / 2);
      // the first and the last time stay what they are, so that growing continues where it ended
      const time = Array.from({ length: pairs }, (_, i) => this.time[2 * i]!);
      const odd = this.time.length % 2 === 1;
      if (!odd) time[pairs - 1] = this.time[this.time.length - 1]!;
      for (const s of this.series) {
        s.low = Array.from({ length: pairs }, (_, i) => pick(s.low[2 * i], s.low[2 * i + 1], Math.min));
        s.high = Array.from({ length: pairs }, (_, i) => pick(s.high[2 * i], s.high[2 * i + 1], Math.max));
      }
      this.time = time;
    }
  }
}

function pick(a: Sample | undefined, b: Sample | undefined, which: (a: number, b: number) => number): Sample {
  if (typeof a !== "number") return b ?? null;
  return typeof b === "number" ? which(a, b) : a;
}

/** Whether some point stands for several frames. */
export function isThinned(part: { low: readonly Sample[]; high: readonly Sample[] }): boolean {
  return part.low.some((v, i) => v !== part.high[i]);
}

/** Index of the time nearest to `time` in an ascending list; -1 of an empty one. */
export function nearest(times: readonly number[], time: number): number {
  if (times.length === 0) return -1;
  let low = 0;
  let high = times.length - 1;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle]! < time) low = middle + 1;
    else high = middle;
  }
  return low > 0 && time - times[low - 1]! <= times[low]! - time ? low - 1 : low;
}
