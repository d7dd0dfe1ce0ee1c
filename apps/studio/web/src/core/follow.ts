// Elements across versions of the text: their ids count from the front and change with every element before them.
import type { TreeElement } from "./protocol";

/** What names an element across versions: the names around it, or its index among its kind. */
export function elementKeys(elements: readonly TreeElement[]): string[] {
  const seen = new Map<string, number>();
  const keys: string[] = [];
  for (const element of elements) {
    const around = element.parent >= 0 ? (keys[element.parent] ?? "") : "";
    const stem = element.name === "" ? `${around}/${element.tag}` : `${around}/${element.tag}=${element.name}`;
    const count = seen.get(stem) ?? 0;
    seen.set(stem, count + 1);
    keys.push(count === 0 && element.name !== "" ? stem : `${stem}#${count}`);
  }
  return keys;
}

/** The ids in the new text of elements of the old one; those that are gone are left out. One that has another name and is
 *  otherwise where it was has been renamed; one that stands elsewhere under a name that there is once has been moved. */
export function followElements(
  ids: readonly number[],
  before: readonly TreeElement[],
  after: readonly TreeElement[],
): number[] {
  if (ids.length === 0) return [];
  const oldKeys = elementKeys(before);
  const newIds = new Map(elementKeys(after).map((key, id) => [key, id]));
  const out = ids.flatMap((id) => {
    const element = before[id];
    if (!element) return [];
    const same = newIds.get(oldKeys[id]!);
    if (same !== undefined) return [same];
    const there = after[id];
    if (before.length !== after.length) return [];
    if (there && there.tag === element.tag && there.parent === element.parent) return [id];
    const moved = element.name === "" ? [] : after.filter((e) => e.tag === element.tag && e.name === element.name);
    return moved.length === 1 ? [moved[0]!.id] : [];
  });
  return [...new Set(out)];
}
