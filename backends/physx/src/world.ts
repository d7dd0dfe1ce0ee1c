// A world of the backend physx.
import {
  type Contact,
  Diverged,
  type Scene,
  type State,
  type StateOut,
  type StepInput,
  type World,
} from './cogrsim_backend.mjs';
import { Articulations } from './articulations.ts';
import { Contacts } from './contacts.ts';
import { dispatcher, P, type PhysX, physics, read, readPose, said, scale, transform, vec } from './engine.ts';
import {
  cross,
  kHere,
  multiply,
  normalized,
  plus,
  type Pose,
  poseOf,
  principal,
  type Q4,
  scale as times,
  turn,
  type V3,
  v3,
} from './math.ts';
import { Shapes } from './shapes.ts';

const kGyroscopic = 1 << 10; // PxRigidBodyFlag::eENABLE_GYROSCOPIC_FORCES, whose name the package does not have
const kZero: V3 = [0, 0, 0];

interface Motion extends Pose {
  v: V3; // of the centre of mass
  w: V3;
  com: V3; // in the world
}

const kStill: Motion = { ...kHere, v: kZero, w: kZero, com: kZero };

/** q after a turn by the vector `angle` in the world. */
function turned(q: Q4, angle: V3): Q4 {
  const size = Math.hypot(...angle);
  const share = size < 1e-12 ? 0.5 : Math.sin(size / 2) / size;
  return normalized(multiply([Math.cos(size / 2), ...times(share, angle)], q));
}

export class PhysxWorld implements World {
  #scene!: PhysX.PxScene;
  #shapes!: Shapes;
  #contacts!: Contacts;
  #trees!: Articulations;
  #actors: (PhysX.PxRigidActor | undefined)[] = [];
  #motions: Motion[] = [];
  #dt = 0; // 0: no step to report
  #attached: Set<number>;

  constructor(
    readonly scene: Scene,
    state: State,
    previous?: PhysxWorld,
  ) {
    // A later joint between bodies that were there stops what it forbids: a joint of PhysX does, while a
    // tree would forget the motion of what is attached.
    this.#attached = new Set(previous ? previous.#attached : []);
    const { joints, bodies } = previous?.scene ?? scene;
    scene.joints.slice(joints.length).forEach(({ parent, child }, i) => {
      if (Math.max(parent, child) < bodies.length) this.#attached.add(joints.length + i);
    });
    try {
      this.#build(state);
    } catch (error) {
      this.free();
      throw error;
    }
  }

