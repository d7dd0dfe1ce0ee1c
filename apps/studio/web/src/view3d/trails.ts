// Where things have been: collected from the frames that this page saw, for all panels that draw it.
import { effect } from "@preact/signals-core";
import type { Frame, Scene, Vec3 } from "../core/protocol";
import type { Studio } from "../core/studio";

export interface Trail {
  label: string;
  /** index in the scene's bodies */
  body: number;
  color: [number, number, number];
  times: number[];
  /** x y z of each [m] */
  points: number[];
}

/** Points of a trail at most; beyond, every second one of it is let go. */
const MOST_POINTS = 4000;
const MOST_TRAILS = 64;

// The colours the pictures of the command line give them, in this order.
const COLORS: [number, number, number][] = [
  [0.85, 0.15, 0.1],
  [0.0, 0.35, 0.75],
  [0.1, 0.55, 0.2],
  [0.6, 0.25, 0.7],
  [0.85, 0.5, 0.0],
  [0.0, 0.55, 0.6],
];

export function top_assembly(scene: Scene, assembly: number): number {
  let at = assembly;
  for (let up = scene.assemblies[at]?.parent ?? -1; up >= 0; up = scene.assemblies[at]?.parent ?? -1) at = up;
  return at;
}

/** The bodies whose trails are drawn: of each top-level assembly the first that moves, and of those outside of any all
 *  that move; with a controller first. */
export function followed_bodies(scene: Scene): { label: string; body: number }[] {
  const seen = new Set<number>();
  const out: { label: string; body: number }[] = [];
  scene.bodies.forEach((body, i) => {
    if (body.removed || body.kind === "fixed") return;
    const top = top_assembly(scene, body.assembly);
    if (top < 0) {
      out.push({ label: body.name, body: i });
    } else if (!seen.has(top)) {
      seen.add(top);
      out.push({ label: scene.assemblies[top]!.name, body: i });
    }
  });
  const steered = new Set(scene.controllers.map((c) => top_assembly(scene, c.assembly)));
  const rank = (b: { body: number }) => {
    const top = top_assembly(scene, scene.bodies[b.body]!.assembly);
    return top >= 0 && steered.has(top) ? 0 : 1;
  };
  return out.sort((a, b) => rank(a) - rank(b)).slice(0, MOST_TRAILS);
}

/** Index of the first time after `time`. */
export function count_until(times: number[], time: number): number {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle]! <= time) low = middle + 1;
    else high = middle;
  }
  return low;
}

export class Trails {
  all: Trail[] = [];
  private names: string[] = [];

  /** Another scene: what is followed by the same name goes on. */
  adopt(scene: Scene): void {
    const old = new Map(this.all.map((trail, i) => [this.names[i], trail]));
    const bodies = followed_bodies(scene);
    this.names = bodies.map((b) => scene.bodies[b.body]!.name);
    this.all = bodies.map((b, i) => ({
      label: b.label,
      body: b.body,
      color: COLORS[i % COLORS.length]!,
      times: old.get(this.names[i])?.times ?? [],
      points: old.get(this.names[i])?.points ?? [],
    }));
  }

  clear(): void {
    for (const trail of this.all) {
      trail.times = [];
      trail.points = [];
    }
  }

  /** Takes a frame in, wherever in time it lies. A live one from before what is known says the run began anew. */
  add(frame: Frame): void {
    for (const trail of this.all) {
      const at = 7 * trail.body;
      const p = frame.poses.subarray(at, at + 3);
      if (p.length < 3 || !Number.isFinite(p[0]! + p[1]! + p[2]!)) continue;
      let n = count_until(trail.times, frame.time);
      if (frame.live && n < trail.times.length) {
        trail.times.length = n;
        trail.points.length = 3 * n;
      }
      if (n > 0 && trail.times[n - 1] === frame.time) {
        trail.points.splice(3 * n - 3, 3, ...p);
        continue;
      }
      trail.times.splice(n, 0, frame.time);
      trail.points.splice(3 * n, 0, ...p);
      if (trail.times.length > MOST_POINTS) {
        trail.times = trail.times.filter((_, i) => i % 2 === 0);
        trail.points = trail.points.filter((_, i) => Math.floor(i / 3) % 2 === 0);
      }
    }
  }
}

/** The stretches of a line of points that are drawn when it is dashed: pairs of points, as `x y z x y z …`. The pattern
 *  goes by the length along the line, so that it stays where it is while the line grows. `dash`: of line and gap [m]. */
export function dashes(points: ArrayLike<number>, count: number, dash: number): number[] {
  const out: number[] = [];
  let along = 0;
  for (let i = 1; i < count; i++) {
    const a = 3 * (i - 1);
    const b = 3 * i;
    const d: Vec3 = [
      points[b]! - points[a]!,
      points[b + 1]! - points[a + 1]!,
      points[b + 2]! - points[a + 2]!,
    ];
    const length = Math.hypot(...d);
    if (!(length > 0)) continue;
    const at = (s: number) => [
      points[a]! + (d[0] * s) / length,
      points[a + 1]! + (d[1] * s) / length,
      points[a + 2]! + (d[2] * s) / length,
    ];
    // A jump (a thing put elsewhere) is not worth more dashes than can be told apart.
    const end = along + length;
    let k = Math.floor(along / (2 * dash));
    for (let n = 0; 2 * dash * k < end && n < 1000; k++, n++) {
      const from = Math.max(along, 2 * dash * k);
      const to = Math.min(end, 2 * dash * k + dash);
      if (to > from) out.push(...at(from - along), ...at(to - along));
    }
    along = end;
  }
  return out;
}

const known = new WeakMap<Studio, Trails>();

/** Those of a page; collected from the first call on. */
export function trails_of(studio: Studio): Trails {
  let trails = known.get(studio);
  if (!trails) {
    const made = (trails = new Trails());
    known.set(studio, made);
    effect(() => {
      const scene = studio.state.scene.value;
      if (scene) made.adopt(scene);
    });
    effect(() => {
      const frame = studio.state.frame.value;
      if (frame && frame.scene === studio.state.scene.peek()?.scene) made.add(frame);
    });
  }
  return trails;
}
