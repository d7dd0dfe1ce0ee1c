// Joints of the scene as Jolt's constraints, and the drives on their axes.
import { J, type Jolt, perpendicular, record, vec, xyz } from './engine.ts';
import { Refusal, type Joint, type Scene } from './cogrsim_backend.mjs';
import {
  conjugate,
  cross,
  dot,
  multiply,
  plus,
  scale,
  turn,
  type Q4,
  type V3,
} from './math.ts';
import { motorsOf } from './scene.ts';

/** Where a body is and how it moves, at its centre of mass. */
export interface Motion {
  p: V3;
  q: Q4;
  v: V3;
  w: V3;
}

/** An effort that is taken at the end of the step: `effort` - `damping` u, within +-`most`. */
interface Law {
  effort: number;
  damping: number;
  most: number;
}

const kTurn = 2 * Math.PI;
/** Jolt's own "no bound of the force". */
const kMost = 3.4e38;
const kX: V3 = [1, 0, 0];
const kY: V3 = [0, 1, 0];
const kZ: V3 = [0, 0, 1];

type Made = Jolt.HingeConstraint | Jolt.SliderConstraint;

/** Frame F or M against the centre of mass of its body: origin, x, y and z. */
export interface Frame {
  p: V3;
  q: Q4;
}

/** Turned by `angle` about its z. */
const turnedBy = (q: Q4, angle: number): Q4 => multiply(q, [Math.cos(angle / 2), 0, 0, Math.sin(angle / 2)]);

/** A constraint between two bodies, with a reference of its own that the caller releases. */
function make(
  joint: Joint,
  bodies: [Jolt.Body, Jolt.Body],
  [F, M]: [Frame, Frame],
  zero: number,
): Jolt.Constraint {
  let settings: Jolt.TwoBodyConstraintSettings;
  switch (joint.type) {
    case 'hinge': {
      const it = new J.HingeConstraintSettings();
      const q = [turnedBy(F.q, zero), M.q];
      it.mPoint1 = new J.RVec3(...F.p);
      it.mPoint2 = new J.RVec3(...M.p);
      it.mHingeAxis1 = vec(turn(F.q, kZ));
      it.mHingeAxis2 = vec(turn(M.q, kZ));
      it.mNormalAxis1 = vec(turn(q[0], kX));
      it.mNormalAxis2 = vec(turn(q[1], kX));
      it.mSpace = J.EConstraintSpace_LocalToBodyCOM;
      settings = it;
      break;
    }
    case 'slider': {
      const it = new J.SliderConstraintSettings();
      it.mAutoDetectPoint = false;
      it.mPoint1 = new J.RVec3(...plus(F.p, turn(F.q, kZ), zero));
      it.mPoint2 = new J.RVec3(...M.p);
      it.mSliderAxis1 = vec(turn(F.q, kZ));
      it.mSliderAxis2 = vec(turn(M.q, kZ));
      it.mNormalAxis1 = vec(turn(F.q, kX));
      it.mNormalAxis2 = vec(turn(M.q, kX));
      it.mSpace = J.EConstraintSpace_LocalToBodyCOM;
      settings = it;
      break;
    }
    case 'fixed': {
      const it = new J.FixedConstraintSettings();
      it.mAutoDetectPoint = false;
      it.mPoint1 = new J.RVec3(...F.p);
      it.mPoint2 = new J.RVec3(...M.p);
      it.mAxisX1 = vec(turn(F.q, kX));
      it.mAxisX2 = vec(turn(M.q, kX));
      it.mAxisY1 = vec(turn(F.q, kY));
      it.mAxisY2 = vec(turn(M.q, kY));
      it.mSpace = J.EConstraintSpace_LocalToBodyCOM;
      settings = it;
      break;
    }
    case 'ball': {
      const it = new J.PointConstraintSettings();
      it.mPoint1 = new J.RVec3(...F.p);
      it.mPoint2 = new J.RVec3(...M.p);
      it.mSpace = J.EConstraintSpace_LocalToBodyCOM;
      settings = it;
      break;
    }
    default:
      throw new Refusal(`joint '${joint.name}': this adapter has no joint of the type ${joint.type}`);
  }
  settings.AddRef();
  const made = settings.Create(...bodies);
  made.AddRef();
  settings.Release();
  return made;
}

/**
 * The coordinate at which Jolt's own is 0. Its angles are those of one turn, its lower limits are in
 * -pi..0 and its upper ones in 0..pi: both limits are seen at the same distance from the middle.
 */
function zeroOf(joint: Joint): number {
  const { lower, upper } = joint.axes[0];
  if (joint.type === 'slider') return Math.min(Math.max(0, lower), upper);
  if (lower === -Infinity) return upper === Infinity ? 0 : upper;
  if (upper === Infinity) return lower;
  const turns = Math.floor((upper - lower) / kTurn);
  return (lower + upper) / 2 + turns * Math.PI;
}

