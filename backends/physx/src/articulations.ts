// Trees of joints as PhysX's articulations, and what closes loops as its joints.
import { type Joint, Refusal, type Scene, type State } from './cogrsim_backend.mjs';
import { address, P, type PhysX, physics, said, transform, vec, vectorAt } from './engine.ts';
import {
  conjugate,
  cross,
  multiply,
  plus,
  type Pose,
  poseOf,
  scale,
  turn,
  type Q4,
  type V3,
} from './math.ts';
import { motorsOf } from './scene.ts';

/** PhysX's joints turn about and slide along x of their frames, those of scenes z. */
const kXToZ: Q4 = [Math.SQRT1_2, 0, -Math.SQRT1_2, 0];
// PxArticulationJointType, whose names the package does not have.
const kFix = 0;
const kPrismatic = 1;
const kUnwrapped = 3; // a hinge whose angle goes on beyond a turn
const kSpherical = 4;
const kForceDrive = 0; // PxArticulationDriveType::eFORCE
const kMost = 3e38; // PhysX's "no bound"
/** Damping of a source of speed: rigid, as far as single precision tells. */
const kRigid = 1e9;
const kSpatial = 8; // floats of a PxSpatialForce, each vector padded

type Type = PhysX.PxArticulationJointTypeEnum;
type Actor = PhysX.PxRigidActor;

const inFrame = (pose: Pose): Pose => ({ p: pose.p, q: multiply(pose.q, kXToZ) });
const clamp = (value: number, most: number): number => Math.min(Math.max(value, -most), most);

/** A hinge or slider of an articulation, and what acts along it in a step. */
class Axis {
  readonly #axis: PhysX.PxArticulationAxisEnum;
  readonly #isHinge: boolean;
  readonly #driver: number; // the motor that has PhysX's drive; -1: none
  #applied = 0; // the effort over the last step that is not of PhysX's drive, without that of couplings
  #coupled = 0;
  #laws: { direct: number; law: Float64Array }[] = []; // by motor

