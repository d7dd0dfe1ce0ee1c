// The editor of the scene's text.
import {
  autocompletion,
  completionKeymap,
  insertCompletionText,
  pickedCompletion,
  type Completion,
  type CompletionContext,
  type CompletionResult,
} from "@codemirror/autocomplete";
import { xml } from "@codemirror/lang-xml";
import { Annotation, Compartment, EditorState, StateEffect, StateField, type Transaction } from "@codemirror/state";
import {
  Decoration,
  EditorView,
  hoverTooltip,
  keymap,
  type DecorationSet,
  type Tooltip,
  type ViewUpdate,
} from "@codemirror/view";
import { effect, signal } from "@preact/signals-core";
import { messageOf, RequestError } from "../core/link";
import type { Studio } from "../core/studio";
import { helpText } from "../forms/help";
import { TreeState } from "../tree/tree_state";
import { codePoints, utf16Offset } from "./columns";
import type { Change } from "./diff";
import { editorBasics, editorKeys, markProblems } from "./editor";
import { TypingGroups } from "./groups";
import { PendingTyping } from "./pending";
import { elementAt, tagAround, writtenSelection } from "./spans";
import { TextSync, type SyncAnswer, type SyncSetText } from "./sync";

const fromServer = Annotation.define<boolean>();
const markLines = StateEffect.define<{ from: number; to: number }[]>();
const markedLine = Decoration.line({ class: "cg-code-selected" });

/** Lines of the selection; they move with the text until the next tree has their positions. */
const marked = StateField.define<DecorationSet>({
  create: () => Decoration.none,
  update(lines, transaction) {
    lines = lines.map(transaction.changes);
    for (const change of transaction.effects) {
      if (change.is(markLines)) {
        lines = Decoration.set(
          change.value.flatMap(({ from, to }) => lineMarks(transaction.state, from, to)),
          true,
        );
      }
    }
    return lines;
  },
  provide: (field) => EditorView.decorations.from(field),
});

function lineMarks(state: EditorState, from: number, to: number) {
  const out = [];
  for (let n = Math.max(1, from); n <= Math.min(to, state.doc.lines); ++n)
    out.push(markedLine.range(state.doc.line(n).from));
  return out;
}

function paragraph(text: string, className = ""): HTMLElement {
  const node = document.createElement("p");
  node.textContent = text;
  if (className !== "") node.className = className;
  return node;
}

export class SceneEditor {
  readonly view: EditorView;
  private readonly sync: TextSync;
  private readonly groups: TypingGroups;
  private readonly editable = new Compartment();
  /** line end of the file; the editor itself knows "\n" only */
  private lineEnd = "\n";
  private readonly stops: (() => void)[] = [];
  /** goes up whenever the server has all typed text: earlier marks may be set */
  private readonly calm = signal(0);
  /** set while this editor selects the element at its cursor */
  private reporting = false;

  constructor(private readonly studio: Studio) {
    const client = studio.state.hello.peek()?.client ?? 0;
    this.groups = new TypingGroups(`typing ${client} ${Date.now().toString(36)} `);
    this.sync = new TextSync({
      send: (fields) => this.send(fields),
      text: () => this.fileText(this.view.state),
      change: (changes) => this.change(changes),
      later: (ms, what) => {
        const timer = setTimeout(what, ms);
        return () => clearTimeout(timer);
      },
      settled: () => (this.calm.value += 1),
      refused: (message) => studio.notify(`the text was not taken: ${message}`, "error"),
    });
    this.view = new EditorView({ state: this.firstState() });
    this.view.contentDOM.setAttribute("aria-label", "Text of the scene");
    this.follow();
    studio.services.get(PendingTyping).source = {
      flush: () => {
        this.groups.end();
        return this.sync.flush();
      },
      unsent: () => this.sync.unsent,
      text: () => this.fileText(this.view.state),
    };
  }

  dispose(): void {
    void this.sync.flush();
    this.studio.services.get(PendingTyping).source = null;
    for (const stop of this.stops) stop();
    this.view.destroy();
  }

  private fileText(state: EditorState): string {
    return state.doc.sliceString(0, state.doc.length, this.lineEnd);
  }