/** A hinge or slider: where it stands, and what acts along it in a step. */
class Axis {
  q = 0;
  u = 0;
  readonly zero: number;
  axis: V3 = kZ; // in the world
  #rows: Made[] = []; // the joint itself, and those beside it with one motor each
  readonly #of: { passive?: number; friction?: number } = {}; // by row
  readonly #ofMotors: (number | undefined)[]; // those with gains
  #applied = 0; // torque or force over the last step that is no row's
  #direct: number[] = []; // the parts of motors in it
  #coupled = 0; // and that of couplings
  readonly #isWide: boolean; // hinge with limits that Jolt does not have
  #limits = [NaN, NaN];

  constructor(
    readonly joint: Joint,
    modes: string[], // of its motors
    create: (zero: number) => Jolt.Constraint,
  ) {
    const { lower, upper, damping, friction, stiffness, rotor_inertia } = joint.axes[0];
    this.zero = zeroOf(joint);
    const isLimited = lower !== -Infinity || upper !== Infinity;
    this.#isWide = isLimited && joint.type === 'hinge' && !(upper - lower < 0.9 * kTurn);
    let rows = 0;
    this.#ofMotors = modes.map((mode) => (mode === 'torque' ? undefined : rows++));
    if (damping > 0 || stiffness > 0 || rotor_inertia > 0) this.#of.passive = rows++;
    if (friction > 0) this.#of.friction = rows++;
    for (let r = 0; r < Math.max(1, rows); ++r) {
      const made = create(this.zero);
      const row: Made = J.castObject(made, joint.type === 'hinge' ? J.HingeConstraint : J.SliderConstraint);
      this.#rows.push(row);
      row.GetMotorSettings().mSpringSettings.mMode = J.ESpringMode_StiffnessAndDamping;
    }
    if (this.#of.friction !== undefined) {
      const row = this.#rows[this.#of.friction];
      if ('SetMaxFrictionTorque' in row) row.SetMaxFrictionTorque(friction);
      else row.SetMaxFrictionForce(friction);
    }
    if (isLimited && !this.#isWide) {
      this.#rows[0].SetLimits(Math.max(lower - this.zero, -kMost), Math.min(upper - this.zero, kMost));
    }
  }

  get constraints(): Made[] {
    return this.#rows;
  }

  /** Coordinate and speed from the motions of the bodies; full turns follow the last coordinate. */
  read(parent: Motion, child: Motion, [F, M]: [Frame, Frame]): void {
    const qF = multiply(parent.q, F.q);
    this.axis = turn(qF, kZ);
    const [armF, armM] = [turn(parent.q, F.p), turn(child.q, M.p)];
    if (this.joint.type === 'hinge') {
      const relative = multiply(conjugate(qF), multiply(child.q, M.q));
      const angle = 2 * Math.atan2(relative[3], relative[0]);
      this.q = angle + kTurn * Math.round((this.q - angle) / kTurn);
      this.u = dot(this.axis, plus(child.w, parent.w, -1));
      return;
    }
    const offset = plus(plus(child.p, armM), plus(parent.p, armF), -1);
    this.q = dot(this.axis, offset);
    const there = plus(parent.v, cross(parent.w, plus(armF, offset)));
    this.u = dot(this.axis, plus(plus(child.v, cross(child.w, armM)), there, -1));
  }

