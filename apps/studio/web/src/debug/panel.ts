// The panel of the debugger, and its commands.
import type { Widget } from "@lumino/widgets";
import { effect } from "@preact/signals-core";
import { h } from "preact";
import type { PanelType, Studio } from "../core/studio";
import { PreactWidget } from "../forms/preact_widget";
import { DebugStore, type How } from "./store";
import { DebugView } from "./view";
import "./debug.css";

export const panel: PanelType = {
  name: "debug",
  title: "Debug",
  create(studio: Studio): Widget {
    const widget = new PreactWidget(() => h(DebugView, { store: studio.services.get(DebugStore), studio }));
    widget.addClass("cg-debug");
    return widget;
  },
};

const kRuns: [How, string][] = [
  ["continue", "Continue the controller"],
  ["pause", "Pause the controller"],
  ["over", "Step over"],
  ["into", "Step into"],
  ["out", "Step out"],
];

/** Adds the panel's commands; called once, before any panel is made. */
export function register(studio: Studio): void {
  const { commands, services } = studio;
  const store = services.get(DebugStore);
  for (const [how, label] of kRuns) {
    commands.addCommand(`debug:${how}`, {
      label,
      isVisible: () => store.mayDebug.value,
      isEnabled: () =>
        store.mayDebug.value && (how === "pause" ? store.now.value?.state === "running" : store.stands.value),
      execute: () => store.run(how),
    });
  }
  commands.addCommand("debug:detach", {
    label: "End debugging",
    isVisible: () => store.mayDebug.value,
    isEnabled: () => store.mayDebug.value && (store.now.value?.state ?? "off") !== "off",
    execute: () => store.detach(),
  });
  effect(() => {
    void store.mayDebug.value;
    void store.now.value;
    commands.notifyCommandChanged();
  });
}
