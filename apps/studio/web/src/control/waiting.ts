// Plugin calls that the run waits for, and faults of plugins.
import { effect } from "@preact/signals-core";
import type { Debug, RunEvent, Scene, Waiting } from "../core/protocol";
import type { Studio } from "../core/studio";
import type { Control } from "./commands";

/** "controller 'bot.driver' of robot 'bot'" */
function who(kind: string, name: string, robot: string): string {
  return `${kind}${name ? ` '${name}'` : ""}${robot ? ` of robot '${robot}'` : ""}`;
}

/** Whether the run waits because the controller stands in the debugger: that has a panel of its own, and no deadline. */
export function isDebugged(waiting: Waiting, debug: Debug | null): boolean {
  return debug?.state === "stopped" && debug.controller === waiting.name;
}

/** Shown instead of the run's state. */
export function waitingText(waiting: Waiting): string {
  return `Waiting for ${who(waiting.kind, waiting.name, waiting.of)}: ${Math.floor(waiting.seconds)} s`;
}

/** Where the call is, when it is ended, what the user can do. */
export function waitingHelp(waiting: Waiting): string {
  const { plugin, doing, time, isolated, limit } = waiting;
  const text = `${plugin ? `Plugin '${plugin}' ` : "It "}has not returned, ${doing}${time === null ? "" : ` at ${short(time)} s of the run`}.`;
  if (!isolated) {
    return `${text} It runs in the studio's own process and cannot be stopped without ending the studio, with Ctrl-C where it was started.`;
  }
  const end = limit === null ? "It has no deadline" : `Its process is ended after ${short(limit)} s`;
  return `${text} ${end}; Stop, Restart and End controller end it now.`;
}

/** The text of a fault for the user; `scene` has the owner. */
export function faultText(event: RunEvent, scene: Scene | null): string {
  const controller = scene?.controllers.find((one) => one.name === event.source);
  const robot = controller && scene?.assemblies[controller.assembly];
  const name = controller
    ? `${who("controller", controller.name, robot?.name ?? "")} (plugin '${controller.plugin}')`
    : `'${event.source}'`;
  const next = controller
    ? "Restart runs from the start. After a rebuild: Pause, then Run ▸ Reload controllers, or Restart."
    : "Restart runs from the start.";
  return `${name[0]!.toUpperCase()}${name.slice(1)} at ${short(event.time)} s: ${event.message}. ${next}`;
}

function short(value: number): string {
  return String(Number(value.toPrecision(6)));
}

/** Notifies of faults as they occur, and of those before the page joined. */
export function notifyFaults(studio: Studio): void {
  const { state } = studio;
  let seen = -1;
  effect(() => {
    if (!state.open.value) seen = -1;
  });
  effect(() => {
    for (const event of state.events.value) {
      if (event.index <= seen) continue;
      seen = event.index;
      if (event.kind === "fault" && state.hello.peek()?.kind === "scene")
        studio.notify(faultText(event, state.scene.peek()), "error");
    }
  });
}

/** Shows the call that the run waits for. */
export function waitingBar(control: Control): HTMLElement {
  const { state } = control.studio;
  const node = document.createElement("div");
  node.className = "cg-waiting";
  node.dataset.testid = "waiting";
  // The seconds are not for being read out.
  const seconds = document.createElement("strong");
  const message = document.createElement("span");
  message.setAttribute("role", "alert");
  const end = document.createElement("button");
  end.textContent = "End controller";
  end.dataset.testid = "end-controller";
  end.addEventListener("click", () => void control.ask("end-controller"));
  node.append(seconds, message, end);
  effect(() => {
    const call = state.open.value ? state.status.value?.waiting : null;
    const waiting = call && !isDebugged(call, state.debug.value) ? call : null;
    node.hidden = !waiting;
    seconds.textContent = waiting ? waitingText(waiting) : "";
    const help = waiting ? waitingHelp(waiting) : "";
    if (message.textContent !== help) message.textContent = help;
    end.hidden = !waiting?.isolated || state.hello.value?.role !== "operator";
  });
  return node;
}
