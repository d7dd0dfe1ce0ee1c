// The editor of a controller's source: a file of its own with a history of its own.
import { closeBrackets, closeBracketsKeymap } from "@codemirror/autocomplete";
import { defaultKeymap, history, historyKeymap, indentWithTab } from "@codemirror/commands";
import { cpp } from "@codemirror/lang-cpp";
import { bracketMatching, foldGutter, foldKeymap, indentOnInput, indentUnit } from "@codemirror/language";
import { lintGutter, lintKeymap, setDiagnostics, type Diagnostic } from "@codemirror/lint";
import { highlightSelectionMatches, searchKeymap } from "@codemirror/search";
import { EditorState } from "@codemirror/state";
import { drawSelection, EditorView, highlightActiveLineGutter, keymap, lineNumbers } from "@codemirror/view";
import type { Problem, SourceFile } from "../core/protocol";
import { utf16Offset } from "./columns";
import { problemRange, sameFile } from "./spans";
import { editorLook } from "./theme";

export class SourceEditor {
  readonly view: EditorView;
  private saved: string;
  private readonly lineEnd: string;

  /** of the file as it was opened or saved last: changes of other programs are not overwritten */
  version: string | undefined;

  /** `changed`: called with whether the text differs from the saved one. */
  constructor(
    readonly file: SourceFile,
    opened: { text: string; version?: string },
    mayEdit: boolean,
    private readonly changed: (dirty: boolean) => void,
  ) {
    const { text } = opened;
    this.version = opened.version;
    this.lineEnd = text.includes("\r\n") ? "\r\n" : "\n";
    this.view = new EditorView({
      state: EditorState.create({
        doc: text,
        extensions: [
          lineNumbers(),
          highlightActiveLineGutter(),
          foldGutter(),
          drawSelection(),
          history(),
          indentOnInput(),
          indentUnit.of("  "),
          bracketMatching(),
          closeBrackets(),
          highlightSelectionMatches(),
          cpp(),
          lintGutter(),
          editorLook,
          EditorState.readOnly.of(!mayEdit || !file.writable),
          EditorView.contentAttributes.of({ "aria-label": file.name, tabindex: "0" }),
          keymap.of([
            ...closeBracketsKeymap,
            ...searchKeymap,
            ...historyKeymap,
            ...foldKeymap,
            ...lintKeymap,
            ...defaultKeymap,
            indentWithTab,
          ]),
          EditorView.updateListener.of((update) => {
            if (update.docChanged) this.changed(this.dirty);
          }),
        ],
      }),
    });
    this.saved = this.text();
  }

  text(): string {
    return this.view.state.doc.sliceString(0, this.view.state.doc.length, this.lineEnd);
  }
  get dirty(): boolean {
    return this.text() !== this.saved;
  }
  /** `text` is what the file holds now. */
  markSaved(text: string, version: string | undefined): void {
    this.version = version;
    this.saved = text;
    this.changed(this.dirty);
  }

  show(problems: readonly Problem[]): void {
    const text = this.view.state.doc.toString();
    const diagnostics = problems
      .filter((p) => sameFile(p.file, this.file.name))
      .map((p): Diagnostic => ({
        ...problemRange(text, p),
        severity: p.severity === "note" ? "info" : p.severity,
        message: p.help ? `${p.message}\n${p.help}` : p.message,
      }));
    this.view.dispatch(setDiagnostics(this.view.state, diagnostics));
  }

  goTo(line: number, column: number): void {
    const { doc } = this.view.state;
    const at = doc.line(Math.max(1, Math.min(line, doc.lines)));
    const anchor = at.from + utf16Offset(at.text, column - 1);
    this.view.dispatch({ selection: { anchor }, effects: EditorView.scrollIntoView(anchor, { y: "center" }) });
    this.view.focus();
  }
}
