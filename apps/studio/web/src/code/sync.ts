// Keeps an editor's text and the server's the same, in both directions, without losing what is being typed.
import { apply, diff, rebase, type Change } from "./diff";

export interface SyncSetText {
  version: number;
  text: string;
  group: string;
}

export type SyncAnswer = { ok: true; version: number } | { ok: false; stale: boolean; message: string };

interface SyncEnds {
  /** Asks the server. Never rejects. */
  send(fields: SyncSetText): Promise<SyncAnswer>;
  /** The editor's text now. */
  text(): string;
  /** Changes the editor's text, in positions of text(). Does not come back as typed(). */
  change(changes: Change[]): void;
  /** After `ms` milliseconds; answers what takes it back. */
  later(ms: number, what: () => void): () => void;
  /** The server refused for another reason than a stale version. */
  refused(message: string): void;
  /** The server knows all that was typed, again. */
  settled(): void;
}

/** Typing is sent when it rests for so long [ms]. */
const kTypingRest = 300;
/** Continuous typing is sent so often [ms]: text that the server does not have is lost with the page. */
export const kTypingMost = 800;
// A stale version is tried again as often as other people's edits can reasonably come in between.
const kMostRetries = 5;

export class TextSync {
  private base = "";
  private latestVersion = -1;
  private known = false;
  /** typed text did not reach the server: it is sent with the next text */
  private resend = false;
  /** ends of bursts that were not sent yet; the last one's text is the editor's when the timer fires */
  private waiting: { text: string; group: string }[] = [];
  private latestGroup = "";
  private dirty = false;
  private cancelTimer: (() => void) | null = null;
  private cancelDeadline: (() => void) | null = null;
  private sending = false;
  private behind: { text: string; version: number } | null = null;
  private retries = 0;
  private idle: (() => void)[] = [];

  constructor(private readonly ends: SyncEnds) {}

  /** The version of the editor's text before unsent typing. */
  get version(): number {
    return this.latestVersion;
  }
  /** Whether the server knows all that was typed. */
  get settled(): boolean {
    return !this.dirty && this.waiting.length === 0 && !this.sending;
  }

  /** Whether the editor has something that the server's text, as it was known last, has not. */
  get unsent(): boolean {
    return this.known && this.ends.text() !== this.base;
  }

  /** The user changed the editor's text; `before` returns the old one. */
  typed(before: () => string, group: string): void {
    if (this.dirty && group !== this.latestGroup) this.waiting.push({ text: before(), group: this.latestGroup });
    this.dirty = true;
    this.latestGroup = group;
    this.cancelTimer?.();
    this.cancelTimer = this.ends.later(kTypingRest, () => this.take());
    this.cancelDeadline ??= this.ends.later(kTypingMost, () => this.take());
    if (this.waiting.length > 0) this.sendNext();
  }

  /** Sends typed text at once; done when the server has it (or refused it). */
  flush(): Promise<void> {
    this.take();
    if (this.settled) return Promise.resolve();
    return new Promise((resolve) => this.idle.push(resolve));
  }

  /** The server's text. */
  arrived(text: string, version: number): void {
    if (version <= this.latestVersion) return;
    // Whether it holds the text just sent is known only with the answer.
    if (this.sending) {
      if (!this.behind || version > this.behind.version) this.behind = { text, version };
      return;
    }
    this.takeOver(text, version);
    if (this.resend && this.waiting.length === 0)
      this.waiting.push({ text: this.ends.text(), group: this.latestGroup });
    this.resend = false;
    if (this.waiting.length > 0) this.sendNext();
  }

  /** Restarts: another connection has other versions. */
  reset(): void {
    this.latestVersion = -1;
    this.behind = null;
  }

  private take(): void {
    this.cancelTimer?.();
    this.cancelDeadline?.();
    this.cancelTimer = this.cancelDeadline = null;
    if (this.dirty) {
      this.waiting.push({ text: this.ends.text(), group: this.latestGroup });
      this.dirty = false;
    }
    this.sendNext();
  }

  private sendNext(): void {
    if (this.sending) return;
    while (this.waiting.length > 0 && this.waiting[0]!.text === this.base) this.waiting.shift();
    const next = this.waiting.shift();
    if (!next) {
      this.resolveIdle();
      if (this.settled) this.ends.settled();
      return;
    }
    this.sending = true;
    void this.ends.send({ version: this.latestVersion, ...next }).then((answer) => this.answered(next, answer));
  }

  private answered(sent: { text: string; group: string }, answer: SyncAnswer): void {
    this.sending = false;
    const behind = this.behind;
    this.behind = null;
    if (answer.ok) {
      this.retries = 0;
      if (answer.version > this.latestVersion) {
        this.base = sent.text;
        this.latestVersion = answer.version;
      }
      if (behind && behind.version >= this.latestVersion) this.takeOver(behind.text, behind.version);
    } else if (answer.stale && this.retries < kMostRetries) {
      ++this.retries;
      // All that is not sent goes as one, merged with what came in between. Without the newer text yet: when it comes.
      this.waiting = [];
      const group = sent.group;
      if (behind) this.takeOver(behind.text, behind.version);
      this.waiting = [{ text: this.ends.text(), group }];
      if (!behind) return;
    } else {
      this.retries = 0;
      if (behind) this.takeOver(behind.text, behind.version);
      this.resend = true;
      this.waiting = [];
      this.ends.refused(answer.message);
      this.resolveIdle();
      return;
    }
    this.sendNext();
  }

  /** Makes the server's text the base and brings what changed there into the editor's text. */
  private takeOver(text: string, version: number): void {
    const local = this.ends.text();
    const unsent = this.known && local !== this.base;
    const changes = unsent ? rebase(diff(this.base, text), diff(this.base, local)) : diff(local, text);
    // Ends of bursts that still wait are earlier texts: one step is made of them.
    const earlier = this.waiting.length > 0 ? this.waiting[this.waiting.length - 1]!.group : this.latestGroup;
    this.base = text;
    this.known = true;
    this.latestVersion = version;
    if (changes.length > 0) this.ends.change(changes);
    if (this.waiting.length > 0) this.waiting = [{ text: apply(local, changes), group: earlier }];
  }

  private resolveIdle(): void {
    const idle = this.idle;
    this.idle = [];
    for (const resolve of idle) resolve();
  }
}
