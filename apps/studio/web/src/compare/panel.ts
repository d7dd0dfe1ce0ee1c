import type { Message } from "@lumino/messaging";
import { Widget } from "@lumino/widgets";
import { h, render } from "preact";
import "uplot/dist/uPlot.min.css";
import type { PanelType, Studio } from "../core/studio";
import "../figures/figures.css";
import "./compare.css";
import { compare_of, type CompareStore } from "./store";
import { CompareView } from "./view";

class CompareWidget extends Widget {
  private readonly see = (): void => {
    this.store.seen.value = this.isVisible && !this.node.ownerDocument.hidden;
  };

  constructor(private readonly store: CompareStore) {
    super();
    this.addClass("cg-compare");
    render(h(CompareView, { store }), this.node);
  }
  override dispose(): void {
    if (this.isDisposed) return;
    this.store.seen.value = false;
    super.dispose();
    render(null, this.node);
  }
  protected override onAfterAttach(_message: Message): void {
    this.node.ownerDocument.addEventListener("visibilitychange", this.see);
    this.see();
  }
  protected override onBeforeDetach(_message: Message): void {
    this.node.ownerDocument.removeEventListener("visibilitychange", this.see);
    this.store.seen.value = false;
  }
  protected override onAfterShow(_message: Message): void {
    this.see();
  }
  protected override onAfterHide(_message: Message): void {
    this.see();
  }
}

export const panel: PanelType = {
  name: "compare",
  title: "Compare",
  create(studio: Studio): Widget {
    return new CompareWidget(compare_of(studio));
  },
};

/** Adds the panel's commands; called once, before any panel is made. */
export function register(studio: Studio): void {
  const store = compare_of(studio);
  const { commands, state } = studio;
  commands.addCommand("compare:backends", {
    label: "Compare with another backend…",
    isEnabled: () => state.may_edit.value && store.others.value.length > 0,
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
    isEnabled: () => state.may_edit.value,
    execute: async () => {
      const dt = store.step.value;
      const answer = await studio.dialog({
        title: "Compare two time steps",
        text: "The same backend runs a second time, both from time 0. Half the step shows how much of the result is the step's.",
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
      else studio.notify(`'${answer.step}' is no time step: above 0 and not above 1000 ms`, "error");
    },
  });
  commands.addCommand("compare:off", {
    label: "End the comparison",
    isEnabled: () => state.may_edit.value && store.labels.value !== null,
    execute: () => store.off(),
  });
}
