import type { Widget } from "@lumino/widgets";
import { h } from "preact";
import type { PanelType, Studio } from "../core/studio";
import { PreactWidget } from "./preact_widget";
import { Properties } from "./properties";
import "./forms.css";

export const panel: PanelType = {
  name: "properties",
  title: "Properties",
  create(studio: Studio): Widget {
    const widget = new PreactWidget(() => h(Properties, { studio }));
    widget.addClass("cg-properties-panel");
    return widget;
  },
};

/** Adds the panel's commands; called once, before any panel is made. */
export function register(_studio: Studio): void {}
