// Panels in windows of their own: each is a page with its own connection (`?panel=NAME`). Over messages between the windows they
// keep what is selected, followed and looked at the same.
import { effect } from "@preact/signals-core";
import type { State } from "../core/state";

/** What one window tells the others. */
type Word =
  | { cogrsim: "state"; selection: number[]; hovered: number; followed: string; theme: "light" | "dark" }
  | { cogrsim: "cursor"; live: boolean; time: number }
  | { cogrsim: "call"; name: "open_panel" | "go_to" | "draw_signal" | "notify"; values: (string | number)[] }
  | { cogrsim: "hello" };

export interface Others {
  /** Does in the main window what a popped-out one cannot. */
  call(name: "open_panel" | "go_to" | "draw_signal" | "notify", values: (string | number)[]): void;
  cursor(live: boolean, time: number): void;
}

export class Windows implements Others {
  private readonly popped = new Map<string, Window>();
  private last = "";

  /** `main`: null in the main window. */
  constructor(
    private readonly state: State,
    private readonly main: Window | null,
    private readonly done: {
      cursor(live: boolean, time: number): void;
      call(name: string, values: (string | number)[]): void;
      returned(panel: string): void;
    },
  ) {
    addEventListener("message", (event: MessageEvent<unknown>) => {
      const from = event.source as Window | null;
      // only windows we opened, or that opened us; a page from elsewhere has no say
      if (!from || (from !== this.main && ![...this.popped.values()].includes(from))) return;
      if (event.origin !== location.origin && location.protocol !== "file:") return;
      this.hear(event.data, from);
    });
    if (main) this.post(main, { cogrsim: "hello" });
    effect(() => {
      const word: Word = {
        cogrsim: "state",
        selection: state.selection.value,
        hovered: state.hovered.value,
        followed: state.followed.value,
        theme: state.theme.value,
      };
      const text = JSON.stringify(word);
      const heard = text === this.last;
      this.last = text;
      // a new window is told by the main one, and does not tell it first
      if (!heard && (this.main === null || this.greeted)) this.tell(word);
    });
    if (!main) setInterval(() => this.look_after(), 500);
  }
  private greeted = false;

  /** Whether the browser let the window open. */
  pop_out(panel: string): boolean {
    const there = this.popped.get(panel);
    if (there && !there.closed) {
      there.focus();
      return true;
    }
    const address = new URL(location.href);
    address.searchParams.set("panel", panel);
    const opened = window.open(address, "", "popup,width=720,height=560");
    if (!opened) return false;
    this.popped.set(panel, opened);
    return true;
  }

  call(name: "open_panel" | "go_to" | "draw_signal" | "notify", values: (string | number)[]): void {
    if (this.main) this.post(this.main, { cogrsim: "call", name, values });
  }
  cursor(live: boolean, time: number): void {
    this.tell({ cogrsim: "cursor", live, time });
  }

  private tell(word: Word, except?: Window): void {
    for (const other of this.main ? [this.main] : this.popped.values()) {
      if (other !== except && !other.closed) this.post(other, word);
    }
  }
  private post(to: Window, word: Word): void {
    to.postMessage(word, location.protocol === "file:" ? "*" : location.origin);
  }

  private hear(data: unknown, from: Window): void {
    const word = data as Word;
    if (typeof word !== "object" || word === null) return;
    const { state } = this;
    switch (word.cogrsim) {
      case "hello":
        this.post(from, JSON.parse(this.last) as Word);
        if (!state.live.value && state.frame.value) {
          this.post(from, { cogrsim: "cursor", live: false, time: state.frame.value.time });
        }
        break;
      case "state":
        this.greeted = true;
        this.last = JSON.stringify(word);
        state.selection.value = word.selection;
        state.hovered.value = word.hovered;
        state.followed.value = word.followed;
        state.theme.value = word.theme;
        this.tell(word, from);
        break;
      case "cursor":
        this.done.cursor(word.live, word.time);
        this.tell(word, from);
        break;
      case "call":
        this.done.call(word.name, word.values);
        break;
    }
  }

  /** Panels whose window was closed come back. */
  private look_after(): void {
    for (const [panel, window] of this.popped) {
      if (!window.closed) continue;
      this.popped.delete(panel);
      this.done.returned(panel);
    }
  }
}
