// What the editors of the scene and of sources share.
import { closeBrackets, closeBracketsKeymap } from "@codemirror/autocomplete";
import { defaultKeymap, indentWithTab } from "@codemirror/commands";
import { bracketMatching, foldGutter, foldKeymap, indentOnInput } from "@codemirror/language";
import { lintGutter, lintKeymap, setDiagnostics, type Diagnostic } from "@codemirror/lint";
import { highlightSelectionMatches, searchKeymap } from "@codemirror/search";
import type { Extension } from "@codemirror/state";
import { drawSelection, EditorView, highlightActiveLineGutter, lineNumbers, type KeyBinding } from "@codemirror/view";
import type { Problem } from "../core/protocol";
import { utf16Offset } from "./columns";
import { problemRange, sameFile } from "./spans";
import { editorLook } from "./theme";

export const editorBasics: Extension = [
  lineNumbers(),
  highlightActiveLineGutter(),
  foldGutter(),
  lintGutter(),
  drawSelection(),
  indentOnInput(),
  bracketMatching(),
  closeBrackets(),
  highlightSelectionMatches(),
  editorLook,
];

export const editorKeys: readonly KeyBinding[] = [
  ...closeBracketsKeymap,
  ...searchKeymap,
  ...foldKeymap,
  ...lintKeymap,
  ...defaultKeymap,
  indentWithTab,
];

/** Marks those of `problems` that are in `file`. */
export function markProblems(view: EditorView, problems: readonly Problem[], file: string): void {
  const text = view.state.doc.toString();
  const diagnostics = problems
    .filter((p) => sameFile(p.file, file))
    .map((p): Diagnostic => ({
      ...problemRange(text, p),
      severity: p.severity === "note" ? "info" : p.severity,
      message: p.help ? `${p.message}\n${p.help}` : p.message,
      source: p.code,
    }));
  view.dispatch(setDiagnostics(view.state, diagnostics));
}

/** Puts the cursor there, and the focus unless `quiet`; line and column (code points) from 1. */
export function putCursor(view: EditorView, line: number, column: number, quiet = false): void {
  const { doc } = view.state;
  const at = doc.line(Math.max(1, Math.min(line, doc.lines)));
  const anchor = at.from + utf16Offset(at.text, column - 1);
  view.dispatch({ selection: { anchor }, effects: EditorView.scrollIntoView(anchor, { y: "center" }) });
  if (!quiet) view.focus();
}
