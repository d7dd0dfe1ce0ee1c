// The panel of the scene's tests, and its commands.
import type { Widget } from "@lumino/widgets";
import { effect } from "@preact/signals-core";
import { h } from "preact";
import type { PanelType, Studio } from "../core/studio";
import { JointsWidget } from "../hands/joints_widget";
import { TestStore } from "./store";
import { TestsView } from "./view";
import "./tests.css";

export const panel: PanelType = {
  name: "tests",
  title: "Tests",
  create: (studio: Studio): Widget => {
    // joints, as tests can be made of them
    const widget = new JointsWidget(studio, "tests", () => h(TestsView, { store: studio.services.get(TestStore) }));
    widget.addClass("cg-tests");
    return widget;
  },
};

/** Adds the panel's commands; called once, before any panel is made. */
export function register(studio: Studio): void {
  const { commands, services } = studio;
  const store = services.get(TestStore);
  commands.addCommand("tools:run-tests", {
    label: "Run the Scene's Tests",
    caption: "On the engines that are chosen in the panel Tests",
    isEnabled: () => store.mayRun.value && store.tests.value.length > 0,
    execute: () => {
      studio.openPanel("tests");
      return store.start(null);
    },
  });
  commands.addCommand("tools:make-test", {
    label: "Make a Test of What I See",
    caption: "Of the selected body or joint, as it is at the shown time",
    isEnabled: () => studio.state.mayEdit.value && studio.state.selection.value.length > 0,
    execute: () => {
      studio.openPanel("tests");
      return store.make();
    },
  });
  effect(() => {
    void store.mayRun.value;
    void store.tests.value;
    void studio.state.selection.value;
    for (const id of ["tools:run-tests", "tools:make-test"]) commands.notifyCommandChanged(id);
  });
}
