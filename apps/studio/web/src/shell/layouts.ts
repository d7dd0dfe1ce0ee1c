// The arrangement of panels: as plain data, the presets, and reading stored ones.

/** A tab area, or areas side by side. Sizes are shares. */
export type Area =
  | { type: "tabs"; panels: string[]; current: number }
  | { type: "split"; orientation: "horizontal" | "vertical"; children: Area[]; sizes: number[] };

const tabs = (...panels: string[]): Area => ({ type: "tabs", panels, current: 0 });
const split = (orientation: "horizontal" | "vertical", sizes: number[], children: Area[]): Area => ({
  type: "split",
  orientation,
  children,
  sizes,
});
const row = (sizes: number[], ...children: Area[]): Area => split("horizontal", sizes, children);
const column = (sizes: number[], ...children: Area[]): Area => split("vertical", sizes, children);

/** The picture has at least half of a window of 1440 x 900 in Run and Edit. */
const workbench = (...below: Area[]): Area =>
  row([1, 4.9], column([3, 2.6], tabs("tree"), tabs("properties")), column([2.85, 1], tabs("view3d"), ...below));

export const presets: Record<string, Area> = {
  Run: workbench(row([1.15, 1, 1.05], tabs("cameras", "joints"), tabs("map"), tabs("console", "tests", "figures"))),
  Edit: workbench(tabs("code", "console", "map", "joints")),
  Code: row(
    [1, 2.4, 1.6],
    column([3, 2.6], tabs("tree"), tabs("properties")),
    column([3, 1], tabs("view3d", "map"), tabs("console")),
    tabs("code"),
  ),
  Debug: row([1.1, 1.5, 1], column([3, 1], tabs("view3d", "map"), tabs("console")), tabs("code"), tabs("debug")),
  Analyse: row([1, 1.1], column([1.3, 1], tabs("view3d", "map", "cameras"), tabs("tree", "console")), tabs("figures")),
  Compare: row([1.2, 1], tabs("view3d", "map"), column([2, 1], tabs("compare"), tabs("console", "tree"))),
};

/** On a phone: the picture, and below it what else there is. */
export const phone: Area = column(
  [3, 1],
  tabs("view3d", "map", "cameras"),
  tabs("figures", "tree", "properties", "code", "console"),
);

/** Reads an arrangement from text that may have been written by an older page, or by another program: null when it is none. Panels that
 *  are not known, or that come twice, are left out, and so are areas without any. */
export function readArea(text: string | null, known: (panel: string) => boolean): Area | null {
  if (text === null) return null;
  try {
    return check(JSON.parse(text), known, new Set(), 0);
  } catch {
    return null;
  }
}

function check(what: unknown, known: (panel: string) => boolean, seen: Set<string>, depth: number): Area | null {
  if (typeof what !== "object" || what === null || depth > 12) return null;
  const area = what as Record<string, unknown>;
  if (area.type === "tabs" && Array.isArray(area.panels)) {
    const wanted = area.panels[Number(area.current)] as unknown;
    const panels = area.panels.filter((p): p is string => {
      if (typeof p !== "string" || !known(p) || seen.has(p)) return false;
      seen.add(p);
      return true;
    });
    if (panels.length === 0) return null;
    return { type: "tabs", panels, current: Math.max(panels.indexOf(wanted as string), 0) };
  }
  if (area.type === "split" && Array.isArray(area.children)) {
    const orientation = area.orientation === "vertical" ? "vertical" : "horizontal";
    const given = Array.isArray(area.sizes) ? (area.sizes as unknown[]) : [];
    const children: Area[] = [];
    const sizes: number[] = [];
    area.children.forEach((child, i) => {
      const good = check(child, known, seen, depth + 1);
      if (!good) return;
      const size = given[i];
      children.push(good);
      sizes.push(typeof size === "number" && Number.isFinite(size) && size > 0 ? size : 1);
    });
    const only = children[0];
    if (!only) return null;
    return children.length === 1 ? only : { type: "split", orientation, children, sizes };
  }
  return null;
}

/** Names of the panels in it, in order. */
export function panelsIn(area: Area | null): string[] {
  if (!area) return [];
  return area.type === "tabs" ? area.panels : area.children.flatMap(panelsIn);
}

/** The arrangement that is left when a panel is closed. */
export function without(area: Area | null, panel: string): Area | null {
  return area && check(area, (p) => p !== panel, new Set(), 0);
}

/** Whether the same panels lie side by side in the same order, whatever their sizes and whichever is in front. */
export function sameOrder(a: Area | null, b: Area | null): boolean {
  if (!a || !b) return a === b;
  if (a.type === "tabs") return b.type === "tabs" && a.panels.join() === b.panels.join();
  if (b.type === "tabs" || a.orientation !== b.orientation || a.children.length !== b.children.length) return false;
  return a.children.every((child, i) => sameOrder(child, b.children[i]!));
}
