// Breakpoints, the line where the controller stands, and values under the pointer, in an editor of a source.
import { StateEffect, StateField, type Extension } from "@codemirror/state";
import {
  Decoration,
  EditorView,
  gutter,
  GutterMarker,
  hoverTooltip,
  keymap,
  ViewPlugin,
  type DecorationSet,
} from "@codemirror/view";
import { effect } from "@preact/signals-core";
import { expressionAt } from "./breakpoints";
import type { DebugStore } from "./store";

interface Mark {
  placed: boolean;
  condition: string;
  note: string;
}
interface Marks {
  breakpoints: Map<number, Mark>;
  /** lines where the innermost frame and the chosen one are; 0: not in this file */
  stands: number;
  chosen: number;
}

const setMarks = StateEffect.define<Marks>();
const kNone: Marks = { breakpoints: new Map(), stands: 0, chosen: 0 };

const marksOf = StateField.define<Marks>({
  create: () => kNone,
  update(marks, transaction) {
    for (const one of transaction.effects) if (one.is(setMarks)) marks = one.value;
    return marks;
  },
  provide: (field) =>
    EditorView.decorations.compute([field, "doc"], (state): DecorationSet => {
      const { stands, chosen } = state.field(field);
      const lines = [...new Set([stands, chosen])].filter((n) => n > 0 && n <= state.doc.lines).sort((a, b) => a - b);
      return Decoration.set(
        lines.map((n) =>
          Decoration.line({ class: n === stands ? "cg-debug-stands" : "cg-debug-chosen" }).range(
            state.doc.line(n).from,
          ),
        ),
      );
    }),
});

class Sign extends GutterMarker {
  constructor(
    private readonly mark: Mark | null,
    private readonly stands: boolean,
  ) {
    super();
  }
  override eq(other: Sign): boolean {
    return this.stands === other.stands && JSON.stringify(this.mark) === JSON.stringify(other.mark);
  }
  override toDOM(): Node {
    const node = document.createElement("span");
    node.className = "cg-debug-sign";
    if (this.mark) {
      node.classList.add(this.mark.placed ? "is-placed" : "is-wanted");
      node.textContent = this.mark.condition ? "◆" : "●";
      node.title = [this.mark.condition && `if ${this.mark.condition}`, this.mark.note].filter(Boolean).join("; ");
    }
    if (this.stands) {
      const arrow = document.createElement("span");
      arrow.className = "cg-debug-arrow";
      arrow.textContent = "➤";
      node.append(arrow);
    }
    return node;
  }
}

/** For an editor of the source `file`. */
export function debugging(store: DebugStore, file: string): Extension {
  const toggle = (view: EditorView, position: number) => store.toggle(file, view.state.doc.lineAt(position).number);
  return [
    marksOf,
    gutter({
      class: "cg-debug-gutter",
      lineMarker(view, block) {
        const n = view.state.doc.lineAt(block.from).number;
        const { breakpoints, stands } = view.state.field(marksOf);
        const mark = breakpoints.get(n) ?? null;
        return mark || n === stands ? new Sign(mark, n === stands) : null;
      },
      lineMarkerChange: (update) => update.startState.field(marksOf) !== update.state.field(marksOf),
      initialSpacer: () => new Sign({ placed: true, condition: "", note: "" }, false),
      domEventHandlers: {
        mousedown(view, block) {
          toggle(view, block.from);
          return true;
        },
      },
    }),
    keymap.of([
      {
        key: "F9",
        run(view) {
          toggle(view, view.state.selection.main.head);
          return true;
        },
      },
    ]),
    EditorView.updateListener.of((update) => {
      if (!update.docChanged) return;
      const { startState, state, changes } = update;
      store.moved(file, (line) => {
        if (line > startState.doc.lines) return line;
        const old = startState.doc.line(line);
        return state.doc.lineAt(changes.mapPos(old.from + /^\s*/.exec(old.text)![0].length, 1)).number;
      });
    }),
    hoverTooltip(async (view, position) => {
      const line = view.state.doc.lineAt(position);
      const found = expressionAt(line.text, position - line.from);
      const value = found && (await store.value(found.text));
      if (!found || !value) return null;
      return {
        pos: line.from + found.from,
        end: line.from + found.to,
        create() {
          const dom = document.createElement("div");
          dom.className = "cg-debug-hover";
          dom.textContent = `${value.name} = ${value.value || "{…}"} (${value.type})`;
          return { dom };
        },
      };
    }),
    ViewPlugin.define((view) => {
      const stop = effect(() => {
        const now = store.now.value;
        const stopped = now?.state === "stopped" ? now.frames : [];
        const breakpoints = new Map<number, Mark>();
        for (const { line, condition, file: its } of store.breakpoints()) {
          if (its !== file) continue;
          const placed = now?.breakpoints.find(
            (one) => one.file === file && one.line === line && one.condition === condition,
          );
          breakpoints.set(line, {
            placed: placed !== undefined && placed.placed !== null,
            condition: condition ?? "",
            note: placed?.note ?? "",
          });
        }
        const first = stopped[0];
        const chosen = stopped[store.frame.value];
        const marks: Marks = {
          breakpoints,
          stands: first?.file === file ? first.line : 0,
          chosen: chosen?.file === file ? chosen.line : 0,
        };
        // An editor cannot be changed while it is being made or updated.
        queueMicrotask(() => view.dispatch({ effects: setMarks.of(marks) }));
      });
      return { destroy: stop };
    }),
  ];
}
