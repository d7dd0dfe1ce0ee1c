// How the editors look: colours are the page's.
import { HighlightStyle, syntaxHighlighting } from "@codemirror/language";
import type { Extension } from "@codemirror/state";
import { EditorView } from "@codemirror/view";
import { tags as t } from "@lezer/highlight";

const look = EditorView.theme({
  "&": { height: "100%", fontSize: "13px", color: "var(--cg-text)", backgroundColor: "var(--cg-panel)" },
  "&.cm-focused": { outline: "none" },
  ".cm-scroller": { fontFamily: "var(--cg-mono)", lineHeight: "1.45" },
  ".cm-content": { caretColor: "var(--cg-text)" },
  ".cm-cursor, .cm-dropCursor": { borderLeftColor: "var(--cg-text)" },
  "&.cm-focused > .cm-scroller > .cm-selectionLayer .cm-selectionBackground, .cm-selectionBackground": {
    backgroundColor: "var(--cg-selected)",
  },
  ".cm-gutters": {
    backgroundColor: "var(--cg-raised)",
    color: "var(--cg-muted)",
    borderRight: "1px solid var(--cg-border)",
  },
  ".cm-activeLine": { backgroundColor: "transparent" },
  ".cm-activeLineGutter": { backgroundColor: "var(--cg-hover)", color: "var(--cg-text)" },
  ".cm-line.cg-code-selected": { boxShadow: "inset 3px 0 0 var(--cg-highlight)" },
  ".cm-tooltip": {
    backgroundColor: "var(--cg-panel)",
    color: "var(--cg-text)",
    border: "1px solid var(--cg-border)",
    boxShadow: "var(--cg-shadow)",
    maxWidth: "460px",
  },
  ".cm-tooltip-autocomplete ul li[aria-selected]": {
    backgroundColor: "var(--cg-accent)",
    color: "var(--cg-accent-text)",
  },
  ".cm-completionDetail": { color: "inherit", opacity: "0.85", fontStyle: "normal" },
  ".cm-panels": { backgroundColor: "var(--cg-raised)", color: "var(--cg-text)" },
  ".cm-lintRange-error": {
    backgroundImage: "none",
    textDecoration: "underline wavy var(--cg-error)",
    textDecorationSkipInk: "none",
  },
  ".cm-lintRange-warning": {
    backgroundImage: "none",
    textDecoration: "underline wavy var(--cg-warn)",
    textDecorationSkipInk: "none",
  },
  ".cm-diagnostic-error": { borderLeftColor: "var(--cg-error)" },
  ".cm-diagnostic-warning": { borderLeftColor: "var(--cg-warn)" },
  ".cm-diagnostic": { whiteSpace: "pre-wrap" },
  ".cm-searchMatch": { backgroundColor: "var(--cg-warn-bg)" },
});

const highlighting = HighlightStyle.define([
  { tag: [t.tagName, t.keyword, t.controlKeyword, t.definitionKeyword, t.modifier], color: "var(--cg-series-1)" },
  { tag: [t.attributeName, t.typeName, t.className], color: "var(--cg-series-3)" },
  { tag: [t.attributeValue, t.string, t.character], color: "var(--cg-series-2)" },
  { tag: [t.comment, t.lineComment, t.blockComment], color: "var(--cg-muted)", fontStyle: "italic" },
  { tag: [t.number, t.bool, t.null, t.processingInstruction, t.meta], color: "var(--cg-series-4)" },
  { tag: [t.angleBracket, t.operator], color: "var(--cg-muted)" },
]);

export const editorLook: Extension = [look, syntaxHighlighting(highlighting)];
