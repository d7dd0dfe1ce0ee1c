// Requests the data of a figure from the run, only as much as needed.
import { signal } from "@preact/signals-core";
import { isClosed, messageOf } from "../core/link";
import type { Answer, FigureAxis, SeriesPart, Status } from "../core/protocol";
import type { Studio } from "../core/studio";
import { Curves, isThinned, type SeriesAnswer } from "./curves";
import {
  axisLabel,
  colorOf,
  kindOf,
  shareAxes,
  type Axis,
  type FigureData,
  type FigureSeries,
  type FigureSpec,
} from "./figure";

/** Points of a curve: more than there are pixels side by side. */
const kPoints = 2000;
/** Samples of box plots and the like, which must not be thinned: as many as the server gives. */
const kSamples = 100_000;
/** [ms] between two updates, of curves and of figures that are costly to draw. */
const kCurvePause = 180;
const kOtherPause = 1000;
/** [ms] after a refusal. */
const kPatience = 2000;

export class Feed {
  readonly data = signal<FigureData | null>(null);
  readonly error = signal("");
  /** a note about the numbers; empty: none */
  readonly note = signal("");
  /** part of the time axis that is seen [s]; null: all */
  readonly range = signal<[number, number] | null>(null);

  private readonly curves = new Curves();
  private key = "";
  private seen: { last: number; frames: number } = { last: -Infinity, frames: 0 };
  private nextLook = 0;
  private busy = false;
  private bad = new Map<string, string>();

  constructor(
    private readonly studio: Studio,
    private readonly spec: () => FigureSpec,
  ) {}

  /** Checks for new data; called again and again while the figure is visible. */
  async tick(now: number): Promise<void> {
    const status = this.studio.state.status.peek();
    if (this.busy || now < this.nextLook || !status || !this.studio.state.open.peek()) return;
    const spec = this.spec();
    const key = this.keyOf(spec, status);
    const rewound = status.last < this.seen.last - 1e-9;
    const restarted = key !== this.key || rewound;
    if (!restarted && status.last === this.seen.last && status.frames === this.seen.frames) return;
    // the visible part of a zoomed figure does not change at its right end
    const range = this.range.peek();
    if (!restarted && spec.kind === "curve" && !spec.plot && range && range[1] < this.seen.last) return;
    this.busy = true;
    if (key !== this.key) this.bad.clear();
    this.key = key;
    this.seen = { last: status.last, frames: status.frames };
    try {
      const data = await this.read(spec, restarted, range, status);
      this.nextLook = now + (spec.kind === "curve" ? kCurvePause : kOtherPause);
      // asked again meanwhile: for something else
      if (key === this.keyOf(this.spec(), this.studio.state.status.peek() ?? status)) {
        this.data.value = data;
        this.error.value = [...this.bad.values()].join("; ");
      }
    } catch (error) {
      this.key = "";
      this.nextLook = now + kPatience;
      if (!isClosed(error)) this.error.value = messageOf(error);
    } finally {
      this.busy = false;
    }
  }

  /** Shows only part of the time axis [s], in full detail; null: all. */
  zoom(range: [number, number] | null): void {
    this.range.value = range;
    this.nextLook = 0;
  }

  private keyOf(spec: FigureSpec, status: Status): string {
    return JSON.stringify([
      spec.kind,
      spec.plot,
      spec.signals,
      status.scene,
      status.compare?.labels,
      this.range.peek(),
    ]);
  }

  private async read(
    spec: FigureSpec,
    restarted: boolean,
    range: [number, number] | null,
    status: Status,
  ): Promise<FigureData> {
    if (spec.plot) {
      this.note.value = "";
      return fromPlot(await this.studio.link.request("figure", { plot: spec.plot }));
    }
    const names = [...new Set(spec.signals.filter((s) => s !== ""))];
    if (names.length === 0) {
      this.curves.clear();
      this.note.value = "";
      return emptyFigure(spec);
    }
    if (spec.kind !== "curve") return this.samples(spec, names, status);
    const ghost = Boolean(status.compare);
    const grows = !restarted && !range && this.curves.time.length > 0;
    const from = grows ? this.curves.last : (range?.[0] ?? null);
    // two runs are requested one after the other: up to one time, though frames come in between
    const to = ghost ? Math.min(range?.[1] ?? Infinity, status.last) : (range?.[1] ?? null);
    const answer = await this.series(names, from, to, kPoints, ghost);
    if (!grows || !this.curves.append(answer))
      this.curves.replace(grows ? await this.series(names, null, to, kPoints, ghost) : answer);
    this.note.value = this.curves.series.some(isThinned)
      ? "More steps than points: the band is from the lowest to the highest value of each interval. Drag over a part to see all of it."
      : "";
    return curveFigure(spec, this.curves, status.compare?.labels ?? null);
  }

  private async samples(spec: FigureSpec, names: string[], status: Status): Promise<FigureData> {
    const answer = await this.series(names, null, null, Math.min(Math.max(status.frames, kPoints), kSamples));
    const parts = answer.series;
    this.note.value = parts.some(isThinned) ? "Only some samples are used: the run is long." : "";
    const part = (name: string | undefined) => parts.find((p) => p.signal === name);
    const data = emptyFigure(spec);
    if (spec.kind === "box" || spec.kind === "histogram") {
      data.series = parts.map((p) => {
        const values = p.low;
        const box = spec.kind === "box";
        const color = colorOf(spec.signals.indexOf(p.signal));
        return seriesOf({ label: p.signal, unit: p.unit, color, x: box ? [] : values, y: box ? values : [] });
      });
      const units = new Set(parts.map((p) => p.unit));
      const axis = { label: axisLabel(parts.map((p) => p.signal)), unit: units.size === 1 ? [...units][0]! : "" };
      // boxes of different units each say their own
      if (units.size > 1)
        data.series.forEach((s) => {
          if (s.unit && s.unit !== "1") s.label = `${s.label} [${s.unit}]`;
        });
      if (spec.kind === "box") data.y = axis;
      else data.x = axis;
      if (spec.kind === "histogram") data.y = { label: "count", unit: "" };
      return data;
    }
    const [x, y, z] = [part(spec.signals[0]), part(spec.signals[1]), part(spec.signals[2])];
    if (!x || !y || (spec.kind === "surface" && !z)) return data;
    data.x = { label: x.signal, unit: x.unit };
    data.y = { label: y.signal, unit: y.unit };
    if (z) data.z = { label: z.signal, unit: z.unit };
    data.times = answer.time;
    data.series = [
      seriesOf({ label: (z ?? y).signal, unit: (z ?? y).unit, color: colorOf(0), x: x.low, y: y.low, z: z?.low ?? [] }),
    ];
    return data;
  }

