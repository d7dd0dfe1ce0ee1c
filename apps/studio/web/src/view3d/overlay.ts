// Overlays of the scene: rays, contacts, axes, trajectories, regions.
import { BoxGeometry, DoubleSide, Group, Mesh, MeshBasicMaterial, SphereGeometry, Vector3, Quaternion } from "three";
import type { Frame } from "../core/frame";
import type { Pose, Scene, Vec3 } from "../core/protocol";
import { jointAxes } from "./joint_axes";
import { Dots, linearColor, Lines, type Rgb } from "./lines";
import { compose, kIdentity, isFinite, poseAt, rotate, transform } from "./pose";
import { rayEnds } from "./rays";
import { drawSelected } from "./selected";
import { overlays } from "./settings";
import { springLine } from "./springs";
import { dashes, type Trails } from "./trails";

const kAxes: Rgb[] = [linearColor([0.9, 0.1, 0.1]), linearColor([0.1, 0.65, 0.1]), linearColor([0.15, 0.3, 0.95])];
const kContact = linearColor([1.0, 0.75, 0.0]);
/** A lidar has so many rays that only thin and pale ones leave anything to see. */
const kFan = linearColor([0.35, 0.6, 0.9]);
const kForce = linearColor([0.9, 0.2, 0.1]);
const kSpring = linearColor([0.35, 0.4, 0.45]);
const kJoint = linearColor([0.85, 0.2, 0.85]);
const kCentre = linearColor([0.95, 0.85, 0.1]);

export class Overlay {
  readonly root = new Group();
  private readonly lines = new Lines(1.6, false);
  private readonly fans = new Lines(1, false, 0.3);
  private readonly topLines = new Lines(2.2, true);
  private readonly dots = new Dots(6, true);
  private readonly regions = new Group();
  private rayHit: Rgb = [1, 0, 0];
  private rayMiss: Rgb = [1, 0.4, 0.4];

  constructor() {
    this.root.add(this.fans.mesh, this.lines.mesh, this.topLines.mesh, this.dots.mesh, this.regions);
  }

