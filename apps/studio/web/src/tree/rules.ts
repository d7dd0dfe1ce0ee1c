// Where dragged elements may go.
import type { Op, TreeElement } from "../core/protocol";
import type { Schema } from "../forms/schema";
import { childrenLists, isInside, topMost } from "./model";

export type DropZone = "before" | "into" | "after";

interface DropTarget {
  parent: number;
  /** null: last */
  before: number | null;
}

/** Which part of a row the pointer is in; `y` [0, 1] of its height. Rows that can hold what is dragged have a middle. */
export function dropZone(y: number, mayHold: boolean): DropZone {
  if (!mayHold) return y < 0.5 ? "before" : "after";
  return y < 0.25 ? "before" : y > 0.75 ? "after" : "into";
}

export function dropTarget(elements: readonly TreeElement[], target: number, zone: DropZone): DropTarget | null {
  const element = elements[target];
  if (!element) return null;
  if (zone === "into") return { parent: target, before: null };
  if (element.parent < 0) return null;
  if (zone === "before") return { parent: element.parent, before: target };
  const siblings = childrenLists(elements)[element.parent]!;
  return { parent: element.parent, before: siblings[siblings.indexOf(target) + 1] ?? null };
}

const kGroups = ["scene", "assembly", "prototype", "template", "body"];

/** Where something is pasted while `main` is selected: into it if it is a group, else beside it. Beside it, too, if it is one of
 *  `copies`: what was copied, and what has been pasted of it. What does not `take` it is left for what is around it. */
export function pastePosition(
  elements: readonly TreeElement[],
  main: number,
  takes: (parent: number) => boolean,
  copies: ReadonlySet<number>,
): DropTarget {
  if (kGroups.includes(elements[main]?.tag ?? "") && takes(main) && !(copies.has(main) && main > 0))
    return { parent: main, before: null };
  let beside = main;
  while (beside > 0 && !takes(elements[beside]!.parent)) beside = elements[beside]!.parent;
  return dropTarget(elements, beside, "after") ?? { parent: 0, before: null };
}

/** Why the elements may not go there; "": they may. */
export function refuseDrop(
  schema: Schema,
  elements: readonly TreeElement[],
  dragged: readonly number[],
  target: DropTarget,
): string {
  const moved = topMost(elements, dragged);
  if (moved.length === 0) return "the scene itself stays where it is";
  const parent = elements[target.parent];
  if (!parent) return "there is nothing to hold it";
  for (const id of moved) {
    if (isInside(elements, target.parent, id)) return "an element cannot go into itself";
    const element = elements[id]!;
    const stays = element.parent === target.parent;
    if (!stays && !schema.mayHold(elements, target.parent, element.tag)) {
      return `<${parent.tag}> holds no <${element.tag}>`;
    }
  }
  return "";
}

/** Moves that change something, in an order that keeps theirs. */
export function dropOps(elements: readonly TreeElement[], dragged: readonly number[], target: DropTarget): Op[] {
  const moved = topMost(elements, dragged);
  let before = target.before;
  // "Before" something that moves too means before the next that stays.
  const siblings = childrenLists(elements)[target.parent] ?? [];
  while (before !== null && moved.includes(before)) before = siblings[siblings.indexOf(before) + 1] ?? null;
  if (moved.length === 1) {
    const at = siblings.indexOf(moved[0]!);
    if (at >= 0 && (siblings[at + 1] ?? null) === before) return [];
  }
  return moved.map((element) => ({ op: "move", element, parent: target.parent, before, keep_place: true }));
}
