// Panels in windows of their own: each is a page with its own connection (`?panel=NAME`). Over messages between the windows they
// share the selection, the followed body and the shown time.
import { batch, effect } from "@preact/signals-core";
import type { State } from "../core/state";

interface Shared {
  selection: number[];
  hovered: number;
  followed: string;
  theme: "light" | "dark";
}

/** The messages between windows: of the shared state only what changed, as two may change different things at once. */
type Message =
  | { cogrsim: "state"; changed: Partial<Shared> }
  | { cogrsim: "cursor"; live: boolean; time: number }
  | { cogrsim: "call"; name: "openPanel" | "goTo" | "drawSignal" | "notify"; values: (string | number)[] }
  | { cogrsim: "hello" };

interface Others {
  /** Calls in the main window what a popped-out one cannot do. */
  call(name: "openPanel" | "goTo" | "drawSignal" | "notify", values: (string | number)[]): void;
  cursor(live: boolean, time: number): void;
}

export class Windows implements Others {
  private readonly popped = new Map<string, Window>();
  /** The state that the others know. */
  private known: Partial<Shared> = {};
  private greeted = false;

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
      this.receive(event.data, from);
    });
    if (main) this.post(main, { cogrsim: "hello" });
    effect(() => {
      const now = this.shared();
      const changed = difference(this.known, now);
      this.known = now;
      // the main window sends its state to a new one first
      if (Object.keys(changed).length > 0 && (this.main === null || this.greeted))
        this.send({ cogrsim: "state", changed });
    });
    if (!main) setInterval(() => this.findClosed(), 500);
  }

  /** Whether the browser let the window open. */
  popOut(panel: string): boolean {
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

  call(name: "openPanel" | "goTo" | "drawSignal" | "notify", values: (string | number)[]): void {
    if (this.main) this.post(this.main, { cogrsim: "call", name, values });
  }
  cursor(live: boolean, time: number): void {
    this.send({ cogrsim: "cursor", live, time });
  }

  private shared(): Shared {
    const { selection, hovered, followed, theme } = this.state;
    return { selection: selection.value, hovered: hovered.value, followed: followed.value, theme: theme.value };
  }
  private send(message: Message, except?: Window): void {
    for (const other of this.main ? [this.main] : this.popped.values()) {
      if (other !== except && !other.closed) this.post(other, message);
    }
  }
  private post(to: Window, message: Message): void {
    to.postMessage(message, location.protocol === "file:" ? "*" : location.origin);
  }

  private receive(data: unknown, from: Window): void {
    const message = data as Message;
    if (typeof message !== "object" || message === null) return;
    const { state } = this;
    switch (message.cogrsim) {
      case "hello":
        this.post(from, { cogrsim: "state", changed: this.shared() });
        if (!state.live.value && state.frame.value) {
          this.post(from, { cogrsim: "cursor", live: false, time: state.frame.value.time });
        }
        break;
      case "state":
        this.greeted = true;
        this.known = { ...this.known, ...message.changed };
        batch(() => {
          const { selection, hovered, followed, theme } = message.changed;
          if (selection !== undefined) state.selection.value = selection;
          if (hovered !== undefined) state.hovered.value = hovered;
          if (followed !== undefined) state.followed.value = followed;
          if (theme !== undefined) state.theme.value = theme;
        });
        this.send(message, from);
        break;
      case "cursor":
        this.done.cursor(message.live, message.time);
        this.send(message, from);
        break;
      case "call":
        this.done.call(message.name, message.values);
        break;
    }
  }

  /** Panels whose window was closed come back. */
  private findClosed(): void {
    for (const [panel, window] of this.popped) {
      if (!window.closed) continue;
      this.popped.delete(panel);
      this.done.returned(panel);
    }
  }
}

/** What of `now` is not as in `before`. */
function difference(before: Partial<Shared>, now: Shared): Partial<Shared> {
  return Object.fromEntries(
    Object.entries(now).filter(([key, value]) => JSON.stringify(before[key as keyof Shared]) !== JSON.stringify(value)),
  );
}
