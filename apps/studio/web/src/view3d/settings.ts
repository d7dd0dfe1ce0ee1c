// Settings of overlays and handles; stored by the browser.
import { signal, type Signal } from "@preact/signals-core";
import type { Pose, Vec3 } from "../core/protocol";
import type { ViewName } from "./views";

export const kOverlays = [
  "grid",
  "rays",
  "contacts",
  "joints",
  "forces",
  "frames",
  "centres",
  "trails",
  "regions",
  "names",
] as const;
type OverlayName = (typeof kOverlays)[number];

export const kOverlayLabels: Record<OverlayName, string> = {
  grid: "Grid",
  rays: "Rays of Sensors",
  contacts: "Contacts",
  joints: "Joint Axes",
  forces: "Forces and Springs",
  frames: "Frames of Bodies",
  centres: "Centres of Mass",
  trails: "Trajectories",
  regions: "Regions",
  names: "Names",
};

export const kMapLayers = ["rays", "trails", "names", "regions"] as const;
export type MapLayer = (typeof kMapLayers)[number];

/** A handle is being dragged. */
export const dragging = signal(false);

/** Poses that are shown instead of those of the frame, until the scene comes that has them; null: none. */
export const preview = signal<ReadonlyMap<number, Pose> | null>(null);

export type HandleMode = "off" | "move" | "rotate" | "resize" | "grab";

const remembered = <T extends boolean | string>(name: string, otherwise: T): Signal<T> => {
  const key = `cogrsim.view.${name}`;
  let value = otherwise;
  try {
    const stored = JSON.parse(globalThis.localStorage?.getItem(key) ?? "null") as unknown;
    if (typeof stored === typeof otherwise) value = stored as T;
  } catch {
    // a browser that stores nothing: the settings hold for this visit
  }
  const made = signal(value);
  let first = true;
  made.subscribe((now) => {
    if (first) {
      first = false;
      return;
    }
    try {
      globalThis.localStorage?.setItem(key, JSON.stringify(now));
    } catch {
      // as above
    }
  });
  return made;
};

const kShownAtFirst = new Set<OverlayName>(["grid", "rays", "forces"]);
export const overlays = Object.fromEntries(
  kOverlays.map((name) => [name, remembered<boolean>(`overlay.${name}`, kShownAtFirst.has(name))]),
) as Record<OverlayName, Signal<boolean>>;

export const overlaysOpen = remembered<boolean>("overlays.open", false);
/** Without perspective: what is parallel stays parallel. */
export const orthographic = remembered<boolean>("orthographic", false);

export const mapLayers = Object.fromEntries(
  kMapLayers.map((name) => [name, remembered<boolean>(`map.${name}`, true)]),
) as Record<MapLayer, Signal<boolean>>;

export const handleMode = remembered<string>("handles", "off") as Signal<HandleMode>;
if (!["off", "move", "rotate", "resize", "grab"].includes(handleMode.peek())) handleMode.value = "off";
/** Axes of the thing instead of those of the world. */
export const handlesLocal = remembered<boolean>("handles.local", false);
/** Steps of 1 cm and 15 degrees. */
export const handlesSnap = remembered<boolean>("handles.snap", false);
export const kSnapLength = 0.01;
export const kSnapAngle = Math.PI / 12;

/** Index of a body that was clicked though no element of the file made it: shown, but not in the selection. */
export const marked = signal(-1);

/** A standard view, everything, the selection, or from a direction (unit, from the middle to the eye). */
export type ViewWish = ViewName | "fit" | "focus" | Vec3;
/** The newest request to show something; every panel that shows the scene follows as far as it can. */
export const viewRequest = signal<{ what: ViewWish } | null>(null);
/** How many 3D views there are. */
export const openViews = signal(0);
