// The figures that are open, what can be drawn, and which figure commands are about.
import { effect, signal } from "@preact/signals-core";
import type { PlotInfo, SignalInfo } from "../core/protocol";
import type { Studio } from "../core/studio";
import { kindOf, kKindNames, type FigureKind, type FigureSpec } from "./figure";
import { Feed } from "./feed";

/** How many signals a kind needs; Infinity: as many as one likes. */
export const kSlots: Record<FigureKind, number> = {
  curve: Infinity,
  box: Infinity,
  histogram: Infinity,
  map: 2,
  surface: 3,
};

/** [ms] */
const kTick = 100;

export class FiguresStore {
  readonly specs = signal<FigureSpec[]>([]);
  /** id of the figure that commands are about; -1: none */
  readonly active = signal(-1);
  /** id of the figure whose list of signals is open; -1: none */
  readonly choosing = signal(-1);
  /** what the list of signals is searched for when it opens */
  readonly search = signal("");
  readonly signals = signal<SignalInfo[]>([]);
  readonly plots = signal<PlotInfo[]>([]);
  /** whether the panel is visible; nothing is requested otherwise */
  readonly seen = signal(false);
  /** time that the page shows [s], a few times a second */
  readonly looked = signal<number | null>(null);

  private readonly feeds = new Map<number, Feed>();
  private readonly visible = new Set<number>();
  private nextId = 1;
  private key = "";
  private listed = "";
  private readonly stops: (() => void)[];

  constructor(readonly studio: Studio) {
    this.stops = [
      effect(() => {
        const file = studio.state.hello.value?.file;
        if (file !== undefined) this.load(`cogrsim.figures.${file}`);
      }),
      effect(() => {
        if (!this.seen.value) return;
        const timer = setInterval(() => this.tick(), kTick);
        return () => clearInterval(timer);
      }),
      effect(() => {
        const open = studio.state.open.value;
        const scene = studio.state.scene.value?.scene;
        if (!this.seen.value || !open || scene === undefined) return;
        // during typing there is a new scene with every character
        const soon = setTimeout(() => void this.list(`${scene}`), this.listed === "" ? 0 : 500);
        return () => clearTimeout(soon);
      }),
    ];
  }
  dispose(): void {
    for (const stop of this.stops) stop();
  }

  feedOf(id: number): Feed {
    let feed = this.feeds.get(id);
    if (!feed) {
      feed = new Feed(this.studio, () => this.spec(id) ?? { id, kind: "curve", title: "", signals: [], plot: "" });
      this.feeds.set(id, feed);
    }
    return feed;
  }
  spec(id: number): FigureSpec | undefined {
    return this.specs.peek().find((s) => s.id === id);
  }
  /** Whether the figure is visible: hidden ones request nothing. */
  setVisible(id: number, visible: boolean): void {
    if (visible) this.visible.add(id);
    else this.visible.delete(id);
  }

