// The data of a run that came with the page.
import type { Frame, Picture } from "./frame";
import type {
  DocumentState,
  Hello,
  Problem,
  Provenance,
  RunEvent,
  RunMessage,
  Scene,
  Status,
  TreeElement,
} from "./protocol";

/** A quantity over the whole run, one value for each frame; NaN where there is none. */
export interface MemorySignal {
  name: string;
  unit: string;
  owner: string;
  values: ArrayLike<number>;
  /** of the second run of a comparison */
  ghost?: ArrayLike<number>;
}

/** All data of a run. Frames may be unpacked on request. */
export interface MemoryRun {
  hello: Hello;
  /** usually one; each frame names the one it belongs to by its number */
  scenes: Scene[];
  count: number;
  /** [s]; never falls */
  timeOf(frame: number): number;
  frame(index: number): Frame;
  backend: string;
  engineVersion: string;
  provenance?: Provenance | null;
  ending: string;
  /** of the last frame, as the command line prints it; "" is not known */
  stateHash?: string;
  /** [s] */
  dt: number;
  document?: DocumentState;
  elements?: TreeElement[];
  problems?: Problem[];
  messages?: RunMessage[];
  events?: RunEvent[];
  signals?: MemorySignal[];
  /** answer to `plots` */
  plots?: unknown[];
  /** answers to `figure`, by name of the plot */
  figures?: Record<string, Record<string, unknown>>;
  compare?: Status["compare"];
  /** where its things have been, of every step */
  paths?: { label: string; body: string; times: ArrayLike<number>; points: ArrayLike<number> }[];
  /** answer to `divergence` */
  divergence?: Record<string, unknown>;
  /** addresses of textures (data: or blob:), by path under /asset/ */
  assets?: Record<string, string>;
  /** what cameras saw, by time */
  pictures?: Picture[];
}
