// Elements as XML, to and from the clipboard.
import type { TreeElement } from "../core/protocol";
import type { Studio } from "../core/studio";
import { offset_at } from "../code/columns";
import { factor_of, parse_numbers, print_numbers, short_number } from "../forms/values";
import { dedent, element_end, split_elements, start_tag } from "../forms/xml_text";
import { element_keys, top_most } from "./model";
import { TreeState } from "./tree_state";

/** The element as it is written, without the indentation of where it stands; null if it is not there. */
export function element_xml(text: string, element: TreeElement): string | null {
  const from = offset_at(text, element.line, element.column);
  const to = element_end(text, from);
  return to === null ? null : dedent(text.slice(from, to).replace(/\r\n/g, "\n"));
}

/** The element `shift` [m] further along x; as it is if its position is not written in plain numbers. */
export function shifted_xml(xml: string, shift: number): string {
  const tag = start_tag(xml, 0);
  const span = tag?.attributes.find((a) => a.name === "xyz");
  if (tag && !span) {
    const behind = tag.attributes[tag.attributes.length - 1]?.to ?? tag.tag.length + 1;
    return `${xml.slice(0, behind)} xyz="${short_number(shift)} 0 0"${xml.slice(behind)}`;
  }
  const parts = span ? parse_numbers(xml.slice(span.value_from, span.value_to)) : null;
  const x = parts?.entries[0];
  const factor = x ? factor_of("m", x.unit) : undefined;
  if (!span || !parts || !x || factor === undefined || parts.entries.length !== 3) return xml;
  x.text = short_number(Number(x.text) + shift / factor);
  return xml.slice(0, span.value_from) + print_numbers(parts.entries) + xml.slice(span.value_to);
}

// What was copied elsewhere since is newer than what was copied here; the window cannot have lost the focus unseen.
let left_window = false;
if (typeof window !== "undefined") window.addEventListener("blur", () => (left_window = true));

export function copy_elements(studio: Studio, ids: readonly number[]): boolean {
  const text = studio.state.document.peek()?.text;
  const { version, elements } = studio.state.tree.peek();
  if (text === undefined || version !== studio.state.document.peek()?.version) {
    studio.notify("the text has errors: nothing can be copied from the tree until they are put right", "error");
    return false;
  }
  const copied = top_most(elements, ids).flatMap((id) => element_xml(text, elements[id]!) ?? []);
  if (copied.length === 0) return false;
  studio.services.get(TreeState).copied.value = copied;
  const keys = element_keys(elements);
  studio.services.get(TreeState).copies = new Set(top_most(elements, ids).map((id) => keys[id]!));
  studio.services.get(TreeState).copied_from.value = elements[elements[ids[0] ?? 0]?.parent ?? 0]?.path ?? null;
  left_window = false;
  // Not allowed everywhere; inside this page copying works without.
  void navigator.clipboard?.writeText(copied.join("\n")).catch(() => undefined);
  return true;
}

/** What was copied last, here or elsewhere; null: no elements. */
export async function copied_elements(studio: Studio): Promise<string[] | null> {
  const own = studio.services.get(TreeState).copied.peek();
  if (own.length > 0 && !left_window) return own;
  try {
    const text = await navigator.clipboard.readText();
    const elements = split_elements(text.replace(/\r\n/g, "\n"));
    if (elements) return elements;
  } catch {
    // not allowed: what was copied here is all that is known
  }
  return own.length > 0 ? own : null;
}
