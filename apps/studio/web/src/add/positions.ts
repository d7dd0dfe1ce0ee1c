// Positions of new elements: on the ground, beside the selection, outside of existing bodies.
import type { Scene, SceneBody, Vec3 } from "../core/protocol";
import type { State } from "../core/state";
import { rotate } from "../view3d/pose";

interface Round {
  centre: Vec3;
  radius: number;
}

/** A ball around a body; null for bodies without an end or a shape: planes, grounds. */
function ballAround(body: SceneBody, scene: Scene): Round | null {
  let radius = 0;
  let any = false;
  for (const shape of body.shapes) {
    if (shape.type === "plane" || shape.type === "heightmap") return null;
    const away = Math.hypot(shape.pose[0], shape.pose[1], shape.pose[2]);
    const [a = 0, b = 0, c = 0] = shape.size;
    let own = 0;
    if (shape.type === "box") own = Math.hypot(a, b, c) / 2;
    else if (shape.type === "sphere") own = a;
    else if (shape.type === "cylinder") own = Math.hypot(a, b / 2);
    else if (shape.type === "capsule") own = a + b / 2;
    else {
      const positions = scene.meshes[shape.mesh ?? -1]?.positions ?? [];
      for (let i = 0; i + 2 < positions.length; i += 3) {
        own = Math.max(own, Math.hypot(positions[i]!, positions[i + 1]!, positions[i + 2]!));
      }
    }
    radius = Math.max(radius, away + own);
    any = true;
  }
  return any ? { centre: [body.pose[0], body.pose[1], body.pose[2]], radius } : null;
}

const overlaps = (a: Round, b: Round): boolean =>
  Math.hypot(a.centre[0] - b.centre[0], a.centre[1] - b.centre[1], a.centre[2] - b.centre[2]) < a.radius + b.radius;

const rounded = (v: number): number => Math.round(v * 1000) / 1000;

/** The first free position for a ball of `radius`: at `start`, then on growing rings around it at the same height. */
export function freePosition(others: readonly Round[], start: Vec3, radius: number): Vec3 {
  for (let ring = 0; ring < 40; ++ring) {
    const count = ring === 0 ? 1 : 6 * ring;
    for (let i = 0; i < count; ++i) {
      const angle = (2 * Math.PI * i) / count;
      const away = ring * 2 * (radius + 0.01);
      const centre: Vec3 = [
        rounded(start[0] + away * Math.cos(angle)),
        rounded(start[1] + away * Math.sin(angle)),
        start[2],
      ];
      if (!others.some((other) => overlaps(other, { centre, radius }))) return centre;
    }
  }
  return start;
}

/** A free position in the world for something new of `radius`, beside the main selected body or at the middle. */
export function newPosition(state: State, radius: number, height: number): Vec3 {
  const scene = state.scene.peek();
  if (!scene) return [0, 0, height];
  const balls = scene.bodies.filter((b) => !b.removed).map((b) => ballAround(b, scene));
  const main = state.selection.peek()[state.selection.peek().length - 1];
  let start: Vec3 = [0, 0, height];
  if (main !== undefined && main > 0) {
    const index = state.bodiesOf(main).find((i) => {
      const body = scene.bodies[i]!;
      return !body.shapes.some((s) => s.type === "plane" || s.type === "heightmap");
    });
    const body = index === undefined ? undefined : scene.bodies[index];
    const ball = body ? ballAround(body, scene) : null;
    if (ball) start = [rounded(ball.centre[0] + ball.radius + radius + 0.05), rounded(ball.centre[1]), height];
  }
  return freePosition(
    balls.filter((b): b is Round => b !== null),
    start,
    radius,
  );
}

/** Extents [m] of a body's shapes in its own frame: the lowest and the highest corner; null if it has none, or no end. */
export function extents(body: SceneBody): { low: Vec3; high: Vec3 } | null {
  const low: Vec3 = [Infinity, Infinity, Infinity];
  const high: Vec3 = [-Infinity, -Infinity, -Infinity];
  for (const shape of body.shapes) {
    const [a = 0, b = 0, c = 0] = shape.size;
    let half: Vec3;
    if (shape.type === "box") half = [a / 2, b / 2, c / 2];
    else if (shape.type === "sphere") half = [a, a, a];
    else if (shape.type === "cylinder") half = [a, a, b / 2];
    else if (shape.type === "capsule") half = [a, a, a + b / 2];
    else return null;
    // A turned box reaches along an axis as far as its edges do together.
    const edges = [0, 1, 2].map((k) => rotate(shape.pose, [0, 1, 2].map((j) => (j === k ? half[k]! : 0)) as Vec3));
    for (let i = 0; i < 3; ++i) {
      const halfExtent = edges.reduce((sum, edge) => sum + Math.abs(edge[i]!), 0);
      low[i] = Math.min(low[i]!, shape.pose[i]! - halfExtent);
      high[i] = Math.max(high[i]!, shape.pose[i]! + halfExtent);
    }
  }
  return low[0] < Infinity ? { low, high } : null;
}

/** Where a new sensor sits on a body that has `count` of its kind, in the body's frame: at its front (+x), where nothing of the
 *  body blocks the view. `high`: at the upper edge, the first in the middle; else at half height, the first two as a pair. */
export function frontPosition(body: SceneBody, count: number, high: boolean): Vec3 | null {
  const box = extents(body);
  if (!box) return null;
  const middle = (i: number): number => (box.low[i]! + box.high[i]!) / 2;
  const side = (high ? [0, 1, -1] : [1, -1, 0])[count % 3]!;
  const y = middle(1) + (side * (box.high[1] - box.low[1])) / 3;
  return [rounded(box.high[0]), rounded(y), rounded(high ? box.high[2] : middle(2))];
}

/** How far from its original a copy stands: beside it along x. */
export function duplicateOffset(state: State, ids: readonly number[]): Vec3 {
  const scene = state.scene.peek();
  if (!scene) return [0.3, 0, 0];
  let low = Infinity;
  let high = -Infinity;
  for (const id of ids) {
    for (const index of state.bodiesOf(id)) {
      const ball = ballAround(scene.bodies[index]!, scene);
      if (!ball) continue;
      low = Math.min(low, ball.centre[0] - ball.radius);
      high = Math.max(high, ball.centre[0] + ball.radius);
    }
  }
  return low < high ? [Math.ceil((high - low + 0.02) * 100) / 100, 0, 0] : [0.3, 0, 0];
}
