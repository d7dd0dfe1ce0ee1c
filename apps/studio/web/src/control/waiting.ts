// What the run waits for, and faults of those that it waited for.
import { effect } from "@preact/signals-core";
import type { RunEvent, Scene, Waiting } from "../core/protocol";
import type { Studio } from "../core/studio";
import type { Control } from "./commands";

/** "controller 'bot.mind' of robot 'bot'" */
function who(kind: string, name: string, robot: string): string {
  return `${kind}${name ? ` '${name}'` : ""}${robot ? ` of robot '${robot}'` : ""}`;
}

/** In place of what the run does. */
export function waiting_text(waiting: Waiting): string {
  return `Waiting for ${who(waiting.kind, waiting.name, waiting.of)}: ${Math.floor(waiting.seconds)} s`;
}

/** Where it is, what becomes of it, what can be done. */
export function waiting_help(waiting: Waiting): string {
  const { plugin, doing, time, isolated, limit } = waiting;
  const place = `${plugin ? `Plugin '${plugin}' ` : "It "}has not returned, ${doing}${time === null ? "" : ` at ${short(time)} s of the run`}.`;
  if (!isolated) {
    return `${place} It runs in the studio's own process and cannot be stopped without ending the studio, with Ctrl-C where that was started.`;
  }
  const end = limit === null ? "It has no deadline" : `Its process is ended after ${short(limit)} s`;
  return `${place} ${end}; Stop, Restart and End controller end it now.`;
}

/** What a fault means to the user; `scene` knows whose it is. */
export function fault_text(event: RunEvent, scene: Scene | null): string {
  const controller = scene?.controllers.find((one) => one.name === event.source);
  const robot = controller && scene?.assemblies[controller.assembly];
  const name = controller
    ? `${who("controller", controller.name, robot?.name ?? "")} (plugin '${controller.plugin}')`
    : `'${event.source}'`;
  const next = controller
    ? "Restart begins the run anew. Once it is built anew: Pause, then Run ▸ Reload controllers, or Restart."
    : "Restart begins the run anew.";
  return `${name[0]!.toUpperCase()}${name.slice(1)} at ${short(event.time)} s: ${event.message}. ${next}`;
}

function short(value: number): string {
  return String(Number(value.toPrecision(6)));
}

/** Faults are notified as they happen; those of before the page came, too. */
export function notify_faults(studio: Studio): void {
  const { state } = studio;
  let seen = -1;
  effect(() => {
    if (!state.open.value) seen = -1;
  });
  effect(() => {
    for (const event of state.events.value) {
      if (event.index <= seen) continue;
      seen = event.index;
      if (event.kind === "fault" && state.hello.peek()?.kind === "scene") studio.notify(fault_text(event, state.scene.peek()), "error");
    }
  });
}

/** Says what is waited for, as long as that is so. */
export function waiting_bar(control: Control): HTMLElement {
  const { state } = control.studio;
  const node = document.createElement("div");
  node.className = "cg-waiting";
  node.dataset.testid = "waiting";
  // The seconds are not for being read out.
  const seconds = document.createElement("strong");
  const words = document.createElement("span");
  words.setAttribute("role", "alert");
  const end = document.createElement("button");
  end.textContent = "End controller";
  end.dataset.testid = "end-controller";
  end.addEventListener("click", () => void control.ask("end-controller"));
  node.append(seconds, words, end);
  effect(() => {
    const waiting = state.open.value ? state.status.value?.waiting : null;
    node.hidden = !waiting;
    seconds.textContent = waiting ? waiting_text(waiting) : "";
    const help = waiting ? waiting_help(waiting) : "";
    if (words.textContent !== help) words.textContent = help;
    end.hidden = !waiting?.isolated || state.hello.value?.role !== "operator";
  });
  return node;
}
