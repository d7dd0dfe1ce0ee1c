// Overlays of the scene: rays, contacts, axes, trajectories, regions.
import { BoxGeometry, DoubleSide, Group, Mesh, MeshBasicMaterial, SphereGeometry, Vector3, Quaternion } from "three";
import type { Frame, Pose, Scene, Vec3 } from "../core/protocol";
import { Dots, linear_color, Lines } from "./lines";
import { compose, IDENTITY, is_finite, pose_at, rotate, transform } from "./pose";
import { ray_ends } from "./rays";
import { overlays } from "./settings";
import { dashes, type Trails } from "./trails";

type Rgb = readonly [number, number, number];
const AXES: Rgb[] = [linear_color([0.9, 0.1, 0.1]), linear_color([0.1, 0.65, 0.1]), linear_color([0.15, 0.3, 0.95])];
const CONTACT = linear_color([1.0, 0.75, 0.0]);
/** A lidar has so many rays that only thin and pale ones leave anything to see. */
const FAN = linear_color([0.35, 0.6, 0.9]);
const JOINT = linear_color([0.85, 0.2, 0.85]);
const CENTRE = linear_color([0.95, 0.85, 0.1]);

/** Unit directions of the axes of a joint, world. Of a universal joint: x of the parent's frame, y of the child's. */
export function joint_axes(type: string, parent: Pose, child: Pose): Vec3[] {
  switch (type) {
    case "hinge":
    case "slider":
    case "screw":
    case "cylindrical":
    case "planar":
      return [rotate(parent, [0, 0, 1])];
    case "universal":
      return [rotate(parent, [1, 0, 0]), rotate(child, [0, 1, 0])];
    case "ball":
      return [rotate(parent, [1, 0, 0]), rotate(parent, [0, 1, 0]), rotate(parent, [0, 0, 1])];
    default:
      return [];
  }
}

export class Overlay {
  readonly root = new Group();
  private readonly lines = new Lines(1.6, false);
  private readonly fans = new Lines(1, false, 0.3);
  private readonly top_lines = new Lines(2.2, true);
  private readonly dots = new Dots(6, true);
  private readonly regions = new Group();
  private ray_hit: Rgb = [1, 0, 0];
  private ray_miss: Rgb = [1, 0.4, 0.4];

  constructor() {
    this.root.add(this.fans.mesh, this.lines.mesh, this.top_lines.mesh, this.dots.mesh, this.regions);
  }

  set_colors(ray: string): void {
    this.ray_hit = linear_color(ray);
    this.ray_miss = this.ray_hit.map((v) => 0.45 * v + 0.4) as unknown as Rgb;
  }

  /** Of another scene. */
  adopt(scene: Scene): void {
    for (const child of [...this.regions.children] as Mesh[]) {
      child.removeFromParent();
      child.geometry.dispose();
      (child.material as MeshBasicMaterial).dispose();
    }
    scene.regions.forEach((region, i) => {
      const geometry =
        region.type === "box" ? new BoxGeometry(...region.size) : new SphereGeometry(region.radius, 32, 16);
      const material = new MeshBasicMaterial({
        color: 0x2aa5c9,
        transparent: true,
        opacity: 0.22,
        depthWrite: false,
        side: DoubleSide,
      });
      const mesh = new Mesh(geometry, material);
      mesh.userData.region = i;
      mesh.raycast = () => {};
      mesh.renderOrder = 1;
      this.regions.add(mesh);
    });
  }

  /** `size`: of the scene [m]; lengths of arrows go by it. */
  update(scene: Scene, frame: Frame, poses: Float32Array, size: number, trails: Trails): void {
    const { lines, fans, top_lines, dots } = this;
    lines.begin();
    fans.begin();
    top_lines.begin();
    dots.begin();
    const pose_of = (body: number): Pose =>
      body < 0 ? IDENTITY : 7 * body + 6 < poses.length ? pose_at(poses, body) : scene.bodies[body]!.pose;

    if (overlays.rays.value) {
      for (const ray of ray_ends(scene, { ...frame, poses })) {
        if (ray.fan) {
          if (ray.hit) fans.add(ray.from, ray.to, FAN);
          continue;
        }
        lines.add(ray.from, ray.to, ray.hit ? this.ray_hit : this.ray_miss);
        if (ray.hit) dots.add(ray.to, this.ray_hit);
      }
    }
    if (overlays.contacts.value) {
      const contacts = frame.tail.contacts ?? [];
      const largest = contacts.reduce((m, c) => Math.max(m, c.force), 0);
      for (const c of contacts) {
        dots.add(c.point, CONTACT);
        if (!(largest > 0)) continue;
        const length = (0.1 * size * c.force) / largest;
        const tip: Vec3 = [
          c.point[0] + length * c.normal[0],
          c.point[1] + length * c.normal[1],
          c.point[2] + length * c.normal[2],
        ];
        top_lines.add(c.point, tip, CONTACT);
      }
    }
    if (overlays.joints.value) {
      for (const joint of scene.joints) {
        const parent = compose(pose_of(joint.parent), joint.parent_pose);
        const child = compose(pose_of(joint.child), joint.child_pose);
        if (!is_finite(parent) || !is_finite(child)) continue;
        const half = 0.04 * size;
        const ends = (d: Vec3, s: number): Vec3 => [
          parent[0] + s * half * d[0],
          parent[1] + s * half * d[1],
          parent[2] + s * half * d[2],
        ];
        for (const axis of joint_axes(joint.type, parent, child)) top_lines.add(ends(axis, -1), ends(axis, 1), JOINT);
        dots.add(parent, JOINT);
      }
    }
    if (overlays.frames.value || overlays.centres.value) {
      scene.bodies.forEach((body, i) => {
        if (body.removed || body.kind === "fixed") return;
        const pose = pose_of(i);
        if (!is_finite(pose)) return;
        if (overlays.frames.value) {
          AXES.forEach((color, k) => {
            const tip: Vec3 = [0, 0, 0];
            tip[k] = 0.05 * size;
            top_lines.add(pose, transform(pose, tip), color);
          });
        }
        if (overlays.centres.value) dots.add(transform(pose, body.com), CENTRE);
      });
    }
    if (overlays.trails.value) {
      for (const trail of trails.all) {
        const color = linear_color(trail.color);
        const line = trails.line(trail, frame);
        const drawn = dashes(line, line.length / 3, 0.012 * size);
        for (let i = 0; i + 5 < drawn.length; i += 6) top_lines.add(drawn, drawn, color, i, i + 3);
      }
    }
    this.regions.visible = overlays.regions.value;
    for (const mesh of this.regions.children) {
      const region = scene.regions[mesh.userData.region as number]!;
      const pose = compose(pose_of(region.body), region.pose);
      mesh.visible = is_finite(pose);
      if (!mesh.visible) continue;
      mesh.position.copy(new Vector3(pose[0], pose[1], pose[2]));
      mesh.quaternion.copy(new Quaternion(pose[4], pose[5], pose[6], pose[3]));
    }
    lines.end();
    fans.end();
    top_lines.end();
    dots.end();
  }

  dispose(): void {
    this.lines.dispose();
    this.fans.dispose();
    this.top_lines.dispose();
    this.dots.dispose();
    this.regions.clear();
  }
}
