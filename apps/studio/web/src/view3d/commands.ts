// What can be done with views, overlays and handles.
import { effect } from "@preact/signals-core";
import type { Studio } from "../core/studio";
import { bodiesOf } from "./selecting";
import {
  dragging,
  handleMode,
  handlesLocal,
  handlesSnap,
  marked,
  openViews,
  orthographic,
  kOverlayLabels,
  kOverlays,
  overlays,
  viewRequest,
  type HandleMode,
} from "./settings";
import { Subscription } from "./subscription";
import { kViews } from "./views";

const kViewLabels: Record<string, [label: string, caption: string]> = {
  front: ["Front", "From +x"],
  back: ["Back", "From \u2212x"],
  left: ["Left", "From +y"],
  right: ["Right", "From \u2212y"],
  top: ["Top", "From above, y up in the picture"],
  bottom: ["Bottom", "From below, y up in the picture"],
  iso: ["Iso", "From the front left, above"],
};

/** Name of the body to follow: the first of the selection that moves; "": none. */
function toFollow(studio: Studio): string {
  const { state } = studio;
  const scene = state.scene.peek();
  if (!scene) return "";
  const bodies = [...bodiesOf(state, state.selection.peek())];
  if (marked.peek() >= 0) bodies.push(marked.peek());
  const all = bodies.map((b) => scene.bodies[b]!).filter(Boolean);
  return (all.find((b) => b.kind !== "fixed") ?? all[0])?.name ?? "";
}

export function registerCommands(studio: Studio): void {
  const { commands, state } = studio;
  const look = (what: NonNullable<typeof viewRequest.value>["what"]) => {
    if (openViews.peek() === 0) studio.openPanel("view3d");
    viewRequest.value = { what };
  };
  for (const view of kViews) {
    const [label, caption] = kViewLabels[view]!;
    commands.addCommand(`view:${view}`, { label, caption, execute: () => look(view) });
  }
  commands.addCommand("view:focus", {
    label: "Focus the Selection",
    caption: "Shows the selection; everything when nothing is selected",
    execute: () => look("focus"),
  });
  commands.addCommand("view:deselect", {
    label: "Select Nothing",
    isEnabled: () => !dragging.value && (state.selection.value.length > 0 || marked.value >= 0),
    execute: () => {
      studio.select([]);
      marked.value = -1;
    },
  });
  commands.addCommand("view:fit", { label: "Zoom to Fit", caption: "Shows everything", execute: () => look("fit") });
  commands.addCommand("view:follow", {
    label: () => (state.followed.value ? `Follow ${state.followed.value}` : "Follow the Selection"),
    caption: "The view moves along with a body",
    isToggleable: true,
    isToggled: () => state.followed.value !== "",
    isEnabled: () => state.followed.value !== "" || toFollow(studio) !== "",
    execute: () => {
      state.followed.value = state.followed.peek() ? "" : toFollow(studio);
    },
  });

  commands.addCommand("view:orthographic", {
    label: "Orthographic",
    caption: "Without perspective: what is parallel stays parallel",
    isToggleable: true,
    isToggled: () => orthographic.value,
    execute: () => {
      orthographic.value = !orthographic.peek();
    },
  });

  for (const name of kOverlays) {
    commands.addCommand(`overlay:${name}`, {
      label: `Show ${kOverlayLabels[name]}`,
      isToggleable: true,
      isToggled: () => overlays[name].value,
      execute: () => {
        overlays[name].value = !overlays[name].peek();
      },
    });
  }

  const handle = (mode: HandleMode, label: string, caption: string) =>
    commands.addCommand(`handles:${mode}`, {
      label,
      caption,
      isToggleable: true,
      isToggled: () => handleMode.value === mode,
      isEnabled: () => state.mayEdit.value,
      execute: () => {
        handleMode.value = handleMode.peek() === mode ? "off" : mode;
      },
    });
  handle("move", "Move with Handles", "Arrows on the selected thing move it; Escape while dragging takes it back");
  handle("rotate", "Rotate with Handles", "Rings on the selected thing turn it; Escape while dragging takes it back");
  handle(
    "resize",
    "Resize with Handles",
    "Cubes on the selected shape change its size; Escape while dragging takes it back",
  );
  handle("grab", "Grab", "While the run plays, a body is pulled to the pointer; with Alt it is so without this tool");
  commands.addCommand("handles:local", {
    label: "Handles along the Thing's Own Axes",
    caption: "Along its own axes instead of those of the world",
    isToggleable: true,
    isToggled: () => handlesLocal.value,
    isEnabled: () => state.mayEdit.value,
    execute: () => {
      handlesLocal.value = !handlesLocal.peek();
    },
  });
  commands.addCommand("handles:snap", {
    label: "Handles Snap",
    caption: "In steps of 1 cm and 15\u00b0",
    isToggleable: true,
    isToggled: () => handlesSnap.value,
    isEnabled: () => state.mayEdit.value,
    execute: () => {
      handlesSnap.value = !handlesSnap.peek();
    },
  });

  // menus and buttons show active options
  effect(() => {
    void state.followed.value;
    void state.selection.value;
    void state.mayEdit.value;
    for (const depends of [handleMode, handlesLocal, handlesSnap, orthographic, marked, ...Object.values(overlays)])
      void depends.value;
    for (const id of commands.listCommands()) {
      if (/^(view:follow|view:orthographic|overlay:|handles:)/.test(id)) commands.notifyCommandChanged(id);
    }
  });
  effect(() => {
    const any = openViews.value > 0;
    studio.services.get(Subscription).set("view3d", {
      readings: any && overlays.rays.value,
      contacts: any && overlays.contacts.value,
    });
  });
}
