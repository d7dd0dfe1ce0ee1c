// Edits whose failure is shown at their field, not at the edge of the window.
import { messageOf } from "../core/link";
import type { Op } from "../core/protocol";
import type { Studio } from "../core/studio";
import { edit } from "../shell/editing";

type Applied = { created: number[] } | { error: string };

/** One step of the history, made of the text that the tree shows. Done when the tree shows the outcome. */
export async function applyOps(studio: Studio, label: string, ops: Op[]): Promise<Applied> {
  try {
    // Waits while the user types faster than scenes compile.
    return { created: await edit(studio.link, studio.state, label, ops) };
  } catch (error) {
    return { error: messageOf(error) };
  }
}
