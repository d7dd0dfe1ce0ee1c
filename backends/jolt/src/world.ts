// A world of the backend jolt.
import {
  type Contact,
  Diverged,
  Refusal,
  type Scene,
  type State,
  type StateOut,
  type StepInput,
  type World,
} from './cogrsim_backend.mjs';
import {
  J,
  type Jolt,
  kMoving,
  kStatic,
  needMemory,
  quat,
  record,
  replay,
  rvec,
  vec,
  wxyz,
  xyz,
} from './engine.ts';
import { Joints, type Motion } from './joints.ts';
import { cross, kHere, plus, poseOf, turn, type Q4, type V3, v3 } from './math.ts';
import { setSettings } from './options.ts';
import { shapeOf } from './shapes.ts';
import { readContacts } from './contacts.ts';
import { Surfaces } from './surfaces.ts';

/** Room for bodies, beside those of the scene. */
const kBodies = 64;
const kWorld = 22 << 20; // [byte]
const kBody = 2 << 10;
const kStill: Motion = { ...kHere, v: [0, 0, 0], w: [0, 0, 0] };

export class JoltWorld implements World {
  #jolt!: Jolt.JoltInterface;
  #system!: Jolt.PhysicsSystem;
  #bodies: (Jolt.Body | undefined)[] = [];
  #numbers = new Map<number, number>(); // of bodies, by Jolt's
  #shapes: (Jolt.Shape | undefined)[] = [];
  #joints!: Joints;
  #surfaces?: Surfaces;
  #motions: Motion[] = [];
  #before: Motion[] = []; // as the last step had them
  #dt = 0; // 0: no step to report

  constructor(
    readonly scene: Scene,
    state: State,
  ) {
    try {
      this.#build(state);
    } catch (error) {
      this.free();
      throw error;
    }
  }

