// What the tree panel, its commands and the other editing panels share.
import { signal } from "@preact/signals-core";
import type { SignalInfo } from "../core/protocol";
import type { Studio } from "../core/studio";
import { SchemaLoader, type Schema } from "../forms/schema";

/** Keys and signals of a studio; asks for schema and signals when there is something to ask. */
export class TreeState {
  /** id of the element whose name is being typed; -1: none */
  readonly renaming = signal(-1);
  readonly schema = signal<Schema | null>(null);
  /** of the present scene, by the dotted name of the owner */
  readonly signals = signal<ReadonlyMap<string, SignalInfo[]>>(new Map());
  /** Elements copied in this page, as XML. */
  readonly copied = signal<string[]>([]);
  /** dotted name of what held them: pasted there they would be inside each other */
  readonly copiedFrom = signal<string | null>(null);
  /** keys of what was copied and of what has been pasted of it: one more goes beside them */
  copies = new Set<string>();
  private asked = -1;
  private readonly stops: (() => void)[];

  constructor(private readonly studio: Studio) {
    this.stops = [
      studio.state.hello.subscribe((hello) => {
        if (hello?.kind === "scene") this.loadSchema();
      }),
      studio.state.scene.subscribe((scene) => {
        if (!scene || scene.scene === this.asked) return;
        this.asked = scene.scene;
        this.listSignals();
      }),
    ];
  }
  dispose(): void {
    for (const stop of this.stops) stop();
  }

  private loadSchema(): void {
    this.studio.services
      .get(SchemaLoader)
      .load()
      .then(
        (loaded) => (this.schema.value = loaded),
        (error: Error) => this.studio.notify(`the vocabulary cannot be read: ${error.message}`, "error"),
      );
  }

  private listSignals(): void {
    this.studio.link.request("signals").then(
      (answer) => {
        const byOwner = new Map<string, SignalInfo[]>();
        for (const info of answer.signals ?? []) {
          const list = byOwner.get(info.owner);
          if (list) list.push(info);
          else byOwner.set(info.owner, [info]);
        }
        this.signals.value = byOwner;
      },
      // A bundle without signals: nothing can be drawn.
      () => (this.signals.value = new Map()),
    );
  }
}

/** Starts typing a name in the tree, which is shown if it is not. */
export function startRenaming(studio: Studio, element: number): void {
  studio.openPanel("tree");
  studio.services.get(TreeState).renaming.value = element;
}

/** Short name of a signal below its owner. */
export function signalLabel(info: SignalInfo): string {
  const short = info.name.startsWith(`${info.owner}.`) ? info.name.slice(info.owner.length + 1) : info.name;
  return info.unit === "" || info.unit === "1" ? short : `${short} [${info.unit}]`;
}
