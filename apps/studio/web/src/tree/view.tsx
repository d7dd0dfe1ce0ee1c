// The scene tree: a virtualised ARIA tree.
import { effect } from "@preact/signals";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { JSX } from "preact";
import { openMenu } from "./menu";
import { labelOf, typeAhead, visibleRows } from "./model";
import { kRowHeight, TreeRow } from "./row";
import { rowKey, type TreeModel } from "./tree_model";
import { signalLabel, TreeState } from "./tree_state";

const kTypeAheadRest = 800;

export function TreeView({ model }: { model: TreeModel }): JSX.Element {
  const { studio } = model;
  const { state } = studio;
  const shared = studio.services.get(TreeState);
  const box = useRef<HTMLDivElement>(null);
  const [scrolled, setScrolled] = useState(0);
  const [height, setHeight] = useState(400);
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

  const onKey = (event: KeyboardEvent) => {
    const row = rows[active];
    if (!row) return;
    const go = (index: number) => {
      const to = Math.min(rows.length - 1, Math.max(0, index));
      // With Ctrl only the keyboard goes there, to add it with Ctrl+Space.
      if (event.ctrlKey) model.active.value = rowKey(rows[to]!);
      else model.select(to, { ctrlKey: false, metaKey: false, shiftKey: event.shiftKey });
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
        model.activate(row);
        break;
      case "F2":
        if (state.mayEdit.peek()) void studio.commands.execute("edit:rename");
        break;
      case " ":
        if (!event.ctrlKey) return;
        model.select(active, { ctrlKey: true, metaKey: false, shiftKey: false });
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
          return (
            element && (
              <TreeRow
                key={rowKey(row)}
                id={`${prefix}-${rowKey(row)}`}
                model={model}
                row={row}
                index={index}
                elements={elements}
                element={element}
                active={index === active}
                selected={!row.signal && selected.has(row.id)}
                hovered={!row.signal && row.id === hovered}
              />
            )
          );
        })}
      </div>
    </div>
  );
}
