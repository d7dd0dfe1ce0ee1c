import type { Widget } from "@lumino/widgets";
import { h } from "preact";
import { register_insert_commands } from "../add/commands";
import { register_robot_commands } from "../add/robots";
import type { PanelType, Studio } from "../core/studio";
import { PreactWidget } from "../forms/preact_widget";
import { register_edit_commands } from "./commands";
import { TreePanel } from "./tree_panel";
import { tree_model } from "./view";
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
  register_edit_commands(studio);
  register_insert_commands(studio);
  register_robot_commands(studio);
  studio.commands.addCommand("tree:show-signals", {
    label: "Signals in the tree",
    execute: (args) => tree_model(studio).toggle_signals(args.element as number),
    isVisible: (args) => args.element !== undefined,
  });
}
