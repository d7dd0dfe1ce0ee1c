// The panel of the map: the scene from above, live.
import { effect, untracked } from "@preact/signals-core";
import { Widget } from "@lumino/widgets";
import type { Frame } from "../core/frame";
import type { Scene } from "../core/protocol";
import type { PanelType, Studio } from "../core/studio";
import { visibleBounds } from "../view3d/bounds";
import { bodiesOf, clickBody, elementOf } from "../view3d/selecting";
import { kMapLayers, mapLayers, marked, viewRequest } from "../view3d/settings";
import { Subscription } from "../view3d/subscription";
import { fillTools, menuButton, observe, openContextMenu, toolbar } from "../view3d/tools";
import { RunTrails } from "../view3d/trails";
import { drawMap, enter, type Colors } from "./draw_map";
import { FarColors } from "./far_color";
import { Items, type Item } from "./items";
import { Sheet } from "./sheet";
import { mapRequest, openMaps, registerCommands } from "./commands";
import "./map2d.css";

const kClick = 4;

class MapWidget extends Widget {
  private readonly host: HTMLElement;
  private readonly canvas: HTMLCanvasElement;
  private readonly context: CanvasRenderingContext2D;
  private readonly where: HTMLElement;
  private readonly sheet = new Sheet();
  private readonly farColors: FarColors;
  private items: Items | null = null;
  private ghostItems: Items | null = null;
  private shownItems: Item[] = [];
  private scene: Scene | null = null;
  private frame: Frame | null = null;
  private colors: Colors | null = null;
  private ratio = 1;
  private visible = false;
  private asked = 0;
  private frames = 0;
  private moved = true;
  private fitted = false;
  private drag: { x: number; y: number; far: boolean } | null = null;
  private readonly stops: (() => void)[] = [];

