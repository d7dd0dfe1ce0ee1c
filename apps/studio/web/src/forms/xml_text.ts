// Finds elements and attributes in XML text by where they begin. Offsets are UTF-16, as in JavaScript's strings.

interface AttributeSpan {
  name: string;
  /** of name, "=" and value with its quotes */
  from: number;
  to: number;
  /** between the quotes */
  valueFrom: number;
  valueTo: number;
}

export interface StartTag {
  tag: string;
  from: number;
  /** behind ">" */
  to: number;
  empty: boolean;
  attributes: AttributeSpan[];
}

const isName = (c: string | undefined): boolean => c !== undefined && /[^\s=<>"'/]/.test(c);

/** The start tag at `from` (where its "<" is); null if there is none or it has no end. */
export function startTag(text: string, from: number): StartTag | null {
  if (text[from] !== "<" || !isName(text[from + 1]) || text[from + 1] === "!" || text[from + 1] === "?") return null;
  let at = from + 1;
  while (isName(text[at])) ++at;
  const tag = text.slice(from + 1, at);
  const attributes: AttributeSpan[] = [];
  while (at < text.length) {
    const c = text[at]!;
    if (c === ">") return { tag, from, to: at + 1, empty: text[at - 1] === "/", attributes };
    if (c === "<") return null;
    if (!isName(c)) {
      ++at;
      continue;
    }
    const nameFrom = at;
    while (isName(text[at])) ++at;
    const name = text.slice(nameFrom, at);
    while (/\s/.test(text[at] ?? "")) ++at;
    if (text[at] !== "=") continue;
    ++at;
    while (/\s/.test(text[at] ?? "")) ++at;
    const quote = text[at];
    if (quote !== '"' && quote !== "'") continue;
    const end = text.indexOf(quote, at + 1);
    if (end < 0) return null;
    attributes.push({ name, from: nameFrom, to: end + 1, valueFrom: at + 1, valueTo: end });
    at = end + 1;
  }
  return null;
}

/** Behind what begins at `at` with "<!" or "<?": a comment, CDATA, an instruction. */
function skipSpecial(text: string, at: number): number {
  const ends: [string, string][] = [
    ["<!--", "-->"],
    ["<![CDATA[", "]]>"],
    ["<?", "?>"],
  ];
  for (const [begin, end] of ends) {
    if (!text.startsWith(begin, at)) continue;
    const found = text.indexOf(end, at + begin.length);
    return found < 0 ? text.length : found + end.length;
  }
  const close = text.indexOf(">", at);
  return close < 0 ? text.length : close + 1;
}

/** Behind the element that begins at `from`; null if it has no end. */
export function elementEnd(text: string, from: number): number | null {
  const start = startTag(text, from);
  if (!start) return null;
  if (start.empty) return start.to;
  let depth = 1;
  let at = start.to;
  while (at < text.length) {
    at = text.indexOf("<", at);
    if (at < 0) return null;
    const next = text[at + 1];
    if (next === "!" || next === "?") {
      at = skipSpecial(text, at);
    } else if (next === "/") {
      const close = text.indexOf(">", at);
      if (close < 0) return null;
      at = close + 1;
      if (--depth === 0) return at;
    } else {
      const inner = startTag(text, at);
      if (!inner) return null;
      if (!inner.empty) ++depth;
      at = inner.to;
    }
  }
  return null;
}

/** The elements of a text that has only elements (and comments between them); null if it has anything else. */
export function splitElements(text: string): string[] | null {
  const out: string[] = [];
  let at = 0;
  while (at < text.length) {
    if (/\s/.test(text[at]!)) {
      ++at;
    } else if (text.startsWith("<!--", at)) {
      at = skipSpecial(text, at);
    } else {
      const end = elementEnd(text, at);
      if (end === null) return null;
      out.push(text.slice(at, end));
      at = end;
    }
  }
  return out.length > 0 ? out : null;
}

/** Lines without the indentation that all but the first share. */
export function dedent(xml: string): string {
  const lines = xml.split("\n");
  const indents = lines
    .slice(1)
    .filter((l) => l.trim() !== "")
    .map((l) => /^[ \t]*/.exec(l)![0].length);
  const common = indents.length > 0 ? Math.min(...indents) : 0;
  return lines.map((l, i) => (i === 0 ? l : l.slice(Math.min(common, /^[ \t]*/.exec(l)![0].length)))).join("\n");
}

export function escapeAttribute(value: string): string {
  return value.replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/"/g, "&quot;").replace(/\n/g, "&#10;");
}

/** `<tag a="1" b="2"/>`; attributes with empty values are left out. */
export function printElement(tag: string, attributes: Record<string, string>, content = ""): string {
  const written = Object.entries(attributes)
    .filter(([, value]) => value !== "")
    .map(([name, value]) => ` ${name}="${escapeAttribute(value)}"`)
    .join("");
  return content === "" ? `<${tag}${written}/>` : `<${tag}${written}>\n  ${content}\n</${tag}>`;
}
