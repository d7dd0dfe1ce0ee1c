// What can be done with the map.
import { effect, signal } from "@preact/signals-core";
import type { Studio } from "../core/studio";
import { MAP_LAYERS, map_layers, type MapLayer } from "../view3d/settings";

/** How many maps are seen. */
export const open_maps = signal(0);
export const map_request = signal<{ what: "fit" | "focus" | "nearer" | "farther" } | null>(null);

const LAYER_LABELS: Record<MapLayer, string> = {
  rays: "Rays of Sensors",
  trails: "Trajectories",
  names: "Names",
  regions: "Regions",
};

export function register_commands(studio: Studio): void {
  const { commands } = studio;
  const add = (what: NonNullable<typeof map_request.value>["what"], label: string) =>
    commands.addCommand(`map:${what}`, {
      label,
      execute: () => {
        if (open_maps.peek() === 0) studio.open_panel("map");
        map_request.value = { what };
      },
    });
  add("fit", "Map: Show Everything");
  add("focus", "Map: Focus the Selection");
  add("nearer", "Map: Zoom in");
  add("farther", "Map: Zoom out");
  for (const name of MAP_LAYERS) {
    commands.addCommand(`map:${name}`, {
      label: `Map: Show ${LAYER_LABELS[name]}`,
      isToggleable: true,
      isToggled: () => map_layers[name].value,
      execute: () => {
        map_layers[name].value = !map_layers[name].peek();
      },
    });
  }
  effect(() => {
    for (const name of MAP_LAYERS) {
      map_layers[name].value;
      if (commands.hasCommand(`map:${name}`)) commands.notifyCommandChanged(`map:${name}`);
    }
  });
}
