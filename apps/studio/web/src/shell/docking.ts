// Panels in a dock: opened, closed, arranged, remembered for each file, popped out.
import type { Message } from "@lumino/messaging";
import { type DockLayout, DockPanel, TabBar, type Widget } from "@lumino/widgets";
import { h } from "@lumino/virtualdom";
import type { Studio } from "../core/studio";
import { panelsIn, presets, readArea, sameOrder, without, type Area } from "./layouts";
import { panelNamed } from "./panels";
import { recall, remember } from "./memory";

/** Tabs that close with the Delete key, as the pattern for tabs has it. */
class Dock extends DockPanel {
  protected override onAfterAttach(message: Message): void {
    super.onAfterAttach(message);
    this.node.addEventListener("keydown", (event) => {
      const tab = (event.target as Element).closest?.(".lm-TabBar-tab");
      if (!tab || (event.key !== "Delete" && event.key !== "Backspace")) return;
      event.preventDefault();
      event.stopPropagation();
      const bar = [...this.tabBars()].find((b) => b.node.contains(tab));
      const index = bar ? [...bar.contentNode.children].indexOf(tab) : -1;
      const widget = bar?.titles[index]?.owner;
      widget?.close();
    });
  }
}

/** Draws tabs with a sign to pop the panel out. For the mouse alone: keys reach the same through the View menu. */
class TabRenderer extends TabBar.Renderer {
  override renderTab(data: TabBar.IRenderData<Widget>) {
    return h.li(
      {
        id: this.createTabKey(data),
        key: this.createTabKey(data),
        className: this.createTabClass(data),
        style: this.createTabStyle(data),
        dataset: this.createTabDataset(data),
        ...this.createTabARIA(data),
      },
      this.renderLabel(data),
      h.div({ className: "cg-tab-out", title: "Pop out into a window of its own", "aria-hidden": "true" }, "↗"),
      h.div({ className: this.closeIconSelector.slice(1), title: "Close", "aria-hidden": "true" }, "✕"),
    );
  }
}

export class Docking {
  readonly dock: DockPanel = new Dock({
    spacing: 5,
    renderer: new (class extends DockPanel.Renderer {
      override createTabBar(document?: Document | ShadowRoot): TabBar<Widget> {
        const bar = new TabBar<Widget>({ document, renderer: new TabRenderer() });
        bar.addClass("lm-DockPanel-tabBar");
        return bar;
      }
    })(),
  });
  /** also those that are closed: what they show is still there when they are opened again */
  private readonly made = new Map<string, Widget>();
  private last = "";
  private present: Area | null = null;
  /** how all was arranged when a panel was closed, by its name */
  private readonly closed = new Map<string, Area>();
  private file = "";
  private arranging = false;
  private saveTimer: ReturnType<typeof setTimeout> | undefined;

  /** `changed`: a panel was opened, closed or moved. `popOut`: its sign was clicked. */
  constructor(
    private readonly studio: Studio,
    private readonly changed: () => void,
    popOut: (panel: string) => void,
  ) {
    // before the tab bar takes it for the beginning of a drag
    this.dock.node.addEventListener(
      "pointerdown",
      (event) => {
        const sign = (event.target as Element).closest(".cg-tab-out");
        if (!sign || event.button !== 0) return;
        event.preventDefault();
        event.stopPropagation();
        const bar = [...this.dock.tabBars()].find((b) => b.node.contains(sign));
        const index = bar ? [...bar.contentNode.children].indexOf(sign.closest("li")!) : -1;
        const panel = bar?.titles[index]?.owner.id;
        if (panel) popOut(panel);
      },
      true,
    );
    const onUse = (event: Event) => {
      const at = event.target as Node;
      for (const [name, widget] of this.made) if (widget.node.contains(at)) this.last = name;
      const bar = [...this.dock.tabBars()].find((b) => b.node.contains(at));
      if (bar?.currentTitle) this.last = bar.currentTitle.owner.id;
    };
    for (const what of ["focusin", "pointerup"]) this.dock.node.addEventListener(what, onUse);
    this.dock.addClass("cg-dock");
    this.dock.id = "dock";
    this.dock.layoutModified.connect(() => this.modified());
  }