  constructor(private readonly studio: Studio) {
    super();
    this.addClass("cg-map");
    const { ownerDocument: document } = this.node;
    const row = toolbar(document, "Map");
    this.stops.push(
      fillTools(studio, row, [
        [
          { command: "map:fit", text: "Fit" },
          { command: "map:focus", text: "Focus" },
          { command: "map:nearer", text: "+" },
          { command: "map:farther", text: "\u2212" },
        ],
      ]),
    );
    menuButton(
      studio,
      row,
      "Show",
      "Contents of the map",
      kMapLayers.map((name) => `map:${name}`),
    );
    this.where = document.createElement("output");
    this.where.className = "cg-map-where";
    this.where.setAttribute("aria-label", "Position of the pointer");
    row.append(this.where);
    this.host = document.createElement("div");
    this.host.className = "cg-map-host";
    this.canvas = document.createElement("canvas");
    this.canvas.dataset.testid = "map";
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "application");
    this.canvas.setAttribute("aria-label", "Map from above. Shift and arrows move it, Page Up and Page Down zoom");
    this.context = this.canvas.getContext("2d", { alpha: false })!;
    this.host.append(this.canvas);
    this.node.append(row, this.host);
    this.farColors = new FarColors(
      (path) => studio.link.asset(path),
      () => this.drawSoon(),
    );
    this.listen();
  }

  protected override onAfterAttach(): void {
    if (this.stops.length > 1) return;
    const { state } = this.studio;
    const on = (run: () => void) => this.stops.push(effect(run));
    const look = (now: boolean) => {
      this.visible = now;
      openMaps.value += now ? 1 : -1;
      this.moved = true;
      this.drawSoon();
    };
    this.stops.push(observe(this.host, () => this.resize(), look));
    const trails = this.studio.services.get(RunTrails);
    on(() => {
      this.scene = state.scene.value;
      this.items = this.scene ? new Items(this.scene) : null;
      this.ghostItems = null;
      this.moved = true;
      this.drawSoon();
    });
    on(() => {
      this.frame = state.frame.value;
      this.moved = true;
      this.drawSoon();
    });
    on(() => {
      for (const depends of [
        state.selection,
        state.tree,
        state.hovered,
        marked,
        trails.changes,
        ...Object.values(mapLayers),
      ]) {
        void depends.value;
      }
      this.drawSoon();
    });
    on(() => {
      void state.theme.value;
      this.colors = null;
      this.drawSoon();
    });
    on(() =>
      this.studio.services
        .get(Subscription)
        .set("map", { readings: openMaps.value > 0 && mapLayers.rays.value, contacts: false }),
    );
    let seen = viewRequest.peek();
    on(() => {
      const request = viewRequest.value;
      if (!request || request === seen) return;
      seen = request;
      if (request.what === "fit" || request.what === "focus") untracked(() => this.showArea(request.what === "focus"));
    });
    let obeyed = mapRequest.peek();
    on(() => {
      const request = mapRequest.value;
      if (!request || request === obeyed) return;
      obeyed = request;
      untracked(() => {
        if (request.what === "nearer") this.sheet.zoom(1.25);
        else if (request.what === "farther") this.sheet.zoom(0.8);
        else this.showArea(request.what === "focus");
        this.drawSoon();
      });
    });
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (width < 1 || height < 1) return;
    this.ratio = this.node.ownerDocument.defaultView?.devicePixelRatio ?? 1;
    this.sheet.width = width;
    this.sheet.height = height;
    this.canvas.width = Math.round(width * this.ratio);
    this.canvas.height = Math.round(height * this.ratio);
    this.draw();
  }

  private soundFrame(): Frame | null {
    return this.frame && this.frame.scene === this.scene?.scene ? this.frame : null;
  }

  private poses(): Float32Array {
    const frame = this.soundFrame();
    if (frame) return frame.poses;
    const poses = new Float32Array(7 * (this.scene?.bodies.length ?? 0));
    this.scene?.bodies.forEach((body, i) => poses.set(body.pose, 7 * i));
    return poses;
  }

  private showArea(selected: boolean): void {
    if (!this.scene) return;
    const { state } = this.studio;
    const bodies = selected ? bodiesOf(state, state.selection.peek()) : null;
    if (bodies && marked.peek() >= 0) bodies.add(marked.peek());
    const around = bodies?.size ? visibleBounds(this.scene, this.poses(), bodies) : null;
    const all = around ?? visibleBounds(this.scene, this.poses());
    this.sheet.fit(all?.low ?? [-1, -1], all?.high ?? [1, 1]);
    this.drawSoon();
  }

  private readColors(): Colors {
    const { ownerDocument: document } = this.node;
    const style = document.defaultView!.getComputedStyle(document.documentElement);
    const color = (name: string, otherwise: string) => style.getPropertyValue(name).trim() || otherwise;
    return {
      ground: color("--cg-canvas", "#dfe6ee"),
      text: color("--cg-text", "#1b2430"),
      rim: color("--cg-panel", "#ffffff"),
      grid: color("--cg-muted", "#55606e"),
      ray: color("--cg-ray", "#d11c1c"),
      highlight: color("--cg-highlight", "#e07a00"),
      accent: color("--cg-accent", "#0b5cad"),
      ghost: color("--cg-ghost", "#7a3fb5"),
    };
  }

  private draw(): void {
    this.asked = 0;
    if (!this.visible) return;
    this.colors ??= this.readColors();
    const { scene, items } = this;
    if (!scene || !items) {
      this.context.setTransform(1, 0, 0, 1, 0, 0);
      this.context.fillStyle = this.colors.ground;
      this.context.fillRect(0, 0, this.canvas.width, this.canvas.height);
      return;
    }
    if (!this.fitted && visibleBounds(scene, this.poses())) {
      this.fitted = true;
      this.showArea(false);
    }
    const { state } = this.studio;
    const frame = this.soundFrame();
    const poses = this.poses();
    if (this.moved) this.shownItems = items.moveTo(poses);
    let ghosts: Item[] = [];
    if (frame && frame.ghost.length > 0) {
      this.ghostItems ??= new Items(scene);
      ghosts = this.ghostItems.moveTo(frame.ghost);
    }
    const selected = bodiesOf(state, state.selection.peek());
    if (marked.peek() >= 0) selected.add(marked.peek());
    drawMap({
      context: this.context,
      sheet: this.sheet,
      ratio: this.ratio,
      scene,
      frame,
      poses,
      items: this.shownItems,
      ghosts,
      trails: this.studio.services.get(RunTrails),
      colors: this.colors,
      layers: {
        rays: mapLayers.rays.peek(),
        trails: mapLayers.trails.peek(),
        names: mapLayers.names.peek(),
        regions: mapLayers.regions.peek(),
      },
      selected,
      hovered: state.hovered.peek(),
      colorOf: (item) => this.farColors.of(item.shape),
    });
    this.moved = false;
    this.frames++;
    this.canvas.dataset.frames = String(this.frames);
    this.canvas.dataset.time = String(frame?.time ?? 0);
  }

  private drawSoon(): void {
    if (this.asked || !this.visible) return;
    const window = this.node.ownerDocument.defaultView ?? globalThis.window;
    this.asked = window.requestAnimationFrame(() => untracked(() => this.draw()));
  }

  /** The uppermost body at a position of the canvas; planes count when nothing else is there. */
  private bodyAt(column: number, row: number): number {
    let plane = -1;
    for (const item of [...this.shownItems].reverse()) {
      if (item.shape.type === "plane") {
        if (plane < 0 && item.normal[2] > 0.5) plane = item.body;
        continue;
      }
      enter(this.context, this.sheet, item, this.ratio);
      if (this.context.isPointInPath(item.path, column * this.ratio, row * this.ratio, "nonzero")) return item.body;
    }
    return plane;
  }

  private listen(): void {
    const { canvas, sheet } = this;
    const at = (event: MouseEvent): [number, number] => {
      const box = canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.drag = { x: event.clientX, y: event.clientY, far: false };
    });
    canvas.addEventListener("pointermove", (event) => {
      const [column, row] = at(event);
      const [x, y] = sheet.position(column, row);
      const digits = Math.max(0, Math.min(4, Math.ceil(Math.log10(sheet.scale))));
      this.where.textContent = `x ${x.toFixed(digits)}  y ${y.toFixed(digits)} m`;
      if (this.drag) {
        const [dx, dy] = [event.clientX - this.drag.x, event.clientY - this.drag.y];
        if (!this.drag.far && Math.hypot(dx, dy) <= kClick) return;
        sheet.pan(dx, dy);
        this.drag = { x: event.clientX, y: event.clientY, far: true };
        this.drawSoon();
        return;
      }
      this.hover(this.bodyAt(column, row));
    });
    canvas.addEventListener("pointerleave", () => {
      this.where.textContent = "";
      this.hover(-1);
    });
    canvas.addEventListener("pointerup", (event) => {
      const { drag } = this;
      this.drag = null;
      if (!drag || drag.far) return;
      const body = this.bodyAt(...at(event));
      if (event.button === 0) clickBody(this.studio, body, event.ctrlKey || event.shiftKey || event.metaKey);
      if (event.button !== 2) return;
      const element = this.scene ? elementOf(this.scene, body) : -1;
      if (body >= 0 && !this.studio.state.selection.peek().includes(element)) clickBody(this.studio, body, false);
      openContextMenu(this.studio, event.clientX, event.clientY, ["view:focus", "view:follow", "map:fit"]);
    });
    canvas.addEventListener("pointercancel", () => (this.drag = null));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("dblclick", () => this.showArea(true));
    canvas.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        const step = event.deltaMode === 1 ? 33 * event.deltaY : event.deltaY;
        sheet.zoom(Math.exp(-0.0015 * Math.max(-300, Math.min(300, step))), ...at(event));
        this.drawSoon();
      },
      { passive: false },
    );
    canvas.addEventListener("keydown", (event) => {
      const far = 40;
      if (event.key === "PageUp") sheet.zoom(1.25);
      else if (event.key === "PageDown") sheet.zoom(0.8);
      else if (!event.shiftKey) return;
      else if (event.key === "ArrowLeft") sheet.pan(far, 0);
      else if (event.key === "ArrowRight") sheet.pan(-far, 0);
      else if (event.key === "ArrowUp") sheet.pan(0, far);
      else if (event.key === "ArrowDown") sheet.pan(0, -far);
      else return;
      event.preventDefault();
      event.stopPropagation();
      this.drawSoon();
    });
  }

  private hover(body: number): void {
    const { hovered } = this.studio.state;
    if (hovered.peek() !== body) hovered.value = body;
    const name = this.scene?.bodies[body]?.name ?? "";
    this.canvas.dataset.hover = name;
    this.canvas.title = name;
  }

  override dispose(): void {
    if (this.isDisposed) return;
    for (const stop of this.stops) stop();
    super.dispose();
  }
}

export const panel: PanelType = {
  name: "map",
  title: "Map",
  create(studio: Studio): Widget {
    return new MapWidget(studio);
  },
};

/** Adds the panel's commands; called once, before any panel is made. */
export function register(studio: Studio): void {
  registerCommands(studio);
}
