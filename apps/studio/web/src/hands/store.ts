// What a person does in the run with joints and motors.
import { computed, effect, signal, type Signal } from "@preact/signals-core";
import { isClosed, messageOf } from "../core/link";
import type { ControllerInput } from "../core/protocol";
import type { Studio } from "../core/studio";
import { preview } from "../view3d/settings";
import { jointRows, movedBy, positionText, type JointRow } from "./mechanism";

/** How long a change that the server took is shown before its scene comes [ms]. */
const kPatience = 3000;

/** Names have no line ends. */
const inputKey = (controller: string, input: string) => `${controller}\n${input}`;

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
  /** Inputs of controllers that were set here and are not in the status yet, by inputKey(). */
  readonly asked = signal<ReadonlyMap<string, number>>(new Map());
  /** How many inputs the run had had when one was set here last, by inputKey(). */
  private readonly givenBefore = new Map<string, number>();
  /** Targets and inputs on their way: one request at a time for each, the newest waits. */
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
        if (steps < before || inputs < given) {
          this.targets.value = new Map();
          this.asked.value = new Map();
        }
        before = steps;
        given = inputs;
        if (inputs > 0) this.any.value = true;
      }),
      effect(() => {
        const given = state.status.value?.inputs ?? 0;
        const names = (state.status.value?.controllers ?? []).flatMap(({ controller, inputs }) =>
          inputs.map(({ name }) => inputKey(controller, name)),
        );
        // others set inputs, too: once the status has ours it is right, whatever it says
        const left = [...this.asked.peek()].filter(
          ([key]) => names.includes(key) && (this.sending.has(key) || given <= (this.givenBefore.get(key) ?? 0)),
        );
        if (left.length < this.asked.peek().size) this.asked.value = new Map(left);
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
    void this.send(name, target, this.targets, async (value) => {
      return (await this.studio.link.request("motor", { motor: name, target: value })).target;
    });
  }

  /** What a controller is asked for from now on. */
  setInput(controller: string, input: ControllerInput, value: number): void {
    const key = inputKey(controller, input.name);
    const limited = Math.min(Math.max(value, input.lower), input.upper);
    this.givenBefore.set(key, this.studio.state.status.peek()?.inputs ?? 0);
    this.asked.value = new Map(this.asked.peek()).set(key, limited);
    void this.send(key, limited, this.asked, async (now) => {
      return (await this.studio.link.request("input", { controller, input: input.name, value: now })).value;
    });
  }
  inputValue(controller: string, input: ControllerInput): number {
    return this.asked.value.get(inputKey(controller, input.name)) ?? input.value;
  }

  /** Sends what is wanted of `key`, and shows in `shown` what the server made of it. */
  private async send(
    key: string,
    wanted: number,
    shown: Signal<ReadonlyMap<string, number>>,
    request: (value: number) => Promise<number>,
  ): Promise<void> {
    this.waiting.set(key, wanted);
    if (this.sending.has(key)) return;
    this.sending.add(key);
    try {
      for (let value = this.waiting.get(key); value !== undefined; value = this.waiting.get(key)) {
        this.waiting.delete(key);
        const taken = await request(value);
        if (taken === value || this.waiting.has(key)) continue;
        shown.value = new Map(shown.peek()).set(key, taken);
      }
    } catch (error) {
      this.waiting.delete(key);
      // it is not as it was asked to be
      const next = new Map(shown.peek());
      next.delete(key);
      shown.value = next;
      if (!isClosed(error)) this.studio.notify(messageOf(error), "error");
    } finally {
      this.sending.delete(key);
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
