// Short notes at the edge of the window. Errors stay until they are closed.

const kNoteTime = 5_000; // [ms]
const kMost = 5;

export class Notices {
  readonly node = document.createElement("div");
  private readonly polite = liveArea("polite");
  private readonly urgent = liveArea("assertive");

  constructor() {
    this.node.className = "cg-notices";
    this.node.setAttribute("role", "region");
    this.node.setAttribute("aria-label", "Notifications");
    document.body.append(this.node, this.polite, this.urgent);
  }

  show(text: string, kind: "note" | "error"): void {
    // A repeated text is shown once, as the newest.
    for (const other of [...this.node.children] as HTMLElement[]) if (other.dataset.text === text) other.remove();
    const note = document.createElement("div");
    note.className = `cg-notice cg-notice-${kind}`;
    note.dataset.text = text;
    note.dataset.testid = `notice-${kind}`;
    const message = document.createElement("span");
    message.textContent = text;
    const close = document.createElement("button");
    close.textContent = "✕";
    close.setAttribute("aria-label", "Close notification");
    close.addEventListener("click", () => note.remove());
    note.append(message, close);
    this.node.append(note);
    while (this.node.children.length > kMost) this.node.firstElementChild?.remove();
    (kind === "error" ? this.urgent : this.polite).textContent = text;
    if (kind === "note") setTimeout(() => note.remove(), kNoteTime);
  }
}

function liveArea(how: "polite" | "assertive"): HTMLElement {
  const area = document.createElement("div");
  area.className = "cg-unseen";
  area.setAttribute("aria-live", how);
  return area;
}
