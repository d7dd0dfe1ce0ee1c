// Made from the table of the protocol, server/protocol_table.cpp: see the test "the page's types are those
// of the table". In words: PROTOCOL.md.

/** The protocol that this page speaks; `hello` answers the server's. */
export const kProtocol = 3;

/** x y z */
export type Vec3 = [number, number, number];

/** x y z [m], then the quaternion w x y z */
export type Pose = [number, number, number, number, number, number, number];

/** Why a request was refused */
export interface Failure {
  message: string;
  help?: string;
  /** file, line and column */
  where?: string;
  /** "viewer", "stale", … */
  code?: string;
}

export type RunState = "stopped" | "playing" | "paused" | "ended" | "recording";

/** Who computes a stage */
export interface StageOrigin {
  by: "engine" | "cogrsim" | "none" | "unanswered";
  name: string;
}

/** The provenance of a run, as in `cogrsim run --json` */
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

/** Two runs beside each other */
export interface Comparison {
  labels: [string, string];
  /** [s] */
  first_over: number | null;
}

/** A plugin that has not returned for half a second, while the run stands */
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
  /** wall-clock time so far */
  seconds: number;
  /** in a process of its own */
  isolated: boolean;
  /** after so many seconds that process is ended */
  limit: number | null;
}

export interface Status {
  state: RunState;
  /** how it ended, with the reason; with "paused": playing has reached the scene's duration, and continues after another `play` */
  ending: string;
  /** [s] */
  time: number;
  step_count: number;
  /** [s] */
  dt: number;
  /** [s] */
  scene_dt: number;
  /** null: as fast as possible */
  speed: number | null;
  /** simulated seconds per wall-clock second, measured */
  factor: number;
  backend: string;
  engine_version: string;
  /** null: there is no run, or a recording does not say */
  provenance: Provenance | null;
  /** the file */
  recording: string | null;
  /** [s]: what can be sought */
  first: number;
  /** [s] */
  last: number;
  frames: number;
  /** its number */
  scene: number;
  /** of the newest state, as `cogrsim run` prints it; "": it moves. Missing in bundles */
  state_hash?: string;
  compare: Comparison | null;
  /** missing in bundles */
  waiting?: Waiting | null;
  viewers: number;
}

export interface DocumentState {
  version: number;
  text: string;
  file: string;
  dirty: boolean;
  /** label of the step */
  undo: string | null;
  /** label of the step */
  redo: string | null;
  /** the client */
  by: number;
  /** the text compiles */
  good: boolean;
  /** published before a compilation that takes long; `good` is still that of the text before, and the same version is published again */
  compiling?: boolean;
}

/** The newest text that an earlier studio could not save */
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
  /** may be made up */
  name: string;
  /** dotted name; "": it has none */
  path: string;
  line: number;
  column: number;
  end_line: number;
  /** one thing: it can be placed and assembled */
  single?: boolean;
  attributes: Record<string, string>;
}

/** Empty if the text is not well-formed */
export interface Tree {
  version: number;
  elements: TreeElement[];
}

export interface ProblemNote {
  message: string;
  file: string;
  line: number;
  column: number;
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
  notes: ProblemNote[];
}

export interface Problems {
  version: number;
  good?: boolean;
  problems: Problem[];
}

export interface CompletionItem {
  label: string;
  detail?: string;
  insert?: string;
}

export interface SourceFile {
  name: string;
  writable: boolean;
}

export interface RunMessage {
  /** [s] */
  time: number;
  severity: "error" | "warning" | "note";
  source: string;
  message: string;
}

export interface Messages {
  messages: RunMessage[];
}

export interface RunEvent {
  index: number;
  /** [s] */
  time: number;
  kind: string;
  source: string;
  subject: string;
  message: string;
}

export interface Events {
  events: RunEvent[];
}

export interface Goodbye {
  reason: string;
}

export interface ReloadedController {
  controller: string;
  version: string;
  memory_kept: boolean;
  /** why it restarted */
  note: string;
}

/** One that stays as it was */
export interface KeptController {
  controller: string;
  /** why */
  message: string;
}

export interface SignalInfo {
  name: string;
  unit: string;
  /** dotted name */
  owner: string;
}

export interface SeriesPart {
  signal: string;
  unit: string;
  low: (number | null)[];
  high: (number | null)[];
}

export interface BodyDistance {
  name: string;
  /** [m] */
  distance: (number | null)[];
}

