// Joints of the scene as Rapier's impulse joints, and the drives on their axes.
import RAPIER from '@dimforge/rapier3d-compat';

import { Refusal, type Joint, type Scene, type State } from './cogrsim_backend.mjs';
import { xyz, xyzw } from './convert.ts';
import { conjugate, cross, dot, multiply, plus, poseOf, turn, type Q4, type V3 } from './math.ts';

/** Rapier's joints turn about and slide along x of their frames, those of scenes z. */
const kXToZ: Q4 = [Math.SQRT1_2, 0, -Math.SQRT1_2, 0];
/** Rapier's own "no limit of the force". */
const kMostForce = 3.4e38;
/** Damping of a source of speed: rigid, as far as single precision tells. */
const kRigid = 1e9;
/** Limits of a hinge that do nothing: a turn apart and more, without a word. */
const kNoLimits = 4;

const frame = (pose: readonly number[]): [RAPIER.Vector, RAPIER.Rotation] => [
  xyz(pose),
  xyzw(multiply(pose.slice(3) as Q4, kXToZ)),
];

function dataOf(joint: Joint): RAPIER.JointData {
  const zero = { x: 0, y: 0, z: 0 };
  switch (joint.type) {
    case 'fixed':
      return RAPIER.JointData.fixed(zero, xyzw([1, 0, 0, 0]), zero, xyzw([1, 0, 0, 0]));
    case 'hinge':
      return RAPIER.JointData.revolute(zero, zero, { x: 1, y: 0, z: 0 });
    case 'slider':
      return RAPIER.JointData.prismatic(zero, zero, { x: 1, y: 0, z: 0 });
    case 'ball':
      return RAPIER.JointData.spherical(zero, zero);
    default:
      throw new Refusal(`joint '${joint.name}': Rapier has no joint of the type ${joint.type}`);
  }
}

/** Those of Rapier's motors that act on an axis. */
interface Motors {
  drive?: RAPIER.UnitImpulseJoint;
  friction?: RAPIER.UnitImpulseJoint;
  passive?: RAPIER.UnitImpulseJoint; // damper and rotor
}

/** A joint with an axis: where it stands, and what acts along it in a step. */
export class Axis {
  q = 0;
  u = 0;
  #axis: V3 = [0, 0, 1]; // in the world
  #point: V3 = [0, 0, 0];
  #dt = 0; // that `#rotor` is of
  #rotor = 0; // the damper that is the rotor
  #isDriven = false; // by a law with gains, in this step
  #held?: number[]; // the limits that Rapier has now

  constructor(
    readonly joint: Joint,
    readonly made: RAPIER.UnitImpulseJoint,
    readonly motors: Motors,
    readonly inertia: number, // of what the axis moves, see inertiaOn
  ) {
    motors.friction?.setMotorMaxForce(joint.axes[0].friction);
    motors.friction?.configureMotor(0, 0, 0, kRigid);
  }