  isOpen(name: string): boolean {
    return this.widget(name) !== undefined;
  }

  private widget(name: string): Widget | undefined {
    const widget = this.made.get(name);
    return widget?.parent ? widget : undefined;
  }

  /** Arranges the panels as they were when the file was last open. */
  arrangeFor(file: string, otherwise: Area): void {
    if (this.file === file) return;
    this.file = file;
    const area = readArea(recall(this.key()), (p) => panelNamed(p) !== undefined);
    this.arrange(area ?? otherwise);
  }

  /** Panels that are not in `area` are closed. */
  arrange(area: Area): void {
    this.arranging = true;
    const wanted = panelsIn(area);
    for (const [name, widget] of this.made) if (widget.parent && !wanted.includes(name)) widget.close();
    this.dock.restoreLayout({ main: this.config(area) });
    this.arranging = false;
    this.modified();
  }

  show(name: string): void {
    const there = this.widget(name);
    if (there) {
      this.dock.activateWidget(there);
      return;
    }
    const widget = this.make(name);
    if (!widget) return;
    // back to where it was, if the rest is where it was
    const before = this.closed.get(name) ?? null;
    if (before && sameOrder(without(before, name), plain(this.dock.saveLayout().main))) {
      this.arrange(before);
      this.dock.activateWidget(widget);
      return;
    }
    const beside = this.neighbour(name);
    this.dock.addWidget(widget, beside ? { mode: "tab-after", ref: beside } : { mode: "split-right" });
    this.dock.activateWidget(widget);
  }

  close(name: string): void {
    this.widget(name)?.close();
  }

  /** Name of the panel that was worked with last, and is open. */
  focused(): string | undefined {
    return this.isOpen(this.last) ? this.last : undefined;
  }

  /** An open panel that goes well with it: what a preset puts into the same area. */
  private neighbour(name: string): Widget | undefined {
    const mates = (area: Area): string[] =>
      area.type === "split" ? area.children.flatMap(mates) : area.panels.includes(name) ? area.panels : [];
    for (const preset of Object.values(presets)) {
      for (const mate of mates(preset)) {
        const widget = this.widget(mate);
        if (widget) return widget;
      }
    }
    return undefined;
  }

  private make(name: string): Widget | undefined {
    const there = this.made.get(name);
    if (there) return there;
    const type = panelNamed(name);
    if (!type) return undefined;
    const widget = type.create(this.studio);
    widget.id = name;
    widget.title.label = type.title;
    widget.title.closable = true;
    widget.addClass("cg-panel");
    widget.node.setAttribute("aria-label", type.title);
    widget.node.dataset.testid = `panel-${name}`;
    this.made.set(name, widget);
    return widget;
  }

  private config(area: Area): DockLayout.AreaConfig | null {
    if (area.type === "tabs") {
      const widgets = area.panels.flatMap((name) => this.make(name) ?? []);
      if (widgets.length === 0) return null;
      return { type: "tab-area", widgets, currentIndex: area.current };
    }
    const children = area.children.flatMap((child) => this.config(child) ?? []);
    return { type: "split-area", orientation: area.orientation, children, sizes: area.sizes };
  }

  private key(): string {
    return `layout:${this.file}`;
  }

  private modified(): void {
    if (this.arranging) return;
    const before = this.present;
    const area = plain(this.dock.saveLayout().main);
    this.present = area;
    for (const name of panelsIn(before)) if (!panelsIn(area).includes(name)) this.closed.set(name, before!);
    this.changed();
    if (!this.file || !area) return;
    clearTimeout(this.saveTimer);
    this.saveTimer = setTimeout(() => remember(this.key(), JSON.stringify(area)), 200);
  }
}

function plain(config: DockLayout.AreaConfig | null): Area | null {
  if (!config) return null;
  if (config.type === "tab-area") {
    return { type: "tabs", panels: config.widgets.map((w) => w.id), current: config.currentIndex };
  }
  const children = config.children.flatMap((child) => plain(child) ?? []);
  return { type: "split", orientation: config.orientation, children, sizes: config.sizes };
}