  #build(state: State): void {
    const { scene } = this;
    this.#shapes = new Shapes(scene);
    this.#contacts = new Contacts(scene, this.#shapes.of);
    this.#makeScene();
    this.#trees = new Articulations(scene, state, this.#attached, (link, b) => {
      this.#actors[b] = link;
      this.#setUp(link, b, true);
    });
    this.#trees.motionOf = (b) => this.#motions[b] ?? kStill;
    this.#motions = scene.bodies.map((model, b) => {
      const { p, q } = poseOf(state.poses, 7 * b);
      const [v, w] = [v3(state.twists, 6 * b), v3(state.twists, 6 * b + 3)];
      const arm = turn(q, model.com);
      return { p, q, v: plus(v, cross(w, arm)), w, com: plus(p, arm) };
    });
    scene.bodies.forEach((model, b) => {
      if (!model.removed && !(model.kind === 'dynamic' && this.#trees.has(b))) this.#makeActor(b);
    });
    this.#trees.make(this.#scene);
    this.#trees.makeLoops((b) => this.#actors[b] ?? null);
    this.#read();
  }

  #makeScene(): void {
    const { gravity, options } = this.scene;
    const desc = new P.PxSceneDesc(scale);
    desc.gravity = vec(gravity);
    desc.cpuDispatcher = dispatcher;
    const { eTGS, ePGS } = P.PxSolverTypeEnum;
    desc.solverType = options['solver-type'] === 'tgs' ? eTGS : ePGS;
    desc.bounceThresholdVelocity = Number(options['bounce-threshold-velocity']);
    desc.frictionOffsetThreshold = Number(options['friction-offset-threshold']);
    desc.frictionCorrelationDistance = Number(options['friction-correlation-distance']);
    P.setupPassThroughFilterShader(desc, this.#contacts.filter);
    desc.simulationEventCallback = this.#contacts.callback;
    said();
    this.#scene = physics.createScene(desc);
    if ((this.#scene as unknown as { ptr: number }).ptr === 0)
      throw new Error(`PhysX makes no scene: ${said()}`);
    P.destroy(desc);
    const flag = P.PxSceneFlagEnum;
    this.#scene.setFlag(flag.eENABLE_PCM, options['pcm'] === true);
    this.#scene.setFlag(flag.eENABLE_CCD, options['ccd'] === true);
    this.#scene.setFlag(flag.eENABLE_STABILIZATION, options['stabilization'] === true);
    this.#scene.setFlag(flag.eENABLE_ENHANCED_DETERMINISM, options['enhanced-determinism'] === true);
  }

  #makeActor(b: number): void {
    const { scene } = this;
    const { options } = scene;
    const model = scene.bodies[b];
    const { p, q, v, w } = this.#motions[b];
    if (model.kind === 'static') {
      const actor = physics.createRigidStatic(transform({ p, q }));
      this.#actors[b] = actor;
      this.#shapes.attach(actor, model, b);
      this.#scene.addActor(actor);
      return;
    }
    const actor = physics.createRigidDynamic(transform({ p, q }));
    this.#actors[b] = actor;
    if (model.kind === 'kinematic') {
      actor.setRigidBodyFlag(P.PxRigidBodyFlagEnum.eKINEMATIC, true);
      this.#shapes.attach(actor, model, b);
      this.#scene.addActor(actor);
      return;
    }
    this.#setUp(actor, b, false);
    actor.setSolverIterationCounts(
      Number(options['position-iterations']),
      Number(options['velocity-iterations']),
    );
    actor.setSleepThreshold(0);
    actor.setStabilizationThreshold(0);
    actor.setLinearVelocity(vec(v));
    actor.setAngularVelocity(vec(w));
    this.#scene.addActor(actor);
  }

  /** What bodies and links have alike. */
  #setUp(body: PhysX.PxRigidBody, b: number, isLink: boolean): void {
    const { options, bodies } = this.scene;
    const model = bodies[b];
    this.#shapes.attach(body, model, b);
    const { moments, axes } = principal(model.inertia);
    body.setCMassLocalPose(transform({ p: model.com, q: axes }));
    body.setMass(model.mass);
    body.setMassSpaceInertiaTensor(vec(moments));
    const of = isLink ? 'link-' : '';
    body.setLinearDamping(Number(options[`${of}linear-damping`]));
    body.setAngularDamping(Number(options[`${of}angular-damping`]));
    body.setMaxLinearVelocity(Number(options['max-linear-velocity']));
    body.setMaxAngularVelocity(Number(options['max-angular-velocity']));
    body.setMaxDepenetrationVelocity(Number(options['max-depenetration-velocity']));
    const flag = P.PxRigidBodyFlagEnum;
    if (options['ccd'] === true) body.setRigidBodyFlag(flag.eENABLE_CCD, true);
    if (options['gyroscopic-forces'] === true && !isLink) body.setRigidBodyFlag(kGyroscopic as never, true);
    if (model.gravity_scale === 0) body.setActorFlag(P.PxActorFlagEnum.eDISABLE_GRAVITY, true);
  }

  step({ dt, drives, efforts, forces, twists }: StepInput): void {
    const { scene } = this;
    this.#contacts.begin();
    const push = (b: number, force: V3, torque: V3): void => {
      if (scene.bodies[b]?.kind !== 'dynamic' || scene.bodies[b].removed) return;
      const body = this.#actors[b] as PhysX.PxRigidBody;
      if (force.some((x) => x !== 0)) body.addForce(vec(force), P.PxForceModeEnum.eFORCE, true);
      if (torque.some((x) => x !== 0)) body.addTorque(vec(torque), P.PxForceModeEnum.eFORCE, true);
    };
    scene.bodies.forEach((model, b) => {
      if (model.removed || model.kind === 'static') return;
      if (model.kind === 'kinematic') return this.#carry(b, dt, twists);
      // PhysX has gravity or not.
      const share = model.gravity_scale - 1;
      if (share !== 0 && share !== -1) push(b, scene.gravity.map((g) => share * model.mass * g) as V3, kZero);
      if (!forces) return;
      const at = forces.subarray(6 * b, 6 * b + 6);
      push(b, [at[0], at[1], at[2]], [at[3], at[4], at[5]]);
    });
    this.#trees.prepare(drives, efforts, push);
    this.#scene.simulate(dt);
    this.#scene.fetchResults(true);
    this.#dt = dt;
    this.#read();
    const bad = this.#motions.findIndex(
      ({ p, w }) => !Number.isFinite(p[0] + p[1] + p[2] + w[0] + w[1] + w[2]),
    );
    if (bad !== -1) throw new Diverged(`PhysX has no finite state of body '${scene.bodies[bad].name}'`, bad);
  }

  /** A kinematic body goes to where its twist takes it. */
  #carry(b: number, dt: number, twists: Float64Array): void {
    const at = this.#motions[b];
    const [v, w] = [v3(twists, 6 * b), v3(twists, 6 * b + 3)];
    const next = { p: plus(at.p, v, dt), q: turned(at.q, w.map((x) => x * dt) as V3) };
    (this.#actors[b] as PhysX.PxRigidDynamic).setKinematicTarget(transform(next));
    this.#motions[b] = { ...next, v, w, com: next.p };
  }

  #read(): void {
    this.#actors.forEach((actor, b) => {
      const model = this.scene.bodies[b];
      if (!actor || model.kind !== 'dynamic') return;
      const body = actor as PhysX.PxRigidBody;
      const { p, q } = readPose(body.getGlobalPose());
      const { com } = model;
      const isPlain = com[0] === 0 && com[1] === 0 && com[2] === 0;
      this.#motions[b] = {
        p,
        q,
        v: read(body.getLinearVelocity()),
        w: read(body.getAngularVelocity()),
        com: isPlain ? p : plus(p, turn(q, com)),
      };
    });
  }

  read(out: StateOut): void {
    this.#readBodies(out);
    if (this.#dt > 0) this.#trees.efforts(out.jointEfforts, out.motorEfforts);
  }

  #readBodies(out: State): void {
    this.#motions.forEach(({ p, q, v, w, com }, b) => {
      if (!this.#actors[b]) return;
      const [i, k] = [7 * b, 6 * b];
      [out.poses[i], out.poses[i + 1], out.poses[i + 2]] = p;
      [out.poses[i + 3], out.poses[i + 4], out.poses[i + 5], out.poses[i + 6]] = q;
      const at = com === p ? v : plus(v, cross(w, plus(com, p, -1)), -1);
      [out.twists[k], out.twists[k + 1], out.twists[k + 2]] =
        this.scene.bodies[b].kind === 'static' ? kZero : at;
      [out.twists[k + 3], out.twists[k + 4], out.twists[k + 5]] = w;
    });
  }

  /** All again: PhysX remembers contacts. */
  write(state: State): void {
    const next = new PhysxWorld(this.scene, state, this);
    this.free();
    this.#scene = next.#scene;
    this.#shapes = next.#shapes;
    this.#contacts = next.#contacts;
    this.#trees = next.#trees;
    this.#actors = next.#actors;
    this.#motions = next.#motions;
    this.#trees.motionOf = (b) => this.#motions[b] ?? kStill;
    this.#dt = 0;
  }

  contacts(): Iterable<Contact> {
    return this.#dt > 0 ? this.#contacts.read(this.#dt) : [];
  }

  reactions(out: Float64Array): void {
    if (this.#dt > 0) this.#trees.reactions(out);
  }

  /** PhysX has no way to save what its contacts remember: the state of the scene is all. */
  save(): Uint8Array {
    return Buffer.from(JSON.stringify([...this.#attached]));
  }
  restore(bytes: Uint8Array, state: State): void {
    this.#attached = new Set(JSON.parse(Buffer.from(bytes).toString()) as number[]);
    this.write(state);
  }

  free(): void {
    this.#trees?.free();
    this.#actors.forEach((actor, b) => {
      if (actor && !this.#trees.links.has(b)) actor.release();
    });
    this.#scene?.release();
    this.#shapes?.free();
    this.#contacts?.free();
    this.#actors = [];
  }
}
