// What the page knows, as signals: panels read them and are notified of changes.
import { computed, signal } from "@preact/signals-core";
import type { Frame } from "./frame";
import type {
  Debug,
  DocumentState,
  Hello,
  Problem,
  RunEvent,
  RunMessage,
  Scene,
  Status,
  TreeElement,
  Unsaved,
} from "./protocol";

export class State {
  readonly hello = signal<Hello | null>(null);
  readonly open = signal(false);
  readonly status = signal<Status | null>(null);
  readonly scene = signal<Scene | null>(null);
  readonly document = signal<DocumentState | null>(null);
  readonly debug = signal<Debug | null>(null);
  readonly unsaved = signal<Unsaved | null>(null);
  /** of the newest text that is well-formed */
  readonly tree = signal<{ version: number; elements: TreeElement[] }>({ version: -1, elements: [] });
  readonly problems = signal<Problem[]>([]);
  /** newest last; bounded */
  readonly messages = signal<RunMessage[]>([]);
  readonly events = signal<RunEvent[]>([]);

  /** What all panels show. Not a reason to render anything but pictures: changes 60 times a second. */
  readonly frame = signal<Frame | null>(null);
  /** Whether the page follows the run; else it shows `frame.time`. */
  readonly live = signal(true);

  /** Element ids that are selected, the last one is the main one. Of things that no element made: none. */
  readonly selection = signal<number[]>([]);
  /** Index of the body under the pointer, in any panel; -1: none. */
  readonly hovered = signal(-1);
  /** Name of the body that the 3D view follows; "": none. */
  readonly followed = signal("");

  readonly theme = signal<"light" | "dark">("light");

  readonly mayEdit = computed(
    () => this.hello.value?.role === "operator" && this.hello.value.kind === "scene" && this.open.value,
  );

  element(id: number): TreeElement | undefined {
    return this.tree.value.elements[id];
  }
  /** Indices of the bodies that an element and all inside it made. */
  bodiesOf(id: number): number[] {
    const scene = this.scene.value;
    if (!scene) return [];
    const elements = this.tree.value.elements;
    const inside = (e: number): boolean => {
      for (let at = e; at >= 0; at = elements[at]?.parent ?? -1) if (at === id) return true;
      return false;
    };
    return scene.bodies.flatMap((body, i) => (!body.removed && inside(body.element) ? [i] : []));
  }
}
