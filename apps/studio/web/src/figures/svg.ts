// A figure as SVG for print: black on white, text as text, nothing but shapes and characters.
import { boxesOf, cellsOf, histogramOf, type Axis, type FigureData, type FigureSeries } from "./figure";
import { rangeOf, type Sample } from "./statistics";
import { drawableRange, logTicks, shortNumber, tickLabels, ticks, withUnit } from "./ticks";

const kFont = 13;
/** Width of a text in the figure's font, about: 0.55 of its height per letter is on the wide side for Helvetica. */
const textWidth = (text: string): number => text.length * kFont * 0.55;
const escapeXml = (text: string): string =>
  text
    // control characters are no XML at all
    .replace(/[^\t\n\r -\uffff]/g, "")
    .replaceAll("&", "&amp;")
    .replaceAll("<", "&lt;")
    .replaceAll(">", "&gt;")
    .replaceAll('"', "&quot;");
/** Two decimals of a pixel are enough and keep files small. */
const px = (value: number): string => String(Math.round(value * 100) / 100);

interface Area {
  left: number;
  top: number;
  width: number;
  height: number;
}

/** From values to pixels along one side of the area. */
class Scale {
  readonly low: number;
  readonly high: number;
  constructor(
    values: Iterable<Sample | undefined>,
    private readonly from: number,
    private readonly to: number,
    readonly log = false,
    pad = 0.04,
  ) {
    const [low, high] = rangeOf(log ? aboveZero(values) : values);
    if (log) [this.low, this.high] = Number.isFinite(low) ? [low / 1.3, high * 1.3] : [0.1, 1];
    else [this.low, this.high] = drawableRange(low, high, pad);
  }
  at(value: number): number {
    const part = this.log
      ? Math.log(value / this.low) / Math.log(this.high / this.low)
      : (value - this.low) / (this.high - this.low);
    return this.from + part * (this.to - this.from);
  }
  drawable(value: Sample | undefined): value is number {
    return typeof value === "number" && Number.isFinite(value) && (!this.log || value > 0);
  }
  marks(gap: number): number[] {
    const count = Math.max(2, Math.floor(Math.abs(this.to - this.from) / gap));
    return this.log ? logTicks(this.low, this.high, count) : ticks(this.low, this.high, count);
  }
}
function* aboveZero(values: Iterable<Sample | undefined>): Iterable<Sample | undefined> {
  for (const v of values) if (typeof v === "number" && v > 0) yield v;
}
function* allOf(series: readonly FigureSeries[], keys: ("x" | "y" | "high")[]): Iterable<Sample | undefined> {
  for (const s of series) for (const key of keys) yield* s[key] ?? [];
}