  setColors(ray: string): void {
    this.rayHit = linearColor(ray);
    this.rayMiss = this.rayHit.map((v) => 0.45 * v + 0.4) as unknown as Rgb;
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
  update(
    scene: Scene,
    frame: Frame,
    poses: Float32Array,
    size: number,
    trails: Trails,
    selected: number[],
    pulled: [Vec3, Vec3] | null,
    outline: { pose: Pose; half: Vec3 } | null,
  ): void {
    const { lines, fans, topLines, dots } = this;
    lines.begin();
    fans.begin();
    topLines.begin();
    dots.begin();
    const poseOf = (body: number): Pose =>
      body < 0 ? kIdentity : 7 * body + 6 < poses.length ? poseAt(poses, body) : scene.bodies[body]!.pose;

    if (outline) {
      const corner = (i: number): Vec3 =>
        transform(
          outline.pose,
          outline.half.map((v, axis) => (i & (1 << axis) ? v : -v)),
        );
      for (let i = 0; i < 8; i++)
        for (const bit of [1, 2, 4]) if (!(i & bit)) topLines.add(corner(i), corner(i | bit), kJoint);
    }
    if (pulled) {
      const line = springLine(...pulled, 0.008 * size, false);
      for (let i = 1; i < line.length; i++) topLines.add(line[i - 1]!, line[i]!, kForce);
      for (const end of pulled) dots.add(end, kForce);
    }
    if (overlays.rays.value) {
      for (const ray of rayEnds(scene, { ...frame, poses })) {
        if (ray.fan) {
          if (ray.hit) fans.add(ray.from, ray.to, kFan);
          continue;
        }
        lines.add(ray.from, ray.to, ray.hit ? this.rayHit : this.rayMiss);
        if (ray.hit) dots.add(ray.to, this.rayHit);
      }
    }
    if (overlays.contacts.value) {
      const contacts = frame.tail.contacts ?? [];
      const largest = contacts.reduce((m, c) => Math.max(m, c.force), 0);
      for (const c of contacts) {
        dots.add(c.point, kContact);
        if (!(largest > 0)) continue;
        const length = (0.1 * size * c.force) / largest;
        const tip: Vec3 = [
          c.point[0] + length * c.normal[0],
          c.point[1] + length * c.normal[1],
          c.point[2] + length * c.normal[2],
        ];
        topLines.add(c.point, tip, kContact);
      }
    }
    if (overlays.joints.value) {
      for (const joint of scene.joints) {
        const parent = compose(poseOf(joint.parent), joint.parent_pose);
        const child = compose(poseOf(joint.child), joint.child_pose);
        if (!isFinite(parent) || !isFinite(child)) continue;
        const half = 0.04 * size;
        const ends = (d: Vec3, s: number): Vec3 => [
          parent[0] + s * half * d[0],
          parent[1] + s * half * d[1],
          parent[2] + s * half * d[2],
        ];
        for (const axis of jointAxes(joint.type, parent, child)) topLines.add(ends(axis, -1), ends(axis, 1), kJoint);
        dots.add(parent, kJoint);
      }
    }
    if (overlays.forces.value) {
      // A force without a vector is one that a controller sets: its value is not in the frame.
      const acting = scene.forces.filter(
        (f) => f.kind === "force" && frame.time >= f.from && frame.time < (f.until ?? Infinity),
      );
      const largest = acting.reduce((m, f) => Math.max(m, Math.hypot(...f.vector)), 0);
      for (const force of scene.forces) {
        const at = compose(poseOf(force.body), force.pose);
        if (force.removed || !isFinite(at)) continue;
        const from: Vec3 = [at[0], at[1], at[2]];
        if (force.kind === "spring") {
          const other = poseOf(force.other);
          if (!isFinite(other)) continue;
          const line = springLine(from, transform(other, force.other_point), 0.012 * size, force.cable);
          for (let i = 1; i < line.length; i++) lines.add(line[i - 1]!, line[i]!, kSpring);
        } else if (acting.includes(force) && largest > 0) {
          const scale = (0.25 * size) / largest;
          const vector = force.in_body ? rotate(at, force.vector) : force.vector;
          const tip: Vec3 = [from[0] + scale * vector[0], from[1] + scale * vector[1], from[2] + scale * vector[2]];
          topLines.add(from, tip, kForce);
          dots.add(tip, kForce);
        }
      }
    }
    if (overlays.frames.value || overlays.centres.value) {
      scene.bodies.forEach((body, i) => {
        if (body.removed || body.kind === "fixed") return;
        const pose = poseOf(i);
        if (!isFinite(pose)) return;
        if (overlays.frames.value) {
          kAxes.forEach((color, k) => {
            const tip: Vec3 = [0, 0, 0];
            tip[k] = 0.05 * size;
            topLines.add(pose, transform(pose, tip), color);
          });
        }
        if (overlays.centres.value) dots.add(transform(pose, body.com), kCentre);
      });
    }
    if (overlays.trails.value) {
      for (const trail of trails.all) {
        const color = linearColor(trail.color);
        const line = trails.line(trail, frame);
        const drawn = dashes(line, line.length / 3, 0.012 * size);
        for (let i = 0; i + 5 < drawn.length; i += 6) topLines.add(drawn, drawn, color, i, i + 3);
      }
    }
    drawSelected({ lines: topLines, dots }, scene, poses, selected, size);
    this.regions.visible = overlays.regions.value;
    for (const mesh of this.regions.children) {
      const region = scene.regions[mesh.userData.region as number]!;
      const pose = compose(poseOf(region.body), region.pose);
      mesh.visible = isFinite(pose);
      if (!mesh.visible) continue;
      mesh.position.copy(new Vector3(pose[0], pose[1], pose[2]));
      mesh.quaternion.copy(new Quaternion(pose[4], pose[5], pose[6], pose[3]));
    }
    lines.end();
    fans.end();
    topLines.end();
    dots.end();
  }

  dispose(): void {
    this.lines.dispose();
    this.fans.dispose();
    this.topLines.dispose();
    this.dots.dispose();
    this.regions.clear();
  }
}
