// Which cameras are shown, how, and where. Asks the server for just these pictures.
import { computed, effect, signal } from "@preact/signals-core";
import { isClosed, messageOf } from "../core/link";
import type { Picture } from "../core/frame";
import type { Studio } from "../core/studio";
import { firstRect, clampedTo, pictureWidth, raised, type Rect } from "./windows";

export type PictureKind = Picture["kind"];
export const kPictureKinds: { kind: PictureKind; label: string }[] = [
  { kind: "color", label: "Colour" },
  { kind: "depth", label: "Depth" },
  { kind: "segmentation", label: "Segmentation" },
];

export interface Camera {
  name: string;
  /** of a sensor, or a saved view */
  from: "sensor" | "view";
  element: number;
}

interface Stored extends Rect {
  shown: boolean;
  kind: PictureKind;
}

interface CameraState {
  shown: boolean;
  kind: PictureKind;
  /** null: has never been shown */
  rect: Rect | null;
}

const kNew: CameraState = { shown: false, kind: "color", rect: null };

export class CameraStore {
  readonly cameras = computed<Camera[]>(() => {
    const scene = this.studio.state.scene.value;
    if (!scene) return [];
    return [
      ...scene.sensors
        .filter((s) => s.type === "camera")
        .map(({ name, element }) => ({ name, element, from: "sensor" as const })),
      ...scene.views.map(({ name, element }) => ({ name, element, from: "view" as const })),
    ].filter((camera, i, all) => camera.name !== "" && all.findIndex((c) => c.name === camera.name) === i);
  });
  readonly states = signal<Record<string, CameraState>>({});
  /** names from the lowest window to the topmost */
  readonly order = signal<string[]>([]);
  /** whether windows can be shown: the panel is open, its page is seen */
  readonly seen = signal(false);
  /** why there are no pictures; empty: there are */
  readonly refusal = signal("");
  /** what is open: shown, and there in the present scene */
  readonly open = computed(() => this.cameras.value.filter((c) => this.stateOf(c.name).shown));

  private key = "";
  private asked = "[]";
  private waiting = false;
  private readonly stops: (() => void)[];

  constructor(readonly studio: Studio) {
    this.stops = [
      effect(() => {
        const file = this.studio.state.hello.value?.file;
        if (file !== undefined) this.load(`cogrsim.cameras.${file}`);
      }),
      effect(() => {
        // a new connection has no requests yet
        if (!this.studio.state.open.value) this.asked = "[]";
      }),
      effect(() => {
        void this.studio.state.open.value;
        const wanted = this.seen.value ? this.wanted() : [];
        // moving a panel in the dock closes and opens it within one turn
        if (this.waiting || JSON.stringify(wanted) === this.asked) return;
        this.waiting = true;
        setTimeout(() => {
          this.waiting = false;
          this.ask();
        }, 50);
      }),
    ];
  }
  dispose(): void {
    for (const stop of this.stops) stop();
  }

  stateOf(name: string): CameraState {
    return this.states.value[name] ?? kNew;
  }

  show(names: readonly string[], shown: boolean): void {
    const all = { ...this.states.value };
    for (const name of names) {
      const state = all[name] ?? kNew;
      const rect = state.rect ?? firstRect(this.freeSlot(all), workArea());
      all[name] = { ...state, shown, rect: shown ? clampedTo(rect, pageSize()) : state.rect };
    }
    this.states.value = all;
    if (shown) this.order.value = names.reduce<string[]>(raised, this.order.value);
    this.save();
  }
  choose(name: string, kind: PictureKind): void {
    this.states.value = { ...this.states.value, [name]: { ...this.stateOf(name), kind } };
    this.save();
  }
  put(name: string, rect: Rect): void {
    const state = this.stateOf(name);
    this.states.value = { ...this.states.value, [name]: { ...state, rect: clampedTo(rect, pageSize()) } };
    this.save();
  }
  raise(name: string): void {
    const { value } = this.order;
    if (value[value.length - 1] === name) return;
    this.order.value = raised(value, name);
    this.save();
  }

