// Stands for a server while working on the page: plays a made-up run and keeps a text with a history.
import { MemoryLink, refused } from "../core/memory_link";
import type { MemoryRun } from "../core/memory_run";
import { kProtocol, type Op, type Paths, type RunState, type Status } from "../core/protocol";
import { demoScene, frameAt, kText } from "./motion";
import { positionOf, tokens } from "./tokens";

type Fields = Record<string, unknown>;
const kSceneStep = 0.001;
/** Steps between frames that are kept. */
const kStride = 10;
const kSignals: [string, string, number][] = [
  ["crate.z", "m", 1 * 7 + 2],
  ["ball.z", "m", 2 * 7 + 2],
  ["robot.deck.x", "m", 3 * 7],
  ["robot.deck.y", "m", 3 * 7 + 1],
];

export class DemoLink extends MemoryLink {
  private state: RunState;
  private speed: number | null = 1;
  private dt = kSceneStep;
  private backend = "bullet";
  private recording: string | null = null;
  private compared: Status["compare"] = null;
  private follows = true;
  private text = kText;
  private saved = kText;
  private version = 1;
  private past: { text: string; label: string }[] = [];
  private future: { text: string; label: string }[] = [];
  private lastGroup = "";

  /** `whole`: all 10 s are there already, as in a recording. */
  constructor(private readonly whole = false) {
    const run: MemoryRun = {
      hello: {
        role: "operator",
        client: 1,
        version: "0.1.0",
        kind: whole ? "recording" : "scene",
        file: whole ? "demo.mcap" : "demo.scene.xml",
        allow_build: false,
        protocol: kProtocol,
        backends: ["bullet", "mujoco"],
      },
      scenes: [demoScene(1, kText)],
      count: whole ? 1001 : 1,
      timeOf: (i) => i * kStride * kSceneStep,
      frame: (i) => frameAt(run.scenes[0]!.scene, i * kStride, kSceneStep, this.compared !== null),
      backend: "bullet",
      engineVersion: "3.24",
      ending: "",
      dt: kSceneStep,
      messages: [{ time: 0, severity: "warning", source: "diff_drive", message: "no waypoints: drives a circle" }],
      events: [],
      problems: [],
    };
    super(run);
    this.state = whole ? "recording" : "stopped";
    if (whole) run.events = this.eventsUntil(10);
    this.replaceText();
    run.signals = kSignals.map(([name, unit, slot]) => ({
      name,
      unit,
      owner: name.replace(/\.\w$/, ""),
      values: new Proxy([], {
        get: (_, key) => (key === "length" ? run.count : run.frame(Number(key)).poses[slot]),
      }),
    }));
    setInterval(() => this.advance(0.05), 50);
  }

  protected override live(): boolean {
    return this.follows && !this.whole;
  }

  protected override status(): Status {
    return {
      ...super.status(),
      state: this.state,
      dt: this.dt,
      scene_dt: kSceneStep,
      speed: this.speed,
      factor: this.state === "playing" ? (this.speed ?? 42) : 0,
      backend: this.backend,
      recording: this.recording,
      compare: this.compared,
      viewers: 2,
    };
  }

  private eventsUntil(time: number) {
    const all = [
      { time: 0.3, kind: "contact", source: "physics", subject: "ball", message: "ball touches ground" },
      { time: 2.6, kind: "enter", source: "region", subject: "robot", message: "robot enters the north" },
      { time: 7.1, kind: "fault", source: "fault", subject: "drive_left", message: "drive_left loses half its torque" },
    ];
    return all.filter((e) => e.time <= time).map((e, index) => ({ index, ...e }));
  }

