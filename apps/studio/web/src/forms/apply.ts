// Edits whose failure is shown where they were made, not at the edge of the window.
import { RequestError } from "../core/link";
import type { Op } from "../core/protocol";
import type { Studio } from "../core/studio";

export type Applied = { created: number[] } | { error: string };

// The tree of the new text follows its answer at once; longer means that the text has gone on already.
const kLongestWait = 2000;

/** One step of the history, made of the text that the tree shows. Done when the tree shows the outcome. */
export async function apply_ops(studio: Studio, label: string, ops: Op[]): Promise<Applied> {
  const { tree } = studio.state;
  try {
    const fields = { version: tree.peek().version, ops, label };
    const answer = await studio.link.request<{ version: number; created?: number[] }>("edit", fields);
    if (tree.peek().version < answer.version) {
      await new Promise<void>((resolve) => {
        const timer = setTimeout(done, kLongestWait);
        const stop = tree.subscribe(({ version }) => {
          if (version >= answer.version) queueMicrotask(done);
        });
        function done(): void {
          clearTimeout(timer);
          stop();
          resolve();
        }
      });
    }
    return { created: tree.peek().version === answer.version ? (answer.created ?? []) : [] };
  } catch (error) {
    if (error instanceof RequestError && error.failure.code === "stale") {
      return { error: "the text has changed in the meantime: try it once more" };
    }
    return { error: error instanceof Error ? error.message : String(error) };
  }
}
