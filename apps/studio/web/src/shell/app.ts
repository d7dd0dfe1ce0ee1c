// The window: docked panels, and what they are given.
import { CommandRegistry } from "@lumino/commands";
import { DockPanel, Widget } from "@lumino/widgets";
import type { Link } from "../core/link";
import type { Op } from "../core/protocol";
import { State } from "../core/state";
import type { DialogContent, Studio } from "../core/studio";
import { panel_named, panels } from "./panels";

export class App implements Studio {
  readonly state = new State();
  readonly commands = new CommandRegistry();
  readonly dock = new DockPanel({ spacing: 4 });
  private readonly open = new Map<string, Widget>();

  constructor(readonly link: Link) {}

  show(): void {
    const shell = document.createElement("div");
    shell.className = "cg-shell";
    document.body.append(shell);
    for (const { register } of panels) register(this);
    this.dock.addClass("cg-dock");
    Widget.attach(this.dock, shell);
    for (const { panel } of panels) this.open_panel(panel.name);
    window.addEventListener("resize", () => this.dock.update());
  }

  async edit(label: string, ops: Op[]): Promise<number[] | null> {
    try {
      const version = this.state.document.value?.version ?? 0;
      const answer = await this.link.request<{ created?: number[] }>("edit", { version, ops, label });
      return answer.created ?? [];
    } catch (error) {
      this.notify(error instanceof Error ? error.message : String(error), "error");
      return null;
    }
  }
  select(elements: number[]): void {
    this.state.selection.value = elements;
  }
  seek(time: number): void {
    this.state.live.value = false;
    this.link.request("seek", { time }).catch((error: Error) => this.notify(error.message, "error"));
  }
  notify(text: string, _kind: "note" | "error" = "note"): void {
    console.log(text);
  }
  go_to(_file: string, _line: number, _column: number): void {
    this.open_panel("code");
  }
  open_panel(name: string): void {
    const panel = panel_named(name);
    if (!panel) return;
    let widget = this.open.get(name);
    if (!widget) {
      widget = panel.create(this);
      widget.id = name;
      widget.title.label = panel.title;
      widget.title.closable = true;
      widget.disposed.connect(() => this.open.delete(name));
      this.open.set(name, widget);
      this.dock.addWidget(widget, { mode: this.open.size % 3 ? "tab-after" : "split-right" });
    }
    this.dock.activateWidget(widget);
  }
  draw_signal(_signal: string, _figure?: string): void {
    this.open_panel("figures");
  }
  async dialog(_content: DialogContent): Promise<Record<string, string> | null> {
    return null;
  }
}
