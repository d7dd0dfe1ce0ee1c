// The scene tree: a virtualised ARIA tree.
import { computed, effect, signal } from "@preact/signals";
import { useEffect, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";
import type { JSX } from "preact";
import type { SignalInfo } from "../core/protocol";
import { kSignalType, type Studio } from "../core/studio";
import { rename } from "./commands";
import { Icon } from "./icons";
import { openMenu } from "./menu";
import { elementKeys, labelOf, treeRows, typeAhead, visibleRows, type Row } from "./model";
import { dropOps, dropTarget, dropZone, refuseDrop, type DropZone } from "./rules";
import { signalLabel, TreeState } from "./tree_state";

const kRowHeight = 24;
const kTypeAheadRest = 800;
const kElementType = "application/x-cogrsim-elements";

/** Same element or same signal of it. */
const rowKey = (row: Row): string => (row.signal ? `${row.id}~${row.signal.name}` : String(row.id));

/** What is open and searched; outlives the panel. */
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
}

function changed(set: ReadonlySet<string>, key: string, member?: boolean): ReadonlySet<string> {
  const next = new Set(set);
  if (member ?? !next.has(key)) next.add(key);
  else next.delete(key);
  return next;
}

function NameField({ studio, id, name }: { studio: Studio; id: number; name: string }): JSX.Element {
  const field = useRef<HTMLInputElement>(null);
  const state = studio.services.get(TreeState);
  useLayoutEffect(() => {
    field.current?.focus();
    field.current?.select();
  }, []);
  const done = (accept: boolean) => {
    if (state.renaming.peek() !== id) return;
    state.renaming.value = -1;
    if (accept) void rename(studio, id, field.current!.value.trim());
  };
  return (
    <input
      ref={field}
      class="cg-tree-name-field"
      aria-label="New name"
      data-testid="rename-field"
      defaultValue={name}
      spellcheck={false}
      onBlur={() => done(true)}
      onKeyDown={(event) => {
        event.stopPropagation();
        const tree = (event.target as HTMLElement).closest<HTMLElement>('[role="tree"]');
        if (event.key === "Enter") done(true);
        else if (event.key === "Escape") done(false);
        else return;
        tree?.focus();
      }}
    />
  );
}

