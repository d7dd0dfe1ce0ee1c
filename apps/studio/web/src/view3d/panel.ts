// The panel of the 3D view. What draws is loaded when it is first shown.
import { effect } from "@preact/signals-core";
import { Widget } from "@lumino/widgets";
import type { PanelType, Studio } from "../core/studio";
import { registerCommands } from "./commands";
import { openViews, kOverlays } from "./settings";
import { fillTools, menuButton, observe, openContextMenu, toolbar } from "./tools";
import type { View3d } from "./view";
import "./view3d.css";

class View3dWidget extends Widget {
  private readonly host: HTMLElement;
  private readonly notes: HTMLElement;
  private readonly texts = new Map<string, string>();
  private view: View3d | null = null;
  private loading = false;
  private readonly stops: (() => void)[] = [];

  constructor(private readonly studio: Studio) {
    super();
    this.addClass("cg-view");
    const { ownerDocument: document } = this.node;
    const row = toolbar(document, "Views, handles and overlays");
    this.stops.push(
      fillTools(studio, row, [
        [
          { command: "view:front", text: "Front" },
          { command: "view:back", text: "Back" },
          { command: "view:left", text: "Left" },
          { command: "view:right", text: "Right" },
          { command: "view:top", text: "Top" },
          { command: "view:bottom", text: "Bottom" },
          { command: "view:iso", text: "Iso" },
        ],
        [
          { command: "view:fit", text: "Fit" },
          { command: "view:focus", text: "Focus" },
          { command: "view:follow", text: "Follow" },
        ],
        [
          { command: "handles:move", text: "Move" },
          { command: "handles:rotate", text: "Rotate" },
          { command: "handles:local", text: "Local" },
          { command: "handles:snap", text: "Snap" },
        ],
      ]),
    );
    menuButton(
      studio,
      row,
      "Show",
      "Overlays of the scene",
      kOverlays.map((name) => `overlay:${name}`),
    );
    this.host = document.createElement("div");
    this.host.className = "cg-view-host";
    this.host.tabIndex = 0;
    this.host.setAttribute("role", "application");
    this.host.setAttribute("aria-label", "3D view. Shift and arrows turn it, Page Up and Page Down zoom");
    this.notes = document.createElement("div");
    this.notes.className = "cg-view-note";
    this.notes.setAttribute("role", "status");
    this.notes.hidden = true;
    const stage = document.createElement("div");
    stage.className = "cg-view-stage";
    stage.append(this.host, this.notes);
    this.node.append(row, stage);
  }

  private note(matter: string, text: string): void {
    if ((this.texts.get(matter) ?? "") === text) return;
    this.texts.set(matter, text);
    const all = [...this.texts.values()].filter(Boolean);
    this.notes.textContent = all.join(" \u00b7 ");
    this.notes.hidden = all.length === 0;
  }

  protected override onAfterAttach(): void {
    if (this.view || this.loading) return;
    this.loading = true;
    void this.load();
  }

  private async load(): Promise<void> {
    const { View3d } = await import("./view");
    if (this.isDisposed) return;
    this.view = new View3d(this.studio, {
      host: this.host,
      note: (matter, text) => this.note(matter, text),
      contextMenu: (event) =>
        openContextMenu(this.studio, event.clientX, event.clientY, ["view:focus", "view:follow", "view:fit"]),
    });
    const resize = () => this.view?.setSize(this.host.clientWidth, this.host.clientHeight);
    const look = (now: boolean) => {
      openViews.value += now ? 1 : -1;
      this.view?.setVisible(now);
    };
    this.stops.push(
      observe(this.host, resize, look),
      effect(() => {
        const { scene } = this.studio.state;
        this.host.toggleAttribute("aria-busy", scene.value === null);
      }),
    );
  }

  override dispose(): void {
    if (this.isDisposed) return;
    for (const stop of this.stops) stop();
    this.view?.dispose();
    super.dispose();
  }
}

export const panel: PanelType = {
  name: "view3d",
  title: "3D",
  create(studio: Studio): Widget {
    return new View3dWidget(studio);
  },
};

/** Adds the panel's commands; called once, before any panel is made. */
export function register(studio: Studio): void {
  registerCommands(studio);
}