/** `width` and `height` in pixels of 1/96 inch. */
export function toSvg(data: FigureData, width = 800, height = 500): string {
  const out: string[] = [];
  const legend = legendRows(data, width - 40);
  const two = data.y2 !== undefined && data.series.some((s) => s.axis === 1);
  const area: Area = { left: 78, top: data.title ? 44 : 20, width: 0, height: 0 };
  area.width = width - area.left - (two || data.kind === "surface" ? 92 : 26);
  area.height = height - area.top - 58 - legend.length * 20;
  const bottom = area.top + area.height;

  out.push(
    `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}" ` +
      `font-family="Helvetica, Arial, sans-serif" font-size="${kFont}" fill="#000">`,
    `<title>${escapeXml(data.title)}</title>`,
    `<rect width="${width}" height="${height}" fill="#fff"/>`,
    `<clipPath id="area"><rect x="${px(area.left)}" y="${px(area.top)}" width="${px(area.width)}" ` +
      `height="${px(area.height)}"/></clipPath>`,
  );
  if (data.title) out.push(text(width / 2, 24, data.title, 'text-anchor="middle" font-size="16" font-weight="bold"'));

  const right = area.left + area.width;
  if (data.kind === "surface") {
    drawSurface(out, data, area);
  } else if (data.kind === "box") {
    const boxes = boxesOf(data);
    const y = new Scale(
      boxes.flatMap((b) => [b.whiskerLow, b.whiskerHigh, ...b.outliers]),
      bottom,
      area.top,
    );
    drawSide(out, y, data.y, area, "left");
    const slot = area.width / Math.max(boxes.length, 1);
    const half = Math.min(slot * 0.3, 45);
    boxes.forEach((b, k) => {
      const middle = area.left + (k + 0.5) * slot;
      const s = data.series[k]!;
      out.push(text(middle, bottom + 20, s.label, 'text-anchor="middle"'));
      if (b.count === 0) return;
      const line = (x1: number, v1: number, x2: number, v2: number, w = 1.2): void =>
        void out.push(
          `<line x1="${px(x1)}" y1="${px(y.at(v1))}" x2="${px(x2)}" y2="${px(y.at(v2))}" stroke="#000" stroke-width="${w}"/>`,
        );
      line(middle, b.whiskerLow, middle, b.q1);
      line(middle, b.q3, middle, b.whiskerHigh);
      line(middle - half / 2, b.whiskerLow, middle + half / 2, b.whiskerLow);
      line(middle - half / 2, b.whiskerHigh, middle + half / 2, b.whiskerHigh);
      out.push(
        `<rect x="${px(middle - half)}" y="${px(y.at(b.q3))}" width="${px(2 * half)}" ` +
          `height="${px(y.at(b.q1) - y.at(b.q3))}" fill="${s.color}" fill-opacity="0.35" stroke="#000" stroke-width="1.2"/>`,
      );
      line(middle - half, b.median, middle + half, b.median, 2.4);
      for (const v of b.outliers)
        out.push(`<circle cx="${px(middle)}" cy="${px(y.at(v))}" r="2.5" fill="none" stroke="${s.color}"/>`);
    });
  } else if (data.kind === "histogram") {
    const { edges, counts } = histogramOf(data);
    const x = new Scale(edges, area.left, right, false, 0.02);
    const y = new Scale([0, 1.04 * (rangeOf(counts.flat())[1] || 1)], bottom, area.top, false, 0);
    drawBottom(out, x, data.x, area);
    drawSide(out, y, { label: data.y.label || "count", unit: data.y.unit }, area, "left");
    counts.forEach((list, k) => {
      const s = data.series[k]!;
      list.forEach((count, i) => {
        if (count === 0) return;
        const [x1, x2] = [x.at(edges[i]!), x.at(edges[i + 1]!)];
        out.push(
          `<rect x="${px(x1)}" y="${px(y.at(count))}" width="${px(x2 - x1)}" height="${px(bottom - y.at(count))}" ` +
            `fill="${s.color}" fill-opacity="0.5" stroke="${s.color}" stroke-width="0.7"/>`,
        );
      });
    });
  } else {
    const leftSeries = data.series.filter((s) => s.axis === 0 || !two);
    const levels = data.levels?.map((l) => l.value) ?? [];
    const padX = data.kind === "map" ? 0.04 : 0;
    let x = new Scale(allOf(data.series, ["x"]), area.left, right, data.x.log, padX);
    let left = new Scale([...allOf(leftSeries, ["y", "high"]), ...levels], bottom, area.top, data.y.log);
    if (data.kind === "map") [x, left] = equalScales(x, left, area);
    const rightScale = two
      ? new Scale(
          allOf(
            data.series.filter((s) => s.axis === 1),
            ["y", "high"],
          ),
          bottom,
          area.top,
          data.y2?.log,
        )
      : left;
    drawBottom(out, x, data.x, area);
    drawSide(out, left, data.y, area, "left");
    if (two) drawSide(out, rightScale, data.y2!, area, "right");
    for (const level of data.levels ?? []) {
      if (!left.drawable(level.value)) continue;
      const at = px(left.at(level.value));
      out.push(
        `<line x1="${px(area.left)}" y1="${at}" x2="${px(right)}" y2="${at}" stroke="#b00020" stroke-dasharray="2 3"/>`,
        text(right - 4, left.at(level.value) - 4, level.label, 'text-anchor="end" fill="#b00020"'),
      );
    }
    out.push('<g clip-path="url(#area)" fill="none" stroke-width="1.6" stroke-linejoin="round">');
    for (const s of data.series) drawCurve(out, s, x, s.axis === 1 ? rightScale : left, data.kind === "map");
    out.push("</g>");
  }
  if (data.kind !== "surface")
    out.push(
      `<rect x="${px(area.left)}" y="${px(area.top)}" width="${px(area.width)}" height="${px(area.height)}" ` +
        `fill="none" stroke="#000"/>`,
    );
  if (data.series.length === 0 || data.series.every((s) => s.x.length + s.y.length === 0))
    out.push(
      text(area.left + area.width / 2, area.top + area.height / 2, "no data", 'text-anchor="middle" fill="#555"'),
    );
  legend.forEach((row, r) => {
    const at = height - (legend.length - r) * 20 + 6;
    for (const { series, x } of row) {
      out.push(
        `<line x1="${px(x)}" y1="${px(at - 4)}" x2="${px(x + 24)}" y2="${px(at - 4)}" stroke="${series.color}" ` +
          `stroke-width="2.4"${series.dashed ? ' stroke-dasharray="6 4"' : ""}/>`,
        text(x + 30, at, legendText(data, series)),
      );
    }
  });
  out.push("</svg>");
  return out.join("\n");
}

