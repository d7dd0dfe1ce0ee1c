// A Link that answers from memory: for a run that came with the page.
import { RequestError, type Link, type Unsubscribe } from "./link";
import type { Frame, Picture } from "./frame";
import type { Paths, Scene, Status } from "./protocol";
import { LinkListeners, nextPicture } from "./listeners";
import type { MemoryRun, MemorySignal } from "./memory_run";
import { divergenceOf, poseSignals } from "./pose_signals";
import { indexAt, lowHigh } from "./series";

/** The paths of a run that came whole do not change. */
const kPathsRevision = 1;

type Fields = Record<string, unknown>;
export class MemoryLink extends LinkListeners implements Link {
  protected readonly run: MemoryRun;
  /** index of the shown frame */
  protected at = 0;
  private subscribed = { contacts: false, readings: false };
  /** cameras whose pictures are requested, with the last one sent */
  private cameras = new Map<string, Picture | null>();
  private publishedScene = -1;
  private poses: { scene: Scene | undefined; signals: MemorySignal[] } = { scene: undefined, signals: [] };
  private waiting = false;

  constructor(run: MemoryRun) {
    super();
    if (run.count < 1) throw new Error("a run in memory needs at least one frame");
    this.run = run;
  }

  async request<Answer = Fields>(what: string, fields: Fields = {}): Promise<Answer> {
    // answers come later, as over a network
    await Promise.resolve();
    return (await this.answer(what, fields)) as Answer;
  }
  onOpen(listener: (open: boolean) => void): Unsubscribe {
    queueMicrotask(() => listener(true));
    return () => {};
  }
  asset(path: string): string {
    return this.run.assets?.[path] ?? "";
  }

  protected status(): Status {
    const { run } = this;
    const scene = run.scenes[run.scenes.length - 1]!;
    const last = run.timeOf(run.count - 1);
    return {
      state: "recording",
      ending: run.ending,
      state_hash: run.stateHash ?? "",
      time: last,
      step_count: run.frame(run.count - 1).step,
      dt: run.dt,
      scene_dt: scene.step,
      speed: 1,
      factor: 0,
      backend: run.backend,
      engine_version: run.engineVersion,
      provenance: run.provenance ?? null,
      recording: null,
      first: run.timeOf(0),
      last,
      frames: run.count,
      scene: scene.scene,
      compare: run.compare ?? null,
      viewers: 1,
    };
  }

  /** Whether the page shows the newest frame of a run that continues. */
  protected live(): boolean {
    return false;
  }

  protected answer(what: string, fields: Fields): unknown {
    const { run } = this;
    switch (what) {
      case "hello":
        queueMicrotask(() => this.publishAll());
        return run.hello;
      case "seek":
        return this.look(indexAt(run.count, (i) => run.timeOf(i), Number(fields.time)));
      case "step-back":
        return this.look(this.at - 1);
      case "live":
        return this.look(run.count - 1);
      case "subscribe":
        this.subscribed = { contacts: fields.contacts === true, readings: fields.readings === true };
        this.show();
        return {};
      case "signals":
        return { signals: this.signals().map(({ name, unit, owner }) => ({ name, unit, owner })) };
      case "series":
        return this.series(fields);
      case "divergence": {
        const divergence = run.divergence ?? (run.compare ? divergenceOf(run, run.compare.labels) : null);
        if (!divergence) throw refused("nothing is compared in this run");
        return divergence;
      }
      case "plots":
        return { plots: run.plots ?? [] };
      case "figure": {
        const figure = run.figures?.[String(fields.plot)];
        if (!figure) throw refused(`no figure '${String(fields.plot)}' in this run`);
        return figure;
      }
      case "paths":
        return this.paths(fields.revision === kPathsRevision);
      case "events":
        return { events: (run.events ?? []).filter((e) => e.index >= Number(fields.from ?? 0)) };
      case "cameras":
        return this.showCameras(fields.show as { name: string; kind: string }[]);
      case "sources":
        return { files: [] };
      default:
        throw refused(`'${what}' needs a server`, "open the scene with 'cogrsim studio'");
    }
  }

  private paths(known: boolean): Paths {
    const { run } = this;
    return {
      revision: kPathsRevision,
      until: run.timeOf(run.count - 1),
      paths: (run.paths ?? []).map(({ label, body, times, points }) => ({
        label,
        body,
        from: known ? times.length : 0,
        times: known ? [] : Array.from(times),
        points: known ? [] : Array.from(points),
        last: [],
      })),
    };
  }