  private async send(fields: SyncSetText): Promise<SyncAnswer> {
    try {
      const answer = await this.studio.link.request("set-text", { ...fields });
      return { ok: true, version: answer.version };
    } catch (error) {
      const stale = error instanceof RequestError && error.failure.code === "stale";
      return { ok: false, stale, message: messageOf(error) };
    }
  }

  /** Positions of the file's text to the editor's, where a line end is one character. */
  private change(changes: Change[]): void {
    let taken = 0;
    let at = 0;
    const text = this.lineEnd === "\n" ? "" : this.fileText(this.view.state);
    const mapped = (position: number): number => {
      if (this.lineEnd === "\n") return position;
      for (let next = text.indexOf("\r\n", at); next >= 0 && next < position; next = text.indexOf("\r\n", at)) {
        ++taken;
        at = next + 2;
      }
      return position - taken;
    };
    const length = this.view.state.doc.length;
    this.view.dispatch({
      changes: changes.map((c) => {
        const from = mapped(c.from);
        return { from, to: Math.min(length, mapped(c.to)), insert: c.insert.replace(/\r\n?/g, "\n") };
      }),
      annotations: fromServer.of(true),
    });
  }

  private firstState(): EditorState {
    return EditorState.create({
      doc: "",
      extensions: [
        editorBasics,
        EditorState.allowMultipleSelections.of(true),
        xml(),
        EditorState.tabSize.of(2),
        marked,
        hoverTooltip((view, position) => this.hover(view, position)),
        autocompletion({ override: [(context) => this.complete(context)], activateOnTyping: true }),
        this.editable.of([]),
        keymap.of([
          { key: "Mod-z", run: () => this.run("edit:undo"), preventDefault: true },
          { key: "Mod-Shift-z", run: () => this.run("edit:redo"), preventDefault: true },
          { key: "Mod-y", run: () => this.run("edit:redo"), preventDefault: true },
          ...completionKeymap,
          ...editorKeys,
        ]),
        EditorView.updateListener.of((update) => this.updated(update)),
      ],
    });
  }

  private run(command: string): boolean {
    if (this.studio.commands.isEnabled(command)) void this.studio.commands.execute(command);
    return true;
  }

  private follow(): void {
    const { state } = this.studio;
    const on = (what: () => void) => this.stops.push(effect(what));
    on(() => {
      // Another server restarts the counts of versions and clients: what comes after a lost connection is the newest.
      if (!state.open.value) this.sync.reset();
    });
    on(() => {
      const documentState = state.document.value;
      if (!documentState) return;
      if (this.sync.version < 0) this.lineEnd = documentState.text.includes("\r\n") ? "\r\n" : "\n";
      // Mixed line ends become one kind here; the file keeps them until something is typed.
      this.sync.arrived(documentState.text.replace(/\r\n?|\n/g, this.lineEnd), documentState.version);
    });
    on(() => {
      const readonly = !state.mayEdit.value;
      this.view.dispatch({
        effects: this.editable.reconfigure([
          EditorState.readOnly.of(readonly),
          EditorView.contentAttributes.of({ "aria-readonly": String(readonly), tabindex: "0" }),
        ]),
      });
    });
    on(() => {
      void this.calm.value;
      const problems = state.problems.value;
      const documentState = state.document.value;
      // Text typed since will be compiled as well; until then marks move with the text.
      if (!documentState || !this.sync.settled) return;
      markProblems(this.view, problems, documentState.file);
    });
    on(() => {
      void this.calm.value;
      const tree = state.tree.value;
      const selection = state.selection.value;
      if (tree.version !== this.sync.version || !this.sync.settled) return;
      const lines = selection.flatMap((id) => {
        const element = id > 0 ? tree.elements[id] : undefined;
        return element ? [{ from: element.line, to: element.end_line }] : [];
      });
      const last = lines[lines.length - 1];
      const effects: StateEffect<unknown>[] = [markLines.of(lines)];
      // A selection made elsewhere is scrolled into view, unless the user types here.
      if (last && !this.reporting && !this.view.hasFocus && last.from <= this.view.state.doc.lines) {
        effects.push(
          EditorView.scrollIntoView(this.view.state.doc.line(last.from).from, { y: "nearest", yMargin: 40 }),
        );
      }
      this.view.dispatch({ effects });
    });
  }

