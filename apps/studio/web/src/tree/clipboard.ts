// Elements as XML, to and from the clipboard.
import type { TreeElement } from "../core/protocol";
import type { Studio } from "../core/studio";
import { offset_at } from "../code/columns";
import { dedent, element_end, split_elements } from "../forms/xml_text";
import { top_most } from "./model";
import { tree_state } from "./tree_state";

/** The element as it is written, without the indentation of where it stands; null if it is not there. */
export function element_xml(text: string, element: TreeElement): string | null {
  const from = offset_at(text, element.line, element.column);
  const to = element_end(text, from);
  return to === null ? null : dedent(text.slice(from, to).replace(/\r\n/g, "\n"));
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
  tree_state(studio).copied.value = copied;
  left_window = false;
  // Not allowed everywhere; inside this page copying works without.
  void navigator.clipboard?.writeText(copied.join("\n")).catch(() => undefined);
  return true;
}

/** What was copied last, here or elsewhere; null: no elements. */
export async function copied_elements(studio: Studio): Promise<string[] | null> {
  const own = tree_state(studio).copied.peek();
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
