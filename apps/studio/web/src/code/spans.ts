// Elements, problems and cursor positions in the text of the scene.
import type { Problem, TreeElement } from "../core/protocol";
import { startTag, type StartTag } from "../forms/xml_text";
import { codePoints, lineSpan, utf16Offset } from "./columns";

/** The selection after this text was inserted at `from`: the text between its first quotes, else the end. */
export function writtenSelection(text: string, from: number): { anchor: number; head: number } {
  const open = text.indexOf('="') + 2;
  const close = open < 2 ? -1 : text.indexOf('"', open);
  return close < 0
    ? { anchor: from + text.length, head: from + text.length }
    : { anchor: from + open, head: from + close };
}

/** The innermost element whose text contains a position; line and column (code points) from 1. -1: none. */
export function elementAt(elements: readonly TreeElement[], line: number, column: number): number {
  let found = -1;
  for (const element of elements) {
    if (element.line > line || (element.line === line && element.column > column)) break;
    if (element.end_line >= line) found = element.id;
  }
  return found;
}

/** Where a problem is; at least one character, so that it can be seen. */
export function problemRange(text: string, problem: Problem): { from: number; to: number } {
  const line = lineSpan(text, problem.line);
  const content = text.slice(line.from, line.to);
  let from = line.from + utf16Offset(content, problem.column - 1);
  let to = from + utf16Offset(text.slice(from), Math.max(0, problem.length));
  if (to <= from) to = from < text.length && from < line.to ? from + utf16Offset(text.slice(from), 1) : from;
  if (to === from && from > line.from)
    from -=
      codePoints(text.slice(0, from)) > 0 && from - 2 >= line.from && text.codePointAt(from - 2)! > 0xffff ? 2 : 1;
  return { from, to };
}

/** The start tag that a position is in; null: it is in none. */
export function tagAround(text: string, position: number): StartTag | null {
  for (let at = text.lastIndexOf("<", position); at >= 0; at = text.lastIndexOf("<", at - 1)) {
    const tag = startTag(text, at);
    if (tag) return position < tag.to ? tag : null;
    // "<" inside quotes is no start; further than a few thousand characters no tag goes
    if (position - at > 5000 || at === 0) return null;
  }
  return null;
}

/** Whether two paths probably name the same file: servers name it with folders or without. */
export function sameFile(a: string, b: string): boolean {
  const name = (path: string) => path.replace(/^.*[\\/]/, "");
  return a === b || name(a) === name(b);
}
