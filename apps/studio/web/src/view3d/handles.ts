// Handles that move and rotate the selection; the text is changed when they are released.
import { Object3D } from "three";
import { TransformControls } from "three/examples/jsm/controls/TransformControls.js";
import type { Camera, Scene as ThreeScene } from "three";
import { restOp } from "../add/rest";
import type { Op, Pose, Scene, TreeElement, Vec3 } from "../core/protocol";
import type { Studio } from "../core/studio";
import { carried, compose, inverse, isFinite, poseAt, tidy } from "./pose";
import { halfExtents, resized, whyNotResized } from "./resize";
import { bodiesIn, movable, type Movable } from "./selecting";
import { handleMode, handlesLocal, handlesSnap, kSnapAngle, kSnapLength } from "./settings";

/** How long a change that the server took is shown before its scene comes [ms]. */
const kPatience = 3000;

const signed = (value: number, digits: number): string => {
  const text = Math.abs(value).toFixed(digits);
  return `${value < 0 && Number(text) > 0 ? "\u2212" : "+"}${text}`;
};

/** How far from a pose to another, as one reads it: along the world's axes, or the angle. */
export function dragText(from: Pose, to: Pose): string {
  const by = compose(to, inverse(from));
  const angle = 2 * Math.atan2(Math.hypot(by[4], by[5], by[6]), Math.abs(by[3]));
  if (angle > 1e-6) {
    const axis = [by[4], by[5], by[6]].reduce((a, b) => (Math.abs(b) > Math.abs(a) ? b : a)) * Math.sign(by[3] || 1);
    return `${signed((Math.sign(axis) * angle * 180) / Math.PI, 1)}\u00b0`;
  }
  return (["x", "y", "z"] as const)
    .map((name, i) => [name, to[i]! - from[i]!] as const)
    .filter(([, moved]) => Math.abs(moved) > 5e-5)
    .map(([name, moved]) => `${name} ${signed(100 * moved, 1)} cm`)
    .join("  ");
}

