// The backend rapier: Rapier's rigid bodies, colliders, impulse joints and its step.
import RAPIER from '@dimforge/rapier3d-compat';

import {
  type Contact,
  type Scene,
  serve,
  type State,
  type StateOut,
  type StepInput,
  type Support,
  type World,
} from './cogrsim_backend.mjs';
import { type Xyz, xyz, xyzw } from './convert.ts';
import { type Joints, makeJoints } from './joints.ts';
import { cross, plus, principal, turn, type V3 } from './math.ts';
import { combineRules, type Rules, surfacePairs } from './scene.ts';
import { colliderOf } from './shapes.ts';

await RAPIER.init();

const key = (a: number, b: number): string => `${Math.min(a, b)} ${Math.max(a, b)}`;
const array = (v: Xyz): V3 => [v.x, v.y, v.z];
function put(out: Float64Array, at: number, v: Xyz): void {
  out[at] = v.x;
  out[at + 1] = v.y;
  out[at + 2] = v.z;
}

/** What a snapshot holds beside Rapier's own. */
interface Handles {
  ground: number;
  bodies: number[];
  colliders: number[][];
  joints: number[][];
  inertias: (number | null)[]; // by joint; as a rotor found it when it was made
}

/** So many hold a rotor of ten times the inertia that it turns to 1 %. */
const kRotorIterations = 32;

class RapierWorld implements World {
  #world: RAPIER.World;
  readonly #rules: Rules;
  #ground!: RAPIER.RigidBody;
  #bodies: (RAPIER.RigidBody | undefined)[] = [];
  #colliders: number[][] = [];
  #joints!: Joints;
  #owners = new Map<number, [number, number]>(); // of colliders: body and shape
  #numbers = new Map<number, number>(); // of bodies, by their handles
  #events = new RAPIER.EventQueue(true);
  #apart = new Set<string>(); // pairs of handles that never touch
  #dt = 1;
  #isPushed = true; // the last step, or the one that a snapshot is of, may have left forces

  constructor(
    readonly scene: Scene,
    state: State,
  ) {
    this.#rules = combineRules(scene, 'Rapier');
    this.#world = new RAPIER.World(xyz(scene.gravity));
    try {
      this.#setOptions();
      this.#ground = this.#world.createRigidBody(RAPIER.RigidBodyDesc.fixed());
      scene.bodies.forEach((_, b) => this.#makeBody(state, b));
      this.#joints = makeJoints(this.#world, scene, (b) => this.#bodies[b] ?? this.#ground, state);
      this.#takeNumbers(state);
    } catch (error) {
      this.free();
      throw error;
    }
  }

  #setOptions(): void {
    const { options } = this.scene;
    const parameters = this.#world.integrationParameters;
    parameters.numSolverIterations = Number(options['num-solver-iterations']);
    // A sweep sees the rotor beside the body alone, and not what its joint holds.
    const hasRotors = this.scene.joints.some(({ removed, axes }) => !removed && axes.some((axis) => axis.rotor_inertia > 0));
    parameters.numInternalPgsIterations =
      Number(options['num-internal-pgs-iterations']) ||
      (hasRotors ? kRotorIterations : parameters.numInternalPgsIterations);
    parameters.maxCcdSubsteps = Number(options['max-ccd-substeps']);
    parameters.normalizedAllowedLinearError = Number(options['normalized-allowed-linear-error']);
    parameters.normalizedPredictionDistance = Number(options['normalized-prediction-distance']);
    const frequency = Number(options['contact-natural-frequency']);
    if (frequency > 0) parameters.contact_natural_frequency = frequency;
  }