  /** Jolt's angle of one turn. */
  #own(): number {
    const angle = this.q - this.zero;
    return this.joint.type === 'hinge' ? angle - kTurn * Math.round(angle / kTurn) : angle;
  }

  /**
   * Jolt's stops have the angles of one turn: of limits that are wider, each is set where it is near, as no
   * other turn has it.
   */
  #setLimits(dt: number): void {
    if (!this.#isWide) return;
    const { lower, upper } = this.joint.axes[0];
    const near = Math.min(2, 1 + 2 * Math.abs(this.u) * dt);
    const stop = (at: number, open: number): number =>
      Math.abs(at - this.q) < near ? this.#own() + at - this.q : open;
    const limits = [Math.min(0, stop(lower, -Math.PI)), Math.max(0, stop(upper, Math.PI))];
    if (limits.every((x, i) => x === this.#limits[i])) return;
    this.#limits = limits;
    this.#rows[0].SetLimits(limits[0], limits[1]);
  }

  /** A law as the motor of a row: Jolt has springs and dampers implicit. */
  #put(index: number, { effort, damping, most }: Law, dt: number): void {
    const row = this.#rows[index];
    const motor = row.GetMotorSettings();
    const bound = Math.min(most, kMost);
    if ('SetTargetAngle' in row) [motor.mMinTorqueLimit, motor.mMaxTorqueLimit] = [-bound, bound];
    else [motor.mMinForceLimit, motor.mMaxForceLimit] = [-bound, bound];
    if (!(damping > 0)) return row.SetMotorState(J.EMotorState_Off);
    if (damping === Infinity) {
      if ('SetTargetAngle' in row) row.SetTargetAngularVelocity(effort);
      else row.SetTargetVelocity(effort);
      return row.SetMotorState(J.EMotorState_Velocity);
    }
    // A spring that is stretched by less than half a turn.
    const stiffness = Math.max(Math.abs(effort) / 3, (1e-3 * damping) / dt);
    motor.mSpringSettings.mStiffness = stiffness;
    motor.mSpringSettings.mDamping = Math.max(0, damping - dt * stiffness);
    const target = this.#own() + effort / stiffness;
    if ('SetTargetAngle' in row) row.SetTargetAngle(target);
    else row.SetTargetPosition(target);
    row.SetMotorState(J.EMotorState_Position);
  }

  /** Before a step; returns the effort that is to be applied over it. */
  prepare(dt: number, drives: Float64Array[], coupled: number): number {
    this.#setLimits(dt);
    const { stiffness, damping, rest, rotor_inertia } = this.joint.axes[0];
    if (this.#of.passive !== undefined) {
      const inertia = rotor_inertia / dt;
      const law = {
        effort: inertia * this.u - stiffness * (this.q - rest),
        damping: inertia + damping + dt * stiffness,
        most: Infinity,
      };
      this.#put(this.#of.passive, law, dt);
    }
    this.#direct = drives.map(([bias, kp, position, kd, velocity, most], m) => {
      const row = this.#ofMotors[m];
      const law =
        kd === Infinity
          ? { effort: velocity, damping: kd, most }
          : { effort: bias + kp * (position - this.q) + kd * velocity, damping: kd + dt * kp, most };
      if (row !== undefined) this.#put(row, law, dt);
      return row !== undefined && law.damping > 0 ? 0 : Math.min(Math.max(bias, -most), most);
    });
    this.#coupled = coupled;
    this.#applied = this.#direct.reduce((sum, effort) => sum + effort, 0);
    return this.#applied + coupled;
  }

  motorEffort(m: number, dt: number): number {
    const row = this.#ofMotors[m];
    return (this.#direct[m] ?? 0) + (row === undefined ? 0 : this.#rows[row].GetTotalLambdaMotor() / dt);
  }

  /** Of motors, springs, dampers, friction and the stops; CogRSim adds those of couplings. */
  effort(dt: number): number {
    return this.#applied + this.#impulse() / dt;
  }

  #impulse(): number {
    const [first] = this.#rows;
    const stop =
      'GetTotalLambdaRotationLimits' in first
        ? first.GetTotalLambdaRotationLimits()
        : first.GetTotalLambdaPositionLimits();
    return this.#rows.reduce((sum, row) => sum + row.GetTotalLambdaMotor(), stop);
  }

  /** Force and torque on the child about its frame, with all along the axis; `q` of F and M as the step had them. */
  reaction(dt: number, q: [Q4, Q4]): number[] {
    let [force, torque]: [V3, V3] = [
      [0, 0, 0],
      [0, 0, 0],
    ];
    const [axis1, axis2] = q.map((it) => turn(it, kZ));
    for (const row of this.#rows) {
      if ('GetTotalLambdaRotationLimits' in row) {
        force = plus(force, xyz(row.GetTotalLambdaPosition()));
        const lambda = row.GetTotalLambdaRotation();
        const b = perpendicular(axis2);
        torque = plus(torque, cross(b, axis1), lambda.GetComponent(0));
        torque = plus(torque, cross(cross(axis2, b), axis1), lambda.GetComponent(1));
      } else {
        const n1 = perpendicular(axis1);
        const lambda = row.GetTotalLambdaPosition();
        const side = plus(scale(lambda.GetComponent(0), n1), cross(axis1, n1), lambda.GetComponent(1));
        force = plus(force, side);
        torque = plus(torque, xyz(row.GetTotalLambdaRotation()));
      }
    }
    const along = this.#impulse() + (this.#applied + this.#coupled) * dt;
    if (this.joint.type === 'hinge') torque = plus(torque, axis1, along);
    else force = plus(force, axis1, along);
    return [...force, ...torque].map((x) => x / dt);
  }
}

