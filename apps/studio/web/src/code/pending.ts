// What is typed in the code panel and not yet known to the server, for those who go on from the server's text.
import type { Studio } from "../core/studio";

const flushes = new WeakMap<Studio, () => Promise<void>>();

/** `flush` sends what was typed at once; null: nothing can be typed any more. */
export function set_typing(studio: Studio, flush: (() => Promise<void>) | null): void {
  if (flush) flushes.set(studio, flush);
  else flushes.delete(studio);
}

/** Done when the server knows all that was typed. */
export async function settle_typing(studio: Studio): Promise<void> {
  await flushes.get(studio)?.();
}
