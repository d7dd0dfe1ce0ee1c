// The 3D view itself: loaded when the panel is first shown.
import { effect, untracked } from "@preact/signals-core";
import { Color, type Quaternion, Raycaster, Scene as ThreeScene, Vector2, Vector3 } from "three";
import type { Frame } from "../core/frame";
import type { Scene, Vec3 } from "../core/protocol";
import type { Studio } from "../core/studio";
import { Backdrop } from "./backdrop";
import { Batches } from "./batches";
import { cornersOf, floorOf, joined, kNothing, radiusOf, visibleBounds, type Bounds } from "./bounds";
import { Eye } from "./camera";
import { ContactShadows } from "./contact";
import { Framing } from "./framing";
import { Grabber } from "./grab";
import { Handles } from "./handles";
import { Highlight } from "./highlight";
import { Labels } from "./labels";
import { Lights } from "./lights";
import { Overlay } from "./overlay";
import { glPainter, serverPainter, type Painter } from "./painters";
import { isFinite, poseAt } from "./pose";
import { bodiesOf, clickBody, elementOf, whyNot } from "./selecting";
import { massText } from "./selected";
import {
  dragging,
  handleMode,
  handlesLocal,
  handlesSnap,
  marked,
  orthographic,
  overlays,
  preview,
  viewRequest,
  type ViewWish,
} from "./settings";
import { RunTrails } from "./trails";
import { fadeFloors } from "./surfaces";

/** The options that the panel gives the view. */
interface Stand {
  host: HTMLElement;
  /** One note for each topic; "": none. */
  note: (matter: "pictures" | "server" | "clicked" | "mass" | "handles", text: string) => void;
  /** How far something is dragged; "": nothing is. */
  measure: (text: string) => void;
  /** The camera looks from elsewhere. */
  turned: (camera: Quaternion) => void;
  contextMenu: (event: MouseEvent, body: number) => void;
}

const kClick = 4; // a pointer that moved less between down and up has clicked [pixel]
const kShadowLimit = 400; // beyond so many bodies the bounds are not checked for every frame

export class View3d {
  private readonly stage = new ThreeScene();
  private readonly backdrop = new Backdrop();
  private readonly highlight = new Highlight();
  private readonly overlay = new Overlay();
  private readonly contact = new ContactShadows();
  private readonly labels: Labels;
  private readonly eye: Eye;
  private readonly framing = new Framing();
  private framed: Bounds | null = null;
  private readonly handles: Handles;
  private readonly grabber: Grabber;
  private readonly ray = new Raycaster();
  private painter: Painter;
  private batches: Batches | null = null;
  private ghosts: Batches | null = null;
  private lights: Lights | null = null;
  private scene: Scene | null = null;
  private frame: Frame | null = null;
  private poses = new Float32Array();
  private bounds: Bounds | null = null;
  private ghostColor = "#7a3fb5";
  private frames = 0;
  private width = 1;
  private height = 1;
  private visible = false;
  private asked = 0;
  private moved = true;
  private relight = true;
  private remark = true;
  private rethemed = true;
  private pointer: Vector2 | null = null;
  private down: { x: number; y: number } | null = null;
  private readonly stops: (() => void)[] = [];

  constructor(
    private readonly studio: Studio,
    private readonly stand: Stand,
  ) {
    const { host } = stand;
    const { ownerDocument: document } = host;
    this.labels = new Labels(document);
    const painter = glPainter(
      document,
      () => this.fallBack(),
      () => this.refresh(),
    );
    this.painter = painter ?? this.serverPictures();
    this.put(this.painter.element);
    // Events are taken from the box around the picture, which stays when the painter changes.
    this.eye = new Eye(host, () => this.drawSoon());
    this.handles = new Handles(studio, this.eye.camera, host, this.stage, {
      changed: () => {
        this.moved = true;
        this.drawSoon();
      },
      dragging: (on) => {
        this.eye.controls.enabled = !on;
        dragging.value = on;
      },
      note: (text) => stand.note("handles", text),
      measure: (text) => stand.measure(text),
    });
    this.grabber = new Grabber(studio, this.eye.camera, host, {
      at: (x, y) => this.hitAt(x, y),
      scene: () => this.scene,
      poses: () => this.poses,
      changed: () => {
        this.remark = true;
        this.drawSoon();
      },
      measure: (text) => stand.measure(text),
    });
    this.stage.add(this.backdrop.root, this.overlay.root);
    host.append(this.labels.element);
    this.listen(host);
    this.observe();
  }

