// The window: the services for panels, and the frame around them.
import { CommandRegistry } from "@lumino/commands";
import { MessageLoop } from "@lumino/messaging";
import { ContextMenu, Widget } from "@lumino/widgets";
import { effect, signal } from "@preact/signals-core";
import { showBar } from "../control/bar";
import { Control } from "../control/commands";
import { notifyFaults, waitingBar } from "../control/waiting";
import { PendingTyping } from "../code/pending";
import { countWrong } from "../console/lines";
import { isClosed, messageOf, type Link } from "../core/link";
import type { Op } from "../core/protocol";
import { Services } from "../core/services";
import { State } from "../core/state";
import type { DialogContent, Studio } from "../core/studio";
import { browserClock, Playback } from "../timeline/playback";
import { Timeline } from "../timeline/timeline";
import { registerCommands } from "./commands";
import { ask } from "./dialog";
import { Docking } from "./docking";
import { edit } from "./editing";
import { bindKeys, listen } from "./keys";
import { phone, presets } from "./layouts";
import { makeMenus } from "./menus";
import { Notices } from "./notices";
import { panelNamed, panels } from "./panels";
import type { Shell } from "./shell";
import { pageTitle, showStatusLine } from "./status_line";
import { UnsavedBar } from "./unsaved";
import { Windows } from "./windows";

