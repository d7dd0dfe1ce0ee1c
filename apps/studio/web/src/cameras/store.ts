// Which cameras are shown, how, and where. Asks the server for just these pictures.
import { computed, effect, signal } from "@preact/signals-core";
import { RequestError } from "../core/link";
import type { Picture } from "../core/protocol";
import type { Studio } from "../core/studio";
import { first_rect, kept_in, picture_width, raised, type Rect } from "./windows";

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

interface Kept extends Rect {
  shown: boolean;
  kind: PictureKind;
}

export interface CameraState {
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
  readonly open = computed(() => this.cameras.value.filter((c) => this.state_of(c.name).shown));

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

  state_of(name: string): CameraState {
    return this.states.value[name] ?? kNew;
  }

  show(names: readonly string[], shown: boolean): void {
    const all = { ...this.states.value };
    for (const name of names) {
      const state = all[name] ?? kNew;
      const rect = state.rect ?? first_rect(this.free_slot(all), work_area());
      all[name] = { ...state, shown, rect: shown ? kept_in(rect, page_size()) : state.rect };
    }
    this.states.value = all;
    if (shown) this.order.value = names.reduce<string[]>(raised, this.order.value);
    this.keep();
  }
  choose(name: string, kind: PictureKind): void {
    this.states.value = { ...this.states.value, [name]: { ...this.state_of(name), kind } };
    this.keep();
  }
  put(name: string, rect: Rect): void {
    const state = this.state_of(name);
    this.states.value = { ...this.states.value, [name]: { ...state, rect: kept_in(rect, page_size()) } };
    this.keep();
  }
  raise(name: string): void {
    const { value } = this.order;
    if (value[value.length - 1] === name) return;
    this.order.value = raised(value, name);
    this.keep();
  }

  private wanted(): { name: string; kind: PictureKind; width: number }[] {
    const ratio = typeof devicePixelRatio === "number" ? devicePixelRatio : 1;
    return this.open.value.map(({ name }) => {
      const { kind, rect } = this.state_of(name);
      return { name, kind, width: picture_width(rect?.width ?? 280, ratio) };
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
        const closed = error instanceof RequestError && error.failure.code === "closed";
        // to be tried again with the next scene
        this.asked = "";
        this.refusal.value = closed || show.length === 0 ? "" : error instanceof Error ? error.message : String(error);
      },
    );
  }

  private free_slot(all: Record<string, CameraState>): number {
    const area = work_area();
    const taken = Object.values(all).flatMap((s) => (s.rect && s.shown ? [`${s.rect.x},${s.rect.y}`] : []));
    for (let slot = 0; ; ++slot) {
      const rect = kept_in(first_rect(slot, area), page_size());
      if (slot > taken.length || !taken.includes(`${rect.x},${rect.y}`)) return slot;
    }
  }

  private load(key: string): void {
    if (key === this.key) return;
    this.key = key;
    const kept = read_kept(key);
    const states: Record<string, CameraState> = {};
    for (const [name, k] of Object.entries(kept.cameras))
      states[name] = { shown: k.shown, kind: k.kind, rect: kept_in(k, page_size()) };
    this.states.value = states;
    this.order.value = kept.order;
  }

  private keep(): void {
    if (this.key === "") return;
    const cameras: Record<string, Kept> = {};
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
export function read_kept(key: string): { cameras: Record<string, Kept>; order: string[] } {
  const out: { cameras: Record<string, Kept>; order: string[] } = { cameras: {}, order: [] };
  try {
    const kept = JSON.parse(localStorage.getItem(key) ?? "{}") as { cameras?: Record<string, Kept>; order?: unknown };
    for (const [name, k] of Object.entries(kept.cameras ?? {})) {
      const numbers = [k.x, k.y, k.width, k.height];
      if (!numbers.every(Number.isFinite) || !kPictureKinds.some(({ kind }) => kind === k.kind)) continue;
      out.cameras[name] = { x: k.x, y: k.y, width: k.width, height: k.height, shown: k.shown === true, kind: k.kind };
    }
    if (Array.isArray(kept.order)) out.order = kept.order.filter((n): n is string => typeof n === "string");
  } catch {
    // as if nothing had been kept
  }
  return out;
}

function page_size(): { width: number; height: number } {
  return typeof window === "undefined"
    ? { width: 1280, height: 800 }
    : { width: window.innerWidth, height: window.innerHeight };
}

/** Where the docked panels are, without bars above and below. */
function work_area(): Rect {
  const dock = typeof document === "undefined" ? null : document.querySelector(".cg-dock, .lm-DockPanel");
  const box = dock?.getBoundingClientRect();
  if (!box || box.width < 100 || box.height < 100) return { x: 0, y: 0, ...page_size() };
  return { x: box.x, y: box.y + 28, width: box.width, height: box.height - 28 };
}
