import { Widget } from "@lumino/widgets";
import { h, render } from "preact";
import type { PanelType, Studio } from "../core/studio";
import "./cameras.css";
import { CameraStore } from "./store";
import { CameraList, CameraWindows } from "./view";

/** The list of cameras; while it is open their windows float over the page. */
class CamerasWidget extends Widget {
  private layer: HTMLElement | null = null;
  private readonly see = (): void => {
    this.store.seen.value = this.layer !== null && !this.layer.ownerDocument.hidden;
  };

  constructor(private readonly store: CameraStore) {
    super();
    this.addClass("cg-cameras");
    render(h(CameraList, { store }), this.node);
  }
  override dispose(): void {
    if (this.isDisposed) return;
    super.dispose();
    render(null, this.node);
  }
  protected override onAfterAttach(): void {
    // a panel may be in a window of its own
    const page = this.node.ownerDocument;
    this.layer = page.createElement("div");
    this.layer.className = "cg-camera-layer";
    page.body.append(this.layer);
    page.addEventListener("visibilitychange", this.see);
    render(h(CameraWindows, { store: this.store }), this.layer);
    this.see();
  }
  protected override onBeforeDetach(): void {
    if (!this.layer) return;
    this.layer.ownerDocument.removeEventListener("visibilitychange", this.see);
    render(null, this.layer);
    this.layer.remove();
    this.layer = null;
    this.see();
  }
}

export const panel: PanelType = {
  name: "cameras",
  title: "Cameras",
  create(studio: Studio): Widget {
    return new CamerasWidget(studio.services.get(CameraStore));
  },
};

/** Adds the panel's commands; called once, before any panel is made. */
export function register(studio: Studio): void {
  const store = studio.services.get(CameraStore);
  const names = (): string[] => store.cameras.value.map((c) => c.name);
  studio.commands.addCommand("cameras:show-all", {
    label: "Show all cameras",
    isEnabled: () => names().length > 0,
    execute: () => {
      studio.openPanel("cameras");
      store.show(names(), true);
    },
  });
  studio.commands.addCommand("cameras:hide-all", {
    label: "Hide all cameras",
    isEnabled: () => store.open.value.length > 0,
    execute: () => store.show(names(), false),
  });
}
