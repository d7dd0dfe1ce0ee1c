// The messages of PROTOCOL.md, as types.

export type Vec3 = [number, number, number];
/** x y z [m], then the quaternion w x y z. */
export type Pose = [number, number, number, number, number, number, number];

export interface Failure {
  message: string;
  help?: string;
  /** "viewer", "stale", … */
  code?: string;
}

/** Of PROTOCOL.md, which this page speaks; kProtocol in server/studio.h is the server's. */
export const kProtocol = 2;

export interface Hello {
  protocol: number;
  role: "operator" | "viewer";
  client: number;
  version: string;
  kind: "scene" | "recording" | "bundle";
  file: string;
  allow_build: boolean;
  backends: string[];
}

export interface StageOrigin {
  by: "engine" | "cogrsim" | "none" | "unanswered";
  name: string;
}
/** The provenance of a run. */
export interface Provenance {
  engine: string;
  version: string;
  solver: string;
  formulation: string;
  integrator: string;
  cogrsim_version: string;
  /** "broad-phase", "contact-law", … */
  stages: Record<string, StageOrigin>;
  options: Record<string, string>;
}

export type RunState = "stopped" | "playing" | "paused" | "ended" | "recording";

export interface Status {
  state: RunState;
  ending: string;
  time: number;
  step_count: number;
  dt: number;
  scene_dt: number;
  /** null: as fast as possible */
  speed: number | null;
  /** simulated seconds per wall-clock second, measured */
  factor: number;
  backend: string;
  engine_version: string;
  /** null: there is no run, or a recording does not say */
  provenance: Provenance | null;
  recording: string | null;
  first: number;
  last: number;
  frames: number;
  scene: number;
  /** of the newest state, as `cogrsim run` prints it; "": it moves. Missing in bundles. */
  state_hash?: string;
  compare: { labels: [string, string]; first_over: number | null } | null;
  /** a plugin that has not returned for long; missing in bundles */
  waiting?: Waiting | null;
  viewers: number;
}

export interface Waiting {
  /** "controller", "sensor", "backend", … */
  kind: string;
  name: string;
  /** the robot; "": none */
  of: string;
  plugin: string;
  /** "in update" */
  doing: string;
  /** of the run [s] */
  time: number | null;
  /** of the clock, so far */
  seconds: number;
  /** in a process of its own */
  isolated: boolean;
  /** [s] after which its process is ended */
  limit: number | null;
}

export interface DocumentState {
  version: number;
  text: string;
  file: string;
  dirty: boolean;
  undo: string | null;
  redo: string | null;
  by: number;
  good: boolean;
}

export interface UnsavedOffer {
  /** names it in requests */
  number: number;
  /** [s since 1970] */
  time: number;
  /** the file is not the one that was edited */
  changed: boolean;
  /** so many wait behind it */
  more: number;
}
export interface Unsaved {
  version: number;
  offer: UnsavedOffer | null;
  /** why unsaved changes are not kept on the disk either; "": they are */
  not_kept: string;
}

export interface TreeElement {
  id: number;
  parent: number;
  tag: string;
  name: string;
  /** dotted name; "": it has none */
  path: string;
  line: number;
  column: number;
  end_line: number;
  attributes: Record<string, string>;
}

export interface Problem {
  severity: "error" | "warning" | "note";
  code: string;
  message: string;
  help: string;
  file: string;
  line: number;
  column: number;
  length: number;
  notes: { message: string; file: string; line: number; column: number }[];
}

export interface RunMessage {
  time: number;
  severity: "error" | "warning" | "note";
  source: string;
  message: string;
}

export interface RunEvent {
  index: number;
  time: number;
  kind: string;
  source: string;
  subject: string;
  message: string;
}

export type ShapeType = "box" | "sphere" | "cylinder" | "capsule" | "plane" | "mesh" | "heightmap";

export interface SceneShape {
  type: ShapeType;
  pose: Pose;
  size: number[];
  mesh?: number;
  heightmap?: number;
  color: [number, number, number, number];
  texture: string;
  tile: [number, number];
  visual: boolean;
}

/** What stands in the file. */
interface FromFile {
  /** id of its element in the present version of the text; -1: not from this file */
  element: number;
  /** the element is this thing and nothing else */
  own?: boolean;
}