  private put(element: HTMLElement): void {
    element.dataset.testid = "view3d";
    element.classList.add("cg-view-picture");
    element.dataset.frames = String(this.frames);
    this.stand.host.prepend(element);
  }

  private serverPictures(): Painter {
    this.stand.host.dataset.pictures = "server";
    this.stand.note(
      "pictures",
      "There is no WebGL here: the server draws these pictures. Overlays and handles are not in them.",
    );
    return serverPainter(this.studio, this.stand.host.ownerDocument, (text) => this.stand.note("server", text));
  }

  private fallBack(): void {
    this.painter.element.remove();
    this.painter.dispose();
    this.painter = this.serverPictures();
    this.put(this.painter.element);
    this.painter.setSize(this.width, this.height);
    this.drawSoon();
  }

  private refresh(): void {
    this.moved = true;
    this.relight = true;
    this.drawSoon();
  }

  private observe(): void {
    const { state } = this.studio;
    const on = (run: () => void) => this.stops.push(effect(run));
    on(() => {
      const scene = state.scene.value;
      untracked(() => this.adopt(scene));
    });
    on(() => {
      this.frame = state.frame.value;
      this.moved = true;
      this.drawSoon();
    });
    on(() => {
      void state.selection.value;
      void state.tree.value;
      void state.scene.value;
      void state.hovered.value;
      if (state.selection.value.length > 0) marked.value = -1;
      this.stand.note("clicked", whyNot(state, marked.value));
      const bodies = state.scene.value ? bodiesOf(state, state.selection.value) : [];
      this.stand.note("mass", state.scene.value ? massText(state.scene.value, bodies) : "");
      this.remark = true;
      this.drawSoon();
    });
    on(() => {
      void state.theme.value;
      // the page's style follows the signal: it is read when drawing
      this.rethemed = true;
      this.refresh();
    });
    on(() => {
      for (const shown of Object.values(overlays)) void shown.value;
      void this.studio.services.get(RunTrails).changes.value;
      this.backdrop.showGrid(overlays.grid.value);
      this.moved = true;
      this.drawSoon();
    });
    on(() => {
      void state.followed.value;
      this.eye.follow(null);
      this.moved = true;
      this.drawSoon();
    });
    on(() => {
      for (const depends of [state.scene, state.selection, state.mayEdit, handleMode, handlesLocal, handlesSnap]) {
        void depends.value;
      }
      untracked(() => this.handles.update(this.scene, this.poses));
      this.drawSoon();
    });
    on(() => {
      void preview.value;
      this.moved = true;
      this.drawSoon();
    });
    on(() => {
      this.eye.setFlat(orthographic.value);
      this.drawSoon();
    });
    let seen = viewRequest.peek();
    on(() => {
      const request = viewRequest.value;
      if (!request || request === seen) return;
      seen = request;
      untracked(() => this.obey(request.what));
    });
  }

  private setTheme(): void {
    const theme = this.studio.state.theme.peek();
    const document = this.stand.host.ownerDocument;
    const style = document.defaultView?.getComputedStyle(document.documentElement);
    const color = (name: string, otherwise: string) => style?.getPropertyValue(name).trim() || otherwise;
    this.backdrop.setTheme(theme, color("--cg-muted", "#55606e"));
    this.highlight.setColors(color("--cg-highlight", "#e07a00"), color("--cg-accent", "#0b5cad"));
    this.overlay.setColors(color("--cg-ray", "#d11c1c"));
    this.ghostColor = color("--cg-ghost", "#7a3fb5");
    this.ghosts?.dispose();
    this.ghosts = null;
    this.batches?.setTheme(theme);
    this.backdrop.showGround(!this.scene?.bodies.some((b) => !b.removed && b.shapes.some((s) => s.type === "plane")));
    this.moved = true;
    this.rethemed = false;
  }