  private updated(update: ViewUpdate): void {
    const own = update.transactions.filter((t) => t.docChanged && !t.annotation(fromServer));
    if (own.length > 0) this.typed(update, own);
    const moved = update.transactions.some((t) => t.selection && t.isUserEvent("select"));
    if (moved) this.reportCursor();
  }

  private typed(update: ViewUpdate, transactions: readonly Transaction[]): void {
    const edits: { time: number; from: number; to: number; insert: string }[] = [];
    for (const transaction of transactions) {
      transaction.changes.iterChanges((from, to, _a, _b, text) => {
        edits.push({ time: performance.now(), from, to, insert: text.toString() });
      });
    }
    this.sync.typed(() => this.fileText(update.startState), this.groups.next(edits));
  }

  private reportCursor(): void {
    const { state } = this.studio;
    const tree = state.tree.peek();
    if (!this.sync.settled || tree.version !== this.sync.version) return;
    const { doc, selection } = this.view.state;
    const line = doc.lineAt(selection.main.head);
    const column = codePoints(line.text, selection.main.head - line.from) + 1;
    const id = elementAt(tree.elements, line.number, column);
    const now = state.selection.peek();
    this.groups.end();
    if (id <= 0 || (now.length > 0 && now[now.length - 1] === id)) return;
    this.reporting = true;
    this.studio.select([id]);
    this.reporting = false;
  }

  private async complete(context: CompletionContext): Promise<CompletionResult | null> {
    if (context.state.readOnly) return null;
    const text = context.state.doc.toString();
    const before = text.slice(Math.max(0, context.pos - 1), context.pos);
    // After a blank outside of tags, and after the end of a tag, completions are not shown unasked.
    if (
      !context.explicit &&
      !/[\w<"'$.{-]/.test(before) &&
      !(/\s/.test(before) && tagAround(`${text.slice(0, context.pos)}>`, context.pos))
    )
      return null;
    try {
      const answer = await this.studio.link.request("complete", { text, offset: codePoints(text, context.pos) });
      if (context.aborted || answer.items.length === 0) return null;
      return {
        from: utf16Offset(text, answer.from),
        options: answer.items.map((item) => ({
          label: item.label,
          detail: item.detail ?? "",
          apply: (view: EditorView, completion: Completion, from: number, to: number) => {
            const insert = item.insert ?? item.label;
            view.dispatch({
              ...insertCompletionText(view.state, insert, from, to),
              // Several cursors stay where each has written.
              ...(view.state.selection.ranges.length === 1 && { selection: writtenSelection(insert, from) }),
              annotations: pickedCompletion.of(completion),
            });
          },
        })),
        validFor: /^[\w.-]*$/,
      };
    } catch {
      return null;
    }
  }

  private hover(view: EditorView, position: number): Tooltip | null {
    const schema = this.studio.services.get(TreeState).schema.peek();
    const text = view.state.doc.toString();
    const tag = tagAround(text, position);
    if (!schema || !tag) return null;
    const attributes = Object.fromEntries(tag.attributes.map((a) => [a.name, text.slice(a.valueFrom, a.valueTo)]));
    const element = schema.element(tag.tag, attributes);
    const span = tag.attributes.find((a) => position >= a.from && position <= a.to);
    const onTag = position <= tag.from + tag.tag.length + 1;
    const spec = span ? element?.attributes.find((a) => a.name === span.name) : undefined;
    if (!(onTag && element) && !spec) return null;
    return {
      pos: span ? span.from : tag.from,
      end: span ? span.to : tag.from + 1 + tag.tag.length,
      above: true,
      create: () => {
        const dom = document.createElement("div");
        dom.className = "cg-code-hover";
        if (spec) {
          const unit = spec.units.filter((u) => u !== "").join(spec.perEntry ? ", " : " or ");
          dom.append(
            paragraph(
              `${spec.name}: ${spec.kind}${unit === "" ? "" : ` [${unit}]`}${spec.required ? ", required" : ""}`,
              "cg-code-hover-title",
            ),
          );
          dom.append(paragraph(helpText(spec)));
          if (spec.choices.length > 0) dom.append(paragraph(`One of: ${spec.choices.join(", ")}.`));
        } else if (element) {
          dom.append(paragraph(`<${element.name}>`, "cg-code-hover-title"), paragraph(element.doc));
          if (element.example !== "") dom.append(paragraph(element.example, "cg-code-hover-example"));
        }
        return { dom };
      },
    };
  }
}
