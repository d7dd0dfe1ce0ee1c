// The scene's tests and their results.
import { computed, effect, signal } from "@preact/signals-core";
import { isClosed, messageOf, RequestError } from "../core/link";
import type { SceneTest } from "../core/protocol";
import type { Studio } from "../core/studio";
import { orWithout } from "../control/leave_out";
import { bodiesOf } from "../view3d/selecting";
import { poseAt } from "../view3d/pose";
import { kTolerance, runsOf, seenOf, testXml, type Seen, type TestResult } from "./write";

/** Of one test on one engine, or on several that must agree. */
export interface Run {
  test: number;
  backends: string[];
  state: "waits" | "runs" | "done";
  result: TestResult | null;
  /** why there is none */
  error: string;
}

const kChosen = "cogrsim.tests.engines";
/** Steps that one request may ask for. */
const kMostSteps = 10_000;

const same = (a: readonly string[], b: readonly string[]) => a.join() === b.join();

export class TestStore {
  readonly tests = signal<SceneTest[]>([]);
  /** of the text that they are of */
  private version = -1;
  /** of the text that the results are of */
  readonly testedVersion = signal(-1);
  readonly chosen = signal<string[]>([]);
  readonly runs = signal<Run[]>([]);
  readonly busy = signal(false);
  /** A test runs that was not started here. */
  readonly others = signal(false);
  private cancelled = false;
  private loading: Promise<void> | null = null;
  private again = false;
  private readonly stops: (() => void)[];

  readonly mayRun = computed(() => this.studio.state.mayEdit.value && !this.busy.value);
  /** The results are of an older text. */
  readonly outdated = computed(
    () =>
      this.testedVersion.value >= 0 && this.testedVersion.value !== (this.studio.state.document.value?.version ?? -1),
  );

  constructor(readonly studio: Studio) {
    const { state } = studio;
    try {
      const stored = JSON.parse(localStorage.getItem(kChosen) ?? "[]") as unknown;
      if (Array.isArray(stored)) this.chosen.value = stored.filter((name) => typeof name === "string");
    } catch {
      // a browser that stores nothing
    }
    this.stops = [
      effect(() => {
        void state.problems.value;
        void state.tree.value;
        if (state.hello.value?.kind === "scene") void this.load();
      }),
      effect(() => {
        // at first the engine that the scene runs on
        const backend = state.status.value?.backend ?? "";
        if (this.chosen.peek().length === 0 && backend !== "") this.chosen.value = [backend];
      }),
    ];
  }
  dispose(): void {
    for (const stop of this.stops) stop();
  }

  /** Done when the tests of the text are there that was the newest at this call. */
  private load(): Promise<void> {
    // what is on its way may be of an older text: it is asked for once more then
    this.again = true;
    this.loading ??= this.ask().finally(() => {
      this.loading = null;
      return this.again ? this.load() : undefined;
    });
    return this.loading;
  }
  private async ask(): Promise<void> {
    this.again = false;
    try {
      const { version, tests } = await this.studio.link.request("tests");
      this.version = version;
      if (JSON.stringify(tests) !== JSON.stringify(this.tests.peek())) this.tests.value = tests;
    } catch {
      // asked again with the next text
    }
  }

  choose(name: string, on: boolean): void {
    const now = this.chosen.peek().filter((one) => one !== name);
    this.chosen.value = on ? [...now, name] : now;
    try {
      localStorage.setItem(kChosen, JSON.stringify(this.chosen.peek()));
    } catch {
      // as above
    }
  }

  run(test: number, backends: string[]): Run | undefined {
    return this.runs.value.find((r) => r.test === test && same(r.backends, backends));
  }
  private set(run: Run): void {
    const others = this.runs.peek().filter((r) => !(r.test === run.test && same(r.backends, run.backends)));
    this.runs.value = [...others, run];
  }

