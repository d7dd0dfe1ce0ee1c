// The data of a figure, for the page, an SVG or PNG file, and a table.
import type { Sample } from "./statistics";
import { binCounts, binEdges, boxNumbers, cellMeans, type BoxNumbers, type Cells } from "./statistics";

export type FigureKind = "curve" | "map" | "box" | "histogram" | "surface";
export const kKindNames: Record<FigureKind, string> = {
  curve: "Curves",
  map: "Path",
  box: "Box plot",
  histogram: "Histogram",
  surface: "Surface",
};

export const kindOf = (name: string): FigureKind => (name in kKindNames ? (name as FigureKind) : "curve");

/** What a figure shows. */
export interface FigureSpec {
  id: number;
  kind: FigureKind;
  title: string;
  /** what is drawn; of surfaces and paths x, y and z, "" where none is chosen yet */
  signals: string[];
  /** name of the scene's own plot; "": signals are drawn */
  plot: string;
}

export interface Axis {
  label: string;
  unit: string;
  log?: boolean;
}

/** One curve, path, box, … Lists that a kind does not use are empty. */
export interface FigureSeries {
  label: string;
  unit: string;
  color: string;
  dashed: boolean;
  /** 0: the axis on the left, 1: on the right */
  axis: 0 | 1;
  x: Sample[];
  /** values; of a thinned curve the lowest of each interval */
  y: Sample[];
  /** of a thinned curve the highest of each interval; else absent */
  high?: Sample[];
  z: Sample[];
}

export interface FigureData {
  kind: FigureKind;
  title: string;
  x: Axis;
  y: Axis;
  /** on the right, where units differ */
  y2?: Axis;
  z: Axis;
  series: FigureSeries[];
  /** [s] of the samples, where they have times */
  times?: readonly number[];
  /** horizontal lines, against the axis on the left */
  levels?: { value: number; label: string }[];
}

/** The theme's colours of series on white, which are those on paper, too. */
const kColors = ["#0b5cad", "#b3541e", "#1b7a3d", "#8a2fa8", "#a3241c", "#00707a", "#6d6100", "#4a5568"];
export const colorOf = (index: number): string => kColors[index % kColors.length]!;
/** The same colour in the present theme, as CSS. */
export const themeColor = (color: string): string => `var(--cg-series-${Math.max(kColors.indexOf(color), 0) + 1})`;

/** Counts and edges, in bins that all series share. */
export function histogramOf(data: FigureData): { edges: number[]; counts: number[][] } {
  const edges = binEdges(data.series.flatMap((s) => s.x));
  return { edges, counts: data.series.map((s) => binCounts(s.x, edges)) };
}
export function boxesOf(data: FigureData): BoxNumbers[] {
  return data.series.map((s) => boxNumbers(s.y));
}
export function cellsOf(data: FigureData): Cells {
  const s = data.series[0];
  return s ? cellMeans(s.x, s.y, s.z) : { x: [], y: [], z: [], counts: [] };
}

/** The corners of cells, each as high as the cells around it are on average: a surface that is as wide as its cells, down to a
 *  single one. null: no cell there has samples. */
export function cornersOf(cells: Cells): Cells {
  const edges = (centres: number[]): number[] => {
    if (centres.length === 0) return [];
    const pitch = centres.length > 1 ? centres[1]! - centres[0]! : 1;
    return [...centres.map((c) => c - pitch / 2), centres[centres.length - 1]! + pitch / 2];
  };
  const [x, y] = [edges(cells.x), edges(cells.y)];
  const counts = y.map(() => x.map(() => 0));
  const z = y.map((_, r) =>
    x.map((_, c) => {
      let sum = 0;
      for (const row of [r - 1, r])
        for (const column of [c - 1, c]) {
          const value = cells.z[row]?.[column];
          if (typeof value !== "number") continue;
          sum += value;
          counts[r]![c]! += 1;
        }
      return counts[r]![c]! > 0 ? sum / counts[r]![c]! : null;
    }),
  );
  return { x, y, z, counts };
}

/** Puts series on the two axes: the first unit is on the left, the second on the right; further ones join the right and say
 *  their unit in the legend. */
export function shareAxes(units: readonly string[]): { axes: (0 | 1)[]; left: string; right: string | null } {
  const kinds = [...new Set(units)];
  return {
    axes: units.map((u) => (u === kinds[0] ? 0 : 1)),
    left: kinds[0] ?? "",
    right: kinds.length > 1 ? (kinds.length === 2 ? kinds[1]! : "") : null,
  };
}

/** The label of an axis: the one name, or the names' common part behind their last dot, or "value". */
export function axisLabel(names: readonly string[]): string {
  const all = [...new Set(names)];
  if (all.length === 1) return all[0]!;
  const tails = [...new Set(all.map((n) => n.slice(n.lastIndexOf(".") + 1)))];
  return tails.length === 1 && all.length > 0 ? tails[0]! : "value";
}

/** A name that any file system takes: "two wheels", "speed of a/b" give "two-wheels-speed-of-a-b". */
export function fileName(scene: string, figure: string, ending: string): string {
  const clean = (text: string): string =>
    text
      .replace(/[^\p{L}\p{N}._-]+/gu, "-")
      .replace(/^[-.]+|[-.]+$/g, "")
      .slice(0, 60);
  const name = [clean(scene), clean(figure)].filter((part) => part !== "").join("-");
  return `${name === "" ? "figure" : name}.${ending}`;
}
