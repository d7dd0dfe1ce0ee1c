// Keeps an editor's text and the server's the same, in both directions, without losing what is being typed.
import { apply, diff, rebase, type Change } from "./diff";

export interface SyncSetText {
  version: number;
  text: string;
  group: string;
}

export type SyncAnswer = { ok: true; version: number } | { ok: false; stale: boolean; message: string };

export interface SyncEnds {
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
export const kTypingRest = 300;
/** Continuous typing is sent so often [ms]: text that the server does not have is lost with the page. */
export const kTypingMost = 800;
// A stale version is tried again as often as other people's edits can reasonably come in between.
const kMostRetries = 5;

export class TextSync {
  private base_ = "";
  private version_ = -1;
  private known_ = false;
  /** typed text did not reach the server: it is sent with the next text */
  private owed_ = false;
  /** ends of bursts that were not sent yet; the last one's text is the editor's when the timer fires */
  private waiting_: { text: string; group: string }[] = [];
  private group_ = "";
  private dirty_ = false;
  private cancel_: (() => void) | null = null;
  private cancel_most_: (() => void) | null = null;
  private sending_ = false;
  private behind_: { text: string; version: number } | null = null;
  private retries_ = 0;
  private idle_: (() => void)[] = [];

  constructor(private readonly ends_: SyncEnds) {}

  /** The version of the editor's text before unsent typing. */
  get version(): number {
    return this.version_;
  }
  /** Whether the server knows all that was typed. */
  get settled(): boolean {
    return !this.dirty_ && this.waiting_.length === 0 && !this.sending_;
  }

  /** Whether the editor has something that the server's text, as it was known last, has not. */
  get unsent(): boolean {
    return this.known_ && this.ends_.text() !== this.base_;
  }

  /** The user changed the editor's text; `before` returns the old one. */
  typed(before: () => string, group: string): void {
    if (this.dirty_ && group !== this.group_) this.waiting_.push({ text: before(), group: this.group_ });
    this.dirty_ = true;
    this.group_ = group;
    this.cancel_?.();
    this.cancel_ = this.ends_.later(kTypingRest, () => this.take_());
    this.cancel_most_ ??= this.ends_.later(kTypingMost, () => this.take_());
    if (this.waiting_.length > 0) this.send_next_();
  }

  /** Sends typed text at once; done when the server has it (or refused it). */
  flush(): Promise<void> {
    this.take_();
    if (this.settled) return Promise.resolve();
    return new Promise((resolve) => this.idle_.push(resolve));
  }

  /** The server's text. */
  arrived(text: string, version: number): void {
    if (version <= this.version_) return;
    // Whether it holds the text just sent is known only with the answer.
    if (this.sending_) {
      if (!this.behind_ || version > this.behind_.version) this.behind_ = { text, version };
      return;
    }
    this.take_over_(text, version);
    if (this.owed_ && this.waiting_.length === 0) this.waiting_.push({ text: this.ends_.text(), group: this.group_ });
    this.owed_ = false;
    if (this.waiting_.length > 0) this.send_next_();
  }

  /** Restarts: another connection has other versions. */
  reset(): void {
    this.version_ = -1;
    this.behind_ = null;
  }

  private take_(): void {
    this.cancel_?.();
    this.cancel_most_?.();
    this.cancel_ = this.cancel_most_ = null;
    if (this.dirty_) {
      this.waiting_.push({ text: this.ends_.text(), group: this.group_ });
      this.dirty_ = false;
    }
    this.send_next_();
  }

  private send_next_(): void {
    if (this.sending_) return;
    while (this.waiting_.length > 0 && this.waiting_[0]!.text === this.base_) this.waiting_.shift();
    const next = this.waiting_.shift();
    if (!next) {
      this.resolve_idle_();
      if (this.settled) this.ends_.settled();
      return;
    }
    this.sending_ = true;
    void this.ends_.send({ version: this.version_, ...next }).then((answer) => this.answered_(next, answer));
  }

  private answered_(sent: { text: string; group: string }, answer: SyncAnswer): void {
    this.sending_ = false;
    const behind = this.behind_;
    this.behind_ = null;
    if (answer.ok) {
      this.retries_ = 0;
      if (answer.version > this.version_) {
        this.base_ = sent.text;
        this.version_ = answer.version;
      }
      if (behind && behind.version >= this.version_) this.take_over_(behind.text, behind.version);
    } else if (answer.stale && this.retries_ < kMostRetries) {
      ++this.retries_;
      // All that is not sent goes as one, merged with what came in between. Without the newer text yet: when it comes.
      this.waiting_ = [];
      const group = sent.group;
      if (behind) this.take_over_(behind.text, behind.version);
      this.waiting_ = [{ text: this.ends_.text(), group }];
      if (!behind) return;
    } else {
      this.retries_ = 0;
      if (behind) this.take_over_(behind.text, behind.version);
      this.owed_ = true;
      this.waiting_ = [];
      this.ends_.refused(answer.message);
      this.resolve_idle_();
      return;
    }
    this.send_next_();
  }

  /** Makes the server's text the base and brings what changed there into the editor's text. */
  private take_over_(text: string, version: number): void {
    const local = this.ends_.text();
    const unsent = this.known_ && local !== this.base_;
    const changes = unsent ? rebase(diff(this.base_, text), diff(this.base_, local)) : diff(local, text);
    // Ends of bursts that still wait are earlier texts: one step is made of them.
    const earlier = this.waiting_.length > 0 ? this.waiting_[this.waiting_.length - 1]!.group : this.group_;
    this.base_ = text;
    this.known_ = true;
    this.version_ = version;
    if (changes.length > 0) this.ends_.change(changes);
    if (this.waiting_.length > 0) this.waiting_ = [{ text: apply(local, changes), group: earlier }];
  }

  private resolve_idle_(): void {
    const idle = this.idle_;
    this.idle_ = [];
    for (const resolve of idle) resolve();
  }
}
