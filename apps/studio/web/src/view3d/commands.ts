// What can be done with views, overlays and handles.
import { effect } from "@preact/signals-core";
import type { Studio } from "../core/studio";
import { bodies_of } from "./selecting";
import {
  handle_mode,
  handles_local,
  handles_snap,
  marked,
  open_views,
  OVERLAY_LABELS,
  OVERLAYS,
  overlays,
  view_request,
  type HandleMode,
} from "./settings";
import { Subscription } from "./subscription";
import { VIEWS } from "./views";

const VIEW_LABELS: Record<string, [label: string, caption: string]> = {
  front: ["Front", "From +x"],
  back: ["Back", "From \u2212x"],
  left: ["Left", "From +y"],
  right: ["Right", "From \u2212y"],
  top: ["Top", "From above, y up in the picture"],
  bottom: ["Bottom", "From below, y up in the picture"],
  iso: ["Iso", "From the front left, above"],
};

/** Name of the body to follow: the first of the selection that moves; "": none. */
function to_follow(studio: Studio): string {
  const { state } = studio;
  const scene = state.scene.peek();
  if (!scene) return "";
  const bodies = [...bodies_of(state, state.selection.peek())];
  if (marked.peek() >= 0) bodies.push(marked.peek());
  const all = bodies.map((b) => scene.bodies[b]!).filter(Boolean);
  return (all.find((b) => b.kind !== "fixed") ?? all[0])?.name ?? "";
}

export function register_commands(studio: Studio): void {
  const { commands, state } = studio;
  const look = (what: NonNullable<typeof view_request.value>["what"]) => {
    if (open_views.peek() === 0) studio.open_panel("view3d");
    view_request.value = { what };
  };
  for (const view of VIEWS) {
    const [label, caption] = VIEW_LABELS[view]!;
    commands.addCommand(`view:${view}`, { label, caption, execute: () => look(view) });
  }
  commands.addCommand("view:focus", {
    label: "Focus the Selection",
    caption: "Shows the selection; everything when nothing is selected",
    execute: () => look("focus"),
  });
  commands.addCommand("view:fit", { label: "Zoom to Fit", caption: "Shows everything", execute: () => look("fit") });
  commands.addCommand("view:follow", {
    label: () => (state.followed.value ? `Follow ${state.followed.value}` : "Follow the Selection"),
    caption: "The view moves along with a body",
    isToggleable: true,
    isToggled: () => state.followed.value !== "",
    isEnabled: () => state.followed.value !== "" || to_follow(studio) !== "",
    execute: () => {
      state.followed.value = state.followed.peek() ? "" : to_follow(studio);
    },
  });

  for (const name of OVERLAYS) {
    commands.addCommand(`overlay:${name}`, {
      label: `Show ${OVERLAY_LABELS[name]}`,
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
      isToggled: () => handle_mode.value === mode,
      isEnabled: () => state.may_edit.value,
      execute: () => {
        handle_mode.value = handle_mode.peek() === mode ? "off" : mode;
      },
    });
  handle("move", "Move with Handles", "Arrows on the selected thing move it; Escape while dragging takes it back");
  handle("rotate", "Rotate with Handles", "Rings on the selected thing turn it; Escape while dragging takes it back");
  commands.addCommand("handles:local", {
    label: "Handles along the Thing's Own Axes",
    caption: "Along its own axes instead of those of the world",
    isToggleable: true,
    isToggled: () => handles_local.value,
    isEnabled: () => state.may_edit.value,
    execute: () => {
      handles_local.value = !handles_local.peek();
    },
  });
  commands.addCommand("handles:snap", {
    label: "Handles Snap",
    caption: "In steps of 1 cm and 15\u00b0",
    isToggleable: true,
    isToggled: () => handles_snap.value,
    isEnabled: () => state.may_edit.value,
    execute: () => {
      handles_snap.value = !handles_snap.peek();
    },
  });

  // menus and buttons show active options
  effect(() => {
    state.followed.value;
    state.selection.value;
    state.may_edit.value;
    for (const depends of [handle_mode, handles_local, handles_snap, marked, ...Object.values(overlays)]) depends.value;
    for (const id of commands.listCommands()) {
      if (/^(view:follow|overlay:|handles:)/.test(id)) commands.notifyCommandChanged(id);
    }
  });
  effect(() => {
    const any = open_views.value > 0;
    studio.services.get(Subscription).set("view3d", {
      readings: any && overlays.rays.value,
      contacts: any && overlays.contacts.value,
    });
  });
}