  constructor(
    readonly joint: Joint,
    readonly made: PhysX.PxArticulationJointReducedCoordinate,
    readonly modes: string[], // of its motors
  ) {
    this.#driver = modes.findIndex((mode) => mode !== 'torque');
    if (modes.some((mode, m) => mode !== 'torque' && m !== this.#driver)) {
      throw new Refusal(
        `joint '${joint.name}': an axis has one drive in PhysX, and so one motor beside torque motors`,
      );
    }
    this.#isHinge = joint.type === 'hinge';
    this.#axis = this.#isHinge ? P.PxArticulationAxisEnum.eTWIST : P.PxArticulationAxisEnum.eX;
    const { lower, upper, rotor_inertia, friction, damping, stiffness, rest } = joint.axes[0];
    made.setJointType((this.#isHinge ? kUnwrapped : kPrismatic) as unknown as Type);
    const { eFREE, eLIMITED } = P.PxArticulationMotionEnum;
    const isLimited = lower !== -Infinity || upper !== Infinity;
    made.setMotion(this.#axis, isLimited ? eLIMITED : eFREE);
    if (isLimited) {
      const limit = new P.PxArticulationLimit(Math.max(lower, -1e30), Math.min(upper, 1e30));
      made.setLimitParams(this.#axis, limit);
      P.destroy(limit);
    }
    if (rotor_inertia > 0) made.setArmature(this.#axis, rotor_inertia);
    if (this.#driver !== -1) return;
    if (friction > 0) this.#drive(0, kRigid, friction);
    else if (damping > 0 || stiffness > 0) {
      this.#drive(stiffness, damping, kMost);
      made.setDriveTarget(this.#axis, rest);
    }
  }

  /** What has no drive of the articulation: damping and greatest effort of drives towards rest. */
  get beside(): [number, number][] {
    const { friction, damping } = this.joint.axes[0];
    const isDriven = this.#driver !== -1;
    const out: [number, number][] = [];
    if (isDriven && friction > 0) out.push([kRigid, friction]);
    if ((isDriven || friction > 0) && damping > 0) out.push([damping, kMost]);
    return out;
  }

  get q(): number {
    return this.made.getJointPosition(this.#axis);
  }
  get u(): number {
    return this.made.getJointVelocity(this.#axis);
  }
  start(q: number, u: number): void {
    this.made.setJointPosition(this.#axis, q);
    this.made.setJointVelocity(this.#axis, u);
  }

  #drive(stiffness: number, damping: number, most: number): void {
    const drive = new P.PxArticulationDrive(stiffness, damping, Math.min(most, kMost), 0 as never);
    drive.driveType = kForceDrive as never;
    this.made.setDriveParams(this.#axis, drive);
    P.destroy(drive);
  }

  /** Laws of motors, six numbers each, as PhysX's drive; returns the effort that is applied beside it. */
  prepare(drives: Float64Array[], coupled: number): number {
    const { stiffness, rest, friction } = this.joint.axes[0];
    this.#coupled = coupled;
    this.#applied = 0;
    // Beside what takes the drive, springs are explicit.
    if (this.#driver !== -1 || friction > 0) this.#applied -= stiffness * (this.q - rest);
    this.#laws = drives.map((law, m) => {
      const [bias, kp, position, kd, velocity, most] = law;
      const isTorque = kp === 0 && kd === 0;
      const direct = isTorque ? clamp(bias, most) : 0;
      this.#applied += direct;
      if (m === this.#driver && isTorque) this.#drive(0, 0, 0);
      else if (m === this.#driver) {
        this.#drive(kp, Math.min(kd, kRigid), most);
        this.made.setDriveTarget(this.#axis, kp > 0 ? position + bias / kp : 0);
        this.made.setDriveVelocity(this.#axis, kp > 0 || kd === Infinity ? velocity : velocity + bias / kd);
      }
      return { direct, law: law.slice() };
    });
    return this.#applied + coupled;
  }

  /** What PhysX has applied to the bodies, and so not to the joint. */
  get applied(): number {
    return this.effort(0) + this.#coupled;
  }
  /** What acts along the axis; CogRSim adds the efforts of couplings. `inJoint`: of PhysX's joint. */
  effort(inJoint: number): number {
    // PhysX does not tell the forces of drives of joints: by their law, at the end of the step.
    const beside = this.beside.map(([damping, most]) => clamp(-damping * this.u, most));
    return beside.reduce((sum, x) => sum + x, inJoint + this.#applied);
  }

  motorEffort(m: number, inJoint: number): number {
    const [bias, kp, position, kd, velocity, most] = this.#laws[m].law;
    const { lower, upper } = this.joint.axes[0];
    const { q, u } = this;
    if (kd !== Infinity)
      return this.#laws[m].direct || clamp(bias + kp * (position - q) + kd * (velocity - u), most);
    // At a stop it has its bound.
    if (q <= lower || q >= upper) return clamp(kRigid * (velocity - u), most);
    return clamp(inJoint, most);
  }
}

interface Link {
  link: PhysX.PxArticulationLink;
  tree: Tree;
  index: number; // in the articulation
}
interface Tree {
  articulation: PhysX.PxArticulationReducedCoordinate;
  cache?: PhysX.PxArticulationCache;
  hasBase: boolean; // its first link is not of a body
  root: number; // body, or that on which it stands
}

/** Joints by which a body hangs in an articulation, by body. */
function treeJoints(scene: Scene, attached: Set<number>): Map<number, number> {
  const out = new Map<number, number>();
  scene.joints.forEach((joint, j) => {
    const { parent, child } = joint;
    if (joint.removed || joint.type === 'free' || joint.closes_loop || joint.bodies_collide || attached.has(j))
      return;
    if (scene.bodies[child]?.kind !== 'dynamic' || out.has(child)) return;
    if (parent >= 0 && scene.bodies[parent].kind === 'kinematic') return;
    // What hangs on itself stays a loop.
    for (let b = parent; b >= 0;) {
      if (b === child) return;
      const above = out.get(b);
      if (above === undefined) break;
      b = scene.joints[above].parent;
    }
    out.set(child, j);
  });
  return out;
}

export class Articulations {
  readonly links = new Map<number, Link>(); // by body
  readonly #axes: (Axis | undefined)[] = [];
  readonly #drives: number[][] = []; // motors, by joint
  readonly #trees: Tree[] = [];
  readonly #loops: PhysX.PxJoint[] = []; // and drives, outside of trees
  readonly #joints: Map<number, number>;
  readonly #frames: Pose[] = []; // F of PhysX where that is turned, by joint

  constructor(
    readonly scene: Scene,
    readonly state: State,
    attached: Set<number>, // joints that are no tree's
    readonly setUp: (link: PhysX.PxArticulationLink, body: number) => void,
  ) {
    this.#joints = treeJoints(scene, attached);
    scene.joints.forEach((_, j) => {
      this.#drives[j] = motorsOf(scene, j);
    });
  }

  /** Bodies that are links. */
  has(b: number): boolean {
    return this.#joints.has(b) || [...this.#joints.values()].some((j) => this.scene.joints[j].parent === b);
  }

  /** Makes all trees, and puts them into the world. */
  make(world: PhysX.PxScene): void {
    const { bodies, joints } = this.scene;
    const members = bodies.map((_, b) => (bodies[b].removed ? false : this.has(b)));
    const children = new Map<number, number[]>();
    for (const [child, j] of this.#joints) {
      const { parent } = joints[j];
      children.set(parent, [...(children.get(parent) ?? []), child]);
    }
    const grow = (tree: Tree, parent: PhysX.PxArticulationLink, b: number): void => {
      const link = this.#link(tree, parent, b);
      for (const child of children.get(b) ?? []) grow(tree, link, child);
    };
    const nobody = null as unknown as PhysX.PxArticulationLink;
    members.forEach((isMember, b) => {
      if (!isMember || bodies[b].kind !== 'dynamic') return;
      const j = this.#joints.get(b);
      const parent = j === undefined ? undefined : joints[j].parent;
      if (parent !== undefined && parent >= 0 && bodies[parent].kind === 'dynamic') return;
      const tree = this.#tree(parent !== undefined, parent ?? b);
      if (parent === undefined) grow(tree, nobody, b);
      else {
        const base = this.#created(
          tree,
          nobody,
          this.#pose(parent),
          `what body '${bodies[b].name}' hangs on`,
        );
        grow(tree, base, b);
      }
      this.#start(tree, world);
    });
  }

  #pose(b: number): Pose {
    return b < 0 ? { p: [0, 0, 0], q: [1, 0, 0, 0] } : poseOf(this.state.poses, 7 * b);
  }

  #tree(hasBase: boolean, root: number): Tree {
    const { options } = this.scene;
    const articulation = physics.createArticulationReducedCoordinate();
    const { eFIX_BASE, eDRIVE_LIMITS_ARE_FORCES } = P.PxArticulationFlagEnum;
    articulation.setArticulationFlag(eFIX_BASE, hasBase);
    articulation.setArticulationFlag(eDRIVE_LIMITS_ARE_FORCES, true);
    articulation.setSolverIterationCounts(
      Number(options['position-iterations']),
      Number(options['velocity-iterations']),
    );
    articulation.setSleepThreshold(0);
    articulation.setStabilizationThreshold(0);
    const tree = { articulation, hasBase, root };
    this.#trees.push(tree);
    return tree;
  }

  #created(tree: Tree, parent: PhysX.PxArticulationLink, pose: Pose, what: string): PhysX.PxArticulationLink {
    said();
    const link = tree.articulation.createLink(parent, transform(pose));
    if (address(link) === 0)
      throw new Refusal(`PhysX has no more room in an articulation for ${what}: ${said()}`);
    return link;
  }

  #link(tree: Tree, parent: PhysX.PxArticulationLink, b: number): PhysX.PxArticulationLink {
    const { scene } = this;
    const model = scene.bodies[b];
    const link = this.#created(tree, parent, this.#pose(b), `body '${model.name}'`);
    this.links.set(b, { link, tree, index: -1 });
    this.setUp(link, b);
    const j = this.#joints.get(b);
    if (j !== undefined) this.#joint(j, link.getInboundJoint());
    return link;
  }

  #joint(j: number, made: PhysX.PxArticulationJointReducedCoordinate): void {
    const { scene, state } = this;
    const joint = scene.joints[j];
    const { parent, child } = joint;
    const M = inFrame(poseOf(joint.X_CM));
    let F = inFrame(poseOf(joint.X_PF));
    made.setFrictionCoefficient(Number(scene.options['friction-coefficient']));
    made.setMaxJointVelocity(Number(scene.options['max-joint-velocity']));
    const modes = this.#drives[j].map((m) => scene.motors[m].mode);
    const { eTWIST, eSWING1, eSWING2 } = P.PxArticulationAxisEnum;
    switch (joint.type) {
      case 'fixed':
        made.setJointType(kFix as unknown as Type);
        break;
      case 'hinge':
      case 'slider':
        this.#axes[j] = new Axis(joint, made, modes);
        this.#axes[j]!.start(state.positions[joint.position_offset], state.speeds[joint.speed_offset]);
        break;
      case 'ball': {
        // It starts where it is: PhysX has three angles, and here they are 0.
        made.setJointType(kSpherical as unknown as Type);
        const qM = multiply(this.#pose(child).q, M.q);
        const qP = this.#pose(parent).q;
        F = { p: F.p, q: multiply(conjugate(qP), qM) };
        const spin = (b: number): V3 =>
          b < 0 ? [0, 0, 0] : ([...state.twists.subarray(6 * b + 3, 6 * b + 6)] as unknown as V3);
        const rate = turn(conjugate(qM), plus(spin(child), spin(parent), -1));
        [eTWIST, eSWING1, eSWING2].forEach((axis, i) => {
          made.setMotion(axis, P.PxArticulationMotionEnum.eFREE);
          made.setJointVelocity(axis, rate[i]);
        });
        break;
      }
      default:
        throw new Refusal(`joint '${joint.name}': this adapter has no joint of the type ${joint.type}`);
    }
    this.#frames[j] = F;
    made.setParentPose(transform(F));
    made.setChildPose(transform(M));
  }

  #start(tree: Tree, world: PhysX.PxScene): void {
    const { articulation } = tree;
    said();
    if (!world.addArticulation(articulation))
      throw new Refusal(`PhysX does not take an articulation: ${said()}`);
    if (!tree.hasBase) {
      const b = tree.root;
      const twist = [0, 3].map(
        (i) => [...this.state.twists.subarray(6 * b + i, 6 * b + i + 3)] as unknown as V3,
      );
      const arm = turn(this.#pose(b).q, this.scene.bodies[b].com);
      articulation.setRootGlobalPose(transform(this.#pose(b)));
      articulation.setRootLinearVelocity(vec(plus(twist[0], cross(twist[1], arm))));
      articulation.setRootAngularVelocity(vec(twist[1]));
    }
    const { ePOSITION, eVELOCITY } = P.PxArticulationKinematicFlagEnum;
    const flags = new P.PxArticulationKinematicFlags(Number(ePOSITION) | Number(eVELOCITY));
    articulation.updateKinematic(flags);
    P.destroy(flags);
    tree.cache = articulation.createCache();
    for (const it of this.links.values()) if (it.tree === tree) it.index = it.link.getLinkIndex();
  }

  /** What is in no tree: a joint between two actors. */
  makeLoops(actorOf: (body: number) => Actor | null): void {
    const used = new Set(this.#joints.values());
    this.scene.joints.forEach((joint, j) => {
      if (joint.removed || joint.type === 'free' || used.has(j)) return;
      const bare = joint.axes.every(
        (axis) =>
          axis.lower === -Infinity &&
          axis.upper === Infinity &&
          !(axis.damping > 0) &&
          !(axis.friction > 0) &&
          !(axis.stiffness > 0) &&
          !(axis.rotor_inertia > 0),
      );
      if (!bare || this.#drives[j].length > 0) {
        throw new Refusal(
          `joint '${joint.name}': on PhysX joints that close loops, that hang on driven bodies, or whose bodies ` +
            'collide are bare: no motor, limit, spring, damper, friction or rotor',
        );
      }
      const create = {
        fixed: P.FixedJointCreate,
        hinge: P.RevoluteJointCreate,
        slider: P.PrismaticJointCreate,
        ball: P.SphericalJointCreate,
      }[joint.type as 'fixed' | 'hinge' | 'slider' | 'ball'] as typeof P.FixedJointCreate | undefined;
      if (!create)
        throw new Refusal(`joint '${joint.name}': this adapter has no joint of the type ${joint.type}`);
      const made = this.#between(create, joint, actorOf);
      if (address(made) === 0) throw new Refusal(`joint '${joint.name}': PhysX does not take it: ${said()}`);
      made.setConstraintFlag(P.PxConstraintFlagEnum.eCOLLISION_ENABLED, joint.bodies_collide);
      this.#loops.push(made);
    });
    this.#axes.forEach((axis, j) => {
      for (const [damping, most] of axis?.beside ?? []) this.#addDrive(j, damping, most, actorOf);
    });
  }

  #between<T extends PhysX.PxJoint>(
    create: (physics: PhysX.PxPhysics, a: Actor, F: PhysX.PxTransform, b: Actor, M: PhysX.PxTransform) => T,
    joint: Joint,
    actorOf: (body: number) => Actor | null,
  ): T {
    const [F, M] = [joint.X_PF, joint.X_CM].map((pose) => {
      const { p, q } = inFrame(poseOf(pose));
      const [v, r] = [new P.PxVec3(...p), new P.PxQuat(q[1], q[2], q[3], q[0])];
      const out = new P.PxTransform(v, r);
      P.destroy(v);
      P.destroy(r);
      return out;
    });
    const made = create(physics, actorOf(joint.parent) as Actor, F, actorOf(joint.child) as Actor, M);
    P.destroy(F);
    P.destroy(M);
    return made;
  }

  /** An axis has one drive in an articulation: another is that of a joint that holds nothing. */
  #addDrive(j: number, damping: number, most: number, actorOf: (body: number) => Actor | null): void {
    const joint = this.scene.joints[j];
    const { PxD6AxisEnum, PxD6DriveEnum, PxD6MotionEnum } = P;
    const made = this.#between(P.D6JointCreate, joint, actorOf);
    if (address(made) === 0) throw new Refusal(`joint '${joint.name}': PhysX does not take it: ${said()}`);
    const { eX, eY, eZ, eTWIST, eSWING1, eSWING2 } = PxD6AxisEnum;
    for (const axis of [eX, eY, eZ, eTWIST, eSWING1, eSWING2]) made.setMotion(axis, PxD6MotionEnum.eFREE);
    const drive = new P.PxD6JointDrive(0, damping, most, false);
    made.setDrive(joint.type === 'hinge' ? PxD6DriveEnum.eTWIST : PxD6DriveEnum.eX, drive);
    P.destroy(drive);
    made.setConstraintFlag(P.PxConstraintFlagEnum.eDRIVE_LIMITS_ARE_FORCES, true);
    made.setConstraintFlag(P.PxConstraintFlagEnum.eCOLLISION_ENABLED, joint.bodies_collide);
    this.#loops.push(made);
  }

  /** Sets drives, and applies what is beside them. */
  prepare(
    drives: Float64Array,
    efforts: Float64Array | null,
    apply: (body: number, force: V3, torque: V3) => void,
  ): void {
    this.scene.joints.forEach((joint, j) => {
      const axis = this.#axes[j];
      if (!axis) return;
      const own = this.#drives[j].map((m) => drives.subarray(6 * m, 6 * m + 6));
      const effort = axis.prepare(own, efforts ? efforts[joint.speed_offset] : 0);
      if (effort === 0) return;
      const [child, parent] = [this.motionOf(joint.child), this.motionOf(joint.parent)];
      const along = turn(multiply(parent.q, joint.X_PF.slice(3) as Q4), [0, 0, effort]);
      if (joint.type === 'hinge') {
        apply(joint.child, [0, 0, 0], along);
        apply(joint.parent, [0, 0, 0], scale(-1, along));
        return;
      }
      const at = plus(child.p, turn(child.q, joint.X_CM.slice(0, 3) as V3));
      apply(joint.child, along, cross(plus(at, child.com, -1), along));
      apply(joint.parent, scale(-1, along), cross(plus(at, parent.com, -1), scale(-1, along)));
    });
  }

  motionOf: (body: number) => Pose & { com: V3 } = () => ({ p: [0, 0, 0], q: [1, 0, 0, 0], com: [0, 0, 0] });

  /** What joints exert on their children in the last step, in the frames of PhysX. */
  #incoming(): Map<number, [V3, V3]> {
    const flags = new P.PxArticulationCacheFlags(
      P.PxArticulationCacheFlagEnum.eLINK_INCOMING_JOINT_FORCE as never,
    );
    for (const { articulation, cache } of this.#trees) articulation.copyInternalStateToCache(cache!, flags);
    P.destroy(flags);
    const out = new Map<number, [V3, V3]>();
    for (const [b, j] of this.#joints) {
      const it = this.links.get(b);
      if (!it) continue;
      const at = address(it.tree.cache!.linkIncomingJointForce) + 4 * kSpatial * it.index;
      out.set(j, [vectorAt(at), vectorAt(at + 16)]);
    }
    return out;
  }

  efforts(joints: Float64Array, motors: Float64Array): void {
    if (this.#axes.length === 0) return;
    const incoming = this.#incoming();
    this.scene.joints.forEach((joint, j) => {
      const axis = this.#axes[j];
      const wrench = incoming.get(j);
      if (!axis || !wrench) return;
      const inJoint = wrench[joint.type === 'hinge' ? 1 : 0][0];
      joints[joint.speed_offset] = axis.effort(inJoint);
      this.#drives[j].forEach((m, i) => (motors[m] = axis.motorEffort(i, inJoint)));
    });
  }

  reactions(out: Float64Array): void {
    const incoming = this.#incoming();
    for (const [j, wrench] of incoming) {
      const joint = this.scene.joints[j];
      wrench[joint.type === 'hinge' ? 1 : 0][0] += this.#axes[j]?.applied ?? 0;
      const q = multiply(this.motionOf(joint.child).q, inFrame(poseOf(joint.X_CM)).q);
      out.set([...turn(q, wrench[0]), ...turn(q, wrench[1])], 6 * j);
    }
  }

  free(): void {
    for (const joint of this.#loops) joint.release();
    for (const { articulation, cache } of this.#trees) {
      cache?.release();
      articulation.release();
    }
  }
}
