// Curves over time on a canvas (uPlot), with the shown time as a line.
import uPlot from "uplot";
import { themeColor, type FigureData } from "./figure";
import { rangeOf, type Sample } from "./statistics";
import { drawableRange, shortNumber, withUnit } from "./ticks";

interface CurveChartEvents {
  /** Index of the sample under the pointer; -1: none. */
  hover(index: number): void;
  /** A click at a time [s]. */
  pick(time: number): void;
  /** Part of the time axis that is to be seen; null: all. */
  zoom(range: [number, number] | null): void;
}

/** A click moves less than this [px]. */
const kClick = 4;

export class CurveChart {
  private plot: uPlot | null = null;
  private structure = "";
  private data: FigureData | null = null;
  private range: [number, number] | null = null;
  private time: number | null = null;
  private readonly line = document.createElement("div");
  private readonly resized: ResizeObserver;
  private pickLater: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly host: HTMLElement,
    private readonly events: CurveChartEvents,
  ) {
    this.line.className = "cg-time-line";
    this.resized = new ResizeObserver(() => {
      const size = this.size();
      if (this.plot && (size.width !== this.plot.width || size.height !== this.plot.height)) this.plot.setSize(size);
    });
    this.resized.observe(host);
  }

  destroy(): void {
    clearTimeout(this.pickLater);
    this.resized.disconnect();
    this.plot?.destroy();
    this.plot = null;
  }

  /** Draws `data`, in which all series share the same x. `range`: the part of the time axis to be seen; null: all. */
  update(data: FigureData, range: [number, number] | null): void {
    this.data = data;
    this.range = range;
    const structure = JSON.stringify([
      data.x,
      data.y,
      data.y2,
      data.levels,
      data.series.map((s) => [s.label, s.color, s.dashed, s.axis, s.high !== undefined]),
      document.documentElement.dataset.theme ?? "",
    ]);
    const columns = aligned(data);
    if (!this.plot || structure !== this.structure) {
      this.structure = structure;
      this.plot?.destroy();
      this.plot = new uPlot(this.options(data), columns, this.host);
      this.plot.over.append(this.line);
      this.listen(this.plot);
    } else {
      this.plot.setData(columns, true);
    }
    this.moveLine();
  }

  /** Marks the shown time [s]; null: none. */
  setTime(time: number | null): void {
    this.time = time;
    this.moveLine();
  }

  /** For use without a mouse: arrows move the cursor, Enter picks its time, Home shows all. */
  key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const by = { ArrowLeft: -1, ArrowRight: 1, PageUp: -50, PageDown: 50 }[event.key];
    if (by !== undefined) this.stepCursor(by);
    else if (event.key === "Enter") {
      const time = this.stepCursor(0);
      if (time !== null) this.events.pick(time);
    } else if (event.key === "Home") this.events.zoom(null);
    else return;
    // arrows also step the run
    event.preventDefault();
    event.stopPropagation();
  }

  private stepCursor(by: number): number | null {
    const { plot, data } = this;
    const times = data?.series[0]?.x ?? [];
    if (!plot || times.length === 0) return null;
    const present = plot.cursor.idx ?? plot.valToIdx(this.time ?? 0);
    const index = Math.min(Math.max(present + by, 0), times.length - 1);
    const time = times[index] ?? null;
    if (time !== null) plot.setCursor({ left: plot.valToPos(time, "x"), top: 10 });
    return time;
  }

  private size(): { width: number; height: number } {
    return { width: Math.max(this.host.clientWidth, 120), height: Math.max(this.host.clientHeight, 80) };
  }

  private moveLine(): void {
    const { plot, time } = this;
    const scale = plot?.scales.x;
    const inside =
      plot && scale && time !== null && typeof scale.min === "number" && time >= scale.min && time <= (scale.max ?? 0);
    this.line.hidden = !inside;
    if (inside) this.line.style.transform = `translateX(${plot.valToPos(time, "x")}px)`;
  }

  private listen(plot: uPlot): void {
    let from: [number, number] | null = null;
    plot.over.addEventListener("pointerdown", (event) => {
      from = event.button === 0 ? [event.clientX, event.clientY] : null;
    });
    plot.over.addEventListener("pointerup", (event) => {
      if (!from || Math.hypot(event.clientX - from[0], event.clientY - from[1]) >= kClick) return;
      const left = event.clientX - plot.over.getBoundingClientRect().left;
      const times = this.data?.series[0]?.x ?? [];
      const time = times[plot.posToIdx(left)];
      clearTimeout(this.pickLater);
      if (typeof time !== "number") return;
      // a zoomed figure waits for a second click, which shows all again and goes nowhere
      if (this.range) this.pickLater = setTimeout(() => this.events.pick(time), 300);
      else if (event.detail < 2) this.events.pick(time);
    });
  }

  private options(data: FigureData): uPlot.Options {
    const style = getComputedStyle(this.host);
    const css = (color: string): string => {
      const name = /^var\((--[\w-]+)\)$/.exec(color)?.[1];
      return (name && style.getPropertyValue(name).trim()) || "#888";
    };
    const text = css("var(--cg-text)");
    const grid = { stroke: css("var(--cg-grid)"), width: 0.5 };
    const font = `12px ${style.fontFamily}`;
    const axis = (label: string, more: uPlot.Axis): uPlot.Axis => ({
      label,
      labelFont: font,
      labelSize: 18,
      font,
      stroke: text,
      grid,
      ticks: { ...grid, size: 5 },
      values: (_plot, marks) => marks.map((m) => shortNumber(m, 6)),
      ...more,
    });
    const sideRange =
      (log: boolean): uPlot.Range.Function =>
      (_plot, low, high) => {
        if (log)
          return low === null || !(low > 0) ? [0.1, 1] : uPlot.rangeLog(low, Math.max(high, low * 1.1), 10, false);
        const levels = data.levels?.map((l) => l.value) ?? [];
        return drawableRange(...rangeOf([low, high, ...levels]), 0.05);
      };
    const series: uPlot.Series[] = [{}];
    const bands: uPlot.Band[] = [];
    for (const s of data.series) {
      const stroke = css(themeColor(s.color));
      const line: uPlot.Series = {
        label: s.label,
        scale: s.axis === 1 && data.y2 ? "y2" : "y",
        stroke,
        width: 1.5,
        dash: s.dashed ? [6, 4] : undefined,
        // one sample is no line yet
        points: { show: (plot) => plot.data[0].length < 2, size: 6 },
        spanGaps: false,
        // smooth curves, not ones in steps of pixels
        pxAlign: false,
      };
      series.push(line);
      if (!s.high) continue;
      series.push({ ...line, width: 1 });
      bands.push({ series: [series.length - 1, series.length - 2], fill: faded(stroke) });
    }
    const axes = [
      axis(withUnit(data.x.label, data.x.unit), { size: 32 }),
      axis(withUnit(data.y.label, data.y.unit), { scale: "y", size: 58 }),
    ];
    if (data.y2)
      axes.push(axis(withUnit(data.y2.label, data.y2.unit), { scale: "y2", side: 1, size: 58, grid: { show: false } }));
    const yScale = (log: boolean | undefined): uPlot.Scale => ({
      distr: log ? 3 : 1,
      range: sideRange(log === true),
    });
    return {
      ...this.size(),
      series,
      bands,
      axes,
      scales: {
        x: {
          time: false,
          // the server's part of a zoomed range may begin or end a frame beside it
          range: (_plot, low, high) => this.range ?? drawableRange(low, high),
        },
        y: yScale(data.y.log),
        ...(data.y2 ? { y2: yScale(data.y2.log) } : {}),
      },
      legend: { show: false },
      cursor: {
        drag: { x: true, y: false, setScale: false, dist: kClick },
        points: { show: false },
        y: false,
        bind: {
          dblclick: () => () => {
            clearTimeout(this.pickLater);
            this.events.zoom(null);
            return null;
          },
        },
      },
      hooks: {
        setCursor: [(plot) => this.events.hover(plot.cursor.idx ?? -1)],
        setSelect: [
          (plot) => {
            const { left, width } = plot.select;
            if (width < kClick) return;
            const range: [number, number] = [plot.posToVal(left, "x"), plot.posToVal(left + width, "x")];
            plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
            this.events.zoom(range);
          },
        ],
        draw: [(plot) => this.drawLevels(plot, css("var(--cg-error)"))],
        setScale: [() => this.moveLine()],
        setSize: [() => this.moveLine()],
      },
    };
  }

  private drawLevels(plot: uPlot, color: string): void {
    const { ctx, bbox } = plot;
    for (const level of this.data?.levels ?? []) {
      const at = plot.valToPos(level.value, "y", true);
      if (!(at >= bbox.top && at <= bbox.top + bbox.height)) continue;
      ctx.save();
      ctx.strokeStyle = color;
      ctx.fillStyle = color;
      ctx.setLineDash([2 * uPlot.pxRatio, 3 * uPlot.pxRatio]);
      ctx.beginPath();
      ctx.moveTo(bbox.left, at);
      ctx.lineTo(bbox.left + bbox.width, at);
      ctx.stroke();
      ctx.textAlign = "right";
      ctx.font = `${11 * uPlot.pxRatio}px sans-serif`;
      ctx.fillText(level.label, bbox.left + bbox.width - 4, at - 4);
      ctx.restore();
    }
  }
}

function aligned(data: FigureData): uPlot.AlignedData {
  const times = (data.series[0]?.x ?? []) as number[];
  const log = (axis: 0 | 1): boolean => (axis === 1 ? data.y2?.log : data.y.log) === true;
  const columns: (number | null)[][] = [];
  for (const s of data.series)
    for (const values of s.high ? [s.y, s.high] : [s.y])
      // no logarithm of what is not above zero
      columns.push(log(s.axis) ? values.map((v: Sample) => (v !== null && v > 0 ? v : null)) : values);
  return [times, ...columns];
}

/** A third of a colour #rrggbb. */
const faded = (color: string): string => (/^#[\da-f]{6}$/i.test(color) ? `${color}55` : "rgb(128 128 128 / 33%)");
