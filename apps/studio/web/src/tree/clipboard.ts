// Elements as XML, to and from the clipboard.
import type { TreeElement } from "../core/protocol";
import type { Studio } from "../core/studio";
import { offsetAt } from "../code/columns";
import { factorOf, parseNumbers, printNumbers, shortNumber } from "../forms/values";
import { dedent, elementEnd, splitElements, startTag } from "../forms/xml_text";
import { elementKeys, topMost } from "./model";
import { TreeState } from "./tree_state";

/** The element as it is written, without the indentation of where it stands; null if it is not there. */
export function elementXml(text: string, element: TreeElement): string | null {
  const from = offsetAt(text, element.line, element.column);
  const to = elementEnd(text, from);
  return to === null ? null : dedent(text.slice(from, to).replace(/\r\n/g, "\n"));
}

/** The element `shift` [m] further along x; as it is if its position is not written in plain numbers. */
export function shiftedXml(xml: string, shift: number): string {
  const tag = startTag(xml, 0);
  const span = tag?.attributes.find((a) => a.name === "xyz");
  if (tag && !span) {
    const behind = tag.attributes[tag.attributes.length - 1]?.to ?? tag.tag.length + 1;
    return `${xml.slice(0, behind)} xyz="${shortNumber(shift)} 0 0"${xml.slice(behind)}`;
  }
  const parts = span ? parseNumbers(xml.slice(span.valueFrom, span.valueTo)) : null;
  const x = parts?.entries[0];
  const factor = x ? factorOf("m", x.unit) : undefined;
  if (!span || !parts || !x || factor === undefined || parts.entries.length !== 3) return xml;
  x.text = shortNumber(Number(x.text) + shift / factor);
  return xml.slice(0, span.valueFrom) + printNumbers(parts.entries) + xml.slice(span.valueTo);
}

// What was copied elsewhere since is newer than what was copied here; the window cannot have lost the focus unseen.
let leftWindow = false;
if (typeof window !== "undefined") window.addEventListener("blur", () => (leftWindow = true));

export function copyElements(studio: Studio, ids: readonly number[]): boolean {
  const text = studio.state.document.peek()?.text;
  const { version, elements } = studio.state.tree.peek();
  if (text === undefined || version !== studio.state.document.peek()?.version) {
    studio.notify("the text has errors: nothing can be copied from the tree until they are put right", "error");
    return false;
  }
  const copied = topMost(elements, ids).flatMap((id) => elementXml(text, elements[id]!) ?? []);
  if (copied.length === 0) return false;
  studio.services.get(TreeState).copied.value = copied;
  const keys = elementKeys(elements);
  studio.services.get(TreeState).copies = new Set(topMost(elements, ids).map((id) => keys[id]!));
  studio.services.get(TreeState).copiedFrom.value = elements[elements[ids[0] ?? 0]?.parent ?? 0]?.path ?? null;
  leftWindow = false;
  // Not allowed everywhere; inside this page copying works without.
  void navigator.clipboard?.writeText(copied.join("\n")).catch(() => undefined);
  return true;
}

/** What was copied last, here or elsewhere; null: no elements. */
export async function copiedElements(studio: Studio): Promise<string[] | null> {
  const own = studio.services.get(TreeState).copied.peek();
  if (own.length > 0 && !leftWindow) return own;
  try {
    const text = await navigator.clipboard.readText();
    const elements = splitElements(text.replace(/\r\n/g, "\n"));
    if (elements) return elements;
  } catch {
    // not allowed: what was copied here is all that is known
  }
  return own.length > 0 ? own : null;
}
