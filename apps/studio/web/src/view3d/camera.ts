// The eye: orbit, pan and zoom around a point, standard views, following a body.
import { MOUSE, PerspectiveCamera, Vector3 } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { Pose, Vec3 } from "../core/protocol";
import { middleOf, kNothing, radiusOf, type Bounds } from "./bounds";
import {
  cameraPose,
  directionOf,
  distanceFor,
  horizontalFov,
  kFieldOfView,
  kFlatField,
  verticalFov,
  type ViewName,
} from "./views";

/** So far above a floor the eye stays, as a share of the distance to what it looks at. */
const kAboveFloor = 0.02;

export class Eye {
  readonly camera = new PerspectiveCamera(40, 1, 0.01, 1000);
  readonly controls: OrbitControls;
  /** Whether a person has taken it: then it goes nowhere by itself. */
  taken = false;
  private handled = false;
  private farthest = 2;
  private followed: Vec3 | null = null;
  private field = kFieldOfView;
  /** Height of the floor under which one does not dive [m]; null: there is none. */
  floor: number | null = null;

  constructor(element: HTMLElement, changed: () => void) {
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, element);
    this.controls.enableDamping = false;
    this.controls.zoomToCursor = true;
    this.controls.screenSpacePanning = true;
    this.controls.minDistance = 1e-3;
    this.controls.mouseButtons = { LEFT: MOUSE.ROTATE, MIDDLE: MOUSE.PAN, RIGHT: MOUSE.PAN };
    // a click alone takes nothing
    this.controls.addEventListener("start", () => (this.handled = true));
    this.controls.addEventListener("end", () => (this.handled = false));
    this.controls.addEventListener("change", () => {
      this.taken ||= this.handled;
      if (this.handled) this.stayAbove();
      changed();
    });
    this.look("iso", kNothing);
  }

  setSize(width: number, height: number): void {
    this.camera.aspect = width / Math.max(height, 1);
    this.camera.fov = (verticalFov(this.camera.aspect, this.field) * 180) / Math.PI;
    this.camera.updateProjectionMatrix();
  }

  /** Without perspective: from very far off through a very narrow angle. What is seen keeps its size. */
  setFlat(flat: boolean): void {
    const field = flat ? kFlatField : kFieldOfView;
    if (field === this.field) return;
    const { target } = this.controls;
    const factor = Math.tan(this.field / 2) / Math.tan(field / 2);
    this.camera.position.sub(target).multiplyScalar(factor).add(target);
    this.field = field;
    this.setSize(this.camera.aspect, 1);
    this.settle();
  }
  get flat(): boolean {
    return this.field === kFlatField;
  }
  /** Horizontal field of view [rad]. */
  get fov(): number {
    return horizontalFov(this.camera.aspect, this.field);
  }
  /** From how far off an eye with perspective sees as much [m]. */
  get distance(): number {
    const factor = Math.tan(this.field / 2) / Math.tan(kFieldOfView / 2);
    return this.camera.position.distanceTo(this.controls.target) * factor;
  }

  /** Where a person's hand leads under the floor, the eye slides along it instead; from below one may look on. */
  private stayAbove(): void {
    const { position } = this.camera;
    const { target } = this.controls;
    if (this.floor === null || this.wasBelow) return;
    if (target.z < this.floor) {
      position.z += this.floor - target.z;
      target.z = this.floor;
    }
    const least = this.floor + kAboveFloor * this.distance;
    if (position.z >= least) return;
    position.z = least;
    this.camera.lookAt(target);
  }
  /** A view from below was asked for. */
  private wasBelow = false;

  /** Shows all of the bounds from a side. */
  look(from: ViewName | Vec3, bounds: Bounds): void {
    this.lookAlong(typeof from === "string" ? directionOf(from) : from, bounds);
  }

  /** Shows all of the bounds from where one looks now. */
  fit(bounds: Bounds): void {
    const d = this.camera.position.clone().sub(this.controls.target).normalize();
    this.lookAlong([d.x, d.y, d.z], bounds);
  }

  private lookAlong(direction: Vec3, bounds: Bounds): void {
    const middle = middleOf(bounds);
    const distance = distanceFor(bounds, direction, this.camera.aspect, this.field);
    this.wasBelow = direction[2] < 0;
    this.controls.target.set(...middle);
    this.camera.position.set(...middle).addScaledVector(new Vector3(...direction), distance);
    this.settle();
  }

  /** After a movement that is not a person's. */
  private settle(): void {
    const { handled } = this;
    this.handled = false;
    this.controls.update();
    this.handled = handled;
  }

  /** Moves along with the followed point; null: none. */
  follow(point: Vec3 | null): void {
    const before = this.followed;
    this.followed = point;
    if (!before || !point || !point.every(Number.isFinite)) return;
    const moved = new Vector3(point[0] - before[0], point[1] - before[1], point[2] - before[2]);
    if (moved.lengthSq() === 0) return;
    this.camera.position.add(moved);
    this.controls.target.add(moved);
    this.settle();
  }

  /** Turns around its target [rad], or comes nearer by a factor: for the keyboard. */
  turn(azimuth: number, elevation: number, nearer = 1): void {
    this.taken = true;
    const offset = this.camera.position.clone().sub(this.controls.target);
    const length = offset.length() / nearer;
    const polar = Math.acos(Math.max(-1, Math.min(1, offset.z / offset.length()))) - elevation;
    const around = Math.atan2(offset.y, offset.x) + azimuth;
    const p = Math.max(1e-4, Math.min(Math.PI - 1e-4, polar));
    offset.set(Math.sin(p) * Math.cos(around), Math.sin(p) * Math.sin(around), Math.cos(p)).multiplyScalar(length);
    this.camera.position.copy(this.controls.target).add(offset);
    this.stayAbove();
    this.controls.update();
  }

  /** Near and far planes that hold everything and waste little depth. */
  adjust(bounds: Bounds | null): void {
    if (bounds) {
      const far = this.controls.target.distanceTo(new Vector3(...middleOf(bounds)));
      this.farthest = this.distance + far + radiusOf(bounds);
    }
    const distance = this.camera.position.distanceTo(this.controls.target);
    this.camera.near = Math.max(1e-3, (this.flat ? 0.5 : 0.005) * distance);
    // far enough for the ground behind, too
    this.camera.far = this.flat ? distance + this.reach : this.reach;
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
  }

  /** So far from what it looks at floors are drawn [m]. */
  get reach(): number {
    return 20 * (this.distance + this.farthest);
  }

  /** As the server has it: looks along +x, z up. */
  pose(): Pose {
    const { position } = this.camera;
    const { target } = this.controls;
    return cameraPose([position.x, position.y, position.z], [target.x, target.y, target.z]);
  }

  dispose(): void {
    this.controls.dispose();
  }
}
