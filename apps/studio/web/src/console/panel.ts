import { effect } from "@preact/signals-core";
import { Widget } from "@lumino/widgets";
import type { PanelType, Studio } from "../core/studio";
import { countWrong } from "./lines";
import { showConsole } from "./view";

export const panel: PanelType = {
  name: "console",
  title: "Console",
  create(studio: Studio): Widget {
    const widget = new Widget();
    widget.addClass("cg-console");
    showConsole(studio, widget.node);
    const { problems, messages } = studio.state;
    effect(() => {
      const wrong = countWrong(problems.value, messages.value);
      // the shell sets the title once the widget is made
      queueMicrotask(() => (widget.title.label = wrong > 0 ? `Console (${wrong})` : "Console"));
    });
    return widget;
  },
};

export function register(_studio: Studio): void {}
