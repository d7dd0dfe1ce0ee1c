// The debugger as the page has it: breakpoints, where the controller stands, the chosen frame and its variables.
import { computed, effect, signal, untracked } from "@preact/signals-core";
import { isClosed, messageOf, type FieldsOf } from "../core/link";
import type { Answer, Debug, DebugBreakpointWish, DebugVariable, RequestName } from "../core/protocol";
import type { Studio } from "../core/studio";
import { movedBreakpoints, toggledBreakpoint } from "./breakpoints";

export type How = "continue" | "over" | "into" | "out" | "pause";

/** A variable and, once it was opened, what is in it. */
export interface Shown extends DebugVariable {
  inside: { variables: Shown[]; more: boolean } | null;
}
export interface Watched {
  expression: string;
  /** null: not evaluated yet */
  variable: Shown | null;
  problem: string;
}

const shown = (variable: DebugVariable): Shown => ({ ...variable, inside: null });

export class DebugStore {
  readonly now = computed(() => this.studio.state.debug.value);
  readonly stands = computed(() => this.now.value?.state === "stopped");
  /** index in the frames of the chosen one */
  readonly frame = signal(0);
  readonly variables = signal<Shown[]>([]);
  /** the frame has variables beside these */
  readonly more = signal(false);
  readonly watches = signal<Watched[]>([]);
  readonly controller = signal("");
  readonly building = signal(false);
  readonly mayDebug = computed(
    () => this.studio.state.mayEdit.value && (this.studio.state.hello.value?.allow_build ?? false),
  );
  private sending: ReturnType<typeof setTimeout> | undefined;
  /** not sent yet: typing moves breakpoints */
  private readonly wanted = signal<DebugBreakpointWish[] | null>(null);
  private readonly stop: () => void;

  constructor(private readonly studio: Studio) {
    let stood = false;
    this.stop = effect(() => {
      const now = this.now.value;
      const stands = now?.state === "stopped";
      const arrived = stands && !stood;
      stood = stands;
      if (!stands) this.variables.value = [];
      if (arrived) untracked(() => this.arrive(now));
    });
  }
  dispose(): void {
    this.stop();
    clearTimeout(this.sending);
  }

  /** The controllers of the scene that can be debugged. */
  readonly controllers = computed(
    () => this.studio.state.scene.value?.controllers.filter((one) => !one.removed).map((one) => one.name) ?? [],
  );
  readonly chosen = computed(() => {
    const names = this.controllers.value;
    const attached = this.now.value?.controller ?? "";
    return names.includes(this.controller.value) ? this.controller.value : attached || (names[0] ?? "");
  });

  /** Builds for debugging, and attaches. `build`: what builds; answers whether that was good. */
  async start(build: () => Promise<boolean>): Promise<void> {
    this.building.value = true;
    try {
      if (!(await build())) return;
      // A scene whose plugin has just been built for the first time has its controllers in a moment.
      for (let i = 0; i < 100 && this.chosen.peek() === ""; ++i) await new Promise((done) => setTimeout(done, 100));
      const controller = this.chosen.peek();
      if (controller === "") this.studio.notify("the scene has no controller to be debugged", "error");
      else await this.ask("debug-attach", { controller });
    } finally {
      this.building.value = false;
    }
  }
  detach(): void {
    void this.ask("debug-detach");
  }
  run(how: How): void {
    void this.ask("debug-run", { how });
  }

  breakpoints(): DebugBreakpointWish[] {
    return (
      this.wanted.value ??
      this.now.value?.breakpoints.map(({ file, line, condition }) => ({ file, line, condition })) ??
      []
    );
  }
  toggle(file: string, line: number): void {
    this.set(toggledBreakpoint(this.breakpoints(), file, line), 0);
  }
  setCondition(file: string, line: number, condition: string): void {
    const all = this.breakpoints().map((one) =>
      one.file === file && one.line === line ? { ...one, condition: condition.trim() } : one,
    );
    this.set(all, 0);
  }
  /** The text of a file has changed: `to` has the new line of an old one. */
  moved(file: string, to: (line: number) => number): void {
    const all = movedBreakpoints(this.breakpoints(), file, to);
    if (all) this.set(all, 400);
  }

  choose(frame: number): void {
    this.frame.value = frame;
    void this.look();
    this.goTo(frame);
  }
  async open(variable: Shown): Promise<void> {
    if (variable.inside) {
      variable.inside = null;
    } else {
      const answer = await this.ask("debug-children", { of: variable.children });
      if (answer) variable.inside = { variables: answer.variables.map(shown), more: answer.more };
    }
    this.variables.value = [...this.variables.value];
    this.watches.value = [...this.watches.value];
  }
  watch(expression: string): void {
    const text = expression.trim();
    if (text === "" || this.watches.value.some((one) => one.expression === text)) return;
    this.watches.value = [...this.watches.value, { expression: text, variable: null, problem: "" }];
    if (this.stands.value) void this.lookAtWatches();
  }
  unwatch(expression: string): void {
    this.watches.value = this.watches.value.filter((one) => one.expression !== expression);
  }
  /** For the pointer over the code: null where it stands for nothing. */
  async value(expression: string): Promise<DebugVariable | null> {
    if (!this.stands.value) return null;
    try {
      const fields = { expression, frame: this.frame.value };
      return (await this.studio.link.request("debug-evaluate", fields)).variable;
    } catch {
      return null;
    }
  }

  private set(all: DebugBreakpointWish[], delay: number): void {
    this.wanted.value = all;
    clearTimeout(this.sending);
    this.sending = setTimeout(() => {
      void this.ask("debug-breakpoints", { breakpoints: all }).then(() => {
        if (this.wanted.value === all) this.wanted.value = null;
      });
    }, delay);
  }
  /** The innermost frame of the controller's own sources is shown. */
  private arrive(now: Debug): void {
    this.frame.value = Math.max(
      0,
      now.frames.findIndex((one) => one.file !== ""),
    );
    this.goTo(this.frame.value);
    void this.look();
  }
  private goTo(frame: number): void {
    const at = this.now.value?.frames[frame];
    if (!at || at.file === "") return;
    void this.studio.commands.execute("code:go-to", { file: at.file, line: at.line, column: 1, quiet: true });
  }
  private async look(): Promise<void> {
    const answer = await this.ask("debug-variables", { frame: this.frame.value });
    if (answer) {
      this.variables.value = answer.variables.map(shown);
      this.more.value = answer.more;
    }
    await this.lookAtWatches();
  }
  private async lookAtWatches(): Promise<void> {
    for (const one of this.watches.value) {
      try {
        const fields = { expression: one.expression, frame: this.frame.value };
        one.variable = shown((await this.studio.link.request("debug-evaluate", fields)).variable);
        one.problem = "";
      } catch (error) {
        one.variable = null;
        one.problem = messageOf(error);
      }
    }
    this.watches.value = [...this.watches.value];
  }
  private async ask<Name extends RequestName>(what: Name, ...fields: FieldsOf<Name>): Promise<Answer<Name> | null> {
    try {
      return await this.studio.link.request(what, ...fields);
    } catch (error) {
      if (!isClosed(error)) this.studio.notify(messageOf(error), "error");
      return null;
    }
  }
}
