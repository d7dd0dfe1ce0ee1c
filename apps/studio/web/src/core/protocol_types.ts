// Made from the table of the protocol, server/protocol_table.cpp: see the test "the page's types are those
// of the table". In words: PROTOCOL.md.

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
  /** of the scene, as --without asked for */
  left_out: LeftOut[];
}

/** A feature of the scene that a run leaves out */
export interface LeftOut {
  /** "joint.coupling", … */
  feature: string;
  /** "coupling", "joint", … */
  of: string;
  /** of how many of these */
  count: number;
}

/** Two runs beside each other */
export interface Comparison {
  labels: [string, string];
  /** [s] */
  first_over: number | null;
  /** of the second run; missing in bundles */
  left_out?: LeftOut[];
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
  /** what was done by hand since the start; missing in bundles */
  inputs?: number;
  /** missing in bundles */
  controllers?: ControllerInputs[];
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
  log?: boolean;
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

export interface StartFile {
  /** relative to the studio's folder */
  name: string;
  /** model: URDF, SDF or MJCF, by its ending */
  kind: "folder" | "scene" | "recording" | "model";
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
  /** lowest and highest coordinate of each axis [rad] or [m]; null: none */
  limits?: (number | null)[][];
  /** coordinates at the start */
  start?: number[];
  /** other joints connect its bodies already */
  closes_loop?: boolean;
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
  /** of its target */
  unit?: string;
  /** least target; null: no limit is stated */
  low?: number | null;
  high?: number | null;
  /** at the start */
  target?: number;
  /** [N m] or [N] */
  max_effort?: number | null;
  /** its axis turns, and does not slide */
  turns?: boolean;
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
  /** origin, direction, range of each, in the sensor's frame; of a camera the corners of its picture, range 0 */
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

/** A force, or what exerts one; drawn are forces and springs. */
export interface SceneForce {
  kind: "force" | "drag" | "spring" | "buoyancy" | "wind";
  body: number;
  /** of the point where it acts, in the body */
  pose: Pose;
  /** [N], without its factor */
  vector: Vec3;
  /** the vector is in the axes of the point; else of the world */
  in_body: boolean;
  /** [s] */
  from: number;
  /** [s] */
  until: number | null;
  /** of a spring: its second body */
  other: number;
  /** in that body */
  other_point: Vec3;
  /** of a spring: it pulls only */
  cable: boolean;
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
  forces: SceneForce[];
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
  /** of an infrared sensor or lidar in the world when it measured */
  pose?: Pose;
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
  /** in the order of the scene's */
  joints?: FrameJoint[];
  /** of the motors [N m] or [N]; with the joints */
  efforts?: (number | null)[];
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

export interface DebugBreakpointWish {
  /** as in `sources` */
  file: string;
  line: number;
  /** an expression of C++ */
  condition?: string;
}

export interface DebugBreakpoint {
  file: string;
  /** where it is wanted */
  line: number;
  condition: string;
  /** the line where it is */
  placed: number | null;
  /** why it is not there, or not where it was wanted */
  note: string;
}

export interface DebugFrame {
  function: string;
  /** as in `sources`; "": not one of them */
  file: string;
  /** 0: not known */
  line: number;
}

export interface DebugVariable {
  name: string;
  value: string;
  type: string;
  argument: boolean;
  /** for `debug-children`, until it goes on; "": has none */
  children: string;
}

export interface DebugValue {
  name: string;
  unit: string;
  value: number | null;
}

export interface DebugReading {
  sensor: string;
  /** of the measurement [s] */
  time: number;
  valid: boolean;
  /** of values */
  count: number;
  /** the first of them */
  values: DebugValue[];
}

/** Of the controller in the debugger */
export interface Debug {
  /** waiting: for a process of the controller */
  state: "off" | "waiting" | "attaching" | "running" | "stopped";
  controller: string;
  process: number | null;
  /** why it stands: "breakpoint", "SIGSEGV: Segmentation fault" */
  reason: string;
  /** it ends by that signal when it goes on */
  crashed: boolean;
  /** what went wrong */
  note: string;
  /** what can be done about it */
  help: string;
  /** the innermost first */
  frames: DebugFrame[];
  breakpoints: DebugBreakpoint[];
  /** of the run [s] */
  time: number | null;
  /** that the controller gets now */
  readings: DebugReading[];
}

export interface FrameJoint {
  /** coordinates [rad] or [m] */
  position: (number | null)[];
  speed: (number | null)[];
}

export interface ControllerInput {
  name: string;
  unit: string;
  lower: number;
  upper: number;
  value: number;
}

/** A controller that has inputs */
export interface ControllerInputs {
  /** dotted name */
  controller: string;
  inputs: ControllerInput[];
}

/** A `<test>` of the scene */
export interface SceneTest {
  name: string;
  line: number;
  /** without `agree`: each engine is judged alone */
  expectations: number;
  /** `agree`: needs several engines */
  agrees: number;
  /** that it is for; empty: all */
  backends: string[];
}

export interface TestVerdict {
  expectation: string;
  passed: boolean;
  message: string;
  /** when it was decided [s] */
  time: number | null;
  /** 0: none */
  line: number;
  column: number;
}
