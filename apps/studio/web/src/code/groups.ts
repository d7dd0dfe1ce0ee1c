// Which edits of a text make one step of the history: a burst of typing, not every key.

interface TypedEdit {
  /** of the clock [ms] */
  time: number;
  /** the replaced range, in positions before the edit */
  from: number;
  to: number;
  insert: string;
}

/** A burst ends when nothing was typed for so long [ms]. */
export const kBurstPause = 1500;

export class TypingGroups {
  private number = 0;
  /** `begin` to `end`: what the burst has written so far */
  private last: { time: number; begin: number; end: number; deletes: boolean } | null = null;

  /** `seed` distinguishes this page's groups from other pages'. */
  constructor(private readonly seed: string) {}

  /** The group of an edit. Another one begins after a pause, at another position, when typing turns into deleting or
   *  the reverse, behind a line end, and with anything that is not typing: pasted text, several positions at once. */
  next(edits: readonly TypedEdit[]): string {
    const edit = edits[0];
    if (!edit) return this.name();
    const deletes = edit.insert === "";
    const last = this.last;
    // Positions inside the text just written count: editors close quotes and tags behind the cursor.
    const touches =
      last !== null &&
      (deletes ? edit.to === last.end || edit.from === last.end : edit.from >= last.begin && edit.from <= last.end);
    const typing = edits.length === 1 && edit.insert.length <= 2 && edit.to - edit.from <= 2;
    const continues =
      last !== null && typing && touches && deletes === last.deletes && edit.time - last.time <= kBurstPause;
    if (!continues) ++this.number;
    const ends = !typing || edit.insert.includes("\n");
    const grown = edit.insert.length - (edit.to - edit.from);
    const begin = continues && !deletes ? last.begin : edit.from;
    const end = continues && !deletes ? last.end + grown : edit.from + edit.insert.length;
    this.last = ends ? null : { time: edit.time, begin, end, deletes };
    return this.name();
  }

  /** The next edit begins another group: the cursor went elsewhere, something else was done in between. */
  end(): void {
    this.last = null;
  }

  private name(): string {
    return `${this.seed}${this.number}`;
  }
}
