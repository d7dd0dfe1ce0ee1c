import type { Widget } from "@lumino/widgets";
import { h } from "preact";
import "uplot/dist/uPlot.min.css";
import { SeenWidget } from "../core/seen_widget";
import type { PanelType, Studio } from "../core/studio";
import type { FigureKind } from "./figure";
import "./figures.css";
import type { FileKind } from "./save";
import { FiguresStore } from "./store";
import { exportFigure, FiguresView } from "./view";

export const panel: PanelType = {
  name: "figures",
  title: "Figures",
  create(studio: Studio): Widget {
    const store = studio.services.get(FiguresStore);
    return new SeenWidget("cg-figures", h(FiguresView, { store }), store.seen);
  },
};

/** Draws a signal: in the figure of that title, else in a new one. */
function drawSignal(store: FiguresStore, signal: string, figure: string): void {
  const there = figure === "" ? undefined : store.specs.value.find((s) => s.title === figure && !s.plot);
  if (there) store.addSignal(there.id, signal);
  else store.add("curve", [signal], figure);
}

/** Adds the panel's commands; called once, before any panel is made. */
export function register(studio: Studio): void {
  const store = studio.services.get(FiguresStore);
  const { commands } = studio;
  const make = (id: string, label: string, kind: FigureKind): void =>
    void commands.addCommand(`figures:${id}`, {
      label,
      execute: ({ signals }) => {
        studio.openPanel("figures");
        store.add(kind, Array.isArray(signals) ? signals.map(String) : []);
      },
    });
  make("new-curve", "New figure: curves", "curve");
  make("new-box", "New figure: box plot", "box");
  make("new-histogram", "New figure: histogram", "histogram");
  make("new-surface", "New figure: surface", "surface");
  make("new-path", "New figure: path", "map");
  for (const kind of ["png", "svg", "csv"] as FileKind[])
    commands.addCommand(`figures:export-${kind}`, {
      label: `Save figure as ${kind.toUpperCase()}`,
      isEnabled: () => store.active.value >= 0,
      execute: () => exportFigure(store, store.active.value, kind),
    });
  commands.addCommand("figures:draw", {
    label: "Draw a signal",
    isVisible: () => false,
    execute: ({ signal, figure }) => drawSignal(store, String(signal), typeof figure === "string" ? figure : ""),
  });
}