export class Handles {
  /** Poses that are shown instead of the frame's: of dragged bodies. */
  readonly held = new Map<number, Pose>();
  private readonly controls: TransformControls;
  private readonly proxy = new Object3D();
  /** The box of what is resized: its pose, and half its extents; null: nothing is. */
  outline: { pose: Pose; half: Vec3 } | null = null;
  private what: Movable | null = null;
  private start: Pose | null = null;
  private starts = new Map<number, Pose>();
  private busy = false;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly studio: Studio,
    camera: Camera,
    private readonly element: HTMLElement,
    stage: ThreeScene,
    private readonly hooks: {
      /** something must be drawn again */
      changed: () => void;
      /** whether the orbit must keep still */
      dragging: (on: boolean) => void;
      note: (text: string) => void;
      /** how far the thing was dragged; "": nothing is dragged */
      measure: (text: string) => void;
    },
  ) {
    this.controls = new TransformControls(camera, element);
    this.controls.setSize(0.8);
    stage.add(this.proxy, this.controls.getHelper());
    this.controls.addEventListener("change", () => this.hooks.changed());
    this.controls.addEventListener("dragging-changed", (event) => {
      this.hooks.dragging(Boolean(event.value));
      if (event.value) this.grab();
      else void this.release();
    });
    this.controls.addEventListener("objectChange", () => this.moved());
  }

  get dragging(): boolean {
    return this.controls.dragging;
  }
  /** Whether the pointer is on a handle. */
  get hot(): boolean {
    return this.controls.object !== undefined && this.controls.axis !== null;
  }

  /** Puts the handles on the main selected thing, at the poses shown; takes them away without one. */
  update(scene: Scene | null, poses: ArrayLike<number> | null): void {
    if (this.controls.dragging) return;
    const { state } = this.studio;
    const element = state.selection.value.at(-1) ?? -1;
    const mode = handleMode.value;
    this.what = null;
    let problem = "";
    if (scene && poses && element >= 0 && mode !== "off" && mode !== "grab" && state.mayEdit.value) {
      const found = movable(scene, element);
      if (typeof found === "string") problem = found;
      else this.what = found;
      if (mode === "resize" && this.what) {
        problem = whyNotResized(scene, this.what.kind === "body" ? this.what.index : -1, state.element(element));
        if (problem !== "") this.what = null;
      }
    }
    this.hooks.note(problem);
    const pose = this.what && scene && poses ? this.poseOf(scene, poses) : null;
    if (!this.what || !pose || !isFinite(pose)) {
      if (this.controls.object) this.controls.detach();
      return;
    }
    this.proxy.position.set(pose[0], pose[1], pose[2]);
    this.proxy.quaternion.set(pose[4], pose[5], pose[6], pose[3]);
    this.proxy.updateMatrixWorld();
    this.proxy.scale.set(1, 1, 1);
    this.controls.setMode(mode === "rotate" ? "rotate" : mode === "resize" ? "scale" : "translate");
    this.controls.setSpace(handlesLocal.value ? "local" : "world");
    this.controls.setTranslationSnap(handlesSnap.value ? kSnapLength : null);
    this.controls.setRotationSnap(handlesSnap.value ? kSnapAngle : null);
    if (this.controls.object !== this.proxy) this.controls.attach(this.proxy);
  }

  /** Where the thing's frame is now. An assembly is carried along by its first body. */
  private poseOf(scene: Scene, poses: ArrayLike<number>): Pose | null {
    const { kind, index } = this.what!;
    const now = (body: number): Pose => {
      const held = this.held.get(body);
      return held ?? (7 * body + 6 < poses.length ? poseAt(poses, body) : scene.bodies[body]!.pose);
    };
    if (kind === "body") return now(index);
    const first = bodiesIn(scene, index)[0];
    const { pose } = scene.assemblies[index]!;
    return first === undefined ? pose : carried(pose, scene.bodies[first]!.pose, now(first));
  }

  private here(): Pose {
    const { position: p, quaternion: q } = this.proxy;
    return [p.x, p.y, p.z, q.w, q.x, q.y, q.z];
  }

  private grab(): void {
    const scene = this.studio.state.scene.peek();
    const frame = this.studio.state.frame.peek();
    if (!scene || !this.what) return;
    this.start = this.here();
    const bodies = this.what.kind === "body" ? [this.what.index] : bodiesIn(scene, this.what.index);
    this.starts = new Map(
      bodies.map((body) => {
        const shown = frame && 7 * body + 6 < frame.poses.length ? poseAt(frame.poses, body) : scene.bodies[body]!.pose;
        return [body, this.held.get(body) ?? shown];
      }),
    );
    this.element.ownerDocument.addEventListener("keydown", this.onKey, true);
  }

  private moved(): void {
    if (!this.controls.dragging || !this.start) return;
    if (this.controls.mode === "scale") return this.grown();
    const by = compose(this.here(), inverse(this.start));
    for (const [body, pose] of this.starts) this.held.set(body, compose(by, pose));
    this.hooks.measure(dragText(this.start, this.here()));
    this.hooks.changed();
  }

  /** What the dragged sizes make of the element; null: it is gone. */
  private size(): { element: TreeElement; now: NonNullable<ReturnType<typeof resized>> } | null {
    const element = this.what ? this.studio.state.element(this.what.element) : undefined;
    const { x, y, z } = this.proxy.scale;
    const now = element ? resized(element, [x, y, z], handlesSnap.peek() ? kSnapLength : null) : null;
    return element && now ? { element, now } : null;
  }
  private grown(): void {
    const size = this.size();
    const shape = this.studio.state.scene.peek()?.bodies[this.what?.index ?? -1]?.shapes[0];
    if (!size || !shape) return;
    const half = halfExtents(shape.type, shape.size);
    this.outline = half && {
      pose: compose(this.here(), shape.pose),
      half: half.map((v, i) => v * size.now.scale[i]!) as Vec3,
    };
    this.hooks.measure(size.now.text);
    this.hooks.changed();
  }
  /** Writes the size that was dragged. */
  private async resize(name: string): Promise<void> {
    const size = this.size();
    this.outline = null;
    this.proxy.scale.set(1, 1, 1);
    this.hooks.changed();
    if (!size || size.now.scale.every((v) => Math.abs(v - 1) < 1e-9)) return;
    const { element, now } = size;
    const changed = now.attributes.filter(([name, value]) => value !== element.attributes[name]);
    const sets = changed.map(([attribute, value]): Op => ({ op: "set", element: element.id, attribute, value }));
    // what stands on the floor still does
    const [only] = changed;
    const rest = only && changed.length === 1 ? restOp(this.studio.state, element, ...only) : null;
    await this.studio.edit(`resize ${name}`, rest ? [...sets, rest] : sets).catch(() => null);
  }

  private readonly onKey = (event: KeyboardEvent): void => {
    if (event.key !== "Escape" || !this.controls.dragging) return;
    event.preventDefault();
    event.stopPropagation();
    this.controls.reset();
    this.start = null;
    // the end of the drag sees that there is nothing to be written
    this.controls.pointerUp(null);
    this.outline = null;
    this.drop();
  };

  private async release(): Promise<void> {
    this.hooks.measure("");
    this.element.ownerDocument.removeEventListener("keydown", this.onKey, true);
    const { what, start } = this;
    this.start = null;
    if (what && start && this.controls.mode === "scale") return this.resize(what.name);
    if (!what || !start || this.held.size === 0) return;
    const pose = this.here();
    if (pose.every((v, i) => Math.abs(v - start[i]!) < 1e-9)) {
      this.drop();
      return;
    }
    this.busy = true;
    const done = await this.studio
      .edit(`move ${what.name}`, [{ op: "place", element: what.element, pose: tidy(pose) }])
      .catch(() => null);
    this.busy = false;
    if (done === null) this.drop();
    else this.timer = setTimeout(() => this.drop(), kPatience);
  }

  /** The scene with the change has come, or none will. */
  drop(): void {
    if (this.busy) return;
    clearTimeout(this.timer);
    if (this.controls.dragging) return;
    this.held.clear();
    this.starts.clear();
    this.hooks.changed();
  }

  dispose(): void {
    clearTimeout(this.timer);
    this.element.ownerDocument.removeEventListener("keydown", this.onKey, true);
    this.controls.detach();
    this.controls.getHelper().removeFromParent();
    this.controls.dispose();
  }
}