  private adopt(scene: Scene | null): void {
    this.batches?.dispose();
    this.ghosts?.dispose();
    this.lights?.dispose();
    this.batches = this.ghosts = null;
    this.lights = null;
    this.scene = scene;
    this.handles.drop();
    if (!scene) return;
    this.batches = new Batches(scene, {
      asset: (path) => this.studio.link.asset(path),
      changed: () => this.drawSoon(),
      slow: this.painter.slow,
    });
    this.lights = new Lights(scene, this.painter.slow);
    this.stage.add(this.batches.root, this.lights.root);
    this.overlay.adopt(scene);
    this.eye.floor = floorOf(scene);
    this.contact.adopt(scene);
    this.labels.adopt(scene);
    this.bounds = null;
    this.remark = true;
    this.rethemed = true;
    this.refresh();
  }

  /** The frame of another scene than the one that is shown is of no use. */
  private soundFrame(): Frame | null {
    return this.frame && this.frame.scene === this.scene?.scene ? this.frame : null;
  }

  private moveBodies(): void {
    const { scene, batches } = this;
    if (!scene || !batches) return;
    const frame = this.soundFrame();
    const poses = new Float32Array(7 * scene.bodies.length);
    scene.bodies.forEach((body, i) => poses.set(body.pose, 7 * i));
    if (frame) poses.set(frame.poses.subarray(0, poses.length));
    for (const held of [this.handles.held, preview.peek() ?? []])
      for (const [body, pose] of held) if (7 * body < poses.length) poses.set(pose, 7 * body);
    this.poses = poses;
    batches.moveTo(poses);

    if (frame && frame.ghost.length > 0) {
      if (!this.ghosts) {
        this.ghosts = new Batches(scene, {
          asset: () => "",
          changed: () => {},
          ghost: new Color(this.ghostColor),
          slow: this.painter.slow,
        });
        this.stage.add(this.ghosts.root);
      }
      this.ghosts.moveTo(frame.ghost);
    } else if (this.ghosts) {
      this.ghosts.dispose();
      this.ghosts = null;
    }
    if (!this.bounds || scene.bodies.length <= kShadowLimit || this.frames % 15 === 0) {
      const first = !this.bounds;
      this.bounds = visibleBounds(scene, poses);
      if (first) this.framing.adopt(this.bounds);
      this.framing.follow(scene, poses, frame?.time ?? null);
      this.lights?.fit(this.bounds ?? kNothing, this.eye.floor);
      this.contact.fit(this.bounds ?? kNothing);
    }
    const followed = this.studio.state.followed.peek();
    if (followed) {
      const body = scene.bodies.findIndex((b) => b.name === followed && !b.removed);
      const pose = body >= 0 ? poseAt(poses, body) : null;
      this.eye.follow(pose && isFinite(pose) ? [pose[0], pose[1], pose[2]] : null);
    }
    this.handles.update(scene, poses);
    this.relight = true;
    this.remark = true;
  }

  /** Lets the camera go along with what moves, unless a person has taken it or holds something. */
  private goAlong(): void {
    const { shown } = this.framing;
    if (!shown || shown === this.framed || this.handles.dragging) return;
    if (this.eye.taken || this.studio.state.followed.peek() || this.grabber.held) return;
    this.framed = shown;
    this.eye.fit(shown);
  }