export interface FirstDivergence {
  /** [s] */
  time: number;
  name: string;
}

export interface PlotSeriesInfo {
  x: string;
  y: string;
  z: string;
  label: string;
}

export interface PlotInfo {
  name: string;
  kind: string;
  title: string;
  series?: PlotSeriesInfo[];
}

export interface FigureAxis {
  label?: string;
  unit?: string;
}

export interface FigureSeries {
  label?: string;
  x?: (number | null)[];
  y?: (number | null)[];
  z?: (number | null)[];
}

export interface PathPart {
  label: string;
  body: string;
  /** index of the first point here */
  from: number;
  times: number[];
  /** x y z of each [m] */
  points: number[];
  /** x y z at `until` */
  last: number[];
}

export interface CameraWish {
  name: string;
  kind?: "color" | "depth" | "segmentation";
  /** [pixel] */
  width?: number;
}

export type ShapeType = "box" | "sphere" | "cylinder" | "capsule" | "plane" | "mesh" | "heightmap";

export interface SceneShape {
  name?: string;
  type: ShapeType;
  /** in the body */
  pose: Pose;
  /** box: extents; sphere: [r]; cylinder, capsule: [r, length], along z; plane: extents of what is drawn */
  size: number[];
  /** index */
  mesh?: number;
  /** index */
  heightmap?: number;
  color: [number, number, number, number];
  /** the NUMBER in `/asset/NUMBER`, or "" */
  texture: string;
  /** [0, 0]: none given, see the table in `sdk/include/cogrsim/model/surface.h` */
  tile: [number, number];
  /** drawn */
  visual: boolean;
  collides?: boolean;
}

export interface SceneBody {
  kind: "dynamic" | "kinematic" | "fixed";
  pose: Pose;
  mass: number;
  com: Vec3;
  assembly: number;
  shapes: SceneShape[];
  name: string;
  /** id; -1: not from this file */
  element: number;
  /** the element is this thing and nothing else */
  own?: boolean;
  removed?: boolean;
}

export interface SceneAssembly {
  parent: number;
  rigid: boolean;
  pose: Pose;
  name: string;
  /** id; -1: not from this file */
  element: number;
  /** the element is this thing and nothing else */
  own?: boolean;
  removed?: boolean;
}

export interface SceneJoint {
  type: string;
  parent: number;
  child: number;
  parent_pose: Pose;
  child_pose: Pose;
  name: string;
  /** id; -1: not from this file */
  element: number;
  /** the element is this thing and nothing else */
  own?: boolean;
  removed?: boolean;
}

export interface SceneMotor {
  joint: number;
  axis?: number;
  mode?: string;
  name: string;
  /** id; -1: not from this file */
  element: number;
  /** the element is this thing and nothing else */
  own?: boolean;
  removed?: boolean;
}

export interface SceneSensor {
  type: string;
  body: number;
  joint?: number;
  pose: Pose;
  /** asked to be seen: where any ranging sensor is, rays of the others are not drawn */
  show?: boolean;
  /** origin, direction, range of each, in the sensor's frame */
  rays: number[][];
  name: string;
  /** id; -1: not from this file */
  element: number;
  /** the element is this thing and nothing else */
  own?: boolean;
  removed?: boolean;
}

export interface SceneLight {
  type: "directional" | "point" | "spot";
  pose: Pose;
  color: number[];
  intensity: number;
  cone: number;
  shadows: boolean;
  name: string;
  /** id; -1: not from this file */
  element: number;
  /** the element is this thing and nothing else */
  own?: boolean;
  removed?: boolean;
}

export interface SceneView {
  pose: Pose;
  fov: number;
  name: string;
  /** id; -1: not from this file */
  element: number;
  /** the element is this thing and nothing else */
  own?: boolean;
  removed?: boolean;
}

export interface SceneRegion {
  type: "box" | "sphere";
  body: number;
  pose: Pose;
  size: Vec3;
  radius: number;
  name: string;
  /** id; -1: not from this file */
  element: number;
  /** the element is this thing and nothing else */
  own?: boolean;
  removed?: boolean;
}

export interface SceneController {
  plugin: string;
  assembly: number;
  name: string;
  /** id; -1: not from this file */
  element: number;
  /** the element is this thing and nothing else */
  own?: boolean;
  removed?: boolean;
}

