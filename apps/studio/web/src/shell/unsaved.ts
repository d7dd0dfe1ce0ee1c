// Unsaved changes: offered when the studio kept earlier ones, and as a download while there is no studio.
import { effect, signal } from "@preact/signals-core";
import { PendingTyping } from "../code/pending";
import type { DocumentState, UnsavedOffer } from "../core/protocol";
import { download } from "./download";
import type { Shell } from "./shell";

interface Lost {
  text: string;
  file: string;
}

/** Whether the studio that is there now has less than the page had when the last one went: not even to offer. */
export function hasLess(lost: Lost | null, now: DocumentState, offer: UnsavedOffer | null): boolean {
  return lost !== null && offer === null && !now.dirty && now.file === lost.file && now.text !== lost.text;
}

/** "24/11/2026, 10:05", as the user writes it. */
function when(time: number): string {
  return new Date(1000 * time).toLocaleString([], { dateStyle: "short", timeStyle: "short" });
}

export class UnsavedBar {
  readonly node = document.createElement("div");
  /** the page's text when the connection broke, as long as no studio has it */
  private readonly lost = signal<Lost | null>(null);
  private readonly less = signal(false);

  constructor(private readonly shell: Shell) {
    this.node.className = "cg-unsaved";
    this.node.dataset.testid = "unsaved";
    this.node.setAttribute("role", "region");
    this.node.setAttribute("aria-label", "Unsaved changes");
    const { state } = shell;
    shell.link.onOpen((open) => {
      if (open || this.lost.peek()) return;
      const text = state.document.peek();
      const typed = shell.services.get(PendingTyping).unsent;
      if (text && state.hello.peek()?.kind === "scene" && (text.dirty || typed)) {
        this.lost.value = { text: shell.services.get(PendingTyping).text ?? text.text, file: text.file };
      }
    });
    // It comes right behind the text, of every studio that the page meets.
    shell.link.on("unsaved", ({ offer }) => {
      const text = state.document.peek();
      this.less.value = text !== null && hasLess(this.lost.peek(), text, offer);
      if (!this.less.value) this.lost.value = null;
    });
    effect(() => this.show());
  }

  /** The button for a download while there is no studio; null: the page has no unsaved changes. */
  downloadButton(): HTMLElement | null {
    const lost = this.lost.value;
    return (
      lost && this.button("Download my text", () => download(new Blob([lost.text], { type: "text/xml" }), lost.file))
    );
  }

  private show(): void {
    const { state } = this.shell;
    const unsaved = state.unsaved.value;
    const file = state.document.value?.file ?? "";
    const rows: HTMLElement[] = [];
    if (state.mayEdit.value && unsaved) {
      const { offer } = unsaved;
      if (offer) {
        const more =
          offer.more > 0 ? ` There ${offer.more === 1 ? "is one" : `are ${offer.more}`} more from before.` : "";
        const changed = offer.changed ? " The file has been changed since." : "";
        rows.push(
          this.row(
            `${file} has changes of ${when(offer.time)} that were not saved.${changed}${more}`,
            this.button("Restore", () => this.ask("restore", offer.number)),
            this.button("Download", () => this.ask("unsaved", offer.number)),
            this.button("Discard…", () => this.discard(offer.number)),
          ),
        );
      }
      const lost = this.lost.value;
      if (this.less.value && lost) {
        rows.push(
          this.row(
            `The studio was restarted, and does not have this page's changes of ${file}.`,
            this.button("Take over", () => this.takeOver(lost.text)),
            this.downloadButton()!,
            this.button("Forget", () => this.forget()),
          ),
        );
      }
      if (unsaved.not_kept) {
        rows.push(
          this.row(
            `Unsaved changes would be lost with the studio, because they cannot be kept beside the scene: ${unsaved.not_kept}`,
          ),
        );
      }
    }
    this.node.hidden = rows.length === 0;
    this.node.replaceChildren(...rows);
  }

  private row(text: string, ...buttons: HTMLElement[]): HTMLElement {
    const row = document.createElement("div");
    const message = document.createElement("span");
    message.textContent = text;
    row.append(message, ...buttons);
    return row;
  }
  private button(text: string, act: () => unknown): HTMLElement {
    const button = document.createElement("button");
    button.textContent = text;
    button.addEventListener("click", () => void act());
    return button;
  }

  private async ask(what: "unsaved" | "restore" | "discard", number: number): Promise<void> {
    try {
      if (what === "unsaved") {
        const { text } = await this.shell.link.request(what, { number });
        download(new Blob([text], { type: "text/xml" }), this.shell.state.document.peek()?.file ?? "scene.xml");
      } else {
        await this.shell.link.request(what, { number });
      }
    } catch (error) {
      this.shell.fail(error);
    }
  }
  private async discard(number: number): Promise<void> {
    const answer = await this.shell.dialog({
      title: "Discard",
      text: "The unsaved changes will be lost.",
      fields: [],
      accept: "Discard",
    });
    if (answer) await this.ask("discard", number);
  }
  private async takeOver(text: string): Promise<void> {
    try {
      const version = this.shell.state.document.peek()?.version;
      if (version === undefined) return; // no document to take it over
      await this.shell.link.request("set-text", { version, text });
      this.forget();
    } catch (error) {
      this.shell.fail(error);
    }
  }
  private forget(): void {
    this.lost.value = null;
    this.less.value = false;
  }
}