export function TreeView({ model }: { model: TreeModel }): JSX.Element {
  const { studio } = model;
  const { state } = studio;
  const shared = studio.services.get(TreeState);
  const box = useRef<HTMLDivElement>(null);
  const [scrolled, setScrolled] = useState(0);
  const [height, setHeight] = useState(400);
  const [drop, setDrop] = useState<{ id: number; zone: DropZone } | null>(null);
  const typed = useMemo(() => ({ text: "", time: 0 }), []);
  const prefix = useMemo(() => `cg-tree-${Math.random().toString(36).slice(2, 8)}`, []);

  const rows = model.rows.value;
  const { elements } = state.tree.value;
  const selection = state.selection.value;
  const selected = useMemo(() => new Set(selection), [selection]);
  const hoveredBody = state.hovered.value;
  const hovered = hoveredBody < 0 ? -1 : (state.scene.value?.bodies[hoveredBody]?.element ?? -1);
  const active = Math.max(
    0,
    rows.findIndex((row) => rowKey(row) === model.active.value),
  );
  const renaming = shared.renaming.value;
  const byOwner = shared.signals.value;
  const mayEdit = state.mayEdit.value;

  useEffect(() => {
    const observer = new ResizeObserver(() => setHeight(box.current?.clientHeight ?? 400));
    observer.observe(box.current!);
    return () => observer.disconnect();
  }, []);

  const scrollTo = (index: number) => {
    const view = box.current;
    if (!view || index < 0) return;
    const top = index * kRowHeight;
    if (top < view.scrollTop) view.scrollTop = top;
    else if (top + kRowHeight > view.scrollTop + view.clientHeight)
      view.scrollTop = top + kRowHeight - view.clientHeight;
  };

  // What is selected elsewhere comes into sight.
  useEffect(
    () =>
      effect(() => {
        const main = state.selection.value[state.selection.value.length - 1];
        const renamed = shared.renaming.value;
        const shown = renamed >= 0 ? renamed : main;
        if (shown === undefined) return;
        model.reveal(shown);
        model.active.value = String(shown);
        const index = model.rows.peek().findIndex((row) => row.id === shown && !row.signal);
        requestAnimationFrame(() => scrollTo(index));
      }),
    [],
  );

  const selectRow = (index: number, event: { ctrlKey: boolean; metaKey: boolean; shiftKey: boolean }) => {
    const row = rows[index];
    if (!row) return;
    model.active.value = rowKey(row);
    if (row.signal) return;
    if (event.shiftKey && model.anchor.peek() >= 0) {
      const from = rows.findIndex((r) => r.id === model.anchor.peek() && !r.signal);
      if (from >= 0) {
        const [low, high] = from < index ? [from, index] : [index, from];
        const range = rows.slice(low, high + 1).flatMap((r) => (r.signal ? [] : [r.id]));
        studio.select(from < index ? range : range.reverse());
        return;
      }
    }
    model.anchor.value = row.id;
    if (event.ctrlKey || event.metaKey) {
      studio.select(selected.has(row.id) ? selection.filter((id) => id !== row.id) : [...selection, row.id]);
    } else {
      studio.select([row.id]);
    }
  };

  const activate = (row: Row) => {
    if (row.signal) studio.drawSignal(row.signal.name);
    else if (studio.commands.hasCommand("view:focus")) void studio.commands.execute("view:focus");
  };

  const onKey = (event: KeyboardEvent) => {
    const row = rows[active];
    if (!row) return;
    const go = (index: number) => {
      const to = Math.min(rows.length - 1, Math.max(0, index));
      // With Ctrl only the keyboard goes there, to add it with Ctrl+Space.
      if (event.ctrlKey) model.active.value = rowKey(rows[to]!);
      else selectRow(to, { ctrlKey: false, metaKey: false, shiftKey: event.shiftKey });
      scrollTo(to);
    };
    const page = Math.max(1, Math.floor(height / kRowHeight) - 1);
    switch (event.key) {
      case "ArrowDown":
        go(active + 1);
        break;
      case "ArrowUp":
        go(active - 1);
        break;
      case "Home":
        go(0);
        break;
      case "End":
        go(rows.length - 1);
        break;
      case "PageDown":
        go(active + page);
        break;
      case "PageUp":
        go(active - page);
        break;
      case "ArrowRight":
        if (row.expanded === false) model.toggle(row.id, true);
        else if (row.expanded) go(active + 1);
        break;
      case "ArrowLeft": {
        if (row.expanded && model.search.value === "") {
          model.toggle(row.id, false);
          break;
        }
        const around = row.signal ? row.id : (elements[row.id]?.parent ?? -1);
        const index = rows.findIndex((r) => r.id === around && !r.signal);
        if (index >= 0) go(index);
        break;
      }
      case "Enter":
        activate(row);
        break;
      case "F2":
        if (mayEdit) void studio.commands.execute("edit:rename");
        break;
      case " ":
        if (!event.ctrlKey) return;
        selectRow(active, { ctrlKey: true, metaKey: false, shiftKey: false });
        break;
      case "ContextMenu":
      case "F10": {
        if (event.key === "F10" && !event.shiftKey) return;
        const rect = box.current!.getBoundingClientRect();
        openMenu(studio, row, rect.left + 40, rect.top + (active + 1) * kRowHeight - box.current!.scrollTop);
        break;
      }
      default: {
        if (event.ctrlKey || event.metaKey || event.altKey || !/^[\p{L}_]$/u.test(event.key)) return;
        if (event.timeStamp - typed.time > kTypeAheadRest) typed.text = "";
        typed.time = event.timeStamp;
        typed.text += event.key;
        const labels = rows.map((r) =>
          r.signal ? signalLabel(r.signal) : labelOf(elements[r.id]!) || elements[r.id]!.tag,
        );
        const to = typeAhead(labels, typed.text.length > 1 ? active : active + 1, typed.text);
        if (to >= 0) go(to);
      }
    }
    event.preventDefault();
    event.stopPropagation();
  };

  const dragStart = (event: DragEvent, row: Row) => {
    const data = event.dataTransfer!;
    const own = row.signal ? [row.signal] : (byOwner.get(elements[row.id]?.path || "-") ?? []);
    if (own.length > 0) data.setData(kSignalType, own[0]!.name);
    if (row.signal) {
      data.setData("text/plain", row.signal.name);
      data.effectAllowed = "copy";
      return;
    }
    const dragged = selected.has(row.id) ? selection : [row.id];
    data.setData(kElementType, JSON.stringify(dragged));
    data.setData("text/plain", elements[row.id]?.path || labelOf(elements[row.id]!));
    data.effectAllowed = "copyMove";
    modelDrag = dragged;
  };

  const dropPosition = (event: DragEvent, row: Row) => {
    const schema = shared.schema.value;
    if (!schema || row.signal || !mayEdit || !event.dataTransfer!.types.includes(kElementType)) return null;
    const bounds = (event.currentTarget as HTMLElement).getBoundingClientRect();
    const into = { parent: row.id, before: null };
    const holds = refuseDrop(schema, elements, modelDrag, into) === "";
    const zone = row.id === 0 ? "into" : dropZone((event.clientY - bounds.top) / bounds.height, holds);
    const target = dropTarget(elements, row.id, zone);
    if (!target || refuseDrop(schema, elements, modelDrag, target) !== "") return null;
    return { zone, target };
  };

  const { first, last } = visibleRows(
    rows.length,
    kRowHeight,
    // A search makes the list shorter before the browser says that it has scrolled.
    Math.max(0, Math.min(scrolled, rows.length * kRowHeight - height)),
    height,
  );
  const drawn = rows.slice(first, last).map((row, i) => ({ row, index: first + i }));
  const keyboardRow = rows[active];
  if (keyboardRow && (active < first || active >= last)) drawn.push({ row: keyboardRow, index: active });

  return (
    <div
      ref={box}
      class="cg-tree"
      role="tree"
      tabIndex={0}
      aria-label="Scene tree"
      aria-multiselectable="true"
      aria-activedescendant={keyboardRow ? `${prefix}-${rowKey(keyboardRow)}` : undefined}
      data-cg-keys="own"
      onScroll={(event) => setScrolled((event.currentTarget as HTMLElement).scrollTop)}
      onKeyDown={onKey}
      onPointerLeave={() => (state.hovered.value = -1)}
    >
      <div class="cg-tree-space" role="presentation" style={{ height: `${rows.length * kRowHeight}px` }}>
        {drawn.map(({ row, index }) => {
          const element = elements[row.id];
          if (!element) return null;
          const isSelected = !row.signal && selected.has(row.id);
          const classes = ["cg-tree-row"];
          if (isSelected) classes.push("is-selected");
          if (index === active) classes.push("is-active");
          if (!row.signal && row.id === hovered) classes.push("is-hovered");
          if (row.found) classes.push("is-found");
          if (drop && drop.id === row.id && !row.signal) classes.push(`is-drop-${drop.zone}`);
          const label = row.signal ? signalLabel(row.signal) : labelOf(element);
          const signals = row.signal || element.path === "" ? undefined : byOwner.get(element.path);
          return (
            <div
              key={rowKey(row)}
              id={`${prefix}-${rowKey(row)}`}
              class={classes.join(" ")}
              role="treeitem"
              aria-level={row.depth + 1}
              aria-posinset={row.position}
              aria-setsize={row.siblings}
              aria-selected={isSelected}
              aria-expanded={row.expanded === null ? undefined : row.expanded}
              aria-label={row.signal ? `${label} signal` : `${label} ${element.tag}`.trim()}
              data-element={row.signal ? undefined : row.id}
              data-path={row.signal ? row.signal.name : element.path}
              style={{ top: `${index * kRowHeight}px`, paddingLeft: `${4 + row.depth * 14}px` }}
              title={row.signal ? row.signal.name : element.path || element.tag}
              draggable={renaming !== row.id || row.signal !== null}
              onClick={(event) => {
                // The field for the name keeps the focus.
                if (!(event.target as HTMLElement).closest("input")) selectRow(index, event);
              }}
              onDblClick={(event) => {
                if (!(event.target as HTMLElement).closest("input, button")) activate(row);
              }}
              onContextMenu={(event) => {
                event.preventDefault();
                if (!row.signal && !selected.has(row.id))
                  selectRow(index, { ctrlKey: false, metaKey: false, shiftKey: false });
                openMenu(studio, row, event.clientX, event.clientY);
              }}
              onPointerEnter={() => (state.hovered.value = row.id > 0 ? (state.bodiesOf(row.id)[0] ?? -1) : -1)}
              onDragStart={(event) => dragStart(event, row)}
              onDragEnd={() => setDrop(null)}
              onDragOver={(event) => {
                const found = dropPosition(event, row);
                if (found) {
                  event.preventDefault();
                  event.dataTransfer!.dropEffect = "move";
                }
                if (drop?.id !== (found ? row.id : undefined) || drop?.zone !== found?.zone) {
                  setDrop(found ? { id: row.id, zone: found.zone } : null);
                }
              }}
              onDrop={(event) => {
                const found = dropPosition(event, row);
                setDrop(null);
                if (!found) return;
                event.preventDefault();
                const ops = dropOps(elements, modelDrag, found.target);
                const what =
                  modelDrag.length === 1 ? labelOf(elements[modelDrag[0]!]!) : `${modelDrag.length} elements`;
                if (ops.length > 0)
                  void studio.edit(`move ${what}`, ops).then((made) => made?.length && studio.select(made));
              }}
            >
              {row.expanded === null ? (
                <span class="cg-tree-twist" />
              ) : (
                <span
                  class={`cg-tree-twist${row.expanded ? " is-open" : ""}`}
                  aria-hidden="true"
                  onClick={(event) => {
                    event.stopPropagation();
                    model.toggle(row.id);
                  }}
                />
              )}
              <Icon tag={row.signal ? "signal" : element.tag} />
              {renaming === row.id && !row.signal ? (
                <NameField studio={studio} id={row.id} name={element.name} />
              ) : (
                <span class="cg-tree-label">
                  {label !== "" && <span class="cg-tree-name">{label}</span>}{" "}
                  {!row.signal && <span class="cg-tree-tag">{element.tag}</span>}
                </span>
              )}
              {signals && (
                <span
                  class="cg-tree-signals"
                  title="Show what can be drawn"
                  aria-hidden="true"
                  onClick={(event) => {
                    event.stopPropagation();
                    model.toggleSignals(row.id);
                  }}
                >
                  <Icon tag="signal" />
                </span>
              )}
            </div>
          );
        })}
      </div>
    </div>
  );
}

// What is dragged, for dragover: the data itself can be read on drop only.
let modelDrag: readonly number[] = [];