function text(x: number, y: number, content: string, attributes = ""): string {
  return `<text x="${px(x)}" y="${px(y)}"${attributes ? ` ${attributes}` : ""}>${escapeXml(content)}</text>`;
}

function legendText(data: FigureData, s: FigureSeries): string {
  if (data.kind === "box" || data.kind === "histogram") return s.label;
  const ownAxis = s.axis === 1 && data.y2 ? data.y2 : data.y;
  return ownAxis.unit === s.unit ? s.label : withUnit(s.label, s.unit);
}

/** Entries side by side in as many rows as they need. A box plot names its boxes below them, one curve is named by its axis. */
function legendRows(data: FigureData, width: number): { series: FigureSeries; x: number }[][] {
  if (data.kind === "box" || data.kind === "surface" || data.series.length < 2) return [];
  const rows: { series: FigureSeries; x: number }[][] = [[]];
  let x = 30;
  for (const series of data.series) {
    const wide = 30 + textWidth(legendText(data, series)) + 18;
    if (x + wide > width && rows[rows.length - 1]!.length > 0) {
      rows.push([]);
      x = 30;
    }
    rows[rows.length - 1]!.push({ series, x });
    x += wide;
  }
  return rows;
}

function drawBottom(out: string[], scale: Scale, axis: Axis, area: Area): void {
  const bottom = area.top + area.height;
  const marks = scale.marks(90);
  const labels = scale.log ? marks.map((m) => shortNumber(m)) : tickLabels(marks);
  marks.forEach((mark, i) => {
    const at = px(scale.at(mark));
    out.push(
      `<line x1="${at}" y1="${px(area.top)}" x2="${at}" y2="${px(bottom)}" stroke="#ddd"/>`,
      `<line x1="${at}" y1="${px(bottom)}" x2="${at}" y2="${px(bottom + 5)}" stroke="#000"/>`,
      text(scale.at(mark), bottom + 20, labels[i]!, 'text-anchor="middle"'),
    );
  });
  out.push(text(area.left + area.width / 2, bottom + 42, withUnit(axis.label, axis.unit), 'text-anchor="middle"'));
}

function drawSide(out: string[], scale: Scale, axis: Axis, area: Area, side: "left" | "right"): void {
  const edge = side === "left" ? area.left : area.left + area.width;
  const away = side === "left" ? -1 : 1;
  const marks = scale.marks(50);
  const labels = scale.log ? marks.map((m) => shortNumber(m)) : tickLabels(marks);
  marks.forEach((mark, i) => {
    const at = px(scale.at(mark));
    if (side === "left")
      out.push(`<line x1="${px(area.left)}" y1="${at}" x2="${px(area.left + area.width)}" y2="${at}" stroke="#ddd"/>`);
    out.push(
      `<line x1="${px(edge)}" y1="${at}" x2="${px(edge + 5 * away)}" y2="${at}" stroke="#000"/>`,
      text(edge + 9 * away, scale.at(mark) + 4.5, labels[i]!, `text-anchor="${side === "left" ? "end" : "start"}"`),
    );
  });
  const x = edge + (side === "left" ? -60 : 72);
  const y = area.top + area.height / 2;
  const turn = `text-anchor="middle" transform="rotate(-90 ${px(x)} ${px(y)})"`;
  out.push(text(x, y, withUnit(axis.label, axis.unit), turn));
}

