import type { Widget } from "@lumino/widgets";
import { h } from "preact";
import "uplot/dist/uPlot.min.css";
import { SeenWidget } from "../core/seen_widget";
import type { PanelType, Studio } from "../core/studio";
import "../figures/figures.css";
import "./compare.css";
import { CompareStore } from "./store";
import { CompareView } from "./view";

export const panel: PanelType = {
  name: "compare",
  title: "Compare",
  create(studio: Studio): Widget {
    const store = studio.services.get(CompareStore);
    return new SeenWidget("cg-compare", h(CompareView, { store }), store.seen);
  },
};

/** Adds the panel's commands; called once, before any panel is made. */
export function register(studio: Studio): void {
  const store = studio.services.get(CompareStore);
  const { commands, state } = studio;
  commands.addCommand("compare:backends", {
    label: "Compare with another backend…",
    isEnabled: () => state.mayEdit.value && store.others.value.length > 0,
    execute: async () => {
      const others = store.others.value;
      if (others.length === 1) return store.compare({ backend: others[0]! });
      const answer = await studio.dialog({
        title: "Compare with another backend",
        text: "Both runs begin at time 0, in lockstep.",
        fields: [{ name: "backend", label: "Backend", kind: "choice", choices: others, value: others[0] }],
        accept: "Compare",
      });
      if (answer?.backend) await store.compare({ backend: answer.backend });
    },
  });
  commands.addCommand("compare:step", {
    label: "Compare two time steps…",
    isEnabled: () => state.mayEdit.value,
    execute: async () => {
      const dt = store.step.value;
      const answer = await studio.dialog({
        title: "Compare two time steps",
        text: "The same backend runs a second time, both from time 0. With half the step the difference shows the error of the time step.",
        fields: [
          {
            name: "step",
            label: "Other time step [ms]",
            kind: "number",
            value: dt === null ? "" : String(Number((dt * 500).toPrecision(6))),
          },
        ],
        accept: "Compare",
      });
      if (!answer) return;
      const step = Number(answer.step) / 1000;
      if (step > 0 && step <= 1) await store.compare({ step });
      else studio.notify(`'${answer.step}' is not a time step: above 0 and not above 1000 ms`, "error");
    },
  });
  commands.addCommand("compare:off", {
    label: "End the comparison",
    isEnabled: () => state.mayEdit.value && store.labels.value !== null,
    execute: () => store.off(),
  });
}