  #build(state: State): void {
    const { scene } = this;
    needMemory(kWorld + kBody * scene.bodies.length, `a world of ${scene.bodies.length} bodies`);
    this.#jolt = makeJolt(scene.bodies.length + kBodies);
    this.#system = this.#jolt.GetPhysicsSystem();
    this.#system.SetGravity(vec(scene.gravity));
    const settings = this.#system.GetPhysicsSettings();
    setSettings(settings, scene.options);
    this.#system.SetPhysicsSettings(settings);
    const filter = this.#filter();
    scene.bodies.forEach((_, b) => this.#makeBody(state, b, filter));
    this.#surfaces = Surfaces.of(scene, this.#system, this.#numbers);
    const ground = J.JoltInterface.prototype.sGetFixedToWorldBody();
    this.#joints = new Joints(
      scene,
      this.#system,
      (b) => this.#bodies[b] ?? ground,
      (b) => this.#com(b),
    );
    // What is static stays where the scene has it.
    this.#motions = scene.bodies.map((_, b) => ({ ...kStill, ...poseOf(state.poses, 7 * b) }));
    this.#readMotions();
    this.#before = this.#motions;
    this.#joints.read((b) => this.#motions[b] ?? kStill, state.positions);
  }

  /** Where Jolt has the centre of mass: a body that is driven turns about its origin. */
  #com(b: number): V3 {
    return this.scene.bodies[b]?.kind === 'dynamic' ? this.scene.bodies[b].com : [0, 0, 0];
  }

  /** Pairs that never touch, by bodies. */
  #filter(): Jolt.GroupFilterTable | undefined {
    const { no_collide: pairs, bodies } = this.scene;
    if (pairs.length === 0) return undefined;
    needMemory(bodies.length ** 2 / 16, `a table of pairs of ${bodies.length} bodies`);
    const filter = new J.GroupFilterTable(bodies.length);
    for (const [a, b] of pairs) if (a >= 0 && b >= 0 && a !== b) filter.DisableCollision(a, b);
    return filter;
  }

  #makeBody(state: State, b: number, filter: Jolt.GroupFilterTable | undefined): void {
    const { scene } = this;
    const { options } = scene;
    const model = scene.bodies[b];
    this.#bodies.push(undefined);
    this.#shapes.push(undefined);
    if (model.removed) return;
    needMemory(kBody, `body '${model.name}', number ${b + 1},`);
    const com = this.#com(b);
    const shape = shapeOf(scene, model, com);
    this.#shapes[b] = shape;
    const kind = {
      dynamic: J.EMotionType_Dynamic,
      kinematic: J.EMotionType_Kinematic,
      static: J.EMotionType_Static,
    }[model.kind];
    const layer = model.kind === 'static' ? kStatic : kMoving;
    const it = new J.BodyCreationSettings(
      shape,
      rvec(state.poses, 7 * b),
      quat(state.poses, 7 * b + 3),
      kind,
      layer,
    );
    it.mAllowSleeping = false;
    it.mGravityFactor = model.gravity_scale;
    Surfaces.setOwn(it, scene, model);
    if (model.kind === 'dynamic') {
      it.mOverrideMassProperties = J.EOverrideMassProperties_MassAndInertiaProvided;
      const mass = it.mMassPropertiesOverride;
      mass.mMass = model.mass;
      const inertia = J.Mat44.prototype.sIdentity();
      for (let c = 0; c < 3; ++c) inertia.SetColumn3(c, vec([0, 3, 6].map((r) => model.inertia[r + c])));
      mass.mInertia = inertia;
      it.mLinearDamping = Number(options['linear-damping']);
      it.mAngularDamping = Number(options['angular-damping']);
      it.mMaxLinearVelocity = Number(options['max-linear-velocity']);
      it.mMaxAngularVelocity = Number(options['max-angular-velocity']);
      it.mApplyGyroscopicForce = options['apply-gyroscopic-force'] === true;
      if (options['motion-quality'] === 'linear-cast') it.mMotionQuality = J.EMotionQuality_LinearCast;
    } else {
      // Kinematic bodies have no greatest speed.
      [it.mMaxLinearVelocity, it.mMaxAngularVelocity] = [1e9, 1e9];
    }
    it.mEnhancedInternalEdgeRemoval = options['enhanced-internal-edge-removal'] === true;
    if (filter) {
      it.mCollisionGroup.SetGroupFilter(filter);
      it.mCollisionGroup.SetGroupID(0);
      it.mCollisionGroup.SetSubGroupID(b);
    }
    const bodies = this.#system.GetBodyInterface();
    const body = bodies.CreateBody(it);
    J.destroy(it);
    this.#bodies[b] = body;
    this.#numbers.set(body.GetID().GetIndexAndSequenceNumber(), b);
    bodies.AddBody(
      body.GetID(),
      model.kind === 'static' ? J.EActivation_DontActivate : J.EActivation_Activate,
    );
    if (model.kind !== 'static') this.#setTwist(b, state.twists, wxyz(body.GetRotation()));
  }

  #setTwist(b: number, twists: Float64Array, q: Q4): void {
    const body = this.#bodies[b]!;
    const [v, w] = [v3(twists, 6 * b), v3(twists, 6 * b + 3)];
    body.SetLinearVelocity(vec(plus(v, cross(w, turn(q, this.#com(b))))));
    body.SetAngularVelocity(vec(w));
  }

  #readMotions(): void {
    this.#motions = this.#bodies.map((body, b) => {
      if (!body) return kStill;
      if (this.scene.bodies[b].kind === 'static') return this.#motions[b];
      return {
        p: xyz(body.GetCenterOfMassPosition()),
        q: wxyz(body.GetRotation()),
        v: xyz(body.GetLinearVelocity()),
        w: xyz(body.GetAngularVelocity()),
      };
    });
  }

  step({ dt, drives, efforts, forces, twists }: StepInput): void {
    const { scene } = this;
    const push = (b: number, force: V3, torque: V3): void => {
      const body = this.#bodies[b];
      if (!body || scene.bodies[b].kind !== 'dynamic') return;
      body.AddForce(vec(force));
      body.AddTorque(vec(torque));
    };
    scene.bodies.forEach((model, b) => {
      if (!this.#bodies[b]) return;
      if (model.kind === 'kinematic') this.#setTwist(b, twists, this.#motions[b].q);
      if (!forces || model.kind !== 'dynamic') return;
      const at = forces.subarray(6 * b, 6 * b + 6);
      if (at.some((x) => x !== 0)) push(b, [at[0], at[1], at[2]], [at[3], at[4], at[5]]);
    });
    const motionOf = (b: number): Motion => this.#motions[b] ?? kStill;
    this.#joints.prepare(dt, drives, efforts, motionOf, push);
    this.#surfaces?.begin(this.#motions);
    this.#jolt.Step(dt, 1);
    this.#surfaces?.end();
    this.#dt = dt;
    this.#before = this.#motions;
    this.#readMotions();
    const bad = this.#motions.findIndex(({ p, q, v, w }) =>
      [...p, ...q, ...v, ...w].some((x) => !Number.isFinite(x)),
    );
    if (bad !== -1) throw new Diverged(`Jolt has no finite state of body '${scene.bodies[bad].name}'`, bad);
    this.#joints.read(motionOf);
  }

  read(out: StateOut): void {
    this.#bodies.forEach((body, b) => {
      if (!body) return;
      const { p, q, v, w } = this.#motions[b];
      const com = this.#com(b);
      const arm = com.every((x) => x === 0) ? com : turn(q, com);
      out.poses.set([...plus(p, arm, -1), ...q], 7 * b);
      out.twists.set([...plus(v, cross(w, arm), -1), ...w], 6 * b);
    });
    if (this.#dt > 0) this.#joints.efforts(this.#dt, out.jointEfforts, out.motorEfforts);
  }

  /** All again: Jolt remembers impulses of contacts and constraints. */
  write(state: State): void {
    const next = new JoltWorld(this.scene, state);
    this.free();
    this.#jolt = next.#jolt;
    this.#system = next.#system;
    this.#bodies = next.#bodies;
    this.#numbers = next.#numbers;
    this.#shapes = next.#shapes;
    this.#joints = next.#joints;
    this.#surfaces = next.#surfaces;
    this.#motions = next.#motions;
    this.#before = next.#before;
    this.#dt = 0;
  }

  contacts(): Iterable<Contact> {
    if (this.#dt === 0) return [];
    const bytes = record((recorder) => this.#system.SaveState(recorder, J.EStateRecorderState_Contacts));
    return readContacts(bytes, this.#dt, (id) => {
      const b = this.#numbers.get(id)!;
      return { body: b, motion: this.#before[b], shape: this.#shapes[b]! };
    });
  }

  reactions(out: Float64Array): void {
    if (this.#dt > 0) this.#joints.reactions(this.#dt, (b) => this.#before[b] ?? kStill, out);
  }

  save(): Uint8Array {
    return record((recorder) => this.#system.SaveState(recorder));
  }

  restore(bytes: Uint8Array, state: State): void {
    if (!replay(bytes, (recorder) => this.#system.RestoreState(recorder))) {
      throw new Refusal('the saved state is of another world');
    }
    this.#dt = 0;
    this.#readMotions();
    this.#before = this.#motions;
    this.#joints.read((b) => this.#motions[b] ?? kStill, state.positions);
  }

  free(): void {
    this.#joints?.free();
    this.#surfaces?.free();
    if (this.#jolt) J.destroy(this.#jolt);
    for (const shape of this.#shapes) shape?.Release();
    this.#shapes = [];
  }
}

function makeJolt(bodies: number): Jolt.JoltInterface {
  const settings = new J.JoltSettings();
  settings.mMaxBodies = bodies;
  const pairs = new J.ObjectLayerPairFilterTable(2);
  pairs.EnableCollision(kStatic, kMoving);
  pairs.EnableCollision(kMoving, kMoving);
  const layers = new J.BroadPhaseLayerInterfaceTable(2, 2);
  for (const layer of [kStatic, kMoving]) {
    const it = new J.BroadPhaseLayer(layer);
    layers.MapObjectToBroadPhaseLayer(layer, it);
    J.destroy(it);
  }
  settings.mObjectLayerPairFilter = pairs;
  settings.mBroadPhaseLayerInterface = layers;
  settings.mObjectVsBroadPhaseLayerFilter = new J.ObjectVsBroadPhaseLayerFilterTable(layers, 2, pairs, 2);
  const jolt = new J.JoltInterface(settings);
  J.destroy(settings);
  return jolt;
}