/** Fixed joints have no getter of their impulses: their saved state ends with them. */
function fixedReaction(made: Jolt.Constraint, dt: number): number[] {
  const bytes = record((recorder) => made.SaveState(recorder));
  const numbers = Array.from({ length: 6 }, (_, i) => bytes.readFloatLE(bytes.length - 24 + 4 * i) / dt);
  return [...numbers.slice(3), ...numbers.slice(0, 3)];
}

export class Joints {
  readonly axes: (Axis | undefined)[] = []; // by joint
  readonly #frames: [Frame, Frame][] = [];
  readonly #made: (Jolt.Constraint[] | undefined)[] = [];
  readonly #drives: number[][] = []; // motors, by joint

  constructor(
    readonly scene: Scene,
    readonly system: Jolt.PhysicsSystem,
    bodyOf: (index: number) => Jolt.Body,
    comOf: (index: number) => V3,
  ) {
    scene.joints.forEach((joint, j) => {
      const frame = (pose: readonly number[], body: number): Frame => ({
        p: plus(pose.slice(0, 3) as V3, comOf(body), -1),
        q: pose.slice(3) as Q4,
      });
      this.#frames[j] = [frame(joint.X_PF, joint.parent), frame(joint.X_CM, joint.child)];
      this.#drives[j] = motorsOf(scene, j);
      if (joint.removed || joint.type === 'free') return;
      const made: Jolt.Constraint[] = [];
      const create = (zero: number): Jolt.Constraint => {
        const it = make(joint, [bodyOf(joint.parent), bodyOf(joint.child)], this.#frames[j], zero);
        system.AddConstraint(it);
        made.push(it);
        return it;
      };
      if (joint.type !== 'hinge' && joint.type !== 'slider') create(0);
      else {
        const modes = this.#drives[j].map((m) => scene.motors[m].mode);
        this.axes[j] = new Axis(joint, modes, create);
      }
      this.#made[j] = made;
    });
  }

  read(motionOf: (body: number) => Motion, positions?: Float64Array): void {
    this.scene.joints.forEach((joint, j) => {
      const axis = this.axes[j];
      if (!axis) return;
      if (positions) axis.q = positions[joint.position_offset];
      axis.read(motionOf(joint.parent), motionOf(joint.child), this.#frames[j]);
    });
  }

  /** Sets motors, and has `apply` put what is no constraint on child and parent. */
  prepare(
    dt: number,
    drives: Float64Array,
    efforts: Float64Array | null,
    motionOf: (body: number) => Motion,
    apply: (body: number, force: V3, torque: V3) => void,
  ): void {
    this.scene.joints.forEach((joint, j) => {
      const axis = this.axes[j];
      if (!axis) return;
      const own = this.#drives[j].map((m) => drives.subarray(6 * m, 6 * m + 6));
      const effort = axis.prepare(dt, own, efforts ? efforts[joint.speed_offset] : 0);
      if (effort === 0) return;
      const along = scale(effort, axis.axis);
      if (joint.type === 'hinge') {
        apply(joint.child, [0, 0, 0], along);
        apply(joint.parent, [0, 0, 0], scale(-1, along));
        return;
      }
      const child = motionOf(joint.child);
      const arm = turn(child.q, this.#frames[j][1].p);
      apply(joint.child, along, cross(arm, along));
      const parentArm = plus(plus(child.p, arm), motionOf(joint.parent).p, -1);
      const back = scale(-1, along);
      apply(joint.parent, back, cross(parentArm, back));
    });
  }

  efforts(dt: number, joints: Float64Array, motors: Float64Array): void {
    this.scene.joints.forEach((joint, j) => {
      const axis = this.axes[j];
      if (!axis) return;
      joints[joint.speed_offset] = axis.effort(dt);
      this.#drives[j].forEach((m, i) => (motors[m] = axis.motorEffort(i, dt)));
    });
  }

  /** `motionOf`: as they were when the step began. */
  reactions(dt: number, motionOf: (body: number) => Motion, out: Float64Array): void {
    this.scene.joints.forEach((joint, j) => {
      const made = this.#made[j];
      if (!made) return;
      const [parent, child] = [motionOf(joint.parent), motionOf(joint.child)];
      const [F, M] = this.#frames[j];
      const q: [Q4, Q4] = [multiply(parent.q, F.q), multiply(child.q, M.q)];
      const axis = this.axes[j];
      if (axis) out.set(axis.reaction(dt, q), 6 * j);
      else if (joint.type === 'fixed') out.set(fixedReaction(made[0], dt), 6 * j);
      else {
        const lambda = xyz(J.castObject(made[0], J.PointConstraint).GetTotalLambdaPosition());
        out.set(
          lambda.map((x) => x / dt),
          6 * j,
        );
      }
    });
  }

  free(): void {
    for (const made of this.#made) for (const it of made ?? []) it.Release();
  }
}
