// Pulls a body of the run to the pointer, by a spring that the server computes in every step.
import { Plane, Raycaster, Vector2, Vector3, type Camera } from "three";
import { isClosed, messageOf } from "../core/link";
import type { Scene, Vec3 } from "../core/protocol";
import type { Studio } from "../core/studio";
import { inverse, poseAt, transform } from "./pose";
import { dragging, handleMode } from "./settings";

interface Held {
  pointer: number;
  body: number;
  name: string;
  /** in the body's frame */
  point: Vec3;
  /** in the world */
  target: Vec3;
  /** of where it can be pulled to: through the point, facing the camera */
  plane: Plane;
  /** [N/m]; 0: not known yet */
  stiffness: number;
}

export class Grabber {
  held: Held | null = null;
  private moving = false;
  private moved = false;
  private readonly ray = new Raycaster();

  constructor(
    private readonly studio: Studio,
    private readonly camera: Camera,
    private readonly host: HTMLElement,
    private readonly hooks: {
      /** what is under a position of the window */
      at: (x: number, y: number) => { body: number; point: Vec3 } | null;
      scene: () => Scene | null;
      poses: () => ArrayLike<number>;
      changed: () => void;
      /** what is pulled, and how; "": nothing is */
      measure: (text: string) => void;
    },
  ) {
    // before what turns the camera
    host.addEventListener("pointerdown", (event) => this.down(event), { capture: true });
    host.addEventListener("pointermove", (event) => this.move(event), { capture: true });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"] as const)
      host.addEventListener(end, (event) => this.up(event), { capture: true });
    host.ownerDocument.addEventListener("keydown", this.onKey, true);
  }
  dispose(): void {
    this.release();
    this.host.ownerDocument.removeEventListener("keydown", this.onKey, true);
  }

  /** Where the spring's two ends are now; null: nothing is pulled. */
  ends(): [Vec3, Vec3] | null {
    const { held } = this;
    const from = held && this.pointNow(held);
    return held && from ? [from, held.target] : null;
  }

  private pointNow(held: Held): Vec3 | null {
    const poses = this.hooks.poses();
    return 7 * held.body + 6 < poses.length ? transform(poseAt(poses, held.body), held.point) : null;
  }

  private mayGrab(): boolean {
    const { state } = this.studio;
    return state.mayEdit.peek() && state.live.peek() && state.status.peek()?.state !== "ended";
  }

  private down(event: PointerEvent): void {
    if (event.button !== 0 || this.held || !(handleMode.peek() === "grab" || event.altKey)) return;
    const scene = this.hooks.scene();
    const found = this.hooks.at(event.clientX, event.clientY);
    const body = found && scene?.bodies[found.body];
    // beside things the camera is turned as ever
    if (!found || !body || body.kind !== "dynamic" || !this.mayGrab()) return;
    event.stopPropagation();
    event.preventDefault();
    this.host.focus({ preventScroll: true });
    const poses = this.hooks.poses();
    const facing = this.camera.getWorldDirection(new Vector3()).negate();
    const held: Held = {
      pointer: event.pointerId,
      body: found.body,
      name: body.name,
      point: transform(inverse(poseAt(poses, found.body)), found.point),
      target: found.point,
      plane: new Plane().setFromNormalAndCoplanarPoint(facing, new Vector3(...found.point)),
      stiffness: 0,
    };
    this.held = held;
    this.host.setPointerCapture(event.pointerId);
    dragging.value = true;
    this.studio.link.request("grab", { body: held.name, point: held.point, target: held.target }).then(
      ({ stiffness }) => {
        held.stiffness = stiffness;
        this.show();
      },
      (error: unknown) => {
        if (this.held === held) this.release(false);
        if (!isClosed(error)) this.studio.notify(messageOf(error), "error");
      },
    );
    this.show();
  }

  private move(event: PointerEvent): void {
    const { held } = this;
    if (!held || event.pointerId !== held.pointer) return;
    event.stopPropagation();
    const box = this.host.getBoundingClientRect();
    const at = new Vector2(
      ((event.clientX - box.left) / box.width) * 2 - 1,
      1 - ((event.clientY - box.top) / box.height) * 2,
    );
    this.ray.setFromCamera(at, this.camera);
    const hit = this.ray.ray.intersectPlane(held.plane, new Vector3());
    if (!hit) return;
    held.target = [hit.x, hit.y, hit.z];
    this.moved = true;
    if (!this.moving) void this.send();
    this.show();
  }
  /** One at a time: the newest target waits. */
  private async send(): Promise<void> {
    this.moving = true;
    try {
      while (this.moved && this.held) {
        this.moved = false;
        await this.studio.link.request("grab-move", { target: this.held.target });
      }
    } catch {
      // it was let go, or refused: the answer to `grab` says why
    } finally {
      this.moving = false;
    }
  }

  private up(event: PointerEvent): void {
    if (!this.held || event.pointerId !== this.held.pointer) return;
    event.stopPropagation();
    this.release();
  }
  private readonly onKey = (event: KeyboardEvent): void => {
    if (event.key !== "Escape" || !this.held) return;
    event.preventDefault();
    event.stopPropagation();
    this.release();
  };

  private release(tell = true): void {
    const { held } = this;
    if (!held) return;
    this.held = null;
    this.moved = false;
    dragging.value = false;
    if (this.host.hasPointerCapture(held.pointer)) this.host.releasePointerCapture(held.pointer);
    if (tell) this.studio.link.request("release").catch(() => {});
    this.show();
  }

  private show(): void {
    this.tell();
    this.hooks.changed();
  }
  /** Says how it is pulled: with every picture. */
  tell(): void {
    const { held } = this;
    const ends = this.ends();
    if (!held || !ends) this.hooks.measure("");
    else if (this.studio.state.status.peek()?.state !== "playing")
      this.hooks.measure(`${held.name}: it is pulled while the run plays`);
    else {
      const [a, b] = ends;
      const force = held.stiffness * Math.hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
      const short = (v: number) => String(Number(v.toPrecision(3)));
      this.hooks.measure(
        held.stiffness > 0 ? `${held.name}: ${short(held.stiffness)} N/m, ${short(force)} N` : held.name,
      );
    }
  }
}