  #makeBody(state: State, b: number): void {
    const model = this.scene.bodies[b];
    this.#bodies.push(undefined);
    this.#colliders.push(model.shapes.map(() => -1));
    if (model.removed) return;
    const pose = state.poses.subarray(7 * b, 7 * b + 7);
    const kinds = {
      dynamic: RAPIER.RigidBodyDesc.dynamic,
      kinematic: RAPIER.RigidBodyDesc.kinematicVelocityBased,
      static: RAPIER.RigidBodyDesc.fixed,
    };
    const desc = kinds[model.kind]()
      .setTranslation(pose[0], pose[1], pose[2])
      .setRotation(xyzw(pose, 3))
      .setCanSleep(false)
      .setCcdEnabled(model.kind === 'dynamic' && this.scene.options['ccd'] === true)
      .setGravityScale(model.gravity_scale);
    if (model.kind === 'dynamic') {
      const { moments, axes } = principal(model.inertia);
      desc.setAdditionalMassProperties(model.mass, xyz(model.com), xyz(moments), xyzw(axes));
    }
    const body = this.#world.createRigidBody(desc);
    this.#bodies[b] = body;
    this.#setTwist(b, state.twists);
    model.shapes.forEach((shape, s) => {
      if (!shape.collides) return;
      this.#colliders[b][s] = this.#world.createCollider(colliderOf(this.scene, this.#rules, shape), body).handle;
    });
  }

  /** The vector from the origin of a body to the point that its velocity is of. */
  #arm(b: number): V3 {
    const model = this.scene.bodies[b];
    if (model.kind !== 'dynamic') return [0, 0, 0];
    const q = this.#bodies[b]!.rotation();
    return turn([q.w, q.x, q.y, q.z], model.com);
  }

  #setTwist(b: number, twists: Float64Array): void {
    const body = this.#bodies[b];
    if (!body || this.scene.bodies[b].kind === 'static') return;
    const [vx, vy, vz, ...w] = twists.subarray(6 * b, 6 * b + 6);
    const spin = w as unknown as V3;
    body.setLinvel(xyz(plus([vx, vy, vz], cross(spin, this.#arm(b)))), true);
    body.setAngvel(xyz(spin), true);
  }

  /** What is found by handles, of a world that is built or restored. */
  #takeNumbers(state: State): void {
    this.#numbers.clear();
    this.#owners.clear();
    this.#apart.clear();
    this.#bodies.forEach((body, b) => body && this.#numbers.set(body.handle, b));
    this.#colliders.forEach((handles, b) =>
      handles.forEach((handle, s) => handle !== -1 && this.#owners.set(handle, [b, s])),
    );
    const jointed = new Set(
      this.scene.joints.filter((j) => !j.removed && !j.bodies_collide).map((j) => key(j.parent, j.child)),
    );
    for (const [a, b] of this.scene.no_collide) {
      // Joints keep their own bodies apart.
      if (jointed.has(key(a, b))) continue;
      this.#apart.add(key(a, b));
      for (const handle of [...this.#colliders[a], ...this.#colliders[b]]) {
        if (handle !== -1) {
          this.#world.getCollider(handle).setActiveHooks(RAPIER.ActiveHooks.FILTER_CONTACT_PAIRS);
        }
      }
    }
    this.#joints.axes.forEach((axis, j) => {
      if (!axis) return;
      axis.q = state.positions[this.scene.joints[j].position_offset];
      axis.read();
    });
  }

  #hooks = {
    filterContactPair: (_a: number, _b: number, body1: number, body2: number) => {
      const [a, b] = [this.#numbers.get(body1), this.#numbers.get(body2)];
      const apart = a !== undefined && b !== undefined && this.#apart.has(key(a, b));
      return apart ? null : RAPIER.SolverFlags.COMPUTE_IMPULSE;
    },
    filterIntersectionPair: () => false,
  };

  step({ dt, drives, efforts, forces, twists }: StepInput): void {
    this.#dt = dt;
    this.#world.timestep = dt;
    this.scene.bodies.forEach((model, b) => {
      const body = this.#bodies[b];
      if (!body) return;
      if (model.kind === 'kinematic') this.#setTwist(b, twists);
      if (model.kind !== 'dynamic') return;
      if (this.#isPushed) {
        body.resetForces(true);
        body.resetTorques(true);
      }
      if (!forces) return;
      body.addForce(xyz(forces, 6 * b), true);
      body.addTorque(xyz(forces, 6 * b + 3), true);
    });
    this.#isPushed = forces !== null || this.#joints.axes.some((axis) => axis !== undefined);
    const substeps = this.#world.integrationParameters.numSolverIterations;
    const beside = new Float64Array(this.scene.joints.length);
    this.scene.motors.forEach((motor, m) => {
      if (!motor.removed) beside[motor.joint] += this.#joints.axes[motor.joint]!.drive(drives, 6 * m);
    });
    this.#joints.axes.forEach((axis, j) => {
      axis?.setLimits();
      axis?.setPassive(dt, substeps);
      const coupled = efforts ? efforts[this.scene.joints[j].speed_offset] : 0;
      axis?.apply(beside[j] + axis.spring() + coupled);
    });
    // Rapier asks hooks only in steps with a queue of events.
    if (this.#apart.size > 0) this.#world.step(this.#events, this.#hooks);
    else this.#world.step();
    for (const axis of this.#joints.axes) axis?.read();
  }

  read(out: StateOut): void {
    const p = { x: 0, y: 0, z: 0 };
    const q = { x: 0, y: 0, z: 0, w: 1 };
    const v = { x: 0, y: 0, z: 0 };
    const w = { x: 0, y: 0, z: 0 };
    this.#bodies.forEach((body, b) => {
      if (!body) return;
      body.translation(p);
      body.rotation(q);
      put(out.poses, 7 * b, p);
      out.poses[7 * b + 3] = q.w;
      put(out.poses, 7 * b + 4, q);
      const model = this.scene.bodies[b];
      if (model.kind === 'static') return;
      body.linvel(v);
      body.angvel(w);
      put(out.twists, 6 * b, v);
      put(out.twists, 6 * b + 3, w);
      if (model.kind !== 'dynamic' || model.com.every((x) => x === 0)) return;
      const lever = cross(array(w), turn([q.w, q.x, q.y, q.z], model.com));
      lever.forEach((x, i) => (out.twists[6 * b + i] -= x));
    });
  }

  write(state: State): void {
    const next = new RapierWorld(this.scene, state);
    next.#events.free();
    this.#world.free();
    this.#world = next.#world;
    this.#ground = next.#ground;
    this.#bodies = next.#bodies;
    this.#colliders = next.#colliders;
    this.#joints = next.#joints;
    this.#owners = next.#owners;
    this.#numbers = next.#numbers;
  }

  *contacts(): Iterable<Contact> {
    for (const [handle, [body, shape]] of this.#owners) {
      const collider = this.#world.getCollider(handle);
      const others: RAPIER.Collider[] = [];
      this.#world.contactPairsWith(collider, (other) => others.push(other));
      for (const other of others) {
        const [otherBody, otherShape] = this.#owners.get(other.handle)!;
        // Each pair once.
        if (otherBody < body || (otherBody === body && otherShape <= shape)) continue;
        const found: Contact[] = [];
        this.#world.contactPair(collider, other, (manifold, flipped) =>
          found.push(...this.#points(manifold, flipped, [collider, other], [body, otherBody, shape, otherShape])),
        );
        yield* found;
      }
    }
  }

  #points(
    manifold: RAPIER.TempContactManifold,
    flipped: boolean,
    colliders: [RAPIER.Collider, RAPIER.Collider],
    names: number[],
  ): Contact[] {
    const out: Contact[] = [];
    const [first, second] = flipped ? [colliders[1], colliders[0]] : colliders;
    const sign = flipped ? -1 : 1;
    const n = array(manifold.normal()).map((x) => sign * x) as V3;
    const inWorld = (collider: RAPIER.Collider, point: Xyz): V3 => {
      const q = collider.rotation();
      return plus(array(collider.translation()), turn([q.w, q.x, q.y, q.z], array(point)));
    };
    for (let i = 0; i < manifold.numContacts(); ++i) {
      const [a, b] = [manifold.localContactPoint1(i), manifold.localContactPoint2(i)];
      const impulse = manifold.contactImpulse(i);
      if (!a || !b || (impulse === 0 && manifold.contactDist(i) > 0)) continue;
      const sum = plus(inWorld(first, a), inWorld(second, b));
      const force = impulse / this.#dt;
      out.push([
        ...names,
        ...sum.map((x) => x / 2),
        ...n,
        -manifold.contactDist(i),
        ...n.map((x) => force * x),
      ]);
    }
    return out;
  }

  save(): Uint8Array {
    const handles: Handles = {
      ground: this.#ground.handle,
      bodies: this.#bodies.map((body) => body?.handle ?? -1),
      colliders: this.#colliders,
      joints: this.#joints.handles,
      inertias: this.#joints.axes.map((axis) => axis?.inertia ?? null),
    };
    const head = Buffer.from(JSON.stringify(handles));
    const length = Buffer.alloc(4);
    length.writeUInt32LE(head.length);
    return Buffer.concat([length, head, this.#world.takeSnapshot()]);
  }

  restore(bytes: Uint8Array, state: State): void {
    const all = Buffer.from(bytes);
    const end = 4 + all.readUInt32LE(0);
    const handles = JSON.parse(all.toString('utf8', 4, end)) as Handles;
    const world = RAPIER.World.restoreSnapshot(new Uint8Array(all.subarray(end)));
    this.#world.free();
    this.#world = world;
    this.#ground = world.getRigidBody(handles.ground);
    this.#bodies = handles.bodies.map((h) => (h === -1 ? undefined : world.getRigidBody(h)));
    this.#colliders = handles.colliders;
    this.#joints = makeJoints(world, this.scene, (b) => this.#bodies[b] ?? this.#ground, state, handles);
    this.#takeNumbers(state);
    this.#isPushed = true;
  }

  free(): void {
    this.#events.free();
    this.#world.free();
  }
}

const kNoInterface = "Rapier's interface for JavaScript does not have it";

const kRotor: Support = [
  'approximate',
  'the motor of a second joint towards the speed at the start of the step, as soft as the inertia',
];

const kCapabilities: Record<string, Support> = {
  'shape.*': ['approximate', 'Rapier computes in single precision'],
  'pair.*': ['approximate', 'soft contact in single precision: rests in some 0.1 mm of penetration'],
  ...surfacePairs(['unsupported', 'two surfaces: neither can be moved by forces']),
  'joint.*': ['unsupported', 'this adapter has fixed, hinge, slider, ball and free joints'],
  'loop.*': ['unsupported', 'this adapter has fixed, hinge, slider, ball and free joints'],
  'joint.rotor-inertia.hinge': kRotor,
  'joint.rotor-inertia.slider': kRotor,
  'joint.fixed': ['approximate', 'an impulse joint, held softly'],
  'joint.hinge': ['approximate', 'an impulse joint, held softly; turns at most a quarter of pi a step'],
  'joint.slider': ['approximate', 'an impulse joint, held softly'],
  'joint.ball': ['approximate', 'an impulse joint, held softly'],
  'joint.free': 'exact',
  'loop.fixed': ['approximate', 'as in trees'],
  'loop.hinge': ['approximate', 'as in trees'],
  'loop.slider': ['approximate', 'as in trees'],
  'loop.ball': ['approximate', 'as in trees'],
  'loop.free': 'exact',
  'joint.limit.hinge': ['approximate', 'soft; of limits a turn apart and more Rapier has the nearer one'],
  'joint.limit.slider': ['approximate', 'soft'],
  'joint.damping.hinge': ['approximate', "Rapier's motor, implicit; beside a drive that of a second joint"],
  'joint.damping.slider': ['approximate', "Rapier's motor, implicit; beside a drive that of a second joint"],
  'joint.friction.hinge': ['approximate', "Rapier's motor towards rest; beside a drive that of a second joint"],
  'joint.friction.slider': ['approximate', "Rapier's motor towards rest; beside a drive that of a second joint"],
  'joint.stiffness.hinge': ['approximate', 'an explicit spring'],
  'joint.stiffness.slider': ['approximate', 'an explicit spring'],
  'joint.coupling': ['approximate', 'Rapier has no gears: efforts that CogRSim finds before each step'],
  'joint.coupling-effort': ['approximate', 'as joint.coupling'],
  'motor.torque': ['approximate', 'a torque on both bodies over the step'],
  'motor.velocity': ['approximate', "Rapier's motor"],
  'motor.position': ['approximate', "Rapier's motor"],
  'motor.servo': ['approximate', "Rapier's motor"],
  'motor.dc': ['approximate', "Rapier's motor"],
  'body.force': 'exact',
  'body.static': 'exact',
  'body.kinematic': 'exact',
  'body.gravity-scale': 'exact',
  'contact.*': ['unsupported', kNoInterface],
  'runtime.*': ['approximate', 'the world is rebuilt: contacts lose their impulses'],
  'runtime.save': 'exact',
  'report.contact_force': ['approximate', `its part along the normal: of friction ${kNoInterface}`],
  'report.joint_reaction': ['unsupported', kNoInterface],
  'report.joint_effort': ['unsupported', kNoInterface],
};

const parameters = new RAPIER.IntegrationParameters();

serve({
  version: RAPIER.version(),
  coordinates: 'bodies',
  couplings: 'host',
  capabilities: kCapabilities,
  options: [
    {
      name: 'num-solver-iterations',
      type: 'integer',
      default: parameters.numSolverIterations,
      minimum: 1,
      maximum: 1000,
      description: 'substeps of the solver in a step',
    },
    {
      name: 'num-internal-pgs-iterations',
      type: 'integer',
      default: 0,
      minimum: 0,
      maximum: 1000,
      description: `iterations of projected Gauss-Seidel in a substep; 0: ${parameters.numInternalPgsIterations}, and ${kRotorIterations} where joints have rotors`,
    },
    {
      name: 'max-ccd-substeps',
      type: 'integer',
      default: parameters.maxCcdSubsteps,
      minimum: 1,
      maximum: 1000,
      description: 'substeps of continuous collision detection',
    },
    { name: 'ccd', default: false, description: 'continuous collision detection of all bodies' },
    {
      name: 'normalized-allowed-linear-error',
      default: parameters.normalizedAllowedLinearError,
      minimum: 0,
      unit: 'm',
      description: 'penetration that is not pushed out',
    },
    {
      name: 'normalized-prediction-distance',
      default: parameters.normalizedPredictionDistance,
      minimum: 0,
      unit: 'm',
      description: 'distance at which contacts begin',
    },
    {
      name: 'contact-natural-frequency',
      default: 0,
      minimum: 0,
      description: 'stiffness of contacts as a frequency; 0: that of Rapier',
    },
  ],
  provenance: () => ({
    engine: 'Rapier',
    solver: 'projected Gauss-Seidel with substeps, soft constraints',
    formulation: 'maximal coordinates, impulse joints',
    integrator: 'semi-implicit Euler with substeps',
    stages: {
      'broad-phase': ['engine', 'BroadPhase (bounding volume hierarchy)'],
      'narrow-phase': ['engine', 'NarrowPhase'],
      'contact-memory': ['engine', 'NarrowPhase: contact manifolds with their impulses'],
      'contact-law': ['engine', 'World.step: contact constraints'],
      friction: ['engine', 'World.step: the CoefficientCombineRule that gives all pairs'],
      restitution: ['engine', 'World.step: the CoefficientCombineRule that gives all pairs'],
      joints: ['engine', 'ImpulseJointSet'],
      limits: ['engine', 'UnitImpulseJoint.setLimits'],
      motors: ['engine', 'UnitImpulseJoint.configureMotor (springs and torque motors by addTorque)'],
      integrator: ['engine', 'World.step'],
    },
  }),
  build: (scene, state) => new RapierWorld(scene, state),
});
