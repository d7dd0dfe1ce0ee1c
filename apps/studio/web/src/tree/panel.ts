import type { Widget } from "@lumino/widgets";
import { h } from "preact";
import { registerInsertCommands } from "../add/commands";
import { registerRobotCommands } from "../add/robots";
import type { PanelType, Studio } from "../core/studio";
import { PreactWidget } from "../forms/preact_widget";
import { registerEditCommands } from "./commands";
import { TreePanel } from "./tree_panel";
import { TreeModel } from "./tree_model";
import "./tree.css";

export const panel: PanelType = {
  name: "tree",
  title: "Scene",
  create(studio: Studio): Widget {
    const widget = new PreactWidget(() => h(TreePanel, { studio }));
    widget.addClass("cg-tree-panel");
    return widget;
  },
};

/** Adds the panel's commands; called once, before any panel is made. */
export function register(studio: Studio): void {
  registerEditCommands(studio);
  registerInsertCommands(studio);
  registerRobotCommands(studio);
  studio.commands.addCommand("tree:show-signals", {
    label: "Signals in the tree",
    execute: (args) => studio.services.get(TreeModel).toggleSignals(args.element as number),
    isVisible: (args) => args.element !== undefined,
  });
}
