// Box plots, histograms, surfaces and paths, drawn by Plotly from numbers that were computed here.
import { boxesOf, cellsOf, cornersOf, histogramOf, type Axis, type FigureData } from "./figure";
import type { Sample } from "./statistics";
import { withUnit } from "./ticks";

/** Colours of text, lines and series. */
interface ChartColors {
  text: string;
  grid: string;
  ground: string;
  series(color: string): string;
}
const kPrintColors: ChartColors = { text: "#000", grid: "#ddd", ground: "#fff", series: (color) => color };

let cartesian: Promise<PlotlyBundle> | null = null;
let solid: Promise<PlotlyBundle> | null = null;
/** Loaded when the first such figure is drawn. */
function load(threeD: boolean): Promise<PlotlyBundle> {
  if (threeD) return (solid ??= import("plotly.js-gl3d-dist-min").then((m) => m.default));
  return (cartesian ??= import("plotly.js-cartesian-dist-min").then((m) => m.default));
}

let webgl: boolean | null = null;
function hasWebgl(): boolean {
  if (webgl === null) {
    const context = document.createElement("canvas").getContext("webgl");
    webgl = context !== null;
    context?.getExtension("WEBGL_lose_context")?.loseContext();
  }
  return webgl;
}

export class PlotlyChart {
  private bundle: PlotlyBundle | null = null;
  private gone = false;
  private busy = false;
  private next: { data: FigureData; colors: ChartColors } | null = null;
  private listening = false;
  private readonly resized: ResizeObserver;

  constructor(
    private readonly host: HTMLElement,
    private readonly pick: (index: number) => void,
  ) {
    this.resized = new ResizeObserver(() => {
      if (this.bundle && !this.gone && this.host.clientWidth > 0) void this.bundle.Plots.resize(this.host);
    });
    this.resized.observe(host);
  }

  destroy(): void {
    this.gone = true;
    this.resized.disconnect();
    this.bundle?.purge(this.host);
  }

  /** Draws `data`; of several that come while one is drawn the last is. */
  async update(data: FigureData, colors: ChartColors): Promise<void> {
    this.next = { data, colors };
    if (this.busy) return;
    this.busy = true;
    try {
      while (this.next && !this.gone) {
        const { data: now, colors: present } = this.next;
        this.next = null;
        const { traces, layout, threeD } = drawing(now, present, hasWebgl());
        const bundle = await load(threeD);
        if (this.gone) return;
        if (this.bundle && this.bundle !== bundle) this.bundle.purge(this.host);
        this.bundle = bundle;
        await bundle.react(this.host, traces, layout, { displaylogo: false, displayModeBar: false, responsive: false });
        this.listen();
      }
    } finally {
      this.busy = false;
    }
  }

  private listen(): void {
    const host = this.host as HTMLElement & { on?(name: string, listener: (event: unknown) => void): void };
    if (this.listening || !host.on) return;
    this.listening = true;
    host.on("plotly_click", (event) => {
      const index = (event as { points?: { pointNumber?: unknown }[] }).points?.[0]?.pointNumber;
      if (typeof index === "number") this.pick(index);
    });
  }
}

/** As a PNG file, in colours for print. */
export async function surfacePng(data: FigureData, width: number, height: number): Promise<Blob> {
  const { traces, layout, threeD } = drawing(data, kPrintColors, hasWebgl());
  const bundle = await load(threeD);
  const address = await bundle.toImage({ data: traces, layout }, { format: "png", width, height, scale: 2 });
  const bytes = Uint8Array.from(atob(address.slice(address.indexOf(",") + 1)), (c) => c.charCodeAt(0));
  return new Blob([bytes], { type: "image/png" });
}

/** Plotly reads tags and entities in texts: they are to be seen as they are. */
function plain(text: string): string {
  return text.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll(">", "&gt;");
}

