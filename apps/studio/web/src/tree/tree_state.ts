// What the tree panel, its commands and the other editing panels share.
import { signal, type Signal } from "@preact/signals-core";
import type { Studio } from "../core/studio";
import { load_schema, type Schema } from "../forms/schema";
import type { SignalInfo } from "./model";

export interface TreeState {
  /** id of the element whose name is being typed; -1: none */
  renaming: Signal<number>;
  schema: Signal<Schema | null>;
  /** of the present scene, by the dotted name of the owner */
  signals: Signal<Map<string, SignalInfo[]>>;
  /** Elements copied in this page, as XML. */
  copied: Signal<string[]>;
  /** dotted name of what held them: pasted there they would be inside each other */
  copied_from: Signal<string | null>;
  /** keys of what was copied and of what has been pasted of it: one more goes beside them */
  copies: Set<string>;
}

const states = new WeakMap<Studio, TreeState>();

/** Keys and signals of a studio; asks for schema and signals when there is something to ask. */
export function tree_state(studio: Studio): TreeState {
  let state = states.get(studio);
  if (state) return state;
  state = { renaming: signal(-1), schema: signal(null), signals: signal(new Map()), copied: signal([]), copied_from: signal(null), copies: new Set() };
  states.set(studio, state);
  const { schema, signals } = state;
  studio.state.hello.subscribe((hello) => {
    if (!hello || hello.kind !== "scene") return;
    load_schema(studio).then(
      (loaded) => (schema.value = loaded),
      (error: Error) => studio.notify(`the vocabulary cannot be read: ${error.message}`, "error"),
    );
  });
  let asked = -1;
  studio.state.scene.subscribe((scene) => {
    if (!scene || scene.scene === asked) return;
    asked = scene.scene;
    studio.link.request<{ signals: SignalInfo[] }>("signals").then(
      (answer) => {
        const by_owner = new Map<string, SignalInfo[]>();
        for (const info of answer.signals ?? []) {
          const list = by_owner.get(info.owner);
          if (list) list.push(info);
          else by_owner.set(info.owner, [info]);
        }
        signals.value = by_owner;
      },
      // A bundle without signals: nothing can be drawn.
      () => (signals.value = new Map()),
    );
  });
  return state;
}

/** Starts typing a name in the tree, which is shown if it is not. */
export function start_renaming(studio: Studio, element: number): void {
  studio.open_panel("tree");
  tree_state(studio).renaming.value = element;
}

export const kSignalType = "application/x-cogrsim-signal";
/** Short name of a signal below its owner. */
export function signal_label(info: SignalInfo): string {
  const short = info.name.startsWith(`${info.owner}.`) ? info.name.slice(info.owner.length + 1) : info.name;
  return info.unit === "" || info.unit === "1" ? short : `${short} [${info.unit}]`;
}