/** A line with gaps where there are no values, single points as dots; a band between lowest and highest. */
function drawCurve(out: string[], s: FigureSeries, x: Scale, y: Scale, path: boolean): void {
  const dash = s.dashed || path ? ' stroke-dasharray="6 4"' : "";
  const runs: number[][] = [];
  let run: number[] = [];
  for (let i = 0; i < s.x.length; ++i) {
    if (x.drawable(s.x[i]) && y.drawable(s.y[i]) && (!s.high || y.drawable(s.high[i]))) {
      run.push(i);
    } else if (run.length > 0) {
      runs.push(run);
      run = [];
    }
  }
  if (run.length > 0) runs.push(run);
  const points = (list: number[], values: readonly Sample[]): string =>
    list.map((i) => `${px(x.at(s.x[i]!))},${px(y.at(values[i]!))}`).join(" ");
  for (const list of runs) {
    if (s.high) {
      const there = points(list, s.y);
      const back = points(list.slice().reverse(), s.high);
      out.push(
        `<polygon points="${there} ${back}" fill="${s.color}" fill-opacity="0.25" stroke="${s.color}" ` +
          `stroke-width="1"${dash}/>`,
      );
    } else if (list.length === 1) {
      const [i] = list as [number];
      out.push(`<circle cx="${px(x.at(s.x[i]!))}" cy="${px(y.at(s.y[i]!))}" r="2" fill="${s.color}"/>`);
    } else {
      out.push(`<polyline points="${points(list, s.y)}" stroke="${s.color}"${dash}/>`);
    }
  }
  if (path && runs.length > 0) {
    const first = runs[0]![0]!;
    const lastRun = runs[runs.length - 1]!;
    const last = lastRun[lastRun.length - 1]!;
    const at = (i: number): [number, number] => [x.at(s.x[i]!), y.at(s.y[i]!)];
    const [[x1, y1], [x2, y2]] = [at(first), at(last)];
    out.push(
      `<circle cx="${px(x1)}" cy="${px(y1)}" r="5" stroke="${s.color}"/>`,
      `<rect x="${px(x2 - 4.5)}" y="${px(y2 - 4.5)}" width="9" height="9" fill="${s.color}"/>`,
    );
  }
}

/** Widens the scale that has more pixels per unit, so that a metre is as long along both axes. */
function equalScales(x: Scale, y: Scale, area: Area): [Scale, Scale] {
  const perPixel = Math.max((x.high - x.low) / area.width, (y.high - y.low) / area.height);
  const widened = (s: Scale, from: number, to: number): Scale => {
    const middle = (s.low + s.high) / 2;
    const half = (perPixel * Math.abs(to - from)) / 2;
    return new Scale([middle - half, middle + half], from, to, false, 0);
  };
  return [widened(x, area.left, area.left + area.width), widened(y, area.top + area.height, area.top)];
}

/** Dark blue over green to yellow, as light rises with the value: readable in grey, too. */
function shade(part: number): string {
  const stops: [number, number, number][] = [
    [59, 15, 112],
    [50, 80, 140],
    [30, 140, 135],
    [100, 195, 95],
    [250, 230, 50],
  ];
  const at = Math.min(Math.max(part, 0), 1) * (stops.length - 1);
  const k = Math.min(Math.floor(at), stops.length - 2);
  const mixed = stops[k]!.map((a, c) => Math.round(a + (at - k) * (stops[k + 1]![c]! - a)));
  return `rgb(${mixed.join(",")})`;
}

/** On paper a surface is a map of its cells with a bar of colours. */
function drawSurface(out: string[], data: FigureData, area: Area): void {
  const cells = cellsOf(data);
  const [bottom, right] = [area.top + area.height, area.left + area.width];
  const half = (list: number[]): number => (list.length > 1 ? (list[1]! - list[0]!) / 2 : 0.5);
  const ends = (list: number[]): number[] =>
    list.length > 0 ? [list[0]! - half(list), list[list.length - 1]! + half(list)] : [];
  const x = new Scale(ends(cells.x), area.left, right, false, 0);
  const y = new Scale(ends(cells.y), bottom, area.top, false, 0);
  drawBottom(out, x, data.x, area);
  drawSide(out, y, data.y, area, "left");
  const [low, high] = drawableRange(...rangeOf(cells.z.flat()));
  const [hx, hy] = [half(cells.x), half(cells.y)];
  cells.z.forEach((row, r) =>
    row.forEach((value, c) => {
      if (value === null) return;
      const [x1, x2] = [x.at(cells.x[c]! - hx), x.at(cells.x[c]! + hx)];
      const [y1, y2] = [y.at(cells.y[r]! + hy), y.at(cells.y[r]! - hy)];
      const color = shade((value - low) / (high - low));
      out.push(
        `<rect x="${px(x1)}" y="${px(y1)}" width="${px(x2 - x1)}" height="${px(y2 - y1)}" fill="${color}" ` +
          `stroke="${color}" stroke-width="0.4"/>`,
      );
    }),
  );
  const bar = right + 14;
  for (let k = 0; k < 50; ++k) {
    const top = bottom - ((k + 1) / 50) * area.height;
    out.push(
      `<rect x="${px(bar)}" y="${px(top)}" width="14" height="${px(area.height / 50 + 0.5)}" fill="${shade((k + 0.5) / 50)}"/>`,
    );
  }
  const z = new Scale([low, high], bottom, area.top, false, 0);
  const marks = z.marks(60);
  tickLabels(marks).forEach((label, i) => out.push(text(bar + 18, z.at(marks[i]!) + 4.5, label)));
  out.push(text(bar + 26, area.top - 8, withUnit(data.z.label, data.z.unit), 'text-anchor="end"'));
}
