// The window: the services for panels, and the frame around them.
import { CommandRegistry } from "@lumino/commands";
import { MessageLoop } from "@lumino/messaging";
import { ContextMenu, Widget } from "@lumino/widgets";
import { effect, signal } from "@preact/signals-core";
import { show_bar } from "../control/bar";
import { Control } from "../control/commands";
import { notify_faults, waiting_bar } from "../control/waiting";
import { PendingTyping } from "../code/pending";
import { count_wrong } from "../console/lines";
import { RequestError, type Link } from "../core/link";
import type { Op } from "../core/protocol";
import { Services } from "../core/services";
import { State } from "../core/state";
import type { DialogContent, Studio } from "../core/studio";
import { browser_clock, Playback } from "../timeline/playback";
import { Timeline } from "../timeline/timeline";
import { register_commands } from "./commands";
import { ask } from "./dialog";
import { Docking } from "./docking";
import { edit } from "./editing";
import { bind_keys, listen } from "./keys";
import { make_menus } from "./menus";
import { Notices } from "./notices";
import { panel_named, panels } from "./panels";
import type { Shell } from "./shell";
import { page_title, show_status_line } from "./status_line";
import { UnsavedBar } from "./unsaved";
import { Windows } from "./windows";

export class App implements Shell {
  readonly state = new State();
  readonly commands = new CommandRegistry();
  readonly services: Services<Studio> = new Services<Studio>(this);
  readonly playback: Playback;
  readonly docking: Docking;
  private readonly notices = new Notices();
  private readonly windows: Windows;

  /** `only`: name of the one panel that this window is for, "": all. */
  constructor(
    readonly link: Link,
    private readonly only: string,
  ) {
    this.playback = new Playback(link, this.state, browser_clock, (message) => this.notify(message, "error"));
    this.docking = new Docking(
      this,
      () => panels.forEach(({ panel }) => this.notify_changed(`panel:${panel.name}`)),
      (panel) => this.pop_out(panel),
    );
    const main = only ? (window.opener as Window | null) : null;
    this.windows = new Windows(this.state, main, {
      cursor: (live, time) => this.playback.follow(live, time),
      call: (name, values) => this.called(name, values),
      returned: (panel) => this.open_panel(panel),
    });
    this.playback.moved = (live, time) => this.windows.cursor(live, time);
  }

  show(): void {
    const control = new Control(this, this.playback);
    for (const { register } of panels) register(this);
    control.register();
    register_commands(this);
    bind_keys(this.commands);
    listen(this.commands, document);
    effect(() => void (document.documentElement.dataset.theme = this.state.theme.value));
    effect(() => this.show_title());

    const shell = document.createElement("div");
    shell.className = "cg-shell";
    const unsaved = new UnsavedBar(this);
    shell.append(this.connection_bar(unsaved));
    document.body.prepend(shell);
    if (this.only) {
      this.show_only(shell);
      return;
    }

    const header = document.createElement("header");
    const menus = document.createElement("div");
    menus.className = "cg-head";
    const bar = document.createElement("div");
    header.append(menus, bar, new Timeline(control).node);
    shell.append(header, unsaved.node, waiting_bar(control));
    notify_faults(this);
    Widget.attach(make_menus(this.commands), menus);
    menus.append(this.layout_choice(), this.theme_button());
    show_bar(control, bar);
    const main = document.createElement("main");
    main.className = "cg-main";
    shell.append(main);
    Widget.attach(this.docking.dock, main);
    new ResizeObserver(() => this.docking.dock.fit()).observe(main);
    const foot = document.createElement("footer");
    shell.append(foot);
    show_status_line(this, foot);
    this.tab_menu();
    effect(() => {
      const hello = this.state.hello.value;
      if (hello) this.docking.arrange_for(hello.file, hello.kind === "scene" ? "Edit" : "Run");
    });
  }

  async edit(label: string, ops: Op[]): Promise<number[] | null> {
    try {
      return await edit(this.link, this.state, label, ops);
    } catch (error) {
      this.fail(error);
      return null;
    }
  }
  select(elements: number[]): void {
    this.state.selection.value = elements;
  }
  seek(time: number): void {
    this.playback.seek(time);
  }
  notify(text: string, kind: "note" | "error" = "note"): void {
    this.notices.show(text, kind);
  }
  fail(error: unknown): void {
    if (error instanceof RequestError && error.failure.code === "closed") return;
    this.notify(error instanceof Error ? error.message : String(error), "error");
  }
  /** The server's protocol is another one than this page's. */
  renew(): void {
    if (!this.services.get(PendingTyping).unsent) return location.reload();
    this.notify("the studio was restarted in another version, and does not have what you typed last: copy that, then reload this page", "error");
  }
  go_to(file: string, line: number, column: number): void {
    if (this.elsewhere("code")) {
      this.windows.call("go_to", [file, line, column]);
      return;
    }
    this.open_panel("code");
    if (this.commands.hasCommand("code:go-to")) void this.commands.execute("code:go-to", { file, line, column });
  }
  open_panel(name: string): void {
    if (this.only) {
      if (this.elsewhere(name)) this.windows.call("open_panel", [name]);
      return;
    }
    if (panel_named(name)) this.docking.show(name);
  }
  draw_signal(signal: string, figure?: string): void {
    if (this.elsewhere("figures")) this.windows.call("draw_signal", figure === undefined ? [signal] : [signal, figure]);
    else {
      this.open_panel("figures");
      void this.commands.execute("figures:draw", { signal, figure: figure ?? "" });
    }
  }
  dialog(content: DialogContent): Promise<Record<string, string> | null> {
    return ask(content);
  }