  /** The rectangle of the picture that holds all that moves: left, bottom, right, top from -1 to 1. */
  private movingInPicture(): string {
    const { moving } = this.framing;
    if (!moving) return "";
    const corners = cornersOf(moving).map((corner) => new Vector3(...corner).project(this.eye.camera));
    const [xs, ys] = [corners.map((c) => c.x), corners.map((c) => c.y)];
    return [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)].map((v) => v.toFixed(4)).join(" ");
  }

  private mark(): void {
    const { state } = this.studio;
    const selected = bodiesOf(state, state.selection.peek());
    if (marked.peek() >= 0) selected.add(marked.peek());
    this.highlight.show(this.batches, selected, selected.has(state.hovered.peek()) ? -1 : state.hovered.peek());
  }

  private draw(): void {
    this.asked = 0;
    if (!this.visible) return;
    untracked(() => {
      if (this.rethemed) this.setTheme();
      const changed = this.moved || this.remark;
      if (this.moved) this.moveBodies();
      if (this.grabber.held) this.grabber.tell();
      if (this.remark) this.mark();
      this.goAlong();
      if (this.scene) {
        const frame = this.soundFrame();
        const empty: Frame = {
          live: true,
          scene: this.scene.scene,
          time: 0,
          step: 0,
          poses: this.poses,
          ghost: new Float32Array(),
          tail: {},
        };
        const size = this.bounds ? 2 * radiusOf(this.bounds) : 2;
        if (changed)
          this.overlay.update(
            this.scene,
            frame ?? empty,
            this.poses,
            size,
            this.studio.services.get(RunTrails),
            this.studio.state.selection.peek(),
            this.grabber.ends(),
            this.handles.outline,
          );
      }
      this.eye.adjust(this.bounds);
      const { reach, distance } = this.eye;
      const whole = this.eye.camera.position.distanceTo(this.eye.controls.target);
      fadeFloors(whole - distance, reach, distance / whole);
      const { x, y, z } = this.eye.controls.target;
      this.batches?.spreadFloors(this.poses, [x, y, z], reach);
      this.backdrop.follow(distance, this.eye.controls.target);
      this.painter.draw(this.stage, this.eye, this.highlight, this.contact, this.relight);
      this.stand.turned(this.eye.camera.quaternion);
      this.labels.update(overlays.names.peek(), this.poses, this.eye.camera, this.width, this.height);
      this.moved = this.remark = this.relight = false;
      this.frames++;
      const { dataset } = this.painter.element;
      dataset.frames = String(this.frames);
      dataset.time = String(this.soundFrame()?.time ?? 0);
      dataset.moving = this.movingInPicture();
      dataset.height = this.eye.camera.position.z.toFixed(4);
    });
  }

  private drawSoon(): void {
    if (this.asked || !this.visible) return;
    const window = this.stand.host.ownerDocument.defaultView ?? globalThis.window;
    this.asked = window.requestAnimationFrame(() => this.draw());
  }

  setVisible(visible: boolean): void {
    this.visible = visible;
    if (visible) this.refresh();
  }

  setSize(width: number, height: number): void {
    if (width < 1 || height < 1) return;
    this.width = width;
    this.height = height;
    this.painter.setSize(width, height);
    this.eye.setSize(width, height);
    this.framed = null;
    // a canvas that was resized is empty until it is drawn, which should not be seen
    if (this.visible && this.frames > 0) this.draw();
    else this.drawSoon();
  }

  private obey(what: ViewWish): void {
    if (this.moved) this.moveBodies();
    if (what === "focus") return this.focus();
    this.eye.taken = false;
    this.framing.reset(this.bounds);
    this.framed = this.framing.shown;
    // what moves is found with the next picture
    this.moved = true;
    if (what === "fit") this.eye.fit(this.bounds ?? kNothing);
    else this.eye.look(what, this.bounds ?? kNothing);
    this.drawSoon();
  }

  /** The selection; without any, everything. */
  private focus(): void {
    const { state } = this.studio;
    const bodies = bodiesOf(state, state.selection.peek());
    if (marked.peek() >= 0) bodies.add(marked.peek());
    const around = this.scene && bodies.size > 0 ? visibleBounds(this.scene, this.poses, bodies) : null;
    this.eye.taken = around !== null;
    if (around) {
      // the camera would be inside of a very thin thing
      const grow = Math.max(0.02 - radiusOf(around), 0);
      this.eye.fit(
        joined(around, {
          low: around.low.map((v) => v - grow) as Bounds["low"],
          high: around.high.map((v) => v + grow) as Bounds["high"],
        }),
      );
    } else this.eye.fit(this.bounds ?? kNothing);
    this.drawSoon();
  }

  /** The body under a position of the window; -1: none. */
  bodyAt(x: number, y: number): number {
    return this.hitAt(x, y)?.body ?? -1;
  }
  /** With the point of it; null: there is none. */
  private hitAt(x: number, y: number): { body: number; point: Vec3 } | null {
    if (!this.batches) return null;
    const box = this.stand.host.getBoundingClientRect();
    const at = new Vector2(((x - box.left) / box.width) * 2 - 1, 1 - ((y - box.top) / box.height) * 2);
    this.eye.adjust(this.bounds);
    this.ray.setFromCamera(at, this.eye.camera);
    const hits = this.ray.intersectObject(this.batches.root, true);
    const first = hits[0];
    return first ? { body: this.batches.bodyAt(first), point: [first.point.x, first.point.y, first.point.z] } : null;
  }

  private isFloor(body: number): boolean {
    const shapes = this.scene?.bodies[body]?.shapes.filter((s) => s.visual) ?? [];
    return shapes.length > 0 && shapes.every((s) => s.type === "plane");
  }

  private hover(): void {
    const { state } = this.studio;
    // the pointer left: another panel sets the hovered body
    if (!this.pointer) return;
    const none = this.down || this.handles.dragging || this.handles.hot;
    const body = none ? -1 : this.bodyAt(this.pointer.x, this.pointer.y);
    if (state.hovered.peek() !== body) state.hovered.value = body;
    const name = body >= 0 ? this.scene!.bodies[body]!.name : "";
    this.painter.element.dataset.hover = name;
    this.stand.host.title = name;
  }

  private listen(host: HTMLElement): void {
    let waiting = false;
    const hoverSoon = () => {
      if (waiting) return;
      waiting = true;
      (host.ownerDocument.defaultView ?? globalThis.window).requestAnimationFrame(() => {
        waiting = false;
        this.hover();
      });
    };
    host.addEventListener("pointermove", (event) => {
      this.pointer = new Vector2(event.clientX, event.clientY);
      hoverSoon();
    });
    host.addEventListener("pointerleave", () => {
      this.pointer = null;
      this.studio.state.hovered.value = -1;
      this.painter.element.dataset.hover = host.title = "";
    });
    host.addEventListener("pointerdown", (event) => {
      host.focus({ preventScroll: true });
      this.down = this.handles.hot || this.handles.dragging ? null : { x: event.clientX, y: event.clientY };
    });
    host.addEventListener("pointerup", (event) => {
      const { down } = this;
      this.down = null;
      if (!down || Math.hypot(event.clientX - down.x, event.clientY - down.y) > kClick) return;
      const body = this.bodyAt(event.clientX, event.clientY);
      if (event.button === 0 && this.isFloor(body)) {
        // a click beside things
        clickBody(this.studio, -1, event.ctrlKey || event.shiftKey || event.metaKey);
      } else if (event.button === 0) {
        clickBody(this.studio, body, event.ctrlKey || event.shiftKey || event.metaKey);
      } else if (event.button === 2) {
        const element = this.scene ? elementOf(this.scene, body) : -1;
        if (body >= 0 && !this.studio.state.selection.peek().includes(element)) clickBody(this.studio, body, false);
        this.stand.contextMenu(event, body);
      }
    });
    host.addEventListener("pointercancel", () => (this.down = null));
    host.addEventListener("dblclick", () => this.focus());
    host.addEventListener("contextmenu", (event) => event.preventDefault());
    host.addEventListener("keydown", (event) => this.onKey(event));
  }

  /** Shift and arrows turn, Page Up and Down come nearer and go away. */
  private onKey(event: KeyboardEvent): void {
    const turn = 0.1;
    if (event.key === "PageUp") this.eye.turn(0, 0, 1.15);
    else if (event.key === "PageDown") this.eye.turn(0, 0, 1 / 1.15);
    else if (!event.shiftKey) return;
    else if (event.key === "ArrowLeft") this.eye.turn(-turn, 0);
    else if (event.key === "ArrowRight") this.eye.turn(turn, 0);
    else if (event.key === "ArrowUp") this.eye.turn(0, turn);
    else if (event.key === "ArrowDown") this.eye.turn(0, -turn);
    else return;
    event.preventDefault();
    event.stopPropagation();
    this.drawSoon();
  }

  dispose(): void {
    for (const stop of this.stops) stop();
    this.visible = false;
    this.handles.dispose();
    this.grabber.dispose();
    this.eye.dispose();
    this.batches?.dispose();
    this.ghosts?.dispose();
    this.lights?.dispose();
    this.overlay.dispose();
    this.highlight.dispose();
    this.contact.dispose();
    this.backdrop.dispose();
    this.painter.dispose();
  }
}