export interface SceneBody extends FromFile {
  name: string;
  kind: "dynamic" | "kinematic" | "fixed";
  pose: Pose;
  mass: number;
  com: Vec3;
  assembly: number;
  removed: boolean;
  shapes: SceneShape[];
}

export interface SceneAssembly extends FromFile {
  name: string;
  parent: number;
  rigid: boolean;
  pose: Pose;
}

export interface SceneJoint extends FromFile {
  name: string;
  type: string;
  parent: number;
  child: number;
  parent_pose: Pose;
  child_pose: Pose;
}

export interface SceneSensor extends FromFile {
  name: string;
  type: string;
  body: number;
  pose: Pose;
  /** asked to be seen: where any ranging sensor is, rays of the others are not drawn */
  show?: boolean;
  /** origin, direction, range of each, in the sensor's frame */
  rays: number[][];
}

export interface SceneLight extends FromFile {
  name: string;
  type: "directional" | "point" | "spot";
  pose: Pose;
  color: number[];
  intensity: number;
  cone: number;
  shadows: boolean;
}

export interface SceneRegion extends FromFile {
  name: string;
  type: "box" | "sphere";
  body: number;
  pose: Pose;
  size: Vec3;
  radius: number;
}

export interface Scene {
  /** goes up with every other scene */
  scene: number;
  name: string;
  bodies: SceneBody[];
  assemblies: SceneAssembly[];
  joints: SceneJoint[];
  motors: (FromFile & { name: string; joint: number })[];
  sensors: SceneSensor[];
  lights: SceneLight[];
  views: (FromFile & { name: string; pose: Pose; fov: number })[];
  regions: SceneRegion[];
  controllers: (FromFile & { name: string; plugin: string; assembly: number })[];
  supervisors: (FromFile & { name: string; plugin: string })[];
  plots: (FromFile & { name: string; kind: string; title: string })[];
  /** `uv`: u, v of each corner of each triangle, in the order of `indices`; empty: none of its own */
  meshes: { positions: number[]; indices: number[]; uv?: number[] }[];
  heightmaps: { rows: number; columns: number; size: Vec3; heights: number[] }[];
  gravity: Vec3;
  step: number;
  duration: number | null;
}

/** The tail of a frame, as subscribed. */
export interface FrameTail {
  readings?: { sensor: number; values: (number | null)[] }[];
  contacts?: { a: number; b: number; point: Vec3; normal: Vec3; depth: number; force: number }[];
}

export interface Frame {
  live: boolean;
  scene: number;
  time: number;
  step: number;
  /** bodies x 7 */
  poses: Float32Array;
  /** empty: no second run */
  ghost: Float32Array;
  tail: FrameTail;
}

/** Answer to `paths`. */
export interface Paths {
  /** with another revision all earlier points are void */
  revision: number;
  /** up to here all is known [s]; null: nothing is */
  until: number | null;
  paths: {
    label: string;
    body: string;
    /** index of the first point here */
    from: number;
    times: number[];
    /** x y z of each [m] */
    points: number[];
    /** x y z at `until` */
    last: number[];
  }[];
}

export interface Picture {
  kind: "color" | "depth" | "segmentation";
  /** of the camera; "": the whole scene */
  name: string;
  width: number;
  height: number;
  time: number;
  file: Blob;
}

/** The messages that the server publishes unasked, by topic. */
export interface Topics {
  status: Status;
  scene: Scene;
  document: DocumentState;
  tree: { version: number; elements: TreeElement[] };
  problems: { version: number; problems: Problem[] };
  messages: { messages: RunMessage[] };
  events: { events: RunEvent[] };
  unsaved: Unsaved;
  goodbye: { reason: string };
}

/** One operation on the text. */
export type Op =
  | { op: "set"; element: number; attribute: string; value: string | null }
  | { op: "insert"; parent: number; xml: string; before: number | null }
  | { op: "remove"; elements: number[] }
  | { op: "move"; element: number; parent: number; before: number | null; keep_place?: boolean }
  | { op: "rename"; element: number; name: string }
  | { op: "duplicate"; element: number; offset?: Vec3 }
  | { op: "place"; element: number; pose: Pose }
  | { op: "assemble"; elements: number[]; name: string; material?: string }
  | { op: "group"; elements: number[]; name: string }
  | { op: "disassemble"; element: number };
