// What of the tree is open, searched and dragged, and how it is selected; outlives the panel.
import { computed, signal } from "@preact/signals-core";
import type { SignalInfo } from "../core/protocol";
import type { Studio } from "../core/studio";
import { elementKeys, treeRows, type Row } from "./model";
import type { DropZone } from "./rules";
import { TreeState } from "./tree_state";

const kNoKeys = { ctrlKey: false, metaKey: false, shiftKey: false };

/** Same element or same signal of it. */
export const rowKey = (row: Row): string => (row.signal ? `${row.id}~${row.signal.name}` : String(row.id));

export class TreeModel {
  readonly search = signal("");
  readonly closed = signal<ReadonlySet<string>>(new Set());
  /** keys of elements whose signals are shown */
  readonly openSignals = signal<ReadonlySet<string>>(new Set());
  readonly keys = computed(() => elementKeys(this.studio.state.tree.value.elements));
  readonly rows = computed(() => {
    const { elements } = this.studio.state.tree.value;
    const byOwner = this.studio.services.get(TreeState).signals.value;
    const signals = new Map<number, readonly SignalInfo[]>();
    const open = this.openSignals.value;
    if (open.size > 0) {
      elements.forEach((e) => {
        const own = e.path === "" ? undefined : byOwner.get(e.path);
        if (own && open.has(this.keys.value[e.id]!)) signals.set(e.id, own);
      });
    }
    return treeRows(elements, { closed: this.closed.value, keys: this.keys.value, search: this.search.value, signals });
  });
  /** the row with the keyboard; in rows */
  readonly active = signal("0");
  readonly anchor = signal(-1);
  /** elements that are dragged: what a drop brings can be read on drop only */
  dragged: readonly number[] = [];
  /** where they would go */
  readonly drop = signal<{ id: number; zone: DropZone } | null>(null);

  constructor(readonly studio: Studio) {}

  toggle(id: number, open?: boolean): void {
    this.closed.value = changed(this.closed.value, this.keys.value[id]!, open === undefined ? undefined : !open);
  }
  toggleSignals(id: number): void {
    this.openSignals.value = changed(this.openSignals.value, this.keys.value[id]!);
    if (this.openSignals.value.has(this.keys.value[id]!)) this.toggle(id, true);
  }
  /** Opens what is around an element, so that it has a row. */
  reveal(id: number): void {
    const { elements } = this.studio.state.tree.peek();
    const closed = new Set(this.closed.peek());
    for (let at = elements[id]?.parent ?? -1; at >= 0; at = elements[at]?.parent ?? -1)
      closed.delete(this.keys.peek()[at]!);
    if (closed.size !== this.closed.peek().size) this.closed.value = closed;
  }

  /** As a click on a row, or its keys, select. */
  select(index: number, event: { ctrlKey: boolean; metaKey: boolean; shiftKey: boolean } = kNoKeys): void {
    const rows = this.rows.peek();
    const row = rows[index];
    if (!row) return;
    this.active.value = rowKey(row);
    if (row.signal) return;
    if (event.shiftKey && this.anchor.peek() >= 0) {
      const from = rows.findIndex((r) => r.id === this.anchor.peek() && !r.signal);
      if (from >= 0) {
        const [low, high] = from < index ? [from, index] : [index, from];
        const range = rows.slice(low, high + 1).flatMap((r) => (r.signal ? [] : [r.id]));
        this.studio.select(from < index ? range : range.reverse());
        return;
      }
    }
    this.anchor.value = row.id;
    const selection = event.ctrlKey || event.metaKey ? this.studio.state.selection.peek() : [];
    if (selection.includes(row.id)) this.studio.select(selection.filter((id) => id !== row.id));
    else this.studio.select([...selection, row.id]);
  }
  activate(row: Row): void {
    const { commands } = this.studio;
    if (row.signal) this.studio.drawSignal(row.signal.name);
    else if (commands.hasCommand("view:focus")) void commands.execute("view:focus");
  }
}

function changed(set: ReadonlySet<string>, key: string, member?: boolean): ReadonlySet<string> {
  const next = new Set(set);
  if (member ?? !next.has(key)) next.add(key);
  else next.delete(key);
  return next;
}
