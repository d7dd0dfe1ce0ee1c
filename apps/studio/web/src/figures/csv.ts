// A figure's numbers as a table (RFC 4180): names with units in the first line, a point as decimal mark.
import { boxes_of, cells_of, histogram_of, type FigureData } from "./figure";
import type { Sample } from "./statistics";
import { with_unit } from "./ticks";

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
  return lines.join("\r\n") + "\r\n";
}

/** Thinned curves have two columns, the lowest and the highest of each interval. Empty: no value. */
export function to_csv(data: FigureData): string {
  switch (data.kind) {
    case "curve":
    case "map":
      return curves(data);
    case "box":
      return boxes(data);
    case "histogram": {
      const { edges, counts } = histogram_of(data);
      return table([
        { name: with_unit(`${data.x.label} from`, data.x.unit), values: edges.slice(0, -1) },
        { name: with_unit(`${data.x.label} to`, data.x.unit), values: edges.slice(1) },
        ...data.series.map((s, k) => ({ name: `count of ${s.label}`, values: counts[k]! })),
      ]);
    }
    case "surface": {
      const cells = cells_of(data);
      return table([
        { name: with_unit(data.x.label, data.x.unit), values: cells.y.flatMap(() => cells.x) },
        { name: with_unit(data.y.label, data.y.unit), values: cells.y.flatMap((y) => cells.x.map(() => y)) },
        { name: with_unit(data.z.label, data.z.unit), values: cells.z.flat() },
        { name: "samples", values: cells.counts.flat() },
      ]);
    }
  }
}

function curves(data: FigureData): string {
  const first = data.series[0];
  const one_x = data.series.every((s) => s.x === first?.x);
  const x_name = with_unit(data.x.label, data.x.unit);
  const columns: { name: string; values: readonly Sample[] }[] = [];
  if (one_x && first) columns.push({ name: x_name, values: first.x });
  for (const s of data.series) {
    if (!one_x) columns.push({ name: with_unit(`${s.label}: ${data.x.label}`, data.x.unit), values: s.x });
    if (s.high) {
      columns.push({ name: with_unit(`${s.label} lowest`, s.unit), values: s.y });
      columns.push({ name: with_unit(`${s.label} highest`, s.unit), values: s.high });
    } else {
      columns.push({ name: with_unit(s.label, s.unit), values: s.y });
    }
  }
  return table(columns);
}

/** The numbers of the boxes, then a blank line, then the samples they are made of. */
function boxes(data: FigureData): string {
  const all = boxes_of(data);
  const numbers = table([
    { name: "series", values: data.series.map((s) => s.label) },
    { name: "unit", values: data.series.map((s) => s.unit) },
    ...(["count", "omitted", "whisker_low", "q1", "median", "q3", "whisker_high", "mean"] as const).map((key) => ({
      name: key.replace("_", " "),
      values: all.map((b) => b[key]),
    })),
  ]);
  return numbers + "\r\n" + table(data.series.map((s) => ({ name: with_unit(s.label, s.unit), values: s.y })));
}
