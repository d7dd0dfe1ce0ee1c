// The compiler counts code points, JavaScript UTF-16 units: an emoji is one of the former and two of the latter.

/** UTF-16 offset of code point number `points` of a text; its length if it has fewer. */
export function utf16Offset(text: string, points: number): number {
  let at = 0;
  for (let left = points; left > 0 && at < text.length; --left) at += text.codePointAt(at)! > 0xffff ? 2 : 1;
  return at;
}

/** Code points before UTF-16 offset `offset`. */
export function codePoints(text: string, offset: number = text.length): number {
  let points = 0;
  for (let at = 0; at < offset && at < text.length; ++points) at += text.codePointAt(at)! > 0xffff ? 2 : 1;
  return points;
}

/** UTF-16 offset where line `line` (from 1) begins, and where it ends (without its line end). */
export function lineSpan(text: string, line: number): { from: number; to: number } {
  let from = 0;
  for (let n = 1; n < line; ++n) {
    const end = text.indexOf("\n", from);
    if (end < 0) return { from: text.length, to: text.length };
    from = end + 1;
  }
  const end = text.indexOf("\n", from);
  const to = end < 0 ? text.length : end;
  return { from, to: to > from && text[to - 1] === "\r" ? to - 1 : to };
}

/** UTF-16 offset of a line and a column in code points, both from 1. */
export function offsetAt(text: string, line: number, column: number): number {
  const { from, to } = lineSpan(text, line);
  return from + utf16Offset(text.slice(from, to), column - 1);
}
