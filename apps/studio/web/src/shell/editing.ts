// Edits of the text: refused ones are reported, those that came too late are tried again if they still mean the same.
import { effect } from "@preact/signals-core";
import { RequestError, type Link } from "../core/link";
import type { Op, TreeElement } from "../core/protocol";
import type { State } from "../core/state";

const kPatience = 5_000; // [ms]

/** Ids of the elements that operations are about. */
export function elementsOf(ops: Op[]): number[] {
  return ops.flatMap((op) => {
    switch (op.op) {
      case "insert":
        return typeof op.before === "number" ? [op.parent, op.before] : [op.parent];
      case "move":
        return typeof op.before === "number" ? [op.element, op.parent, op.before] : [op.element, op.parent];
      case "remove":
      case "assemble":
      case "group":
        return op.elements;
      default:
        return [op.element];
    }
  });
}

/** Whether the ids mean the same elements in both texts. */
export function sameElements(ids: number[], before: TreeElement[], after: TreeElement[]): boolean {
  return ids.every((id) => {
    for (let at = id; at >= 0;) {
      const [a, b] = [before[at], after[at]];
      if (!a || !b || a.tag !== b.tag || a.name !== b.name || a.parent !== b.parent) return false;
      at = a.parent;
    }
    return true;
  });
}

/** Done when the tree is of `version` or a later one; false when that does not come. */
function treeOf(state: State, version: number): Promise<boolean> {
  return new Promise((resolve) => {
    const timer = setTimeout(() => finish(false), kPatience);
    const finish = (there: boolean) => {
      clearTimeout(timer);
      // an effect cannot end itself before it has begun
      queueMicrotask(() => stop());
      resolve(there);
    };
    const stop = effect(() => {
      if (state.tree.value.version >= version) finish(true);
    });
  });
}

/** Ids of the new elements, in the version that `state.tree` then has. Throws the reason of a failure. */
export async function edit(link: Link, state: State, label: string, ops: Op[]): Promise<number[]> {
  const { version, elements } = state.tree.value;
  const ask = (of: number) => link.request("edit", { version: of, ops, label });
  let answer;
  try {
    answer = await ask(version);
  } catch (error) {
    if (!(error instanceof RequestError) || error.failure.code !== "stale") throw error;
    if (state.document.value && state.document.value.version > version)
      await treeOf(state, state.document.value.version);
    else await treeOf(state, version + 1);
    const now = state.tree.value;
    if (now.version === version) {
      throw new Error("the text has an error: mend it in the code panel first");
    }
    if (!sameElements(elementsOf(ops), elements, now.elements)) {
      throw new Error("the text was changed at the same time: look at it and try again");
    }
    answer = await ask(now.version);
  }
  await treeOf(state, answer.version);
  return answer.created ?? [];
}