  /** Of the signals that there are; the others are remembered as bad, with why. */
  private async series(
    names: string[],
    from: number | null,
    to: number | null,
    points: number,
    ghost = false,
  ): Promise<SeriesAnswer> {
    const one = (signals: string[], p: number, run?: "ghost"): Promise<SeriesAnswer> =>
      this.studio.link.request("series", { signals, from, to, points: p, ...(run ? { run } : {}) });
    const ask = async (signals: string[], p: number): Promise<SeriesAnswer> => {
      const solid = await one(signals, p);
      return ghost ? withGhost(solid, await one(signals, p, "ghost")) : solid;
    };
    let good = names.filter((n) => !this.bad.has(n));
    if (good.length === 0) return { time: [], series: [] };
    try {
      return await ask(good, points);
    } catch (error) {
      if (isClosed(error)) throw error;
      if (good.length === 1) this.bad.set(good[0]!, messageOf(error));
      else
        for (const name of good)
          await ask([name], 1).catch((e: unknown) => {
            if (isClosed(e)) throw e;
            this.bad.set(name, messageOf(e));
          });
      good = good.filter((n) => !this.bad.has(n));
      if (good.length === 0) return { time: [], series: [] };
      return ask(good, points);
    }
  }
}

/** Both runs in one answer; times that only one of them has are left out. */
export function withGhost(solid: SeriesAnswer, ghost: SeriesAnswer): SeriesAnswer {
  let count = 0;
  while (count < solid.time.length && solid.time[count] === ghost.time[count]) count += 1;
  const cut = (s: SeriesPart): SeriesPart => ({ ...s, low: s.low.slice(0, count), high: s.high.slice(0, count) });
  return {
    time: solid.time.slice(0, count),
    series: [...solid.series.map(cut), ...ghost.series.map((s) => ({ ...cut(s), run: "ghost" }))],
  };
}

function seriesOf(fields: Partial<FigureSeries>): FigureSeries {
  return { label: "", unit: "", color: colorOf(0), dashed: false, axis: 0, x: [], y: [], z: [], ...fields };
}

function emptyFigure(spec: FigureSpec): FigureData {
  const none = { label: "", unit: "" };
  const x = spec.kind === "curve" ? { label: "time", unit: "s" } : none;
  return { kind: spec.kind, title: spec.title, x, y: none, z: none, series: [] };
}

/** Curves with two axes where units differ. `labels`: of the solid and the dashed run of a comparison. */
function curveFigure(spec: FigureSpec, curves: Curves, labels: readonly string[] | null): FigureData {
  const time = curves.time.slice();
  const shared = shareAxes(curves.series.map((s) => s.unit));
  const names = (axis: 0 | 1): string =>
    axisLabel(curves.series.filter((_, k) => shared.axes[k] === axis).map((s) => s.signal));
  return {
    ...emptyFigure(spec),
    y: { label: names(0), unit: shared.left },
    y2: shared.right === null ? undefined : { label: names(1), unit: shared.right },
    series: curves.series.map((s, k) => {
      const ghost = s.run === "ghost";
      const run = labels?.[ghost ? 1 : 0];
      return seriesOf({
        label: run ? `${s.signal} (${run})` : s.signal,
        unit: s.unit,
        color: colorOf(Math.max(spec.signals.indexOf(s.signal), 0)),
        dashed: ghost,
        axis: shared.axes[k]!,
        x: time,
        y: s.low.slice(),
        high: isThinned(s) ? s.high.slice() : undefined,
      });
    }),
  };
}

/** A plot of the scene, as the server sampled it. */
export function fromPlot(answer: Answer<"figure">): FigureData {
  const axis = (a: FigureAxis | undefined): Axis => ({ label: a?.label ?? "", unit: a?.unit ?? "", log: a?.log });
  return {
    kind: kindOf(answer.kind),
    title: answer.title ?? "",
    x: axis(answer.x),
    y: axis(answer.y),
    z: axis(answer.z),
    series: answer.series.map((s, k) =>
      seriesOf({
        label: s.label ?? "",
        unit: (answer.kind === "histogram" ? answer.x?.unit : answer.y?.unit) ?? "",
        color: colorOf(k),
        x: s.x ?? [],
        y: s.y ?? [],
        z: s.z ?? [],
      }),
    ),
  };
}

/** Whether a figure's curves go over time, so that a click can go to it and the time can be shown. */
export function overTime(data: FigureData): boolean {
  const x = data.series[0]?.x ?? [];
  return (
    data.kind === "curve" &&
    data.x.unit === "s" &&
    data.series.every((s) => s.x.length === x.length) &&
    x.every((t, i) => t !== null && (i === 0 || t >= (x[i - 1] ?? NaN))) &&
    data.series.every((s) => s.x === x || s.x.every((t, i) => t === x[i]))
  );
}
