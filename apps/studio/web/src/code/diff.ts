// The differences of two texts, in few and small pieces, so that the cursor and the scroll position stay.

export interface Change {
  from: number;
  to: number;
  insert: string;
}

const lowSurrogate = (c: number): boolean => c >= 0xdc00 && c <= 0xdfff;

/** One piece: the rest without the common beginning and end. Never cuts a code point in two. */
function narrow(a: string, b: string, offset: number): Change | null {
  if (a === b) return null;
  const most = Math.min(a.length, b.length);
  let head = 0;
  while (head < most && a.charCodeAt(head) === b.charCodeAt(head)) ++head;
  if (head > 0 && (lowSurrogate(a.charCodeAt(head)) || lowSurrogate(b.charCodeAt(head)))) --head;
  let tail = 0;
  while (tail < most - head && a.charCodeAt(a.length - 1 - tail) === b.charCodeAt(b.length - 1 - tail)) ++tail;
  if (tail > 0 && lowSurrogate(a.charCodeAt(a.length - tail))) --tail;
  return { from: offset + head, to: offset + a.length - tail, insert: b.slice(head, b.length - tail) };
}

function linesOf(text: string): string[] {
  const out: string[] = [];
  for (let at = 0; at < text.length;) {
    const end = text.indexOf("\n", at);
    const next = end < 0 ? text.length : end + 1;
    out.push(text.slice(at, next));
    at = next;
  }
  return out;
}

// Above this many differing lines on both sides the middle is replaced as one piece: time and memory go with the product.
const kMostCells = 4_000_000;

/** Matching lines of two lists by the longest common subsequence: pairs of indices, going up. */
function commonLines(a: string[], b: string[]): [number, number][] {
  const width = b.length + 1;
  const best = new Uint32Array((a.length + 1) * width);
  for (let i = a.length - 1; i >= 0; --i) {
    for (let j = b.length - 1; j >= 0; --j) {
      best[i * width + j] =
        a[i] === b[j]
          ? best[(i + 1) * width + j + 1]! + 1
          : Math.max(best[(i + 1) * width + j]!, best[i * width + j + 1]!);
    }
  }
  const out: [number, number][] = [];
  for (let i = 0, j = 0; i < a.length && j < b.length;) {
    if (a[i] === b[j]) out.push([i++, j++]);
    else if (best[(i + 1) * width + j]! >= best[i * width + j + 1]!) ++i;
    else ++j;
  }
  return out;
}

/** Changes that make `b` of `a`, from front to back, in positions of `a`, not touching each other. */
export function diff(a: string, b: string): Change[] {
  const whole = narrow(a, b, 0);
  if (!whole) return [];
  // whole lines around the piece, so that equal lines inside it are found
  const begin = whole.from === 0 ? 0 : a.lastIndexOf("\n", whole.from - 1) + 1;
  const fromEnd = a.length - whole.to;
  const lineEnd = a.indexOf("\n", whole.to);
  const end = lineEnd < 0 ? a.length : lineEnd + 1;
  const endB = b.length - (fromEnd - (end - whole.to));
  const linesA = linesOf(a.slice(begin, end));
  const linesB = linesOf(b.slice(begin, endB));
  if (linesA.length < 2 || linesB.length < 2 || linesA.length * linesB.length > kMostCells) return [whole];

  const out: Change[] = [];
  let at = begin;
  let i = 0;
  let j = 0;
  for (const [nextI, nextJ] of [...commonLines(linesA, linesB), [linesA.length, linesB.length] as const]) {
    const oldLines = linesA.slice(i, nextI);
    const newLines = linesB.slice(j, nextJ);
    if (oldLines.length === newLines.length) {
      // line by line: several edits in neighbouring lines stay several
      for (let k = 0; k < oldLines.length; ++k) {
        const change = narrow(oldLines[k]!, newLines[k]!, at);
        if (change) out.push(change);
        at += oldLines[k]!.length;
      }
    } else {
      const oldText = oldLines.join("");
      const change = narrow(oldText, newLines.join(""), at);
      if (change) out.push(change);
      at += oldText.length;
    }
    if (nextI < linesA.length) at += linesA[nextI]!.length;
    i = nextI + 1;
    j = nextJ + 1;
  }
  return out;
}

export function apply(text: string, changes: readonly Change[]): string {
  let out = "";
  let at = 0;
  for (const change of changes) {
    out += text.slice(at, change.from) + change.insert;
    at = change.to;
  }
  return out + text.slice(at);
}

/** `theirs` in positions of the text that `mine` made, when both changed the same text. Where both changed the same
 *  piece, mine stays: nothing typed is ever lost. */
export function rebase(theirs: readonly Change[], mine: readonly Change[]): Change[] {
  const out: Change[] = [];
  for (const change of theirs) {
    let shift = 0;
    let clash = false;
    for (const own of mine) {
      const before =
        own.to < change.from ||
        (own.to === change.from && own.from < change.from) ||
        (own.from === change.from && own.to === own.from && change.to > change.from);
      if (before || (own.from === own.to && own.from === change.from && change.to === change.from)) {
        shift += own.insert.length - (own.to - own.from);
      } else if (own.from < change.to && change.from < own.to) {
        clash = true;
      } else if (own.from === own.to && own.from > change.from && own.from < change.to) {
        clash = true;
      } else if (change.from === change.to && change.from > own.from && change.from < own.to) {
        clash = true;
      }
    }
    if (!clash) out.push({ from: change.from + shift, to: change.to + shift, insert: change.insert });
  }
  return out;
}