  /** Makes a figure and answers its number. Without signals its list of them opens. */
  add(kind: FigureKind, signals: string[] = [], title = "", plot = ""): number {
    const id = this.nextId++;
    const same = this.specs.value.filter((s) => s.kind === kind && !s.plot).length;
    const name = title || (kind === "curve" && signals.length === 1 ? signals[0]! : `${kKindNames[kind]} ${same + 1}`);
    const slots = kSlots[kind];
    const filled = Number.isFinite(slots) ? Array.from({ length: slots }, (_, i) => signals[i] ?? "") : signals;
    this.change([...this.specs.value, { id, kind, title: name, signals: filled, plot }]);
    this.active.value = id;
    if (!plot && filled.every((s) => s === "")) this.choose(id);
    return id;
  }
  addPlot(name: string): number {
    const there = this.specs.value.find((s) => s.plot === name);
    if (there) {
      this.active.value = there.id;
      return there.id;
    }
    const plot = this.plots.value.find((p) => p.name === name);
    return this.add(kindOf(plot?.kind ?? ""), [], plot?.title || name, name);
  }
  remove(id: number): void {
    this.change(this.specs.value.filter((s) => s.id !== id));
    this.feeds.delete(id);
    this.visible.delete(id);
    if (this.choosing.value === id) this.choosing.value = -1;
    if (this.active.value === id) this.active.value = this.specs.value[this.specs.value.length - 1]?.id ?? -1;
  }
  rename(id: number, title: string): void {
    this.change(this.specs.value.map((s) => (s.id === id ? { ...s, title } : s)));
  }
  /** Adds a signal: behind the others, or where none is chosen yet. What is there already stays once. */
  addSignal(id: number, name: string): void {
    this.change(this.specs.value.map((s) => (s.id === id ? { ...s, signals: withSignal(s, name) } : s)));
    const spec = this.spec(id);
    if (spec && Number.isFinite(kSlots[spec.kind]) && !spec.signals.includes("")) this.choosing.value = -1;
    this.active.value = id;
  }
  /** Takes the signal number `index` away. */
  removeSignal(id: number, index: number): void {
    this.change(
      this.specs.value.map((s) => {
        if (s.id !== id) return s;
        const signals = Number.isFinite(kSlots[s.kind])
          ? s.signals.map((n, i) => (i === index ? "" : n))
          : s.signals.filter((_, i) => i !== index);
        return { ...s, signals };
      }),
    );
  }
  /** Opens the list of signals of a figure. */
  choose(id: number, search = ""): void {
    this.search.value = search;
    this.choosing.value = id;
  }
  /** Handles a drop on a figure (-1: beside them): a signal is drawn, of an element its signals are offered. */
  drop(id: number, text: string): void {
    const known = this.signals.value;
    const names = text
      .split(/\r?\n/)
      .map((n) => n.trim())
      .filter((n) => n !== "");
    for (const name of names) {
      const owner = !known.some((s) => s.name === name) && known.some((s) => s.owner === name);
      const target = id >= 0 && this.spec(id) && !this.spec(id)!.plot ? id : this.add("curve", owner ? [] : [name]);
      if (owner) this.choose(target, `${name}.`);
      else this.addSignal(target, name);
    }
  }

  private tick(): void {
    this.looked.value = this.studio.state.frame.peek()?.time ?? null;
    const now = performance.now();
    for (const { id } of this.specs.peek()) if (this.visible.has(id)) void this.feedOf(id).tick(now);
  }

  private async list(scene: string): Promise<void> {
    if (scene === this.listed) return;
    this.listed = scene;
    const { link } = this.studio;
    try {
      this.signals.value = (await link.request("signals")).signals;
      this.plots.value = (await link.request("plots")).plots;
    } catch {
      // no list of signals, but figures show the error themselves; requested again when the panel is opened
      this.listed = "";
    }
  }

  private change(specs: FigureSpec[]): void {
    this.specs.value = specs;
    if (this.key === "") return;
    try {
      localStorage.setItem(this.key, JSON.stringify(specs));
    } catch {
      // no storage: figures are forgotten with the page
    }
  }
  private load(key: string): void {
    if (key === this.key) return;
    const first = this.key === "";
    this.key = key;
    const stored = readSpecs(key).map((s) => ({ ...s, id: this.nextId++ }));
    // figures from before the scene had a name stay
    if (!first || this.specs.value.length === 0) this.specs.value = stored;
    this.active.value = this.specs.value[0]?.id ?? -1;
  }
}

/** A figure's signals and `name`. */
export function withSignal(spec: FigureSpec, name: string): string[] {
  if (Number.isFinite(kSlots[spec.kind])) {
    const free = spec.signals.indexOf("");
    const slot = free >= 0 ? free : spec.signals.length - 1;
    return spec.signals.map((n, i) => (i === slot ? name : n));
  }
  return spec.signals.includes(name) ? spec.signals : [...spec.signals, name];
}

function readSpecs(key: string): FigureSpec[] {
  try {
    const stored = JSON.parse(localStorage.getItem(key) ?? "[]") as FigureSpec[];
    const text = (value: unknown): string => (typeof value === "string" ? value : "");
    return stored
      .filter((s) => s.kind in kKindNames && Array.isArray(s.signals))
      .map((s) => ({ id: 0, kind: s.kind, title: text(s.title), signals: s.signals.map(text), plot: text(s.plot) }));
  } catch {
    return [];
  }
}