function drawing(
  data: FigureData,
  colors: ChartColors,
  webglWorks: boolean,
): { traces: object[]; layout: object; threeD: boolean } {
  const axis = (a: Axis): object => ({
    title: { text: plain(withUnit(a.label, a.unit)) },
    type: a.log ? "log" : "linear",
    gridcolor: colors.grid,
    zerolinecolor: colors.grid,
    linecolor: colors.text,
    color: colors.text,
    automargin: true,
  });
  const layout: Record<string, unknown> = {
    title: colors === kPrintColors ? { text: plain(data.title) } : undefined,
    paper_bgcolor: colors === kPrintColors ? colors.ground : "rgba(0,0,0,0)",
    plot_bgcolor: "rgba(0,0,0,0)",
    font: { color: colors.text, size: 12 },
    margin: { l: 60, r: 16, t: colors === kPrintColors ? 44 : 12, b: 48 },
    showlegend: false,
    hoverlabel: { bgcolor: colors.ground, font: { color: colors.text } },
    // zoom and rotation stay while new samples come
    uirevision: "same",
  };
  switch (data.kind) {
    case "box": {
      const boxes = boxesOf(data);
      const traces = data.series.map((s, k) => {
        const b = boxes[k]!;
        const one = (v: number): number[] => (b.count > 0 ? [v] : []);
        return {
          type: "box",
          name: plain(s.label),
          x: one(k),
          q1: one(b.q1),
          median: one(b.median),
          q3: one(b.q3),
          lowerfence: one(b.whiskerLow),
          upperfence: one(b.whiskerHigh),
          mean: one(b.mean),
          // Plotly draws no box that has an empty list of them
          ...(b.outliers.length > 0 ? { y: [b.outliers], boxpoints: "outliers" } : {}),
          marker: { color: colors.series(s.color) },
        };
      });
      const ranks = {
        ...axis({ label: "", unit: "" }),
        showgrid: false,
        tickvals: data.series.map((_, k) => k),
        ticktext: data.series.map((s) => plain(s.label)),
        range: [-0.6, Math.max(data.series.length, 1) - 0.4],
      };
      return { traces, layout: { ...layout, xaxis: ranks, yaxis: axis(data.y) }, threeD: false };
    }
    case "histogram": {
      const { edges, counts } = histogramOf(data);
      const traces = data.series.map((s, k) => ({
        type: "bar",
        name: plain(s.label),
        x: counts[k]!.map((_, i) => (edges[i]! + edges[i + 1]!) / 2),
        width: counts[k]!.map((_, i) => edges[i + 1]! - edges[i]!),
        y: counts[k]!,
        opacity: data.series.length > 1 ? 0.6 : 1,
        marker: { color: colors.series(s.color) },
        hovertemplate: "%{x}: %{y}<extra></extra>",
      }));
      const y = { label: data.y.label || "count", unit: data.y.unit };
      return {
        traces,
        layout: { ...layout, barmode: "overlay", bargap: 0, xaxis: axis(data.x), yaxis: axis(y) },
        threeD: false,
      };
    }
    case "surface": {
      const cells = cellsOf(data);
      const scale = {
        colorscale: "Viridis",
        colorbar: { title: { text: plain(withUnit(data.z.label, data.z.unit)) }, len: 0.8 },
      };
      if (!webglWorks)
        return {
          traces: [{ type: "heatmap", x: cells.x, y: cells.y, z: cells.z, ...scale }],
          layout: { ...layout, xaxis: axis(data.x), yaxis: axis(data.y) },
          threeD: false,
        };
      const { x, y, z } = cornersOf(cells);
      const trace = { type: "surface", x, y, z, ...scale };
      const scene = {
        xaxis: axis(data.x),
        yaxis: axis(data.y),
        zaxis: axis(data.z),
        aspectmode: "cube",
        camera: { eye: { x: 1.6, y: 1.6, z: 1.1 } },
      };
      return {
        traces: [trace],
        layout: { ...layout, margin: { l: 0, r: 0, t: colors === kPrintColors ? 40 : 0, b: 0 }, scene },
        threeD: true,
      };
    }
    case "map":
    case "curve": {
      const path = data.kind === "map";
      const traces = data.series.flatMap((s) => {
        const line = {
          type: "scatter",
          mode: "lines",
          name: plain(s.label),
          x: s.x,
          y: s.y,
          line: { color: colors.series(s.color), dash: path || s.dashed ? "dash" : "solid", width: 1.6 },
        };
        const [first, last] = [s.x.findIndex(isNumber), s.x.length - 1 - [...s.x].reverse().findIndex(isNumber)];
        if (!path || first < 0) return [line];
        const ends = {
          type: "scatter",
          mode: "markers",
          x: [s.x[first], s.x[last]],
          y: [s.y[first], s.y[last]],
          marker: { color: colors.series(s.color), size: 10, symbol: ["circle-open", "square"] },
          hoverinfo: "skip",
        };
        return [line, ends];
      });
      const y = path ? { ...axis(data.y), scaleanchor: "x" } : axis(data.y);
      return { traces, layout: { ...layout, xaxis: axis(data.x), yaxis: y, hovermode: "closest" }, threeD: false };
    }
  }
}

const isNumber = (value: Sample): boolean => value !== null && Number.isFinite(value);