  private advance(seconds: number): void {
    if (this.state !== "playing") return;
    const before = this.run.events!.length;
    this.run.count = Math.min(this.run.count + Math.max(1, Math.round((seconds * (this.speed ?? 42)) / 0.01)), 1001);
    if (this.run.count === 1001) {
      this.state = "ended";
      this.run.ending = "its duration of 10 s is over";
    }
    this.run.events = this.eventsUntil(this.run.timeOf(this.run.count - 1));
    if (this.run.events.length > before) this.publish("events", { events: this.run.events.slice(before) });
    if (this.compared && this.run.count > 200) this.compared = { ...this.compared, first_over: 2 };
    this.changed();
  }

  private changed(): void {
    if (this.follows) this.at = this.run.count - 1;
    this.publish("status", this.status());
    this.show();
  }

  protected override answer(what: string, fields: Fields): unknown {
    switch (what) {
      case "seek":
      case "step-back":
        this.follows = false;
        return super.answer(what, fields);
      case "live":
        this.follows = true;
        return super.answer(what, fields);
      case "plots":
        return { plots: [{ name: "heights", kind: "line", title: "Heights", series: [] }] };
      case "figure":
        return this.figure();
      case "divergence":
        return this.divergence();
      case "paths":
        return this.deckPath();
      case "complete":
        return {
          from: fields.offset,
          items: [{ label: "box", detail: "a box", insert: 'box name="" size="10 10 10 cm"/>' }],
        };
      case "mass":
        return { mass: 1.2, com: [0, 0, 0.06], inertia: [0.002, 0.004, 0.005, 0, 0, 0], bodies: ["robot.deck"] };
      case "set-text":
        this.check(fields);
        this.write(String(fields.text), "typing", String(fields.group ?? ""));
        return { version: this.version };
      case "edit":
        this.check(fields);
        return this.edit(fields.ops as Op[], String(fields.label));
      case "undo":
      case "redo":
        return this.back(what);
      case "save":
        this.saved = this.text;
        this.publishText();
        return { file: "demo.scene.xml", backup: "demo.scene.xml~" };
      default:
        return this.steer(what, fields);
    }
  }

  private steer(what: string, fields: Fields): unknown {
    if (this.whole) return super.answer(what, fields);
    switch (what) {
      case "play":
        if (this.state === "ended") throw refused("the run has ended", "restart it");
        this.state = "playing";
        break;
      case "pause":
        this.state = "paused";
        break;
      case "stop":
      case "restart":
        this.run.count = 1;
        this.run.events = [];
        this.run.ending = "";
        this.follows = true;
        this.state = "stopped";
        this.changed();
        if (what === "restart") this.state = "playing";
        break;
      case "step":
        this.state = "paused";
        this.run.count = Math.min(this.run.count + Number(fields.count ?? 1), 1001);
        break;
      case "speed":
        this.speed = fields.factor as number | null;
        break;
      case "dt":
        this.dt = (fields.value as number | null) ?? kSceneStep;
        break;
      case "backend":
        this.backend = String(fields.name);
        this.changed();
        return { notes: ["contacts are solved again"] };
      case "lacking":
        return { name: String(fields.name), left_out: [], needed: [] };
      case "record":
        this.recording = fields.on ? String(fields.file ?? "demo.mcap") : null;
        this.changed();
        return { file: this.recording };
      case "compare":
        this.compared = { labels: ["bullet", String(fields.backend ?? "bullet")], first_over: null };
        break;
      case "compare-off":
        this.compared = null;
        break;
      default:
        return super.answer(what, fields);
    }
    this.changed();
    return {};
  }

  private figure(): unknown {
    const x = Array.from({ length: this.run.count }, (_, i) => this.run.timeOf(i));
    const y = Array.from(x, (_, i) => this.run.frame(i).poses[16]!);
    return {
      kind: "line",
      title: "Heights",
      x: { label: "time", unit: "s" },
      y: { label: "height", unit: "m" },
      series: [{ label: "ball", x, y }],
    };
  }

