// Text typed in the code panel that the server does not have yet, for edits that begin with the server's text.
import type { Studio } from "../core/studio";

export interface Typing {
  /** Sends typed text at once. */
  flush(): Promise<void>;
  /** Whether there is anything that the server does not have. */
  unsent(): boolean;
  /** of the scene, with typed text */
  text(): string;
}

const typings = new WeakMap<Studio, Typing>();

/** null: nothing can be typed any more. */
export function set_typing(studio: Studio, typing: Typing | null): void {
  if (typing) typings.set(studio, typing);
  else typings.delete(studio);
}

export function unsent_typing(studio: Studio): boolean {
  return typings.get(studio)?.unsent() ?? false;
}

/** What stands in the code panel; undefined: there is none. */
export function text_here(studio: Studio): string | undefined {
  return typings.get(studio)?.text();
}

/** Done when the server knows all that was typed. */
export async function settle_typing(studio: Studio): Promise<void> {
  await typings.get(studio)?.flush();
}