  #motor(position: number, velocity: number, kp: number, kd: number, most: number): void {
    this.motors.drive?.setMotorMaxForce(Math.min(most, kMostForce));
    this.motors.drive?.configureMotor(position, velocity, kp, kd);
  }

  /** Coordinate and speed from the motions of the bodies; full turns follow the last coordinate. */
  read(): void {
    const parent = this.made.body1();
    const child = this.made.body2();
    const [qp, qc] = [parent.rotation(), child.rotation()];
    const P: Q4 = [qp.w, qp.x, qp.y, qp.z];
    const C: Q4 = [qc.w, qc.x, qc.y, qc.z];
    const F = multiply(P, this.joint.X_PF.slice(3) as Q4);
    const M = multiply(C, this.joint.X_CM.slice(3) as Q4);
    const at = (body: RAPIER.RigidBody, q: Q4, pose: readonly number[]): V3 => {
      const p = body.translation();
      return plus([p.x, p.y, p.z], turn(q, pose.slice(0, 3) as V3));
    };
    this.#axis = turn(F, [0, 0, 1]);
    this.#point = at(child, C, this.joint.X_CM);
    if (this.joint.type === 'hinge') {
      const relative = multiply(conjugate(F), M);
      const angle = 2 * Math.atan2(relative[3], relative[0]);
      this.q = angle + 2 * Math.PI * Math.round((this.q - angle) / (2 * Math.PI));
      const [wp, wc] = [parent.angvel(), child.angvel()];
      this.u = dot(this.#axis, [wc.x - wp.x, wc.y - wp.y, wc.z - wp.z]);
      return;
    }
    this.q = dot(this.#axis, plus(this.#point, at(parent, P, this.joint.X_PF), -1));
    const [vp, vc] = [parent, child].map((body) => body.velocityAtPoint(xyz(this.#point)));
    this.u = dot(this.#axis, [vc.x - vp.x, vc.y - vp.y, vc.z - vp.z]);
  }

  /**
   * Before a step. Rapier's angles of a hinge are between -pi and pi around the middle of its limits, which so
   * must be less than a turn apart: of others it has the one that is near, and one that is not met. Nothing
   * turns by more than pi/4 in a step.
   */
  setLimits(): void {
    const { lower, upper } = this.joint.axes[0];
    if (lower === -Infinity && upper === Infinity) return;
    let limits: [number, number];
    if (this.joint.type === 'slider') limits = [Math.max(lower, -kMostForce), Math.min(upper, kMostForce)];
    else if (upper - lower < 2 * Math.PI) limits = [lower, upper];
    else if (this.q > upper - Math.PI / 2) limits = [upper - 1.5 * Math.PI, upper];
    else if (this.q < lower + Math.PI / 2) limits = [lower, lower + 1.5 * Math.PI];
    else limits = [-kNoLimits, kNoLimits];
    if (this.#held?.every((x, i) => x === limits[i])) return;
    this.#held = limits;
    this.made.setLimits(...limits);
  }

  /**
   * Before a step of n substeps of h = dt / n: the damper d of the axis, and the inertia R of its rotor as a damper c towards
   * the speed at the start of the step, both implicit in each substep. Under a force F a mass m then gains
   * F / c (1 - (1 + c h / m)^-n), and with the rotor it shall gain F dt / (m + R): between R / dt (a large R) and
   * 2 n / (n + 1) times that c is found by halving.
   */
  setPassive(dt: number, n: number): void {
    if (!this.motors.passive) return;
    if (dt !== this.#dt) this.#rotor = this.#rotorDamping(dt, n);
    this.#dt = dt;
    const { damping } = this.joint.axes[0];
    this.motors.passive.configureMotorVelocity(
      (this.#rotor * this.u) / (this.#rotor + damping),
      this.#rotor + damping,
    );
  }

  #rotorDamping(dt: number, n: number): number {
    const R = this.joint.axes[0].rotor_inertia;
    const m = this.inertia;
    let [low, high] = [R / dt, (2 * R) / dt];
    for (let i = 0; i < 20 && R > 0; ++i) {
      const c = (low + high) / 2;
      if (1 - (1 + (c * dt) / (n * m)) ** -n > (c * dt) / (m + R)) low = c;
      else high = c;
    }
    return low;
  }

  /** The law of a motor, six numbers at `at`, as Rapier's motor; returns the effort beside it. */
  drive(drives: Float64Array, at: number): number {
    const [bias, kp, position, kd, velocity, most] = drives.subarray(at, at + 6);
    if (kp === 0 && kd === 0) return Math.min(Math.max(bias, -most), most);
    this.#isDriven = true;
    if (kd === Infinity) {
      this.#motor(0, velocity, 0, kRigid, most);
      return 0;
    }
    if (kp === 0) {
      this.#motor(0, velocity + bias / kd, 0, kd, most);
      return 0;
    }
    let error = position + bias / kp - this.q;
    let gain = kp;
    if (this.joint.type === 'hinge' && Math.abs(error) > 3) {
      // Rapier goes the shorter way round: the same effort from a nearer target.
      gain = (kp * Math.abs(error)) / 3;
      error = 3 * Math.sign(error);
    }
    // Its angles are those of one turn.
    const turns = this.joint.type === 'hinge' ? 2 * Math.PI * Math.round(this.q / (2 * Math.PI)) : 0;
    this.#motor(this.q - turns + error, velocity, gain, kd, most);
    return 0;
  }

  /** After drive(): the effort of the spring. */
  spring(): number {
    // A motor without gains holds rigidly if its force has no bound.
    if (!this.#isDriven) this.#motor(0, 0, 0, 0, 0);
    this.#isDriven = false;
    const { stiffness, rest } = this.joint.axes[0];
    return -stiffness * (this.q - rest);
  }

  /** Applies an effort along the axis to both bodies until forces are reset. */
  apply(effort: number): void {
    if (effort === 0) return;
    const [a, p] = [this.#axis, xyz(this.#point)];
    const on = (body: RAPIER.RigidBody, e: number): void => {
      const f = { x: e * a[0], y: e * a[1], z: e * a[2] };
      if (!body.isDynamic()) return;
      if (this.joint.type === 'hinge') body.addTorque(f, true);
      else body.addForceAtPoint(f, p, true);
    };
    on(this.made.body2(), effort);
    on(this.made.body1(), -effort);
  }
}

/** Inertia along the axis of a joint of what it moves, the other joints held; of two parts that are free the reduced one. */
function inertiaOn(scene: Scene, state: State, joint: Joint): number {
  const links = scene.joints.filter((it) => it !== joint && !it.removed && it.type !== 'free');
  const isFree = (b: number): boolean => scene.bodies[b]?.kind === 'dynamic';
  const { p, q } = poseOf(state.poses, 7 * joint.child);
  const at = plus(p, turn(q, joint.X_CM.slice(0, 3) as V3));
  const axis = turn(multiply(q, joint.X_CM.slice(3) as Q4), [0, 0, 1]);
  const part = (first: number): number => {
    const found = new Set([first]);
    for (const b of found) {
      if (!isFree(b)) return Infinity;
      for (const { parent, child } of links) {
        if (parent === b) found.add(child);
        if (child === b) found.add(parent);
      }
    }
    let sum = 0;
    for (const b of found) {
      const { mass, com, inertia } = scene.bodies[b];
      const body = poseOf(state.poses, 7 * b);
      const local = turn(conjugate(body.q), axis);
      const arm = cross(axis, plus(plus(body.p, turn(body.q, com)), at, -1));
      const about = dot(local, [0, 3, 6].map((r) => dot(inertia.slice(r, r + 3) as V3, local)) as V3);
      sum += joint.type === 'slider' ? mass : about + mass * dot(arm, arm);
    }
    return sum;
  };
  const [a, b] = [part(joint.parent), part(joint.child)];
  return a === Infinity ? b : b === Infinity ? a : (a * b) / (a + b);
}

export interface Joints {
  handles: number[][]; // by joint, with those that Rapier has for its further motors
  axes: (Axis | undefined)[]; // by joint
}

/** Makes the joints between `bodyOf`, or takes those that are known. */
export function makeJoints(
  world: RAPIER.World,
  scene: Scene,
  bodyOf: (index: number) => RAPIER.RigidBody,
  state: State,
  known?: { joints: number[][]; inertias: (number | null)[] },
): Joints {
  const driven = new Set<number>();
  const taken = new Set<number>();
  for (const { removed, joint, mode } of scene.motors) {
    if (removed) continue;
    driven.add(joint);
    if (mode === 'torque') continue;
    if (taken.has(joint)) {
      throw new Refusal(`joint '${scene.joints[joint].name}': Rapier has one motor on an axis, beside torques`);
    }
    taken.add(joint);
  }
  const out: Joints = { handles: [], axes: [] };
  scene.joints.forEach((joint, j) => {
    const all: number[] = [];
    out.handles.push(all);
    out.axes.push(undefined);
    if (joint.removed || joint.type === 'free') return;
    const make = (): RAPIER.ImpulseJoint => {
      const handle = known?.joints[j][all.length];
      const it =
        handle === undefined
          ? world.createImpulseJoint(dataOf(joint), bodyOf(joint.parent), bodyOf(joint.child), true)
          : world.getImpulseJoint(handle);
      all.push(it.handle);
      if (handle !== undefined) return it;
      it.setLocalFrame1(...frame(joint.X_PF));
      it.setLocalFrame2(...frame(joint.X_CM));
      it.setContactsEnabled(joint.bodies_collide);
      return it;
    };
    const made = make() as RAPIER.UnitImpulseJoint;
    if (joint.type !== 'hinge' && joint.type !== 'slider') return;
    // A joint has one motor in Rapier: what else acts on the axis has that of a second joint, or of a third.
    let isFree = true;
    const motorIf = (needed: boolean): RAPIER.UnitImpulseJoint | undefined => {
      if (!needed) return undefined;
      const it = isFree ? made : (make() as RAPIER.UnitImpulseJoint);
      isFree = false;
      it.configureMotorModel(RAPIER.MotorModel.ForceBased);
      return it;
    };
    const { friction, damping, rotor_inertia } = joint.axes[0];
    const motors: Motors = {
      drive: motorIf(driven.has(j)),
      friction: motorIf(friction > 0),
      passive: motorIf(damping > 0 || rotor_inertia > 0),
    };
    out.axes[j] = new Axis(
      joint,
      made,
      motors,
      rotor_inertia > 0 ? (known?.inertias[j] ?? inertiaOn(scene, state, joint)) : 0,
    );
  });
  return out;
}
