// A row of the scene tree: what it shows, its clicks, and dragging it.
import { useLayoutEffect, useRef } from "preact/hooks";
import type { JSX } from "preact";
import type { TreeElement } from "../core/protocol";
import { kSignalType, type Studio } from "../core/studio";
import { rename } from "./commands";
import { Icon } from "./icons";
import { openMenu } from "./menu";
import { labelOf, type Row } from "./model";
import { dropOps, dropTarget, dropZone, refuseDrop, type DropZone } from "./rules";
import type { TreeModel } from "./tree_model";
import { signalLabel, TreeState } from "./tree_state";

export const kRowHeight = 24;
const kElementType = "application/x-cogrsim-elements";

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

function dragStart(event: DragEvent, model: TreeModel, row: Row): void {
  const { state, services } = model.studio;
  const { elements } = state.tree.peek();
  const selection = state.selection.peek();
  const data = event.dataTransfer!;
  const byOwner = services.get(TreeState).signals.peek();
  const own = row.signal ? [row.signal] : (byOwner.get(elements[row.id]?.path || "-") ?? []);
  if (own.length > 0) data.setData(kSignalType, own[0]!.name);
  if (row.signal) {
    data.setData("text/plain", row.signal.name);
    data.effectAllowed = "copy";
    return;
  }
  model.dragged = selection.includes(row.id) ? selection : [row.id];
  data.setData(kElementType, JSON.stringify(model.dragged));
  data.setData("text/plain", elements[row.id]?.path || labelOf(elements[row.id]!));
  data.effectAllowed = "copyMove";
}

function dropPosition(event: DragEvent, model: TreeModel, row: Row) {
  const { state, services } = model.studio;
  const { elements } = state.tree.peek();
  const schema = services.get(TreeState).schema.peek();
  const may = state.mayEdit.peek() && event.dataTransfer!.types.includes(kElementType);
  if (!schema || row.signal || !may) return null;
  const bounds = (event.currentTarget as HTMLElement).getBoundingClientRect();
  const into = { parent: row.id, before: null };
  const holds = refuseDrop(schema, elements, model.dragged, into) === "";
  const zone: DropZone = row.id === 0 ? "into" : dropZone((event.clientY - bounds.top) / bounds.height, holds);
  const target = dropTarget(elements, row.id, zone);
  if (!target || refuseDrop(schema, elements, model.dragged, target) !== "") return null;
  return { zone, target };
}

export function TreeRow(props: {
  id: string;
  model: TreeModel;
  row: Row;
  index: number;
  elements: readonly TreeElement[];
  element: TreeElement;
  active: boolean;
  selected: boolean;
  hovered: boolean;
}): JSX.Element {
  const { model, row, index, elements, element, active, selected, hovered } = props;
  const { studio } = model;
  const { state } = studio;
  const shared = studio.services.get(TreeState);
  const renaming = shared.renaming.value;
  const drop = model.drop.value;
  const classes = ["cg-tree-row"];
  if (selected) classes.push("is-selected");
  if (active) classes.push("is-active");
  if (hovered) classes.push("is-hovered");
  if (row.found) classes.push("is-found");
  if (drop?.id === row.id && !row.signal) classes.push(`is-drop-${drop.zone}`);
  const label = row.signal ? signalLabel(row.signal) : labelOf(element);
  const signals = row.signal || element.path === "" ? undefined : shared.signals.value.get(element.path);
  return (
    <div
      id={props.id}
      class={classes.join(" ")}
      role="treeitem"
      aria-level={row.depth + 1}
      aria-posinset={row.position}
      aria-setsize={row.siblings}
      aria-selected={selected}
      aria-expanded={row.expanded === null ? undefined : row.expanded}
      aria-label={row.signal ? `${label} signal` : `${label} ${element.tag}`.trim()}
      data-element={row.signal ? undefined : row.id}
      data-path={row.signal ? row.signal.name : element.path}
      style={{ top: `${index * kRowHeight}px`, paddingLeft: `${4 + row.depth * 14}px` }}
      title={row.signal ? row.signal.name : element.path || element.tag}
      draggable={renaming !== row.id || row.signal !== null}
      onClick={(event) => {
        // The field for the name keeps the focus.
        if (!(event.target as HTMLElement).closest("input")) model.select(index, event);
      }}
      onDblClick={(event) => {
        if (!(event.target as HTMLElement).closest("input, button")) model.activate(row);
      }}
      onContextMenu={(event) => {
        event.preventDefault();
        if (!row.signal && !selected) model.select(index);
        openMenu(studio, row, event.clientX, event.clientY);
      }}
      onPointerEnter={() => (state.hovered.value = row.id > 0 ? (state.bodiesOf(row.id)[0] ?? -1) : -1)}
      onDragStart={(event) => dragStart(event, model, row)}
      onDragEnd={() => (model.drop.value = null)}
      onDragOver={(event) => {
        const found = dropPosition(event, model, row);
        if (found) {
          event.preventDefault();
          event.dataTransfer!.dropEffect = "move";
        }
        if (drop?.id !== (found ? row.id : undefined) || drop?.zone !== found?.zone) {
          model.drop.value = found ? { id: row.id, zone: found.zone } : null;
        }
      }}
      onDrop={(event) => {
        const found = dropPosition(event, model, row);
        model.drop.value = null;
        if (!found) return;
        event.preventDefault();
        const ops = dropOps(elements, model.dragged, found.target);
        const what =
          model.dragged.length === 1 ? labelOf(elements[model.dragged[0]!]!) : `${model.dragged.length} elements`;
        if (ops.length > 0) void studio.edit(`move ${what}`, ops).then((made) => made?.length && studio.select(made));
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
}