/** As narrow as a phone held upright: the picture comes first (the same width is in shell.css). */
export const isNarrow = (): boolean => matchMedia("(max-width: 700px)").matches;

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
    this.playback = new Playback(link, this.state, browserClock, (message) => this.notify(message, "error"));
    this.docking = new Docking(
      this,
      () => panels.forEach(({ panel }) => this.notifyChanged(`panel:${panel.name}`)),
      (panel) => this.popOut(panel),
    );
    const main = only ? (window.opener as Window | null) : null;
    this.windows = new Windows(this.state, main, {
      cursor: (live, time) => this.playback.follow(live, time),
      call: (name, values) => this.called(name, values),
      returned: (panel) => this.openPanel(panel),
    });
    this.playback.moved = (live, time) => this.windows.cursor(live, time);
  }

  show(): void {
    const control = new Control(this, this.playback);
    for (const { register } of panels) register(this);
    control.register();
    registerCommands(this);
    bindKeys(this.commands);
    listen(this.commands, document);
    effect(() => void (document.documentElement.dataset.theme = this.state.theme.value));
    effect(() => this.showTitle());

    const shell = document.createElement("div");
    shell.className = "cg-shell";
    const unsaved = new UnsavedBar(this);
    shell.append(this.connectionBar(unsaved));
    document.body.prepend(shell);
    if (this.only) {
      this.showOnly(shell);
      return;
    }

    const header = document.createElement("header");
    const menus = document.createElement("div");
    menus.className = "cg-head";
    const settings = document.createElement("div");
    const drive = document.createElement("div");
    drive.className = "cg-drive";
    const bar = document.createElement("div");
    drive.append(bar, new Timeline(control).node);
    header.append(menus, drive);
    shell.append(header, unsaved.node, waitingBar(control));
    notifyFaults(this);
    Widget.attach(makeMenus(this.commands), menus);
    menus.append(settings, this.layoutChoice(), this.themeButton());
    showBar(control, bar, settings);
    const main = document.createElement("main");
    main.className = "cg-main";
    shell.append(main);
    Widget.attach(this.docking.dock, main);
    new ResizeObserver(() => this.docking.dock.fit()).observe(main);
    const foot = document.createElement("footer");
    shell.append(foot);
    showStatusLine(this, foot);
    this.tabMenu();
    effect(() => {
      const hello = this.state.hello.value;
      if (hello)
        this.docking.arrangeFor(hello.file, isNarrow() ? phone : presets[hello.kind === "scene" ? "Edit" : "Run"]!);
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
    if (isClosed(error)) return;
    this.notify(messageOf(error), "error");
  }
  /** The server's protocol is another one than this page's. */
  renew(): void {
    if (!this.services.get(PendingTyping).unsent) return location.reload();
    this.notify(
      "the studio was restarted in another version, and does not have what you typed last: copy that, then reload this page",
      "error",
    );
  }
  goTo(file: string, line: number, column: number): void {
    if (this.elsewhere("code")) {
      this.windows.call("goTo", [file, line, column]);
      return;
    }
    this.openPanel("code");
    if (this.commands.hasCommand("code:go-to")) void this.commands.execute("code:go-to", { file, line, column });
  }
  openPanel(name: string): void {
    if (this.only) {
      if (this.elsewhere(name)) this.windows.call("openPanel", [name]);
      return;
    }
    if (panelNamed(name)) this.docking.show(name);
  }
  drawSignal(signal: string, figure?: string): void {
    if (this.elsewhere("figures")) this.windows.call("drawSignal", figure === undefined ? [signal] : [signal, figure]);
    else {
      this.openPanel("figures");
      void this.commands.execute("figures:draw", { signal, figure: figure ?? "" });
    }
  }
  dialog(content: DialogContent): Promise<Record<string, string> | null> {
    return ask(content);
  }

  popOut(panel: string): void {
    if (this.windows.popOut(panel)) this.docking.close(panel);
    else this.notify("the browser did not let a window open: allow pop-ups for this page", "error");
  }

  /** Whether a panel is a matter of the main window, and this is none. */
  private elsewhere(panel: string): boolean {
    return this.only !== "" && this.only !== panel;
  }
  /** Another window asks. */
  private called(name: string, values: (string | number)[]): void {
    if (name === "openPanel") this.openPanel(String(values[0]));
    if (name === "goTo") this.goTo(String(values[0]), Number(values[1]), Number(values[2]));
    if (name === "drawSignal")
      this.drawSignal(String(values[0]), values[1] === undefined ? undefined : String(values[1]));
    if (name === "notify") this.notify(String(values[0]));
  }
  private notifyChanged(command: string): void {
    if (this.commands.hasCommand(command)) this.commands.notifyCommandChanged(command);
  }

  private showOnly(shell: HTMLElement): void {
    const type = panelNamed(this.only);
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

  private showTitle(): void {
    const { scene, document: text, status, problems, messages, hello } = this.state;
    const name = scene.value?.name || hello.value?.file || "";
    const panel = this.only ? (panelNamed(this.only)?.title ?? "") : "";
    const title = pageTitle(
      name,
      text.value?.dirty ?? false,
      status.value?.waiting ? "waiting" : (status.value?.state ?? ""),
      countWrong(problems.value, messages.value),
    );
    document.title = panel ? `${panel} – ${title}` : title;
  }

  private connectionBar(unsaved: UnsavedBar): HTMLElement {
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
      const download = unsaved.downloadButton();
      bar.hidden = !lost;
      bar.textContent = lost
        ? `${this.state.hello.value ? "Connection lost" : "No connection to the studio"}${ended ? ` (${ended})` : ""}, trying again. If the studio was restarted, open the address it printed.`
        : "";
      if (lost && download) bar.append(" ", download);
    });
    return bar;
  }

  private layoutChoice(): HTMLElement {
    const group = document.createElement("div");
    group.className = "cg-layouts";
    group.setAttribute("role", "group");
    group.setAttribute("aria-label", "Layout");
    for (const name of Object.keys(presets)) {
      const button = document.createElement("button");
      button.textContent = name;
      button.title = `Layout: ${name}`;
      button.setAttribute("aria-label", `Layout ${name}`);
      button.addEventListener("click", () => void this.commands.execute(`layout:${name.toLowerCase()}`));
      if (name === "Debug") effect(() => void (button.hidden = !this.state.hello.value?.allow_build));
      group.append(button);
    }
    return group;
  }
  private themeButton(): HTMLElement {
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

  private tabMenu(): void {
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
