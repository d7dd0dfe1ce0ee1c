// Text typed in the code panel that the server does not have yet, for edits that begin with the server's text.

interface Typing {
  /** Sends typed text at once. */
  flush(): Promise<void>;
  /** Whether there is anything that the server does not have. */
  unsent(): boolean;
  /** of the scene, with typed text */
  text(): string;
}

export class PendingTyping {
  /** null: nothing can be typed */
  source: Typing | null = null;

  get unsent(): boolean {
    return this.source?.unsent() ?? false;
  }
  /** What stands in the code panel; undefined: there is none. */
  get text(): string | undefined {
    return this.source?.text();
  }
  /** Done when the server knows all that was typed. */
  async settle(): Promise<void> {
    await this.source?.flush();
  }
}
