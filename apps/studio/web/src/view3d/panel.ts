// The panel of the 3D view. What draws is loaded when it is first shown.
import { effect } from "@preact/signals-core";
import { Widget } from "@lumino/widgets";
import type { PanelType, Studio } from "../core/studio";
import { registerCommands } from "./commands";
import { overlayPanel } from "./overlay_panel";
import { openViews, viewRequest } from "./settings";
import { fillTools, observe, openContextMenu, toolbar } from "./tools";
import type { View3d } from "./view";
import { ViewCube } from "./view_cube";
import "./view3d.css";

class View3dWidget extends Widget {
  private readonly host: HTMLElement;
  private readonly notes: HTMLElement;
  private readonly measure: HTMLElement;
  private readonly cube: ViewCube;
  private readonly texts = new Map<string, string>();
  private view: View3d | null = null;
  private loading = false;
  private readonly stops: (() => void)[] = [];

  constructor(private readonly studio: Studio) {
    super();
    this.addClass("cg-view");
    const { ownerDocument: document } = this.node;
    this.host = document.createElement("div");
    this.host.className = "cg-view-host";
    this.host.tabIndex = 0;
    this.host.setAttribute("role", "application");
    this.host.setAttribute("aria-label", "3D view. Shift and arrows turn it, Page Up and Page Down zoom");
    this.notes = document.createElement("div");
    this.notes.className = "cg-view-note";
    this.notes.setAttribute("role", "status");
    this.notes.hidden = true;
    this.measure = document.createElement("output");
    this.measure.className = "cg-view-measure";
    this.measure.hidden = true;
    const stage = document.createElement("div");
    stage.className = "cg-view-stage";
    this.cube = new ViewCube(document, (what) => (viewRequest.value = { what }));
    stage.append(this.host, ...this.tools(document), this.measure, this.notes);
    this.node.append(stage);
  }

  /** Over the picture: handles on the left, views on the right. */
  private tools(document: Document): HTMLElement[] {
    const handles = toolbar(document, "Handles");
    handles.className = "cg-over cg-over-left";
    const views = toolbar(document, "Views and overlays");
    views.className = "cg-over cg-over-right";
    const side = document.createElement("div");
    side.className = "cg-over-side";
    side.append(this.cube.element, views);
    this.stops.push(
      fillTools(this.studio, handles, [
        [
          { command: "handles:move", text: "Move", icon: "move" },
          { command: "handles:rotate", text: "Rotate", icon: "rotate" },
          { command: "handles:resize", text: "Resize", icon: "resize" },
          { command: "handles:grab", text: "Grab", icon: "grab" },
        ],
        [
          { command: "handles:local", text: "Local", icon: "local" },
          { command: "handles:snap", text: "Snap", icon: "snap" },
        ],
      ]),
      fillTools(this.studio, views, [
        [
          { command: "view:iso", text: "Iso", icon: "home" },
          { command: "view:fit", text: "Fit", icon: "fit" },
          { command: "view:focus", text: "Focus", icon: "focus" },
          { command: "view:follow", text: "Follow", icon: "follow" },
          { command: "view:orthographic", text: "Orthographic", icon: "flat" },
        ],
      ]),
      overlayPanel(this.studio, views, side),
    );
    return [handles, side];
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
      measure: (text) => {
        this.measure.textContent = text;
        this.measure.hidden = text === "";
      },
      turned: (camera) => this.cube.update(camera),
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