  pop_out(panel: string): void {
    if (this.windows.pop_out(panel)) this.docking.close(panel);
    else this.notify("the browser did not let a window open: allow pop-ups for this page", "error");
  }

  /** Whether a panel is a matter of the main window, and this is none. */
  private elsewhere(panel: string): boolean {
    return this.only !== "" && this.only !== panel;
  }
  /** Another window asks. */
  private called(name: string, values: (string | number)[]): void {
    if (name === "open_panel") this.open_panel(String(values[0]));
    if (name === "go_to") this.go_to(String(values[0]), Number(values[1]), Number(values[2]));
    if (name === "draw_signal") this.draw_signal(String(values[0]), values[1] === undefined ? undefined : String(values[1]));
    if (name === "notify") this.notify(String(values[0]));
  }
  private notify_changed(command: string): void {
    if (this.commands.hasCommand(command)) this.commands.notifyCommandChanged(command);
  }

  private show_only(shell: HTMLElement): void {
    const type = panel_named(this.only);
    const main = document.createElement("main");
    main.className = "cg-main cg-only";
    shell.append(main);
    if (!type) {
      main.textContent = `There is no panel '${this.only}'.`;
      return;
    }
    const widget = type.create(this);
    widget.node.dataset.testid = `panel-${type.name}`;
    widget.node.setAttribute("aria-label", type.title);
    Widget.attach(widget, main);
    new ResizeObserver(() => MessageLoop.sendMessage(widget, Widget.ResizeMessage.UnknownSize)).observe(main);
  }

  private show_title(): void {
    const { scene, document: text, status, problems, messages, hello } = this.state;
    const name = scene.value?.name || hello.value?.file || "";
    const panel = this.only ? (panel_named(this.only)?.title ?? "") : "";
    const title = page_title(
      name,
      text.value?.dirty ?? false,
      status.value?.waiting ? "waiting" : (status.value?.state ?? ""),
      count_wrong(problems.value, messages.value),
    );
    document.title = panel ? `${panel} – ${title}` : title;
  }

  private connection_bar(unsaved: UnsavedBar): HTMLElement {
    const bar = document.createElement("div");
    bar.className = "cg-connection";
    bar.setAttribute("role", "alert");
    bar.dataset.testid = "connection";
    let ended = "";
    this.link.on("goodbye", ({ reason }) => (ended = reason));
    // a page that has just been opened is given a short time
    const opened = signal(false);
    setTimeout(() => (opened.value = true), 2_000);
    effect(() => {
      const lost = !this.state.open.value && (this.state.hello.value !== null || opened.value);
      if (this.state.open.value) ended = "";
      const keep = unsaved.download_button();
      bar.hidden = !lost;
      bar.textContent = lost
        ? `${this.state.hello.value ? "Connection lost" : "No connection to the studio"}${ended ? ` (${ended})` : ""}, trying again. If the studio was restarted, open the address it printed.`
        : "";
      if (lost && keep) bar.append(" ", keep);
    });
    return bar;
  }

  private layout_choice(): HTMLElement {
    const group = document.createElement("div");
    group.className = "cg-layouts";
    group.setAttribute("role", "group");
    group.setAttribute("aria-label", "Layout");
    for (const name of ["Run", "Edit", "Analyse", "Compare"]) {
      const button = document.createElement("button");
      button.textContent = name;
      button.title = `Layout: ${name}`;
      button.setAttribute("aria-label", `Layout ${name}`);
      button.addEventListener("click", () => void this.commands.execute(`layout:${name.toLowerCase()}`));
      group.append(button);
    }
    return group;
  }
  private theme_button(): HTMLElement {
    const button = document.createElement("button");
    button.className = "cg-theme";
    button.dataset.testid = "theme";
    button.addEventListener("click", () => void this.commands.execute("view:theme"));
    effect(() => {
      const dark = this.state.theme.value === "dark";
      button.textContent = dark ? "☀" : "☾";
      button.title = dark ? "Light colours" : "Dark colours";
      button.setAttribute("aria-label", button.title);
    });
    return button;
  }

  private tab_menu(): void {
    const menu = new ContextMenu({ commands: this.commands });
    this.docking.dock.node.addEventListener("contextmenu", (event) => {
      const tab = (event.target as Element).closest(".lm-TabBar-tab");
      const bar = tab && [...this.docking.dock.tabBars()].find((b) => b.node.contains(tab));
      const panel = bar?.titles[[...bar.contentNode.children].indexOf(tab!)]?.owner.id;
      if (!panel) return;
      menu.menu.clearItems();
      menu.menu.addItem({ command: "panel:pop-out", args: { panel } });
      menu.menu.addItem({ command: "panel:close", args: { panel } });
      menu.menu.open(event.clientX, event.clientY);
      event.preventDefault();
    });
  }
}
