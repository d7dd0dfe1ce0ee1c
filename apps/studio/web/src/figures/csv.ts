// A figure's numbers as a table (RFC 4180): names with units in the first line, a point as decimal mark.
import { boxesOf, cellsOf, histogramOf, type FigureData } from "./figure";
import type { Sample } from "./statistics";
import { withUnit } from "./ticks";

const cell = (text: string): string => (/[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
/** Text that a table program would take for a formula is kept text. */
const heading = (text: string): string => cell(/^[=+@\t-]/.test(text) ? `'${text}` : text);
const number = (value: Sample | undefined): string =>
  typeof value === "number" && Number.isFinite(value) ? String(value) : "";

function table(columns: { name: string; values: readonly (Sample | string | undefined)[] }[]): string {
  const rows = columns.reduce((most, c) => Math.max(most, c.values.length), 0);
  const lines = [columns.map((c) => heading(c.name)).join(",")];
  for (let i = 0; i < rows; ++i)
    lines.push(
      columns
        .map((c) => {
          const value = c.values[i];
          return typeof value === "string" ? heading(value) : number(value);
        })
        .join(","),
    );
  return `${lines.join("\r\n")}\r\n`;
}

/** Thinned curves have two columns, the lowest and the highest of each interval. Empty: no value. */
export function toCsv(data: FigureData): string {
  switch (data.kind) {
    case "curve":
    case "map":
      return curves(data);
    case "box":
      return boxes(data);
    case "histogram": {
      const { edges, counts } = histogramOf(data);
      return table([
        { name: withUnit(`${data.x.label} from`, data.x.unit), values: edges.slice(0, -1) },
        { name: withUnit(`${data.x.label} to`, data.x.unit), values: edges.slice(1) },
        ...data.series.map((s, k) => ({ name: `count of ${s.label}`, values: counts[k]! })),
      ]);
    }
    case "surface": {
      const cells = cellsOf(data);
      return table([
        { name: withUnit(data.x.label, data.x.unit), values: cells.y.flatMap(() => cells.x) },
        { name: withUnit(data.y.label, data.y.unit), values: cells.y.flatMap((y) => cells.x.map(() => y)) },
        { name: withUnit(data.z.label, data.z.unit), values: cells.z.flat() },
        { name: "samples", values: cells.counts.flat() },
      ]);
    }
  }
}

function curves(data: FigureData): string {
  const first = data.series[0];
  const oneX = data.series.every((s) => s.x === first?.x);
  const xName = withUnit(data.x.label, data.x.unit);
  const columns: { name: string; values: readonly Sample[] }[] = [];
  if (oneX && first) columns.push({ name: xName, values: first.x });
  for (const s of data.series) {
    if (!oneX) columns.push({ name: withUnit(`${s.label}: ${data.x.label}`, data.x.unit), values: s.x });
    if (s.high) {
      columns.push({ name: withUnit(`${s.label} lowest`, s.unit), values: s.y });
      columns.push({ name: withUnit(`${s.label} highest`, s.unit), values: s.high });
    } else {
      columns.push({ name: withUnit(s.label, s.unit), values: s.y });
    }
  }
  return table(columns);
}

/** The numbers of the boxes, then a blank line, then the samples they are made of. */
function boxes(data: FigureData): string {
  const all = boxesOf(data);
  const numbers = table([
    { name: "series", values: data.series.map((s) => s.label) },
    { name: "unit", values: data.series.map((s) => s.unit) },
    ...(["count", "omitted", "whiskerLow", "q1", "median", "q3", "whiskerHigh", "mean"] as const).map((key) => ({
      name: key.replace(/[A-Z]/, (letter) => ` ${letter.toLowerCase()}`),
      values: all.map((b) => b[key]),
    })),
  ]);
  return `${numbers}\r\n${table(data.series.map((s) => ({ name: withUnit(s.label, s.unit), values: s.y })))}`;
}
