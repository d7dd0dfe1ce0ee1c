// The shapes of a scene as the map draws them: in order of height, each with an outline that is kept while the shape's tilt stays.
import type { Pose, Scene, SceneShape, Vec3 } from "../core/protocol";
import { compose, isFinite, poseAt } from "../view3d/pose";
import { level, planOutline, upwardExtent, turnOf, upIn } from "./outline";
import type { Rotation } from "../view3d/pose";

export interface Item {
  body: number;
  shape: SceneShape;
  fixed: boolean;
  /** position of the shape's origin [m] and its angle about the vertical [rad]; NaN: not drawn */
  x: number;
  y: number;
  turn: number;
  /** height of its highest point [m] */
  top: number;
  /** in metres, around the origin, before the turn */
  path: Path2D;
  /** half of what the outline spans along x and y of the world [m] */
  half: [number, number];
  /** unit normal of a plane, world */
  normal: Vec3;
}

interface Kept extends Item {
  up: Vec3;
  tilt: Rotation;
  extent: number;
  /** half of what the outline spans before the turn */
  span: [number, number];
}

/** So little tilt [rad] changes an outline by less than a pixel on any screen. */
const kSameTilt = 1e-4;

function pathOf(polygons: [number, number][][]): Path2D {
  const path = new Path2D();
  for (const polygon of polygons) {
    polygon.forEach(([x, y], i) => (i === 0 ? path.moveTo(x, y) : path.lineTo(x, y)));
    path.closePath();
  }
  return path;
}

function spanOf(outline: [number, number][][]): [number, number] {
  const span: [number, number] = [0, 0];
  for (const polygon of outline) {
    for (const [x, y] of polygon) {
      span[0] = Math.max(span[0], Math.abs(x));
      span[1] = Math.max(span[1], Math.abs(y));
    }
  }
  return span;
}

export class Items {
  private readonly all: Kept[] = [];

  constructor(private readonly scene: Scene) {
    scene.bodies.forEach((body, b) => {
      if (body.removed) return;
      for (const shape of body.shapes) {
        if (!shape.visual) continue;
        this.all.push({
          body: b,
          shape,
          fixed: body.kind === "fixed",
          x: NaN,
          y: NaN,
          turn: 0,
          top: 0,
          path: new Path2D(),
          half: [0, 0],
          normal: [0, 0, 1],
          span: [0, 0],
          up: [NaN, NaN, NaN],
          tilt: [1, 0, 0, 0, 1, 0, 0, 0, 1],
          extent: 0,
        });
      }
    });
  }

  /** Puts all at their poses; the lowest first. Those without a pose are left out. */
  moveTo(poses: ArrayLike<number>): Item[] {
    for (const item of this.all) {
      const body: Pose =
        7 * item.body + 6 < poses.length ? poseAt(poses, item.body) : this.scene.bodies[item.body]!.pose;
      const pose = compose(body, item.shape.pose);
      item.x = NaN;
      if (!isFinite(pose)) continue;
      [item.x, item.y] = pose;
      const up = upIn(pose);
      const change = Math.max(...up.map((v, i) => Math.abs(v - item.up[i]!)));
      if (!(change <= kSameTilt)) {
        item.up = up;
        item.tilt = level(up);
        const outline = planOutline(this.scene, item.shape, item.tilt);
        item.path = pathOf(outline);
        item.span = spanOf(outline);
        item.extent = upwardExtent(this.scene, item.shape, up);
      }
      item.turn = turnOf(pose, item.tilt);
      item.top = pose[2] + item.extent;
      const [c, n] = [Math.abs(Math.cos(item.turn)), Math.abs(Math.sin(item.turn))];
      item.half = [c * item.span[0] + n * item.span[1], n * item.span[0] + c * item.span[1]];
      if (item.shape.type === "plane") item.normal = planeNormal(item.up, item.turn, item.tilt);
    }
    return this.all.filter((item) => !Number.isNaN(item.x)).sort((a, b) => a.top - b.top);
  }
}

/** The shape's z axis in the world. */
function planeNormal(up: Vec3, turn: number, tilt: Rotation): Vec3 {
  const x = tilt[2];
  const y = tilt[5];
  const c = Math.cos(turn);
  const s = Math.sin(turn);
  return [c * x - s * y, s * x + c * y, up[2]];
}
