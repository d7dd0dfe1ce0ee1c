// The panel of joints and motors, and its commands.
import type { Widget } from "@lumino/widgets";
import { effect } from "@preact/signals-core";
import { h } from "preact";
import type { PanelType, Studio } from "../core/studio";
import { PreactWidget } from "../forms/preact_widget";
import { Subscription } from "../view3d/subscription";
import { HandStore } from "./store";
import { HandsView } from "./view";
import "./hands.css";

/** Frames have the numbers of joints and motors while the panel is there. */
class HandsWidget extends PreactWidget {
  constructor(private readonly studio: Studio) {
    super(() => h(HandsView, { store: studio.services.get(HandStore) }));
    this.addClass("cg-hands");
  }
  private need(joints: boolean): void {
    this.studio.services.get(Subscription).set("joints", { readings: false, contacts: false, joints });
  }
  protected override onAfterAttach(): void {
    super.onAfterAttach();
    this.need(true);
  }
  protected override onBeforeDetach(): void {
    this.need(false);
    super.onBeforeDetach();
  }
}

export const panel: PanelType = {
  name: "joints",
  title: "Joints",
  create: (studio: Studio): Widget => new HandsWidget(studio),
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
