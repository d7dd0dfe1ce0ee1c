// Steering the run, as commands.
import { effect } from "@preact/signals-core";
import { isClosed, messageOf, type FieldsOf } from "../core/link";
import type { Answer, RequestName } from "../core/protocol";
import type { Studio } from "../core/studio";
import type { Playback } from "../timeline/playback";
import { isRefused, leftOutByEngine, leftOutText, orWithout } from "./leave_out";
import { neighbour } from "../timeline/scale";
import {
  kSpeeds,
  nextSpeed,
  playMeans,
  recorded,
  reloadText,
  speedText,
  whyNot,
  type Action,
  type Situation,
} from "./rules";

export class Control {
  constructor(
    readonly studio: Studio,
    readonly playback: Playback,
  ) {}

  /** Reads signals: an effect that calls it runs again on changes. */
  situation(): Situation {
    const { state } = this.studio;
    return {
      hello: state.hello.value,
      open: state.open.value,
      status: state.status.value,
      live: state.live.value,
      replaying: this.playback.running.value,
    };
  }
  whyNot(action: Action): string | null {
    return whyNot(action, this.situation());
  }

  /** Whether something moves on this page. */
  moving(): boolean {
    const now = this.situation();
    return now.replaying || (now.live && now.status?.state === "playing");
  }
  speed(): number | null {
    const now = this.situation();
    return recorded(now) ? this.playback.speed.value : (now.status?.speed ?? null);
  }

  async ask<Name extends RequestName>(what: Name, ...fields: FieldsOf<Name>): Promise<Answer<Name> | null> {
    try {
      return await this.studio.link.request(what, ...fields);
    } catch (error) {
      if (!isClosed(error)) this.studio.notify(messageOf(error), "error");
      return null;
    }
  }

  play(): void {
    if (playMeans(this.situation()) === "run") {
      void this.ask("play");
      return;
    }
    this.playback.run(() => {
      if (this.playback.recorded()) return;
      this.playback.live();
      if (this.whyNot("play") === null) void this.ask("play");
    });
  }
  pause(): void {
    if (this.playback.running.value) this.playback.halt();
    else void this.ask("pause");
  }
  stop(): void {
    if (recorded(this.situation())) {
      this.playback.seek(this.studio.state.status.value?.first ?? 0);
      return;
    }
    this.playback.halt();
    void this.ask("stop").then((done) => done && this.playback.live());
  }
  restart(): void {
    if (recorded(this.situation())) {
      this.playback.seek(this.studio.state.status.value?.first ?? 0);
      this.play();
      return;
    }
    this.playback.halt();
    void this.ask("restart").then((done) => done && this.playback.live());
  }
  step(): void {
    const now = this.situation();
    if (recorded(now) || !now.live) void this.playback.stepForward();
    else void this.ask("step", { count: 1 });
  }
  changeSpeed(direction: 1 | -1): void {
    this.setSpeed(nextSpeed(this.speed(), direction, !recorded(this.situation())));
  }
  setSpeed(factor: number | null): void {
    if (recorded(this.situation())) this.playback.speed.value = factor ?? 10;
    else void this.ask("speed", { factor });
  }
  async setBackend(name: string): Promise<void> {
    const answer = await orWithout(this.studio, { name }, (without) =>
      this.studio.link.request("backend", { name, without }),
    );
    if (answer) this.studio.notify([`the run continues with ${name}`, ...answer.notes].join("; "));
  }
  /** Of a scene that the present engine refuses. */
  async leaveOut(): Promise<void> {
    if (!isRefused(this.studio)) return;
    const name = this.studio.state.status.value?.backend || (await this.ask("lacking", { name: "" }))?.name;
    if (name) await this.setBackend(name);
  }
  /** Shows what the run leaves out; who steers it can run with everything. */
  async showLeftOut(): Promise<void> {
    const name = this.studio.state.status.value?.backend ?? "";
    const list = document.createElement("ul");
    list.dataset.testid = "left-out-list";
    for (const { engine, all } of leftOutByEngine(this.studio)) {
      const row = document.createElement("li");
      row.textContent = `${engine}: ${leftOutText(all)}`;
      list.append(row);
    }
    const steers = this.whyNot("backend") === null;
    const accepted = await this.studio.dialog({
      title: "Left out of this run",
      text: "What these engines lack of the scene, and the run is without.",
      fields: [],
      preview: () => Promise.resolve(list),
      accept: steers ? "Run with everything" : "Close",
    });
    if (accepted && steers) await this.ask("backend", { name, without: [] });
  }
  /** The libraries of all controllers as they are on disk now. */
  async reload(): Promise<void> {
    const answer = await this.ask("reload");
    if (answer) this.studio.notify(reloadText(answer));
  }
  async record(file: string): Promise<void> {
    const on = !this.studio.state.status.value?.recording;
    const answer = await this.ask("record", on && file ? { on, file } : { on });
    if (!answer) return;
    const { file: named } = answer;
    this.studio.notify(on ? `recording to ${named}` : `recorded${named ? ` to ${named}` : ""}`);
  }

  /** [s], in order: events, and where two runs part. */
  bookmarks(): number[] {
    const { events, status } = this.studio.state;
    const divergence = status.value?.compare?.first_over;
    const times = events.value.map((e) => e.time);
    if (typeof divergence === "number") times.push(divergence);
    return times.sort((a, b) => a - b);
  }
  toBookmark(direction: 1 | -1): void {
    const time = neighbour(this.bookmarks(), this.playback.time, direction);
    if (time === undefined)
      this.studio.notify(direction > 0 ? "no event after this time" : "no event before this time");
    else this.playback.seek(time);
  }

  register(): void {
    const { commands } = this.studio;
    const add = (id: string, label: string, action: Action | null, execute: () => void) =>
      commands.addCommand(id, {
        label,
        caption: () => (action && this.whyNot(action)) ?? "",
        isEnabled: () => action === null || this.whyNot(action) === null,
        execute: () => execute(),
      });
    commands.addCommand("run:toggle", {
      label: () => (this.moving() ? "Pause" : "Play"),
      isEnabled: () => this.whyNot(this.moving() ? "pause" : "play") === null,
      execute: () => (this.moving() ? this.pause() : this.play()),
    });
    add("run:stop", "Stop, back to the start", "stop", () => this.stop());
    add("run:restart", "Restart", "restart", () => this.restart());
    add("run:step-back", "Step back", "step-back", () => void this.playback.stepBack());
    add("run:step", "Step forward", "step", () => this.step());
    add("run:slower", "Slower", "speed", () => this.changeSpeed(-1));
    add("run:faster", "Faster", "speed", () => this.changeSpeed(1));
    add("run:as-fast-as-possible", "As fast as possible", "speed", () =>
      this.setSpeed(recorded(this.situation()) ? 10 : null),
    );
    add("run:live", "Follow the run (live)", "live", () => this.playback.live());
    add("run:previous-event", "Previous event", null, () => this.toBookmark(-1));
    add("run:next-event", "Next event", null, () => this.toBookmark(1));
    add("run:reload", "Reload controllers", "reload", () => void this.reload());
    commands.addCommand("run:leave-out", {
      label: "Leave out what the engine lacks…",
      isEnabled: () => this.whyNot("backend") === null && isRefused(this.studio),
      execute: () => void this.leaveOut(),
    });
    add("run:record", "Record, or end the recording", "record", () => void this.record(""));
    // menus and palette read what is enabled when they open; a palette that is open is notified
    effect(() => {
      this.situation();
      commands.notifyCommandChanged("run:toggle");
    });
  }
}

export { kSpeeds, speedText };
