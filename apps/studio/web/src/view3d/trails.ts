// Where things have been, as the run itself has it: of every step, whatever this page saw of it.
import { effect, signal } from "@preact/signals-core";
import type { Frame } from "../core/frame";
import type { Paths, Scene, Vec3 } from "../core/protocol";
import type { Studio } from "../core/studio";
import { mapLayers, overlays } from "./settings";

interface Trail {
  label: string;
  /** name of the body */
  name: string;
  /** its index in the scene's bodies; -1: it is not there */
  body: number;
  color: [number, number, number];
  /** [s]; never falls */
  times: number[];
  /** x y z of each [m] */
  points: number[];
  /** x y z at the newest time that is known */
  last: number[];
}

// The colours the pictures of the command line give them, in this order.
const kColors: [number, number, number][] = [
  [0.85, 0.15, 0.1],
  [0.0, 0.35, 0.75],
  [0.1, 0.55, 0.2],
  [0.6, 0.25, 0.7],
  [0.85, 0.5, 0.0],
  [0.0, 0.55, 0.6],
];

export function topAssembly(scene: Scene, assembly: number): number {
  let at = assembly;
  for (let up = scene.assemblies[at]?.parent ?? -1; up >= 0; up = scene.assemblies[at]?.parent ?? -1) at = up;
  return at;
}

/** Index of the first time after `time`. */
function countUntil(times: number[], time: number): number {
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
  /** up to here all is known [s] */
  until = -Infinity;
  /** goes up with everything that was taken in */
  readonly changes = signal(0);
  private revision = 0;
  private indices = new Map<string, number>();

  adopt(scene: Scene): void {
    this.indices = new Map(scene.bodies.flatMap((body, i) => (body.removed ? [] : [[body.name, i] as const])));
    for (const trail of this.all) trail.body = this.index(trail.name);
  }

  /** The known points: fields of the request. */
  get known(): { revision: number; counts: number[] } {
    return { revision: this.revision, counts: this.all.map((trail) => trail.times.length) };
  }

  take({ revision, until, paths }: Paths): void {
    const before = revision === this.revision ? this.all : [];
    this.revision = revision;
    this.until = until ?? -Infinity;
    this.all = paths.map(({ label, body, from, times, points, last }, i) => {
      const trail = before[i] ?? {
        label,
        name: body,
        body: this.index(body),
        color: kColors[i % kColors.length]!,
        times: [],
        points: [],
        last,
      };
      trail.times.length = from;
      trail.points.length = 3 * from;
      for (const time of times) trail.times.push(time);
      for (const x of points) trail.points.push(x);
      trail.last = last;
      return trail;
    });
    this.changes.value += 1;
  }

  /** x y z of the points of a trail until a frame: to where the body is in it, but never farther than is known. */
  line(trail: Trail, frame: Frame | null): number[] {
    const now = frame?.time ?? 0;
    const points = trail.points.slice(0, 3 * countUntil(trail.times, now));
    if (now >= this.until) return points.concat(trail.last);
    const here = trail.body < 0 ? [] : [...(frame?.poses.subarray(7 * trail.body, 7 * trail.body + 3) ?? [])];
    return here.every(Number.isFinite) ? points.concat(here) : points;
  }

  private index(name: string): number {
    return this.indices.get(name) ?? -1;
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
    const d: Vec3 = [points[b]! - points[a]!, points[b + 1]! - points[a + 1]!, points[b + 2]! - points[a + 2]!];
    const length = Math.hypot(...d);
    if (!(length > 0)) continue;
    const at = (s: number) => [
      points[a]! + (d[0] * s) / length,
      points[a + 1]! + (d[1] * s) / length,
      points[a + 2]! + (d[2] * s) / length,
    ];
    // A jump (a thing put elsewhere) is not worth more dashes than can be distinguished.
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

/** A recording is read through in its own time: asked again after so long [ms]. */
const kLater = 200;

/** Those of a page, up to date from the first use on, while they are drawn anywhere. */
export class RunTrails extends Trails {
  private asking = false;
  private scene = -1;
  private readonly stops: (() => void)[];

  constructor(private readonly studio: Studio) {
    super();
    const { state } = studio;
    this.stops = [
      effect(() => {
        if (state.scene.value) this.adopt(state.scene.value);
      }),
      effect(() => {
        for (const why of [state.open, state.frame, overlays.trails, mapLayers.trails]) void why.value;
        void this.ask();
      }),
    ];
  }
  dispose(): void {
    for (const stop of this.stops) stop();
  }

  private behind(): boolean {
    const { state } = this.studio;
    const frame = state.frame.peek();
    const status = state.status.peek();
    if (!state.open.peek() || !frame || !(overlays.trails.peek() || mapLayers.trails.peek())) return false;
    const end = status?.state === "recording" ? status.last : frame.time;
    return frame.live || frame.scene !== this.scene || this.until < end;
  }

  private async ask(): Promise<void> {
    if (this.asking || !this.behind()) return;
    this.asking = true;
    const { state, link } = this.studio;
    const of = state.frame.peek();
    try {
      this.take(await link.request("paths", this.known));
      this.scene = of?.scene ?? -1;
    } catch {
      // the connection was lost: requested again with the next frame
    } finally {
      this.asking = false;
    }
    // Frames that have come meanwhile requested in vain.
    if (state.frame.peek() !== of) void this.ask();
    else if (state.status.peek()?.state === "recording" && this.behind()) setTimeout(() => void this.ask(), kLater);
  }
}
