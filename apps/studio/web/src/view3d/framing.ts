// What the view shows of a run: it goes along with what moves, by the rule of the command line's pictures
// (sdk/include/cogrsim/rendering/framing.h).
import type { Scene, Vec3 } from "../core/protocol";
import { joined, kNothing, middleOf, radiusOf, visibleBounds, type Bounds } from "./bounds";

/** What moves may spread so many times as far as everything at the start; beyond, what is farthest is given up. */
const kMostSpread = 10;
/** Within this share of the box to its edge it goes along. */
const kBand = 0.2;

const median = (values: number[]): number => values.sort((a, b) => a - b)[Math.floor(values.length / 2)]!;

/** Of what moves; null: nothing does. `start`: of everything at the start. */
function movingBounds(scene: Scene, poses: ArrayLike<number>, start: Bounds): Bounds | null {
  const boxes = scene.bodies.flatMap((body, i) => {
    const box = body.kind === "fixed" ? null : visibleBounds(scene, poses, [i]);
    return box ? [box] : [];
  });
  if (boxes.length === 0) return null;
  const limit = kMostSpread * radiusOf(start);
  const all = boxes.reduce(joined);
  if (boxes.length < 2 || radiusOf(all) <= limit) return all;
  const middles = [start, ...boxes].map(middleOf);
  const middle = ([0, 1, 2] as const).map((axis) => median(middles.map((m) => m[axis])));
  const away = (box: Bounds) => Math.hypot(...middleOf(box).map((v, i) => v - middle[i]!));
  boxes.sort((a, b) => away(a) - away(b));
  let kept = boxes[0]!;
  for (const box of boxes) {
    const more = joined(kept, box);
    if (radiusOf(more) > limit) break;
    kept = more;
  }
  return kept;
}

/** How far an edge goes along, outwards: what moves came `by` nearer to it, and is `gap` inside of it now [m]. */
function share(by: number, gap: number, size: number): number {
  const band = kBand * size;
  if (by <= 0 || gap >= band) return 0;
  const x = Math.min(Math.max(1 - gap / band, 0), 1);
  return Math.min(by, band - gap) * x * x * (3 - 2 * x);
}

/** The box moved as far as it must to hold `now`, which was `before` in the previous frame. It grows only if it is too
 *  small. */
export function followed(shown: Bounds, now: Bounds, before: Bounds | null): Bounds {
  const low: Vec3 = [...shown.low];
  const high: Vec3 = [...shown.high];
  for (const axis of [0, 1, 2] as const) {
    const size = high[axis] - low[axis];
    if (before) {
      const by =
        share(now.high[axis] - before.high[axis], high[axis] - now.high[axis], size) -
        share(before.low[axis] - now.low[axis], now.low[axis] - low[axis], size);
      low[axis] += by;
      high[axis] += by;
    }
    if (now.low[axis] < low[axis]) {
      low[axis] = now.low[axis];
      high[axis] = Math.max(low[axis] + size, now.high[axis]);
    } else if (now.high[axis] > high[axis]) {
      high[axis] = now.high[axis];
      low[axis] = Math.min(high[axis] - size, now.low[axis]);
    }
  }
  return { low, high };
}

export class Framing {
  /** What the view shows; null: nothing was visible yet. */
  shown: Bounds | null = null;
  private start: Bounds = kNothing;
  /** Of what moves in the last frame, in the world [m]; null: nothing. */
  moving: Bounds | null = null;
  private time = 0;

  /** A scene that was opened or edited: what is visible stays or comes into view. */
  adopt(visible: Bounds | null): void {
    this.moving = null;
    if (!visible) return;
    this.start = visible;
    this.shown = this.shown ? followed(this.shown, visible, null) : visible;
  }

  /** Shows all of this from now on. */
  reset(visible: Bounds | null): void {
    this.shown = null;
    this.adopt(visible);
  }

  /** A frame of the run; `time` null: there is none yet. Back at its start everything is shown as at first. */
  follow(scene: Scene, poses: ArrayLike<number>, time: number | null): void {
    if (time !== null) {
      if (time < this.time && time <= 0) this.reset(visibleBounds(scene, poses));
      this.time = time;
    }
    const now = movingBounds(scene, poses, this.start);
    if (now && this.shown) {
      const next = followed(this.shown, now, this.moving);
      // the same object as long as nothing changes
      if (radiusOf(next) !== radiusOf(this.shown) || middleOf(next).some((v, i) => v !== middleOf(this.shown!)[i]))
        this.shown = next;
    }
    this.moving = now;
  }
}
