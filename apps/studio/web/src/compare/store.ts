// Starts and ends comparisons, and requests the divergence of the two runs.
import { computed, effect, signal } from "@preact/signals-core";
import { isClosed, messageOf } from "../core/link";
import type { Studio } from "../core/studio";
import { orWithout } from "../control/leave_out";
import type { Divergence } from "./divergence";

/** [ms] between two looks; more when answers take their time. */
const kPause = 400;

export class CompareStore {
  readonly data = signal<Divergence | null>(null);
  readonly error = signal("");
  /** whether the panel is visible; nothing is requested otherwise */
  readonly seen = signal(false);
  /** time that the page shows [s], a few times a second */
  readonly looked = signal<number | null>(null);
  readonly busy = signal(false);

  readonly labels = computed(() => this.studio.state.status.value?.compare?.labels ?? null);
  /** what can be compared with what runs now */
  readonly others = computed(() => {
    const present = this.studio.state.status.value?.backend;
    return (this.studio.state.hello.value?.backends ?? []).filter((b) => b !== present);
  });
  readonly step = computed(() => this.studio.state.status.value?.dt ?? null);

  private asking = false;
  private nextLook = 0;
  private key = "";
  private readonly stops: (() => void)[];

  constructor(readonly studio: Studio) {
    this.stops = [
      effect(() => {
        if (!this.seen.value) return;
        const timer = setInterval(() => void this.tick(), 100);
        return () => clearInterval(timer);
      }),
      effect(() => {
        if (this.labels.value === null) this.data.value = null;
      }),
    ];
  }
  dispose(): void {
    for (const stop of this.stops) stop();
  }

  /** Runs the scene on `backend` beside the present one, both from time 0; null: with another `step` [s]. */
  async compare(what: { backend: string } | { step: number }): Promise<void> {
    this.busy.value = true;
    const asked = await orWithout(
      this.studio,
      { name: "backend" in what ? what.backend : "", beside: true },
      (without) => this.studio.link.request("compare", { backend: null, step: null, ...what, without }),
    );
    if (asked) this.studio.openPanel("compare");
    this.busy.value = false;
  }
  async off(): Promise<void> {
    try {
      await this.studio.link.request("compare-off");
    } catch (error) {
      this.studio.notify(messageOf(error), "error");
    }
  }

  /** Selects the body of that name, if something in the file made it. */
  select(name: string): void {
    const body = this.studio.state.scene.value?.bodies.find((b) => b.name === name);
    if (body && body.element >= 0) this.studio.select([body.element]);
    else this.studio.notify(`nothing in this file made ${name}`);
  }

  private async tick(): Promise<void> {
    this.looked.value = this.studio.state.frame.peek()?.time ?? null;
    const status = this.studio.state.status.peek();
    const now = performance.now();
    if (!status?.compare || this.asking || now < this.nextLook) return;
    const key = JSON.stringify([status.compare, status.scene, status.last, status.frames]);
    if (key === this.key) return;
    this.asking = true;
    try {
      this.data.value = await this.studio.link.request("divergence");
      this.error.value = "";
      this.key = key;
    } catch (error) {
      if (!isClosed(error)) this.error.value = messageOf(error);
    } finally {
      this.asking = false;
      const took = performance.now() - now;
      this.nextLook = performance.now() + Math.max(kPause, 4 * took);
    }
  }
}