export interface SceneSupervisor {
  plugin: string;
  assembly?: number;
  name: string;
  /** id; -1: not from this file */
  element: number;
  /** the element is this thing and nothing else */
  own?: boolean;
  removed?: boolean;
}

export interface ScenePlot {
  kind: string;
  title: string;
  name: string;
  /** id; -1: not from this file */
  element: number;
  /** the element is this thing and nothing else */
  own?: boolean;
  removed?: boolean;
}

export interface SceneMesh {
  positions: number[];
  indices: number[];
  /** u, v of each corner of each triangle, in the order of `indices`; empty: none of its own */
  uv?: number[];
}

export interface SceneHeightmap {
  rows: number;
  columns: number;
  size: Vec3;
  heights: number[];
}

export interface Scene {
  /** goes up with every other scene */
  scene: number;
  /** of the document that the element ids are of */
  version?: number;
  name: string;
  bodies: SceneBody[];
  assemblies: SceneAssembly[];
  joints: SceneJoint[];
  motors: SceneMotor[];
  sensors: SceneSensor[];
  lights: SceneLight[];
  views: SceneView[];
  regions: SceneRegion[];
  controllers: SceneController[];
  supervisors: SceneSupervisor[];
  plots: ScenePlot[];
  meshes: SceneMesh[];
  heightmaps: SceneHeightmap[];
  gravity: Vec3;
  /** [s] */
  step: number;
  /** [s] */
  duration: number | null;
}

export interface FrameReading {
  /** index in the scene */
  sensor: number;
  values: (number | null)[];
}

export interface FrameContact {
  /** index of a body in the scene; -1: the world */
  a: number;
  b: number;
  point: Vec3;
  normal: Vec3;
  depth: number;
  /** its length [N] */
  force: number;
}

/** As subscribed */
export interface FrameTail {
  readings?: FrameReading[];
  contacts?: FrameContact[];
}

/** null removes it */
export interface OpSet {
  op: "set";
  element: number;
  attribute: string;
  value: string | null;
}

/** One element. A `name` that is taken gets a number */
export interface OpInsert {
  op: "insert";
  parent: number;
  xml: string;
  /** an element; null: last */
  before?: number | null;
}

/** With all inside, and what refers to them (joints, motors, sensors of a removed body) */
export interface OpRemove {
  op: "remove";
  /** ids */
  elements: number[];
}

/** With `keep_place` the pose in the world stays */
export interface OpMove {
  op: "move";
  element: number;
  parent: number;
  /** an element; null: last */
  before?: number | null;
  keep_place?: boolean;
}

/** References in the file follow */
export interface OpRename {
  op: "rename";
  element: number;
  name: string;
}

export interface OpDuplicate {
  op: "duplicate";
  element: number;
  offset?: Vec3;
}

/** Written as `xyz` and `rpy` in the units the attributes have, short numbers */
export interface OpPlace {
  op: "place";
  element: number;
  /** of the element's frame in the world */
  pose: Pose;
}

/** One rigid assembly around them, at their poses */
export interface OpAssemble {
  op: "assemble";
  /** ids */
  elements: number[];
  name: string;
  material?: string;
}

/** An assembly around them that is not rigid */
export interface OpGroup {
  op: "group";
  /** ids */
  elements: number[];
  name: string;
}

/** Its parts replace it, at their poses */
export interface OpDisassemble {
  op: "disassemble";
  element: number;
}

/** One operation on the text */
export type Op = OpSet | OpInsert | OpRemove | OpMove | OpRename | OpDuplicate | OpPlace | OpAssemble | OpGroup | OpDisassemble;

/** The messages that the server publishes unasked, by topic. */
export interface Topics {
  status: Status;
  scene: Scene;
  document: DocumentState;
  unsaved: Unsaved;
  tree: Tree;
  problems: Problems;
  messages: Messages;
  events: Events;
  goodbye: Goodbye;
}