  private wanted(): { name: string; kind: PictureKind; width: number }[] {
    const ratio = typeof devicePixelRatio === "number" ? devicePixelRatio : 1;
    return this.open.value.map(({ name }) => {
      const { kind, rect } = this.stateOf(name);
      return { name, kind, width: pictureWidth(rect?.width ?? 280, ratio) };
    });
  }

  private ask(): void {
    const show = this.seen.peek() ? this.wanted() : [];
    const text = JSON.stringify(show);
    if (text === this.asked) return;
    this.asked = text;
    this.studio.link.request("cameras", { show }).then(
      () => void (this.refusal.value = ""),
      (error: unknown) => {
        // the link asks again when the connection is restored
        // to be tried again with the next scene
        this.asked = "";
        this.refusal.value = isClosed(error) || show.length === 0 ? "" : messageOf(error);
      },
    );
  }

  private freeSlot(all: Record<string, CameraState>): number {
    const area = workArea();
    const taken = Object.values(all).flatMap((s) => (s.rect && s.shown ? [`${s.rect.x},${s.rect.y}`] : []));
    for (let slot = 0; ; ++slot) {
      const rect = clampedTo(firstRect(slot, area), pageSize());
      if (slot > taken.length || !taken.includes(`${rect.x},${rect.y}`)) return slot;
    }
  }

  private load(key: string): void {
    if (key === this.key) return;
    this.key = key;
    const stored = readStored(key);
    const states: Record<string, CameraState> = {};
    for (const [name, k] of Object.entries(stored.cameras))
      states[name] = { shown: k.shown, kind: k.kind, rect: clampedTo(k, pageSize()) };
    this.states.value = states;
    this.order.value = stored.order;
  }

  private save(): void {
    if (this.key === "") return;
    const cameras: Record<string, Stored> = {};
    for (const [name, { shown, kind, rect }] of Object.entries(this.states.peek()))
      if (rect) cameras[name] = { shown, kind, ...rect };
    try {
      localStorage.setItem(this.key, JSON.stringify({ cameras, order: this.order.peek() }));
    } catch {
      // no storage (a bundle opened from disk, a full one): positions are forgotten, all else works
    }
  }
}

/** What was kept; whatever is not of the right form is left out. */
function readStored(key: string): { cameras: Record<string, Stored>; order: string[] } {
  const out: { cameras: Record<string, Stored>; order: string[] } = { cameras: {}, order: [] };
  try {
    const stored = JSON.parse(localStorage.getItem(key) ?? "{}") as {
      cameras?: Record<string, Stored>;
      order?: unknown;
    };
    for (const [name, k] of Object.entries(stored.cameras ?? {})) {
      const numbers = [k.x, k.y, k.width, k.height];
      if (!numbers.every(Number.isFinite) || !kPictureKinds.some(({ kind }) => kind === k.kind)) continue;
      out.cameras[name] = { x: k.x, y: k.y, width: k.width, height: k.height, shown: k.shown === true, kind: k.kind };
    }
    if (Array.isArray(stored.order)) out.order = stored.order.filter((n): n is string => typeof n === "string");
  } catch {
    // as if nothing had been kept
  }
  return out;
}

function pageSize(): { width: number; height: number } {
  return typeof window === "undefined"
    ? { width: 1280, height: 800 }
    : { width: window.innerWidth, height: window.innerHeight };
}

/** Where the docked panels are, without bars above and below. */
function workArea(): Rect {
  const dock = typeof document === "undefined" ? null : document.querySelector(".cg-dock, .lm-DockPanel");
  const box = dock?.getBoundingClientRect();
  if (!box || box.width < 100 || box.height < 100) return { x: 0, y: 0, ...pageSize() };
  // beside the view cube and the tools below it
  return { x: box.x, y: box.y + 28, width: box.width - kViewTools, height: box.height - 28 };
}
const kViewTools = 130;
