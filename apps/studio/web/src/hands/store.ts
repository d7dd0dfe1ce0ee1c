// What a person does in the run with joints and motors.
import { computed, effect, signal } from "@preact/signals-core";
import { isClosed, messageOf } from "../core/link";
import type { Studio } from "../core/studio";
import { preview } from "../view3d/settings";
import { jointRows, movedBy, positionText, type JointRow } from "./mechanism";

/** How long a change that the server took is shown before its scene comes [ms]. */
const kPatience = 3000;

export class HandStore {
  /** Targets that were set by hand in this run, by the motor's name. */
  readonly targets = signal<ReadonlyMap<string, number>>(new Map());
  /** Something was done by hand in this run, or in one before it. */
  readonly any = signal(false);
  readonly mayDrive = computed(() => {
    const { hello, open, status } = this.studio.state;
    return hello.value?.role === "operator" && hello.value.kind === "scene" && open.value && !!status.value;
  });
  /** At the start: where joints start is set here; later motors and forces move them. */
  readonly atStart = computed(() => {
    const status = this.studio.state.status.value;
    return status?.state === "stopped" && status.step_count === 0;
  });
  readonly joints = computed<JointRow[]>(() => {
    const scene = this.studio.state.scene.value;
    return scene ? jointRows(scene) : [];
  });
  /** Targets on their way: one request at a time for each motor, the newest waits. */
  private readonly waiting = new Map<string, number>();
  private readonly sending = new Set<string>();
  private readonly stops: (() => void)[];

  constructor(readonly studio: Studio) {
    const { state } = studio;
    let scene = -1;
    let before = 0;
    let given = 0;
    this.stops = [
      effect(() => {
        // what runs is seen as it is
        if (!this.atStart.value) preview.value = null;
      }),
      effect(() => {
        // back at the start motors have the scene's own targets again; a run that was stopped and begun
        // between two statuses may have as many steps, but not as many inputs
        const steps = state.status.value?.step_count ?? 0;
        const inputs = state.status.value?.inputs ?? 0;
        if (steps < before || inputs < given) this.targets.value = new Map();
        before = steps;
        given = inputs;
        if (inputs > 0) this.any.value = true;
      }),
      effect(() => {
        const now = state.scene.value?.scene ?? -1;
        if (now !== scene) preview.value = null;
        scene = now;
      }),
    ];
  }
  dispose(): void {
    for (const stop of this.stops) stop();
    preview.value = null;
  }

  setMotor(name: string, target: number): void {
    const next = new Map(this.targets.peek());
    next.set(name, target);
    this.targets.value = next;
    this.waiting.set(name, target);
    if (!this.sending.has(name)) void this.send(name);
  }
  private async send(name: string): Promise<void> {
    this.sending.add(name);
    try {
      for (let target = this.waiting.get(name); target !== undefined; target = this.waiting.get(name)) {
        this.waiting.delete(name);
        const answer = await this.studio.link.request("motor", { motor: name, target });
        if (answer.target === target || this.waiting.has(name)) continue;
        const next = new Map(this.targets.peek());
        next.set(name, answer.target);
        this.targets.value = next;
      }
    } catch (error) {
      this.waiting.delete(name);
      if (!isClosed(error)) this.studio.notify(messageOf(error), "error");
    } finally {
      this.sending.delete(name);
    }
  }

  /** Shows what a joint carries where it would start; the text stays as it is. */
  showStart({ index, joint }: JointRow, position: number): void {
    const { scene, frame } = this.studio.state;
    const now = scene.peek();
    if (!now) return;
    const shown = frame.peek();
    const poses = shown && shown.scene === now.scene ? shown.poses : now.bodies.flatMap((b) => b.pose);
    preview.value = movedBy(now, poses, index, position - (joint.start?.[0] ?? 0));
  }
  /** Writes it. The picture of it stays until the scene comes that has it. */
  async setStart({ joint }: JointRow, position: number): Promise<void> {
    const done = await this.studio.edit(`set position of ${joint.name}`, [
      { op: "set", element: joint.element, attribute: "position", value: positionText(joint, position) },
    ]);
    const shown = preview.peek();
    if (done === null) preview.value = null;
    else setTimeout(() => preview.peek() === shown && (preview.value = null), kPatience);
  }

  async repeat(): Promise<void> {
    try {
      const { inputs } = await this.studio.link.request("repeat");
      this.studio.notify(`from the start, with ${inputs} inputs by hand as before`);
    } catch (error) {
      if (!isClosed(error)) this.studio.notify(messageOf(error), "error");
    }
  }
}
