// What is drawn over the scene: a list of switches that stays open while one looks at what they do.
import { effect } from "@preact/signals-core";
import type { Studio } from "../core/studio";
import { iconOf } from "./icons";
import { kOverlayLabels, kOverlays, overlays, overlaysOpen } from "./settings";

/** A button, and the list that it opens below `list`. Returns what ends both. */
export function overlayPanel(studio: Studio, tools: HTMLElement, list: HTMLElement): () => void {
  const { ownerDocument: document } = tools;
  const button = document.createElement("button");
  button.type = "button";
  button.className = "cg-over-tool";
  button.title = "What is shown over the scene";
  button.setAttribute("aria-label", "Overlays of the scene");
  button.append(iconOf(document, "show"));
  button.addEventListener("click", () => (overlaysOpen.value = !overlaysOpen.peek()));
  tools.append(button);

  const panel = document.createElement("fieldset");
  panel.className = "cg-over-list";
  const legend = document.createElement("legend");
  legend.textContent = "Show";
  panel.append(legend);
  const boxes = kOverlays.map((name) => {
    const label = document.createElement("label");
    const box = document.createElement("input");
    box.type = "checkbox";
    box.addEventListener("change", () => void studio.commands.execute(`overlay:${name}`));
    label.append(box, kOverlayLabels[name]);
    panel.append(label);
    return { box, name };
  });
  panel.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    event.stopPropagation();
    overlaysOpen.value = false;
    button.focus();
  });
  list.append(panel);
  const stop = effect(() => {
    for (const { box, name } of boxes) box.checked = overlays[name].value;
    panel.hidden = !overlaysOpen.value;
    button.setAttribute("aria-expanded", String(overlaysOpen.value));
  });
  return stop;
}