  protected publishAll(): void {
    const { run } = this;
    this.publish("status", this.status());
    this.publishedScene = -1;
    this.publishScene(run.frame(this.at).scene);
    if (run.document) this.publish("document", run.document);
    if (run.elements) this.publish("tree", { version: run.document?.version ?? 0, elements: run.elements });
    if (run.problems) this.publish("problems", { version: run.document?.version ?? 0, problems: run.problems });
    if (run.messages) this.publish("messages", { messages: run.messages });
    if (run.events) this.publish("events", { events: run.events });
    this.show();
  }

  /** Forgets which scene was published, after a change of its contents. */
  protected publishScene(number: number): void {
    if (number === this.publishedScene) return;
    const scene = this.run.scenes.find((s) => s.scene === number);
    if (!scene) return;
    this.publishedScene = number;
    this.publish("scene", scene);
  }

  /** Pictures that came with the run are all there is. */
  private showCameras(show: { name: string; kind: string }[]): unknown {
    const { pictures = [] } = this.run;
    const there = show.filter(({ name, kind }) => pictures.some((p) => p.name === name && p.kind === kind));
    if (show.length > 0 && there.length === 0) {
      const what = show.map(({ name, kind }) => `'${name}' (${kind})`).join(", ");
      throw refused(`no pictures of ${what} came with this run`, "open the scene with 'cogrsim studio'");
    }
    this.cameras = new Map(there.map(({ name }) => [name, null]));
    this.show();
    return {};
  }

  /** The newest of each camera not later than `time` [s]. */
  private publishPictures(time: number): void {
    const { pictures = [] } = this.run;
    for (const [name, last] of this.cameras) {
      const mine = pictures.filter((p) => p.name === name);
      const picture = mine[indexAt(mine.length, (i) => mine[i]!.time, time)];
      if (!picture || picture === last || picture.time > time + 5e-10) continue;
      this.cameras.set(name, picture);
      this.pictures.publish(picture);
    }
  }

  private look(index: number): { time: number } {
    this.at = Math.min(Math.max(index, 0), this.run.count - 1);
    this.show();
    return { time: this.run.timeOf(this.at) };
  }

  /** Hands the present frame out, once per animation frame. */
  protected show(): void {
    if (this.waiting) return;
    this.waiting = true;
    nextPicture(() => {
      this.waiting = false;
      const frame = this.run.frame(this.at);
      this.publishScene(frame.scene);
      const tail: Frame["tail"] = {};
      if (this.subscribed.contacts && frame.tail.contacts) tail.contacts = frame.tail.contacts;
      if (this.subscribed.readings && frame.tail.readings) tail.readings = frame.tail.readings;
      const { scene, time, step, poses, ghost } = frame;
      this.frames.publish({ live: this.live(), scene, time, step, poses, ghost, tail });
      this.publishPictures(time);
    });
  }

  /** Those that came with the run, and where its bodies are. */
  private signals(): MemorySignal[] {
    const newest = this.run.scenes[this.run.scenes.length - 1];
    if (this.poses.scene !== newest) this.poses = { scene: newest, signals: poseSignals(this.run) };
    const own = this.run.signals ?? [];
    const names = new Set(own.map((s) => s.name));
    return [...own, ...this.poses.signals.filter((s) => !names.has(s.name))];
  }

  private series(fields: Fields): unknown {
    const { run } = this;
    const names = fields.signals as string[];
    const from = typeof fields.from === "number" ? fields.from : -Infinity;
    const to = typeof fields.to === "number" ? fields.to : Infinity;
    const points = typeof fields.points === "number" ? fields.points : 2000;
    let begin = indexAt(run.count, (i) => run.timeOf(i), from);
    if (run.timeOf(begin) < from) begin += 1;
    const end = to < run.timeOf(0) ? 0 : indexAt(run.count, (i) => run.timeOf(i), to) + 1;
    let time: number[] = [];
    const all = this.signals();
    const series = names.map((name) => {
      const signal = all.find((s) => s.name === name);
      if (!signal) throw refused(`no signal '${name}'`);
      const values = fields.run === "ghost" ? (signal.ghost ?? new Float64Array(run.count).fill(NaN)) : signal.values;
      const { picks, low, high } = lowHigh(values, begin, end, points);
      time = picks.map((i) => run.timeOf(i));
      return { signal: name, unit: signal.unit, low, high };
    });
    return { time, series };
  }
}

export function refused(message: string, help?: string, code?: string): RequestError {
  return new RequestError({ message, help, code });
}
