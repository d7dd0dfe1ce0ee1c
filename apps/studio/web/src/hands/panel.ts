// The panel of joints and motors, and its commands.
import type { Widget } from "@lumino/widgets";
import { effect } from "@preact/signals-core";
import { h } from "preact";
import type { PanelType, Studio } from "../core/studio";
import { JointsWidget } from "./joints_widget";
import { HandStore } from "./store";
import { HandsView } from "./view";
import "./hands.css";

export const panel: PanelType = {
  name: "joints",
  title: "Joints",
  create: (studio: Studio): Widget => {
    const widget = new JointsWidget(studio, "joints", () => h(HandsView, { store: studio.services.get(HandStore) }));
    widget.addClass("cg-hands");
    return widget;
  },
};

/** Adds the panel's commands; called once, before any panel is made. */
export function register(studio: Studio): void {
  const { commands, services } = studio;
  const store = services.get(HandStore);
  commands.addCommand("run:repeat", {
    label: "Repeat What Was Done by Hand",
    caption: "From the start, with the same motor targets and pulls at the same steps: the same states come again",
    isEnabled: () => store.mayDrive.value && store.any.value,
    execute: () => store.repeat(),
  });
  effect(() => {
    void store.mayDrive.value;
    void store.any.value;
    commands.notifyCommandChanged("run:repeat");
  });
}