/** What a page asks, with its fields and the answer's. */
export interface Requests {
  /** comes first; may have fields that the server does not know. A page of another protocol loads itself again, once. Afterwards every topic is sent once */
  hello: {
    fields: Record<string, never>;
    answer: {
      /** number of the server's protocol */
      protocol: number;
      role: "operator" | "viewer";
      client: number;
      version: string;
      kind: "scene" | "recording" | "bundle";
      file: string;
      allow_build: boolean;
      /** where textures are: `/asset/SECRET/` */
      assets?: string;
      backends: string[];
    };
  };
  /** runs at the present speed; pauses at the scene's duration */
  play: {
    fields: Record<string, never>;
    answer: Record<string, never>;
  };
  /** while a plugin call is waited for, it is answered at once, and the run's state is "paused"; it takes effect when the call returns */
  pause: {
    fields: Record<string, never>;
    answer: Record<string, never>;
  };
  /** back to time 0 from the present text, paused; the old frames are gone. A controller that is waited for is ended, if it has a process of its own; so does `restart` */
  stop: {
    fields: Record<string, never>;
    answer: Record<string, never>;
  };
  /** `stop`, then `play` */
  restart: {
    fields: Record<string, never>;
    answer: Record<string, never>;
  };
  /** so many steps, then paused */
  step: {
    fields: {
      count?: number;
    };
    answer: Record<string, never>;
  };
  /** simulated seconds per wall-clock second */
  speed: {
    fields: {
      /** null: as fast as possible */
      factor?: number | null;
    };
    answer: Record<string, never>;
  };
  /** takes effect at once; another result, not another speed */
  dt: {
    fields: {
      /** [s]; null: the scene's own */
      value?: number | null;
    };
    answer: Record<string, never>;
  };
  /** the run continues there, from the same state */
  backend: {
    fields: {
      name: string;
    };
    answer: {
      /** what could not be carried over */
      notes: string[];
    };
  };
  /** only while paused, and not while comparing: replaces the controllers' running libraries by those on disk now */
  reload: {
    fields: {
      /** null: all of them */
      controller?: string | null;
    };
    answer: {
      reloaded: ReloadedController[];
      /** with a name that is an error */
      kept: KeptController[];
    };
  };
  /** ends the process of the controller that the run waits for (`waiting` in `status`), which is a fault of it. Refused when there is none, or when it runs in the studio's process */
  "end-controller": {
    fields: Record<string, never>;
    answer: {
      controller: string;
    };
  };
  /** begins or ends a recording */
  record: {
    fields: {
      on?: boolean;
      /** a bare name, beside the scene */
      file?: string;
    };
    answer: {
      file?: string;
      /** [s] */
      from?: number;
    };
  };
  /** this client now views the last frame at or before it */
  seek: {
    fields: {
      /** [s] */
      time: number;
    };
    answer: {
      /** [s] */
      time: number;
    };
  };
  /** this client views the frame before the one it sees */
  "step-back": {
    fields: Record<string, never>;
    answer: {
      /** [s] */
      time: number;
    };
  };
  /** this client follows the newest frame again */
  live: {
    fields: Record<string, never>;
    answer: Record<string, never>;
  };
  /** what comes in the tail of frames for this client */
  subscribe: {
    fields: {
      contacts?: boolean;
      readings?: boolean;
    };
    answer: Record<string, never>;
  };
  /** a second run beside the first, in lockstep, both from time 0 */
  compare: {
    fields: {
      /** null: the same */
      backend?: string | null;
      /** [s]; null: the same */
      step?: number | null;
    };
    answer: Record<string, never>;
  };
  /** the first run continues without the second */
  "compare-off": {
    fields: Record<string, never>;
    answer: Record<string, never>;
  };
  /** what can be drawn */
  signals: {
    fields: Record<string, never>;
    answer: {
      signals: SignalInfo[];
    };
  };
  /** of the frames that are kept; intervals with more than one frame keep the lowest and highest (equal otherwise) */
  series: {
    fields: {
      signals: string[];
      /** [s]; null: from the start */
      from?: number | null;
      /** [s]; null: to the end */
      to?: number | null;
      points?: number;
      /** the second run's */
      run?: "ghost";
    };
    answer: {
      time: number[];
      series: SeriesPart[];
    };
  };
  /** of a comparison */
  divergence: {
    fields: Record<string, never>;
    answer: {
      time: number[];
      /** largest distance of two bodies of one name [m] */
      worst: (number | null)[];
      /** [rad] */
      worst_angle: (number | null)[];
      /** the ten worst */
      bodies: BodyDistance[];
      first: FirstDivergence | null;
      labels: [string, string];
    };
  };
  /** the scene's own figures */
  plots: {
    fields: Record<string, never>;
    answer: {
      plots: PlotInfo[];
    };
  };
  /** the data of one */
  figure: {
    fields: {
      /** its name */
      plot: string;
    };
    answer: {
      name?: string;
      kind: string;
      title?: string;
      x?: FigureAxis;
      y?: FigureAxis;
      z?: FigureAxis;
      series: FigureSeries[];
    };
  };
  /** what is new of the paths of the run, made from every step; of another revision nothing is known */
  paths: {
    fields: {
      revision?: number;
      /** points known of each path */
      counts?: number[];
    };
    answer: {
      /** with another one all earlier points are void */
      revision: number;
      /** up to there all is known [s]; null: nothing is */
      until: number | null;
      paths: PathPart[];
    };
  };
  /** of the whole run */
  events: {
    fields: {
      /** index */
      from?: number;
    };
    answer: {
      events: RunEvent[];
    };
  };
  /** from now on pictures of these (of sensors or saved views) come whenever what this client sees has changed, one at a time; an empty list stops all rendering for it */
  cameras: {
    fields: {
      show: CameraWish[];
    };
    answer: Record<string, never>;
  };
  /** one picture of the whole scene, for pages without WebGL; comes as a binary message with `name` "" */
  view: {
    fields: {
      /** [pixel] */
      width?: number;
      /** [pixel] */
      height?: number;
      /** null: one that shows the whole scene */
      pose?: Pose | null;
      /** [rad] */
      fov?: number;
    };
    answer: Record<string, never>;
  };
  /** changes with the same non-empty `group` in a row make one step of the history */
  "set-text": {
    fields: {
      version: number;
      text: string;
      group?: string;
    };
    answer: {
      version: number;
    };
  };
  /** all or nothing, one step of the history */
  edit: {
    fields: {
      version: number;
      ops: Op[];
      label?: string;
    };
    answer: {
      version: number;
      /** ids */
      created: number[];
    };
  };
  /** one step back in the history */
  undo: {
    fields: Record<string, never>;
    answer: {
      version: number;
      label: string;
    };
  };
  /** one step forward */
  redo: {
    fields: Record<string, never>;
    answer: {
      version: number;
      label: string;
    };
  };
  /** continues with the copy, if there is one */
  save: {
    fields: {
      /** a bare name: a copy under it */
      file?: string;
    };
    answer: {
      file: string;
      backup: string;
    };
  };
  /** the text as it was last saved */
  revert: {
    fields: Record<string, never>;
    answer: {
      version: number;
      text: string;
    };
  };
  /** what an offer (see the topic `unsaved`) holds */
  unsaved: {
    fields: {
      number: number;
    };
    answer: {
      text: string;
    };
  };
  /** the text is that of the offer now, one step of the history; the file stays as it is. Refused as "stale" when the offer is gone */
  restore: {
    fields: {
      number: number;
    };
    answer: {
      version: number;
    };
  };
  /** the offer is deleted */
  discard: {
    fields: {
      number: number;
    };
    answer: Record<string, never>;
  };
  /** the vocabulary: see *Schema* */
  schema: {
    fields: Record<string, never>;
    answer: {
      schema: object;
    };
  };
  /** what may stand there */
  complete: {
    fields: {
      text: string;
      /** code points */
      offset: number;
    };
    answer: {
      from: number;
      items: CompletionItem[];
    };
  };
  /** of the bodies in them as one */
  mass: {
    fields: {
      /** ids */
      elements: number[];
    };
    answer: {
      /** [kg] */
      mass: number;
      com: Vec3;
      /** xx yy zz xy xz yz, about the centre of mass */
      inertia: number[];
      bodies: string[];
    };
  };
  /** controllers' sources beside the scene */
  sources: {
    fields: Record<string, never>;
    answer: {
      files: SourceFile[];
    };
  };
  /** one of them */
  "open-source": {
    fields: {
      name: string;
    };
    answer: {
      text: string;
      /** of its content */
      version: string;
    };
  };
  /** refused as "stale" when another program changed the file */
  "save-source": {
    fields: {
      name: string;
      text: string;
      /** as it was opened */
      version?: string;
    };
    answer: {
      version: string;
    };
  };
  /** only with `--allow-build`: builds the project beside the scene, and takes its plugins */
  build: {
    fields: Record<string, never>;
    answer: {
      /** false: the compiler complained */
      built: boolean;
      log: string;
      problems: Problem[];
    };
  };
}

export type RequestName = keyof Requests;
export type Answer<Name extends RequestName> = Requests[Name]["answer"];
export type Hello = Answer<"hello">;
export type Paths = Answer<"paths">;