  /** One test, or all of them; one after the other, on the chosen engines. */
  async start(only: number | null): Promise<void> {
    if (this.busy.peek()) return;
    this.busy.value = true;
    this.others.value = false;
    this.cancelled = false;
    await this.load();
    if (only === null || this.testedVersion.peek() !== this.version) this.runs.value = [];
    this.testedVersion.value = this.version;
    const plan = this.tests
      .peek()
      .flatMap((test, i) =>
        only !== null && only !== i ? [] : runsOf(test, this.chosen.peek()).map((backends) => ({ test: i, backends })),
      );
    for (const one of plan) this.set({ ...one, state: "waits", result: null, error: "" });
    for (const one of plan) {
      if (this.cancelled) break;
      this.set({ ...one, state: "runs", result: null, error: "" });
      try {
        const result = await this.studio.link.request("test", { ...one, version: this.version });
        this.set({ ...one, state: "done", result, error: "" });
      } catch (error) {
        this.set({ ...one, state: "done", result: null, error: isClosed(error) ? "no connection" : messageOf(error) });
        const code = error instanceof RequestError ? error.failure.code : "";
        if (code === "busy") this.others.value = true;
        if (isClosed(error) || code === "stale" || code === "busy") this.cancelled = true;
      }
    }
    // what was not begun has no result
    this.runs.value = this.runs.peek().filter((r) => r.state === "done");
    this.busy.value = false;
  }
  cancel(): void {
    this.cancelled = true;
    this.others.value = false;
    this.studio.link.request("test-cancel").catch(() => {});
  }

  /** Shows the scene's run on that engine at that time; what has not been run yet is run up to there. */
  async goTo(backend: string, time: number): Promise<void> {
    const { link, state } = this.studio;
    try {
      const status = state.status.peek();
      if (!status) return;
      if (status.backend !== backend || status.last < time - 0.5 * status.dt) {
        // an engine that is refused leaves the run as it was
        if (status.backend !== backend) {
          const ask = (without: string[] | null) => link.request("backend", { name: backend, without });
          if (!(await orWithout(this.studio, { name: backend }, ask))) return;
        }
        if (status.backend !== backend || status.state === "ended") await link.request("stop");
        else if (status.state === "playing") await link.request("pause");
        await link.request("live");
        const begun = status.backend === backend && status.state !== "ended" ? status.time : 0;
        for (let left = Math.round((time - begun) / status.dt); left > 0; left -= kMostSteps)
          await link.request("step", { count: Math.min(left, kMostSteps) });
        // live, it shows that time as soon as it is there
      } else this.studio.seek(time);
    } catch (error) {
      if (!isClosed(error)) this.studio.notify(messageOf(error), "error");
    }
  }

  /** What a test can be made of now: what is selected, as it is shown. */
  seen(): Seen[] {
    const { state } = this.studio;
    const [scene, frame] = [state.scene.value, state.frame.value];
    if (!scene || !frame || frame.scene !== scene.scene) return [];
    const selected = state.selection.value;
    return seenOf(
      scene,
      selected,
      selected.length > 0 ? bodiesOf(state, selected) : [],
      (body) => (7 * body + 6 < frame.poses.length ? poseAt(frame.poses, body) : null),
      (joint) => frame.tail.joints?.[joint]?.position[0] ?? null,
    );
  }

  /** Asks for name and tolerance, and writes the test into the scene. */
  async make(): Promise<void> {
    const { state } = this.studio;
    const seen = this.seen();
    const time = state.frame.peek()?.time ?? 0;
    const unit = seen[0]?.unit;
    if (!unit || time <= 0) {
      this.studio.notify("run to a time, and select a body that moves or a joint", "error");
      return;
    }
    const [shown, scale] = unit === "m" ? ["cm", 0.01] : ["°", Math.PI / 180];
    const answer = await this.studio.dialog({
      title: "Make a test of what I see",
      text: `At ${time.toFixed(3)} s: ${seen.map((s) => s.that).join(", ")}. Inputs by hand are not part of a test.`,
      fields: [
        { name: "name", label: "Name", value: `${seen[0]!.that.replace(/\.[^.]*$/, "")} at ${time.toFixed(2)} s` },
        {
          name: "tolerance",
          label: `Tolerance [${shown}]`,
          kind: "number",
          value: "1",
          help: "Engines differ, the more the later: see Comparing engines",
        },
      ],
      accept: "Make",
    });
    if (!answer) return;
    const tolerance = Number((answer.tolerance ?? "").replace(",", ".")) * scale;
    const name = (answer.name ?? "").trim();
    if (!(tolerance > 0) || !Number.isFinite(tolerance) || name === "") {
      this.studio.notify("a test needs a name and a tolerance above 0", "error");
      return;
    }
    const xml = testXml(name, time, seen, { ...kTolerance, [unit]: tolerance });
    await this.studio.edit(`make a test of ${seen[0]!.that}`, [{ op: "insert", parent: 0, xml, before: null }]);
  }
}
