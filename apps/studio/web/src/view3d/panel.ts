import { Widget } from "@lumino/widgets";
import type { PanelType, Studio } from "../core/studio";

export const panel: PanelType = {
  name: "view3d",
  title: "3D",
  create(_studio: Studio): Widget {
    return new Widget();
  },
};

/** Adds the panel's commands; called once, before any panel is made. */
export function register(_studio: Studio): void {}
