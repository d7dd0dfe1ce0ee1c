// Motors as MuJoCo's actuators, whose gains are given in each step.
import { type MjData, type MjModel, mujoco } from './engine.ts';
import type { Program } from './mjcf.ts';
import type { Scene } from './cogrsim_backend.mjs';

interface Actuator {
  motor: number;
  dof: number;
  q: number; // index into qpos
  response: number; // acceleration by effort [1/(kg m^2) or 1/kg], in the reference configuration
  crowd: number; // what all axes with gains move it together, over its own response
  bound: -1 | 0 | 1; // taken to be at this bound of its effort
  law?: { effort: number; damping: number; most: number }; // of a stiff one: effort - damping u, at the end of the step
}

export class Drives {
  readonly all: Actuator[] = [];
  readonly damping: Float64Array; // of the axes by themselves, by dof

  constructor(
    scene: Scene,
    program: Program,
    model: MjModel,
    data: MjData,
    readonly isExplicit: boolean, // integrator: it has no damping implicit
  ) {
    this.damping = Float64Array.from(model.dof_damping as Float64Array);
    program.motors.forEach((actuator, motor) => {
      if (actuator < 0) return;
      const joint = model.actuator_trnid[2 * actuator];
      const dof = model.jnt_dofadr[joint];
      const response = model.dof_invweight0[dof];
      this.all[actuator] = { motor, dof, q: model.jnt_qposadr[joint], response, crowd: 1, bound: 0 };
    });
    this.#findCrowds(scene, model, data);
  }

  #findCrowds(scene: Scene, model: MjModel, data: MjData): void {
    const others = this.all.filter(it => scene.motors[it.motor].mode !== 'torque');
    if (others.length < 2) return;
    for (const find of [mujoco.mj_kinematics, mujoco.mj_comPos, mujoco.mj_crb, mujoco.mj_factorM]) find(model, data);
    const [column, unit] = [new mujoco.DoubleBuffer(model.nv), new Float64Array(model.nv)];
    for (const it of others) {
      unit.fill(0)[it.dof] = 1;
      mujoco.mj_solveM(model, data, column, unit as unknown as number[]);
      const moved = column.GetView() as Float64Array;
      it.crowd = others.reduce((sum, k) => sum + Math.abs(moved[k.dof]) / Math.sqrt(it.response * k.response), 0);
    }
    column.delete();
  }

  /** Before a step; `numbers` has six for each motor. */
  set(model: MjModel, data: MjData, dt: number, numbers: Float64Array): void {
    if (this.all.length === 0) return;
    const [ctrl, qpos] = [data.ctrl as Float64Array, data.qpos as Float64Array];
    const bias = model.actuator_biasprm as Float64Array;
    const range = model.actuator_forcerange as Float64Array;
    const damping = model.dof_damping as Float64Array;
    const stride = bias.length / this.all.length;
    damping.set(this.damping);
    this.all.forEach((it, a) => {
      const [effort, kp0, position, kd0, velocity, most] = numbers.subarray(6 * it.motor, 6 * it.motor + 6);
      // What stops the axis in a step, and is stable: half of it beside many.
      const stops = 1 / (dt * it.response);
      let kp = kp0;
      // A source of speed is explicit: from more gain the contacts of what it drives would meet a thrust that
      // is taken back at the end of the step.
      let kd = kd0 === Infinity ? Math.min(1, 1.5 / it.crowd) * stops : kd0;
      let share = kd0 === Infinity ? 1 : ((kd + (dt * kp) / 2) * it.crowd) / stops;
      if (share > 1 && this.isExplicit) {
        [kp, kd] = [kp / share, kd / share];
        share = 1;
      }
      it.law = undefined;
      let [constant, ofPosition, ofSpeed] = [effort + kp * position + kd * velocity, -kp, -kd];
      if (share > 1) {
        // MuJoCo has dampers of joints implicit, actuators in Euler's method not: the law is taken at
        // the end of the step, or at its bound.
        const free = effort + kp * (position - qpos[it.q]) + kd * velocity;
        it.law = { effort: free, damping: kd + dt * kp, most };
        [constant, ofPosition, ofSpeed] = [it.bound === 0 ? free : it.bound * most, 0, 0];
        if (it.bound === 0) damping[it.dof] += it.law.damping;
      }
      ctrl[a] = constant;
      bias[stride * a + 1] = ofPosition;
      bias[stride * a + 2] = ofSpeed;
      const unbound = it.law !== undefined && it.bound === 0;
      range[2 * a] = unbound ? -Infinity : -most;
      range[2 * a + 1] = unbound ? Infinity : most;
    });
  }

  /** After a step: whether one was taken to be within its bound, or beyond, and is not. */
  correct(data: MjData, isFirst: boolean): boolean {
    const qvel = data.qvel as Float64Array;
    let changed = false;
    for (const it of this.all) {
      if (!it.law) {
        it.bound = 0;
        continue;
      }
      const wanted = it.law.effort - it.law.damping * qvel[it.dof];
      if (it.bound === 0 && Math.abs(wanted) > it.law.most) it.bound = wanted > 0 ? 1 : -1;
      else if (it.bound !== 0 && isFirst && wanted * it.bound < it.law.most) it.bound = 0;
      else continue;
      changed = true;
    }
    return changed;
  }

  /** Of the last step, by motor. */
  efforts(data: MjData, out: Float64Array): void {
    const force = data.actuator_force as Float64Array;
    const qvel = data.qvel as Float64Array;
    this.all.forEach((it, a) => {
      const isFree = it.law !== undefined && it.bound === 0;
      out[it.motor] = isFree ? it.law!.effort - it.law!.damping * qvel[it.dof] : force[a];
    });
  }
}
