// What can be done with the map.
import { effect, signal } from "@preact/signals-core";
import type { Studio } from "../core/studio";
import { kMapLayers, mapLayers, type MapLayer } from "../view3d/settings";

/** How many maps are seen. */
export const openMaps = signal(0);
export const mapRequest = signal<{ what: "fit" | "focus" | "nearer" | "farther" } | null>(null);

const kLayerLabels: Record<MapLayer, string> = {
  rays: "Rays of Sensors",
  trails: "Trajectories",
  names: "Names",
  regions: "Regions",
};

export function registerCommands(studio: Studio): void {
  const { commands } = studio;
  const add = (what: NonNullable<typeof mapRequest.value>["what"], label: string) =>
    commands.addCommand(`map:${what}`, {
      label,
      execute: () => {
        if (openMaps.peek() === 0) studio.openPanel("map");
        mapRequest.value = { what };
      },
    });
  add("fit", "Map: Show Everything");
  add("focus", "Map: Focus the Selection");
  add("nearer", "Map: Zoom in");
  add("farther", "Map: Zoom out");
  for (const name of kMapLayers) {
    commands.addCommand(`map:${name}`, {
      label: `Map: Show ${kLayerLabels[name]}`,
      isToggleable: true,
      isToggled: () => mapLayers[name].value,
      execute: () => {
        mapLayers[name].value = !mapLayers[name].peek();
      },
    });
  }
  effect(() => {
    for (const name of kMapLayers) {
      void mapLayers[name].value;
      if (commands.hasCommand(`map:${name}`)) commands.notifyCommandChanged(`map:${name}`);
    }
  });
}
