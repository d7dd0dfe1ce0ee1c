// Elements of a text in XML, with their positions: as much of XML as the demonstration needs.
import type { TreeElement } from "../core/protocol";

interface Placed extends TreeElement {
  /** of the start tag, in the text */
  from: number;
  to: number;
}

interface Tokens {
  elements: Placed[];
  /** position of the first error; -1: well-formed */
  wrong: number;
  why: string;
}

export function positionOf(text: string, offset: number): { line: number; column: number } {
  const before = text.slice(0, offset).split("\n");
  return { line: before.length, column: before[before.length - 1]!.length + 1 };
}

export function tokens(text: string): Tokens {
  const elements: Placed[] = [];
  const open: number[] = [];
  const pattern = /<!--[\s\S]*?-->|<\?[\s\S]*?\?>|<\/([\w-]+)\s*>|<([\w-]+)((?:\s+[\w-]+\s*=\s*"[^"<]*")*)\s*(\/?)>|</g;
  for (const found of text.matchAll(pattern)) {
    const at = found.index ?? 0;
    const [all, closed, tag, list, empty] = found;
    if (closed !== undefined) {
      const last = open.pop();
      const element = last === undefined ? undefined : elements[last];
      if (element?.tag !== closed) return { elements, wrong: at, why: `'</${closed}>' closes nothing` };
      element.end_line = positionOf(text, at + all.length).line;
    } else if (tag !== undefined) {
      const attributes: Record<string, string> = {};
      for (const one of (list ?? "").matchAll(/([\w-]+)\s*=\s*"([^"]*)"/g)) attributes[one[1]!] = one[2]!;
      const parent = open[open.length - 1] ?? -1;
      const name = attributes.name ?? "";
      const above = elements[parent]?.parent === -1 ? "" : (elements[parent]?.path ?? "");
      const { line, column } = positionOf(text, at);
      elements.push({
        id: elements.length,
        parent,
        tag,
        name,
        path: name && above ? `${above}.${name}` : name,
        line,
        column,
        end_line: positionOf(text, at + all.length).line,
        attributes,
        from: at,
        to: at + all.length,
      });
      if (!empty) open.push(elements.length - 1);
    } else if (all === "<") {
      return { elements, wrong: at, why: "a tag that does not end" };
    }
  }
  const left = open[open.length - 1];
  if (left !== undefined)
    return { elements, wrong: elements[left]!.from, why: `<${elements[left]!.tag}> is not closed` };
  return { elements, wrong: -1, why: "" };
}
