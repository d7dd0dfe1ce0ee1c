// Types of cogrsim_backend.mjs. SI units, right-handed frames, world axes where nothing else is said.

/** Version of the protocol between an adapter and CogRSim. */
export const kProtocol: number;

/** Support of a feature; all but "exact" with a reason for the user. */
export type Support = 'exact' | ['approximate' | 'unsupported', string];

/** An option of the engine: the attributes of `<NAME …/>` in a scene. */
export interface Option {
  name: string;
  default: boolean | number | string;
  type?: 'integer'; // of a number
  unit?: string; // SI, as in scenes
  description?: string;
  minimum?: number;
  maximum?: number;
  choices?: string[]; // of a text
}
export type Options = Record<string, boolean | number | string | number[]>;

/** Who computes a stage of a step: the class or function, or for "none" what follows from it. */
export type Stage = ['engine' | 'cogrsim' | 'none', string];
export type StageName =
  | 'broad-phase'
  | 'narrow-phase'
  | 'contact-memory'
  | 'contact-law'
  | 'friction'
  | 'restitution'
  | 'joints'
  | 'limits'
  | 'motors'
  | 'integrator';

export interface Provenance {
  engine: string;
  solver: string;
  formulation: string;
  integrator: string;
  stages: Record<StageName, Stage>;
}

export type ShapeType =
  | 'box'
  | 'sphere'
  | 'cylinder'
  | 'capsule'
  | 'plane'
  | 'convex-mesh'
  | 'mesh'
  | 'heightmap';
export type JointType =
  | 'fixed'
  | 'hinge'
  | 'slider'
  | 'screw'
  | 'cylindrical'
  | 'universal'
  | 'planar'
  | 'ball'
  | 'free'
  | 'gimbal';

/** x y z [m], then the quaternion w x y z. */
export type Pose = [number, number, number, number, number, number, number];
export type Vector = [number, number, number];

export interface Shape {
  name: string;
  type: ShapeType;
  X_BS: Pose; // in the body
  size: Vector; // box: full extents
  radius: number;
  length: number; // cylinder, capsule (without caps), along z
  mesh: number; // index, -1: none
  heightmap: number;
  material: number;
  surface_velocity: Vector;
  collides: boolean;
}

export interface Body {
  name: string;
  kind: 'dynamic' | 'kinematic' | 'static';
  removed: boolean; // its place stays
  X_WB: Pose;
  V_WB: [number, number, number, number, number, number];
  mass: number;
  com: Vector; // in the body
  inertia: number[]; // 3 x 3 about the centre of mass, in the axes of the body
  gravity_scale: number;
  shapes: Shape[];
}

/** Limits may be infinite. */
export interface JointAxis {
  lower: number;
  upper: number;
  damping: number;
  friction: number;
  stiffness: number;
  rest: number;
  max_effort: number;
  max_speed: number;
  rotor_inertia: number;
}

/** Frames F in the parent and M in the child coincide at the coordinate 0; hinges turn about z. */
export interface Joint {
  name: string;
  type: JointType;
  removed: boolean;
  parent: number; // index of a body; -1: the world
  child: number;
  X_PF: Pose;
  X_CM: Pose;
  axes: JointAxis[];
  pitch: number;
  closes_loop: boolean;
  bodies_collide: boolean;
  position: number[];
  velocity: number[];
  position_offset: number; // into the coordinates of all joints
  speed_offset: number;
  options: Options;
}

export interface Motor {
  name: string;
  removed: boolean;
  joint: number;
  axis: number;
  mode: 'velocity' | 'torque' | 'position' | 'servo' | 'dc';
  max_effort: number;
  max_speed: number;
}

export interface Coupling {
  name: string;
  removed: boolean;
  joint: number;
  terms: { joint: number; ratio: number }[];
  offset: number;
  max_effort: number;
  options: Options;
}

/** What two touching materials have together. */
export interface Surface {
  friction: number;
  rolling_friction: number;
  spinning_friction: number;
  restitution: number;
  stiffness: number | null;
}

export interface Scene {
  name: string;
  gravity: Vector;
  step: number; // the usual one [s]
  seed: number;
  bounce_threshold: number; // [m/s]
  options: Options;
  materials: { name: string; density: number; friction: number; restitution: number; options: Options }[];
  surfaces: Surface[][]; // by material and material
  bodies: Body[];
  joints: Joint[];
  motors: Motor[];
  couplings: Coupling[];
  no_collide: [number, number][]; // pairs of bodies
  meshes: { name: string; vertices: number[]; triangles: number[] }[];
  heightmaps: {
    name: string;
    columns: number;
    rows: number;
    size_x: number;
    size_y: number;
    heights: number[];
  }[];
  joint_positions: number;
  joint_speeds: number;
}

/** Of all bodies and joints of a scene, one after the other, by their indices. */
export interface State {
  poses: Float64Array; // 7 for each body
  twists: Float64Array; // 6: velocity of its origin, angular velocity
  positions: Float64Array; // coordinates of joints; empty in read() with coordinates "bodies"
  speeds: Float64Array;
}

/** What read() fills in; all numbers are 0 before. */
export interface StateOut extends State {
  jointEfforts: Float64Array; // mean over the last step, for each speed
  motorEfforts: Float64Array;
}

export interface StepInput {
  dt: number;
  /** Six for each motor: bias, kp, position, kd, velocity, max_effort. The effort is
   * clamp(bias + kp (position - q) + kd (velocity - u), ±max_effort); an infinite kd is a source of
   * speed. */
  drives: Float64Array;
  efforts: Float64Array | null; // along the speeds of joints, beside the drives: of couplings
  forces: Float64Array | null; // six for each body: force through the centre of mass, torque
  twists: Float64Array; // six for each body; those of kinematic ones hold
}

/** Body, body, shape, shape (within its body); point, normal from the first to the second; depth, and
 * the force on the second. */
export type Contact = readonly number[];

export interface World {
  step(input: StepInput): void;
  read(out: StateOut): void;
  /** All bodies in trees of joints are where the coordinates place them. */
  write?(state: State): void;
  contacts?(): Iterable<Contact>; // of the last step
  /** Six for each joint: force and torque on the child about the origin of M. */
  reactions?(out: Float64Array): void;
  save?(): Uint8Array;
  restore?(bytes: Uint8Array, state: State): void;
  free?(): void;
}

export interface Adapter {
  version: string; // of the engine, asked of it
  /** By feature (`cogrsim plugins` lists them) or by a pattern with *; later ones overrule. */
  capabilities: Record<string, Support>;
  options?: Option[];
  elementOptions?: Partial<Record<'assembly' | 'material' | 'joint' | 'couple', Option[]>>;
  /** "bodies": the engine has no coordinates, and CogRSim finds them from the motions of bodies. */
  coordinates?: 'joints' | 'bodies';
  /** "host": CogRSim finds the efforts of couplings, and step() applies them. */
  couplings?: 'engine' | 'host';
  forceTime?: number; // time of a step at which forces are evaluated, 0 to 1
  provenance(options: Options): Provenance;
  /** `previous`: the world that it follows, after a change of the scene. */
  build(scene: Scene, state: State, previous?: World): World;
}

/** What the adapter cannot do for this scene, in words for its user; the adapter goes on. */
export class Refusal extends Error {}

/** Thrown by step(): the state has left all bounds. */
export class Diverged extends Error {
  constructor(message: string, body?: number);
  body: number;
}

/** Answers CogRSim until it ends this program. */
export function serve(adapter: Adapter): void;
