// The page's own cursor: shows and plays past frames.
import { signal } from "@preact/signals-core";
import { isClosed, messageOf, type Link } from "../core/link";
import type { State } from "../core/state";

interface Clock {
  /** [s] */
  now(): number;
  /** Calls back before the next picture; answers how to call it off. */
  next(then: () => void): () => void;
}

export class Playback {
  /** Whether the cursor runs. */
  readonly running = signal(false);
  /** Simulated per wall second. Of recordings alone: the past of a run is played at the run's speed. */
  readonly speed = signal(1);
  /** The time that the page has requested [s], until the frame is there; null: it shows `state.frame`. */
  readonly wanted = signal<number | null>(null);

  /** Called when the user changed this page's time: other windows follow. */
  moved: (live: boolean, time: number) => void = () => {};

  private inFlight = false;
  private stopClock: (() => void) | null = null;

  constructor(
    private readonly link: Link,
    private readonly state: State,
    private readonly clock: Clock,
    private readonly failed: (message: string) => void,
  ) {}

  /** [s] */
  get time(): number {
    return this.wanted.value ?? this.state.frame.value?.time ?? this.state.status.value?.time ?? 0;
  }

  recorded(): boolean {
    const kind = this.state.hello.value?.kind;
    return kind === "recording" || kind === "bundle";
  }

  /** Shows the last frame at or before `time`; the cursor no longer runs. */
  seek(time: number): void {
    this.halt();
    this.go(time);
  }

  /** The frame after the shown one, when there is one. */
  async stepForward(): Promise<void> {
    this.halt();
    const status = this.state.status.value;
    if (!status) return;
    const from = this.time;
    // Frames may lie further apart than steps, and further the older they are: reach out twice as far each time. That
    // skips none, as neighbours lie equally far apart.
    let span = Math.max(status.dt, 1e-6);
    this.state.live.value = false;
    try {
      for (;;) {
        const to = Math.min(from + span, status.last);
        const { time } = await this.link.request("seek", { time: to });
        this.moved(false, time);
        if (time > from + 1e-9 || to >= status.last) return;
        span *= 2;
      }
    } catch (error) {
      this.fail(error);
    }
  }

  async stepBack(): Promise<void> {
    this.halt();
    this.state.live.value = false;
    try {
      const { time } = await this.link.request("step-back");
      this.moved(false, time);
    } catch (error) {
      this.fail(error);
    }
  }

  live(): void {
    this.halt();
    this.wanted.value = null;
    this.state.live.value = true;
    this.moved(true, this.time);
    this.link.request("live").catch((error: unknown) => this.fail(error));
  }

  halt(): void {
    this.stopClock?.();
    this.stopClock = null;
    this.running.value = false;
  }

  /** Runs the cursor from where it is to the end, a recording that is at its end from its start. `arrived` is called at the end,
   *  not when halted. */
  run(arrived: () => void): void {
    this.halt();
    const status = this.state.status.value;
    if (!status) return;
    let time = this.time;
    if (this.recorded() && time >= status.last - 1e-9) time = status.first;
    this.running.value = true;
    let before = this.clock.now();
    const tick = () => {
      const now = this.clock.now();
      // a page that slept does not leap
      const passed = Math.min(now - before, 0.25);
      before = now;
      const status = this.state.status.value;
      if (!status) return this.halt();
      const speed = this.recorded() ? this.speed.value : (status.speed ?? 10);
      time += passed * speed;
      if (time >= status.last) {
        this.halt();
        this.go(status.last);
        arrived();
        return;
      }
      this.go(time);
      this.stopClock = this.clock.next(tick);
    };
    this.stopClock = this.clock.next(tick);
  }

  /** Another window moved. */
  follow(live: boolean, time: number): void {
    const moved = this.moved;
    this.moved = () => {};
    if (live) this.live();
    else this.seek(time);
    this.moved = moved;
  }

  /** One question at a time; those overtaken are not asked. */
  private go(time: number): void {
    const status = this.state.status.value;
    if (status) time = Math.min(Math.max(time, status.first), status.last);
    this.state.live.value = false;
    this.wanted.value = time;
    this.moved(false, time);
    if (!this.inFlight) void this.ask();
  }

  private async ask(): Promise<void> {
    this.inFlight = true;
    try {
      while (this.wanted.value !== null) {
        const time = this.wanted.value;
        await this.link.request("seek", { time });
        if (this.wanted.value === time && !this.running.value) this.wanted.value = null;
        else if (this.wanted.value === time) break;
      }
    } catch (error) {
      this.halt();
      this.wanted.value = null;
      this.fail(error);
    } finally {
      this.inFlight = false;
    }
  }

  private fail(error: unknown): void {
    // a broken connection has its own bar, and the time is requested again when it is restored
    if (isClosed(error)) return;
    this.failed(messageOf(error));
  }
}

export const browserClock: Clock = {
  now: () => performance.now() / 1000,
  next: (then) => {
    if (document.hidden) {
      const timer = setTimeout(then, 100);
      return () => clearTimeout(timer);
    }
    const id = requestAnimationFrame(then);
    return () => cancelAnimationFrame(id);
  },
};
