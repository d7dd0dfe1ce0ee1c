// The rows of the scene tree: which elements are shown, in which order, how deep.
import type { SignalInfo, TreeElement } from "../core/protocol";

export { elementKeys } from "../core/follow";

export interface Row {
  /** of the element, or of the one whose signal it is */
  id: number;
  signal: SignalInfo | null;
  /** from 0: the scene */
  depth: number;
  /** null: nothing inside */
  expanded: boolean | null;
  /** number among its siblings that are shown, from 1 */
  position: number;
  siblings: number;
  /** the search found it itself, not only something inside */
  found: boolean;
}

/** Ids of what stands inside each element, in order. */
export function childrenLists(elements: readonly TreeElement[]): number[][] {
  const out: number[][] = elements.map(() => []);
  for (const element of elements) if (element.parent >= 0) out[element.parent]?.push(element.id);
  return out;
}

export function labelOf(element: TreeElement): string {
  if (element.name !== "") return element.name;
  const attributes = element.attributes;
  if (element.tag === "set") return Object.keys(attributes).join(", ");
  return attributes.plugin ?? attributes.of ?? attributes.joint ?? attributes.between ?? attributes.href ?? "";
}

/** Whether every word of the search is in the tag, the name, the dotted name or an attribute's value. */
function matches(element: TreeElement, words: readonly string[]): boolean {
  const text = `${element.tag} ${element.name} ${element.path} ${Object.values(element.attributes).join(" ")}`;
  const low = text.toLowerCase();
  return words.every((word) => low.includes(word));
}

export interface RowOptions {
  /** keys of elements that are closed */
  closed: ReadonlySet<string>;
  keys: readonly string[];
  search: string;
  /** signals to be shown below their owner, by element id */
  signals: ReadonlyMap<number, readonly SignalInfo[]>;
}

/** Rows from top to bottom. A search keeps what is found, what is around it and nothing else, and opens everything. */
export function treeRows(elements: readonly TreeElement[], options: RowOptions): Row[] {
  const words = options.search
    .toLowerCase()
    .split(/\s+/)
    .filter((w) => w !== "");
  const searching = words.length > 0;
  const children = childrenLists(elements);
  const found = elements.map((e) => searching && matches(e, words));
  const shown = found.slice();
  // Parents come before what is inside them, so going backwards every element is done before its parent.
  for (let i = elements.length - 1; i > 0; --i) {
    const parent = elements[i]!.parent;
    if (shown[i] && parent >= 0) shown[parent] = true;
  }
  const rows: Row[] = [];
  const show = (id: number, depth: number, position: number, siblings: number): void => {
    const inside = searching ? children[id]!.filter((c) => shown[c]) : children[id]!;
    const signals = options.signals.get(id) ?? [];
    const any = inside.length + signals.length > 0;
    const open = any && (searching || !options.closed.has(options.keys[id]!));
    rows.push({ id, signal: null, depth, expanded: any ? open : null, position, siblings, found: found[id]! });
    if (!open) return;
    const count = signals.length + inside.length;
    signals.forEach((signal, i) =>
      rows.push({ id, signal, depth: depth + 1, expanded: null, position: i + 1, siblings: count, found: false }),
    );
    inside.forEach((c, i) => show(c, depth + 1, signals.length + i + 1, count));
  };
  const roots = elements.filter((e) => e.parent < 0 && (!searching || shown[e.id]));
  roots.forEach((root, i) => show(root.id, 0, i + 1, roots.length));
  return rows;
}

/** The rows to draw: those in sight and some around. */
export function visibleRows(
  count: number,
  rowHeight: number,
  scrolled: number,
  height: number,
  spare = 8,
): { first: number; last: number } {
  const first = Math.max(0, Math.floor(scrolled / rowHeight) - spare);
  const last = Math.min(count, Math.ceil((scrolled + height) / rowHeight) + spare);
  return { first: Math.min(first, last), last };
}

/** The next row from `from` on (going round) whose label begins with what was typed; -1: none. */
export function typeAhead(labels: readonly string[], from: number, typed: string): number {
  const start = typed.toLowerCase();
  for (let i = 0; i < labels.length; ++i) {
    const at = (from + i) % labels.length;
    if (labels[at]!.toLowerCase().startsWith(start)) return at;
  }
  return -1;
}

/** Whether `id` is `around` or stands in it. */
export function isInside(elements: readonly TreeElement[], id: number, around: number): boolean {
  for (let at = id; at >= 0; at = elements[at]?.parent ?? -1) if (at === around) return true;
  return false;
}

/** Without what stands inside others of them, without the root, in document order. */
export function topMost(elements: readonly TreeElement[], ids: readonly number[]): number[] {
  const chosen = new Set(ids);
  return [...chosen]
    .filter((id) => {
      const element = elements[id];
      if (!element || element.parent < 0) return false;
      for (let at = element.parent; at >= 0; at = elements[at]?.parent ?? -1) if (chosen.has(at)) return false;
      return true;
    })
    .sort((a, b) => a - b);
}