  private divergence(): unknown {
    if (!this.compared) throw refused("nothing is compared");
    const time = Array.from({ length: this.run.count }, (_, i) => this.run.timeOf(i));
    const distance = time.map((_, i) => {
      const frame = this.run.frame(i);
      return Math.hypot(frame.poses[21]! - frame.ghost[21]!, frame.poses[22]! - frame.ghost[22]!);
    });
    return {
      time,
      worst: distance,
      worst_angle: time.map((t) => 0.012 * t),
      bodies: [{ name: "robot.deck", distance }],
      first: this.run.count > 200 ? { time: 2, name: "robot.deck" } : null,
      labels: this.compared.labels,
    };
  }

  private deckPath(): Paths {
    const frames = Array.from({ length: this.run.count }, (_, i) => this.run.frame(i));
    const points = frames.flatMap(({ poses }) => [...poses.subarray(21, 24)]);
    const path = { label: "robot", body: "robot.deck", from: 0, times: frames.map((f) => f.time), points, last: [] };
    return { revision: Date.now(), until: frames[frames.length - 1]!.time, paths: [path] };
  }

  private check(fields: Fields): void {
    if (fields.version !== this.version) throw refused("the text has changed since", "try again", "stale");
  }

  private edit(ops: Op[], label: string): unknown {
    let text = this.text;
    for (const op of ops) {
      if (op.op !== "set") throw refused(`the demonstration knows no '${op.op}'`);
      const element = tokens(text).elements[op.element];
      if (!element) throw refused(`no element ${op.element}`);
      let tag = text.slice(element.from, element.to);
      const there = new RegExp(`(\\s${op.attribute}\\s*=\\s*")[^"]*(")`);
      if (op.value === null) tag = tag.replace(new RegExp(`\\s+${op.attribute}\\s*=\\s*"[^"]*"`), "");
      else if (there.test(tag)) tag = tag.replace(there, (_, a: string, b: string) => a + op.value + b);
      else tag = tag.replace(/\s*\/?>$/, (end) => ` ${op.attribute}="${op.value}"${end}`);
      text = text.slice(0, element.from) + tag + text.slice(element.to);
    }
    this.write(text, label, "");
    return { version: this.version, created: [] };
  }

  private write(text: string, label: string, group: string): void {
    if (!group || group !== this.lastGroup) this.past.push({ text: this.text, label });
    this.lastGroup = group;
    this.future = [];
    this.text = text;
    this.publishText();
  }

  private back(what: "undo" | "redo"): unknown {
    const [from, to] = what === "undo" ? [this.past, this.future] : [this.future, this.past];
    const step = from.pop();
    if (!step) throw refused(`nothing to ${what}`);
    to.push({ text: this.text, label: step.label });
    this.text = step.text;
    this.lastGroup = "";
    this.publishText();
    return { version: this.version, label: step.label };
  }

  private publishText(): void {
    this.version += 1;
    this.replaceText();
    const { run } = this;
    this.publish("document", run.document!);
    if (run.document!.good) {
      run.scenes = [demoScene(run.scenes[0]!.scene + 1, this.text)];
      this.publish("tree", { version: this.version, elements: run.elements! });
      this.publishScene(run.scenes[0]!.scene);
    }
    this.publish("problems", { version: this.version, problems: run.problems! });
    this.changed();
  }

  private replaceText(): void {
    const read = tokens(this.text);
    const good = read.wrong < 0;
    this.run.document = {
      version: this.version,
      text: this.text,
      file: "demo.scene.xml",
      dirty: this.text !== this.saved,
      undo: this.past[this.past.length - 1]?.label ?? null,
      redo: this.future[this.future.length - 1]?.label ?? null,
      by: 1,
      good,
    };
    if (good) this.run.elements = read.elements;
    this.run.problems = good
      ? []
      : [
          {
            severity: "error",
            code: "xml",
            message: read.why,
            help: "",
            file: "demo.scene.xml",
            ...positionOf(this.text, read.wrong),
            length: 1,
            notes: [],
          },
        ];
  }
}
