// A world of the backend mujoco3: a compiled model, its data, and the places of the scene's parts in them.
import {
  type Contact,
  Diverged,
  type Scene,
  type State,
  type StateOut,
  type StepInput,
  type World,
} from './cogrsim_backend.mjs';
import { Drives } from './drives.ts';
import {
  badBody,
  compile,
  type DoubleBuffer,
  idOf,
  isFull,
  kState,
  type MjData,
  type MjModel,
  mujoco,
} from './engine.ts';
import {
  conjugate,
  cross,
  kHere,
  multiply,
  normalized,
  plus,
  poseOf,
  q4,
  scale,
  turn,
  turnBack,
  v3,
  type V3,
} from './math.ts';
import { loopData, type Program, reference, writeMjcf } from './mjcf.ts';

interface Coordinates {
  qpos: Float64Array;
  qvel: Float64Array;
  warmstart: Float64Array;
}

export class MujocoWorld implements World {
  #program!: Program;
  #model!: MjModel;
  #data!: MjData;
  #drives!: Drives;
  #poses: Float64Array; // of what stands
  #memory = 0;
  #bodies: number[] = []; // MuJoCo's, by the scene's
  #joints: number[] = []; // MuJoCo's first one, by the scene's; -1: none
  #geoms: [number, number][] = []; // body and shape, by MuJoCo's
  #force!: DoubleBuffer;
  #efforts!: DoubleBuffer;
  #before: Coordinates;
  #hasStepped = false;
  #attached: Set<number>;

  constructor(
    readonly scene: Scene,
    state: State,
    previous?: MujocoWorld,
  ) {
    // A later joint between bodies that were there stops what it forbids: MuJoCo has that as an equality.
    this.#attached = new Set(previous ? previous.#attached : []);
    const { joints, bodies } = previous?.scene ?? scene;
    scene.joints.slice(joints.length).forEach(({ parent, child }, i) => {
      if (Math.max(parent, child) < bodies.length) this.#attached.add(joints.length + i);
    });
    this.#poses = state.poses;
    this.#compile();
    this.write(state);
    this.#before = this.#coordinates();
  }

  #compile(): void {
    const { scene } = this;
    this.#program = writeMjcf(scene, this.#poses, this.#attached);
    const model = compile(this.#program.xml, this.#memory);
    this.free();
    this.#model = model;
    const { mjOBJ_BODY, mjOBJ_GEOM, mjOBJ_JOINT, mjOBJ_EQUALITY } = mujoco.mjtObj;
    this.#bodies = scene.bodies.map((body, b) => (body.removed ? -1 : idOf(model, mjOBJ_BODY, `b${b}`)));
    this.#joints = scene.joints.map((_, j) => (this.#program.moved[j] < 0 ? -1 : idOf(model, mjOBJ_JOINT, `j${j}_0`)));
    this.#geoms = [];
    this.#program.geoms.forEach((geom, g) => {
      const id = idOf(model, mjOBJ_GEOM, `g${g}`);
      this.#geoms[id] = [geom.body, geom.shape];
      this.#setHeights(geom.body, geom.shape, model.geom_dataid[id]);
    });
    this.#setLimits();
    const [numbers, stride] = [model.eq_data as Float64Array, model.eq_data.length / Math.max(1, model.neq)];
    for (const j of this.#program.loops) {
      loopData(this.#program, scene, j).forEach((data, i) => {
        numbers.set(data, stride * idOf(model, mjOBJ_EQUALITY, `e${j}_${i}`));
      });
    }
    this.#setMeanInertia();
    this.#data = new mujoco.MjData(model);
    this.#drives = new Drives(scene, this.#program, model, this.#data, scene.options.integrator === 'RK4');
    this.#force = new mujoco.DoubleBuffer(6);
    this.#efforts = new mujoco.DoubleBuffer(Math.max(1, model.nv));
    this.#hasStepped = false;
  }

  #setHeights(b: number, s: number, field: number): void {
    const shape = this.scene.bodies[b].shapes[s];
    if (shape.type !== 'heightmap') return;
    const { heights } = this.scene.heightmaps[shape.heightmap];
    const low = heights.reduce((a, h) => Math.min(a, h), Infinity);
    const rise = this.#model.hfield_size[4 * field + 2];
    const at = this.#model.hfield_adr[field];
    (this.#model.hfield_data as Float32Array).set(
      heights.map(h => (h - low) / rise),
      at,
    );
  }

  #setLimits(): void {
    const range = this.#model.jnt_range as Float64Array;
    this.scene.joints.forEach((joint, j) => {
      if (this.#joints[j] < 0) return;
      const { axis } = this.#program.branches[this.#program.moved[j]]!;
      joint.axes.forEach(({ lower, upper }, i) => {
        if (axis[i] === undefined) return;
        range.set([joint.type === 'ball' ? 0 : lower, upper], 2 * (this.#joints[j] + axis[i]));
      });
    });
  }

  /** The solver's tolerance goes by the mean inertia: that of what forces move. */
  #setMeanInertia(): void {
    const model = this.#model;
    const kinematic = new Set(this.#bodies.filter((_, b) => this.scene.bodies[b].kind === 'kinematic'));
    if (kinematic.size === 0) return;
    const moments: number[] = [];
    for (let i = 0; i < model.nv; ++i) {
      if (!kinematic.has(model.dof_bodyid[i])) moments.push(model.dof_M0[i]);
    }
    if (moments.length > 0) model.stat.meaninertia = moments.reduce((sum, x) => sum + x, 0) / moments.length;
  }

  #coordinates(): Coordinates {
    const { qpos, qvel, qacc_warmstart } = this.#data;
    return { qpos: qpos.slice(), qvel: qvel.slice(), warmstart: qacc_warmstart.slice() };
  }

  #put({ qpos, qvel, warmstart }: Coordinates): void {
    this.#data.qpos.set(qpos);
    this.#data.qvel.set(qvel);
    this.#data.qacc_warmstart.set(warmstart);
  }

  #setFreeVelocity(b: number, twists: Float64Array): void {
    const [model, data] = [this.#model, this.#data];
    const joint = model.body_jntadr[this.#bodies[b]];
    const q = q4(data.qpos, model.jnt_qposadr[joint] + 3);
    const spin = v3(twists, 6 * b + 3);
    const at = plus(v3(twists, 6 * b), cross(spin, turn(q, this.#program.origins[b])));
    data.qvel.set([...at, ...turnBack(q, spin)], model.jnt_dofadr[joint]);
  }

  write(state: State): void {
    const [model, data, { scene }] = [this.#model, this.#data, this];
    mujoco.mj_resetData(model, data);
    const qpos = data.qpos as Float64Array;
    const qvel = data.qvel as Float64Array;
    scene.bodies.forEach((_, b) => {
      if (!this.#program.free[b] || this.#bodies[b] < 0) return;
      const { p, q } = poseOf(state.poses, 7 * b);
      const address = model.jnt_qposadr[model.body_jntadr[this.#bodies[b]]];
      qpos.set([...plus(p, turn(q, this.#program.origins[b])), ...q], address);
      this.#setFreeVelocity(b, state.twists);
    });
    scene.joints.forEach((joint, j) => {
      const id = this.#joints[j];
      if (id < 0) return;
      const [q, u] = [model.jnt_qposadr[id], model.jnt_dofadr[id]];
      if (joint.type === 'ball') {
        this.#putBall(j, state, q, u);
        return;
      }
      this.#program.branches[this.#program.moved[j]]!.axis.forEach((at, i) => {
        qpos[q + at] = state.positions[joint.position_offset + i];
        qvel[u + at] = state.speeds[joint.speed_offset + i];
      });
      if (joint.type !== 'screw') return;
      const rise = joint.pitch / (2 * Math.PI);
      [qpos[q + 1], qvel[u + 1]] = [rise * qpos[q], rise * qvel[u]];
    });
    this.#hasStepped = false;
    this.#findKinematics();
  }

  /** MuJoCo turns the body that is moved from where it is at 0, and has the rate in its axes. */
  #putBall(j: number, state: State, q: number, u: number): void {
    const joint = this.scene.joints[j];
    const moved = this.#program.moved[j];
    const above = moved === joint.child ? joint.parent : joint.child;
    const [X, spin] = [poseOf(state.poses, 7 * moved), v3(state.twists, 6 * moved + 3)];
    const X_above = above < 0 ? kHere : poseOf(state.poses, 7 * above);
    const spinAbove: V3 = above < 0 ? [0, 0, 0] : v3(state.twists, 6 * above + 3);
    const zero = moved === joint.child ? reference(joint).q : conjugate(reference(joint).q);
    const turned = multiply(conjugate(zero), multiply(conjugate(X_above.q), X.q));
    this.#data.qpos.set(normalized(turned), q);
    this.#data.qvel.set(turnBack(X.q, plus(spin, spinAbove, -1)), u);
  }

  step({ dt, drives, forces, twists }: StepInput): void {
    const { scene } = this;
    this.#before = this.#coordinates();
    for (let isFirst = true; ; isFirst = false) {
      this.#model.opt.timestep = dt;
      this.#drives.set(this.#model, this.#data, dt, drives);
      this.#apply(forces);
      scene.bodies.forEach((body, b) => body.kind === 'kinematic' && !body.removed && this.#setFreeVelocity(b, twists));
      const hadRoom = this.#stepOnce();
      // Stiff drives were taken to be within their bounds, or beyond, and may be otherwise.
      if (hadRoom && !this.#drives.correct(this.#data, isFirst)) break;
      this.#put(this.#before);
    }
    this.#check();
    scene.bodies.forEach((body, b) => body.kind === 'kinematic' && !body.removed && this.#setFreeVelocity(b, twists));
    this.#hasStepped = true;
    this.#findKinematics();
  }

  /** False: its memory was too small, and is larger now. */
  #stepOnce(): boolean {
    try {
      mujoco.mj_step(this.#model, this.#data);
      if (!isFull(this.#data)) return true;
    } catch (error) {
      if (!/stack|arena|memory/i.test(String(error))) throw error;
    }
    this.#memory = 4 * Number(this.#model.narena);
    if (this.#memory > 2 ** 30) throw new Error("MuJoCo's contacts need more than 1 GiB");
    const bounds = this.#drives.all.map(it => it.bound);
    this.#compile();
    this.#drives.all.forEach((it, a) => (it.bound = bounds[a]));
    return false;
  }

  /** External ones, through the centres of mass. */
  #apply(forces: Float64Array | null): void {
    const applied = this.#data.xfrc_applied as Float64Array;
    applied.fill(0);
    if (!forces) return;
    this.scene.bodies.forEach((body, b) => {
      if (body.kind !== 'dynamic' || body.removed) return;
      applied.set(forces.subarray(6 * b, 6 * b + 6), 6 * this.#bodies[b]);
    });
  }

  #check(): void {
    const bad = badBody(this.#model, this.#data);
    if (bad < 0) return;
    this.#put(this.#before);
    throw new Diverged("the state has left MuJoCo's bounds, 1e10", this.#bodies.indexOf(bad));
  }

  /** Poses and velocities of bodies by the coordinates, which stay as they are. */
  #findKinematics(): void {
    const [model, data] = [this.#model, this.#data];
    const qpos = data.qpos.slice();
    mujoco.mj_kinematics(model, data);
    mujoco.mj_comPos(model, data);
    mujoco.mj_comVel(model, data);
    data.qpos.set(qpos);
  }

  read(out: StateOut): void {
    const [model, { scene }] = [this.#model, this];
    const { xpos, xquat, qvel, cvel, subtree_com: centres } = this.#data;
    const { body_jntadr, jnt_dofadr, body_rootid } = model;
    scene.bodies.forEach((body, b) => {
      if (body.removed) return;
      const i = this.#bodies[b];
      if (body.kind === 'static') {
        out.poses.set(this.#poses.subarray(7 * b, 7 * b + 7), 7 * b);
        return;
      }
      const [p, q] = [v3(xpos, 3 * i), q4(xquat, 4 * i)];
      const r = turn(q, this.#program.origins[b]);
      out.poses.set([...plus(p, r, -1), ...q], 7 * b);
      if (this.#program.free[b]) {
        const u = jnt_dofadr[body_jntadr[i]];
        const spin = turn(q, v3(qvel, u + 3));
        out.twists.set([...plus(v3(qvel, u), cross(spin, r), -1), ...spin], 6 * b);
        return;
      }
      // About the centre of mass of the whole tree.
      const spin = v3(cvel, 6 * i);
      const arm = plus(p, v3(centres, 3 * body_rootid[i]), -1);
      out.twists.set([...plus(v3(cvel, 6 * i + 3), cross(spin, arm)), ...spin], 6 * b);
    });
    if (!this.#hasStepped) return;
    this.#drives.efforts(this.#data, out.motorEfforts);
    if (scene.joint_speeds > 0) this.#readEfforts(out.jointEfforts);
  }

  /** Springs, dampers, motors, dry friction and limits, along the speeds of the scene. */
  #readEfforts(out: Float64Array): void {
    const [model, data] = [this.#model, this.#data];
    const effort = new Float64Array(model.nv);
    if (data.nefc > data.ne) {
      // Their rows come before those of contacts.
      const { mjCNSTR_FRICTION_DOF, mjCNSTR_LIMIT_JOINT } = mujoco.mjtConstraint;
      const wanted = [mjCNSTR_FRICTION_DOF.value, mjCNSTR_LIMIT_JOINT.value] as number[];
      const rows = new Float64Array(data.nefc);
      const [types, forces] = [data.efc_type, data.efc_force];
      let some = false;
      for (let row = data.ne; row < data.nefc && wanted.includes(types[row]); ++row) {
        rows[row] = forces[row];
        some = true;
      }
      if (some) {
        mujoco.mj_mulJacTVec(model, data, this.#efforts, rows as unknown as number[]);
        effort.set(this.#efforts.GetView());
      }
    }
    const { qfrc_spring, qfrc_damper, qfrc_actuator, qvel } = data;
    const damping = model.dof_damping as Float64Array;
    for (let i = 0; i < effort.length; ++i) {
      // Dampers are implicit: by the speed at the end of the step.
      const damper = this.#drives.isExplicit ? qfrc_damper[i] : -damping[i] * qvel[i];
      effort[i] += qfrc_spring[i] + qfrc_actuator[i] + damper;
    }
    this.scene.joints.forEach((joint, j) => {
      const id = this.#joints[j];
      if (id < 0) return;
      const u = model.jnt_dofadr[id];
      const moved = this.#program.moved[j];
      const { axis, reversed } = this.#program.branches[moved]!;
      if (joint.type === 'ball') {
        // In F, of the child; MuJoCo's are in the axes of the body that is moved.
        const inWorld = turn(q4(data.xquat, 4 * this.#bodies[moved]), v3(effort, u));
        const F = joint.parent < 0 ? kHere.q : q4(data.xquat, 4 * this.#bodies[joint.parent]);
        const inF = turnBack(poseOf(joint.X_PF).q, turnBack(F, inWorld));
        out.set(scale(reversed ? -1 : 1, inF), joint.speed_offset);
        return;
      }
      axis.forEach((at, i) => (out[joint.speed_offset + i] = effort[u + at]));
      if (joint.type === 'screw') out[joint.speed_offset] += (joint.pitch / (2 * Math.PI)) * effort[u + 1];
    });
  }

  *contacts(): Iterable<Contact> {
    const [model, data] = [this.#model, this.#data];
    if (!this.#hasStepped) return;
    const all = data.contact;
    for (let i = 0; i < data.ncon; ++i) {
      const it = all.get(i)!;
      const [a, b] = [this.#geoms[it.geom1], this.#geoms[it.geom2]];
      mujoco.mj_contactForce(model, data, i, this.#force);
      const local = this.#force.GetView() as Float64Array;
      const [frame, point, depth] = [it.frame as Float64Array, v3(it.pos), -it.dist];
      const normal = v3(frame);
      const force = [0, 1, 2].reduce((sum, k) => plus(sum, scale(local[k], v3(frame, 3 * k))), [0, 0, 0] as V3);
      it.delete();
      yield [a[0], b[0], a[1], b[1], ...point, ...normal, depth, ...force];
    }
    all.delete();
  }

  reactions(out: Float64Array): void {
    const [model, data] = [this.#model, this.#data];
    if (!this.#hasStepped) return;
    // Where and when the forces were found, with the accelerations that came out.
    const now = this.#coordinates();
    this.#put(this.#before);
    this.#findKinematics();
    const dt = model.opt.timestep;
    const qacc = data.qacc as Float64Array;
    if (!this.#drives.isExplicit)
      for (let i = 0; i < qacc.length; ++i) qacc[i] = (now.qvel[i] - this.#before.qvel[i]) / dt;
    mujoco.mj_rnePostConstraint(model, data);
    const { cfrc_int: wrenches, subtree_com: centres, xpos, xquat } = data;
    this.scene.joints.forEach((joint, j) => {
      const moved = this.#program.moved[j];
      if (moved < 0) return;
      const i = this.#bodies[moved];
      const force = v3(wrenches, 6 * i + 3);
      const centre = v3(centres, 3 * model.body_rootid[i]);
      const child = this.#bodies[joint.child];
      const q = q4(xquat, 4 * child);
      const M = plus(v3(xpos, 3 * child), turn(q, plus(v3(joint.X_CM), this.#program.origins[joint.child], -1)));
      const torque = plus(v3(wrenches, 6 * i), cross(plus(centre, M, -1), force));
      const sign = moved === joint.child ? 1 : -1;
      out.set([...scale(sign, force), ...scale(sign, torque)], 6 * j);
    });
    this.#put(now);
    this.#findKinematics();
  }

  save(): Uint8Array {
    const size = mujoco.mj_stateSize(this.#model, kState);
    const buffer = new mujoco.DoubleBuffer(size);
    mujoco.mj_getState(this.#model, this.#data, buffer, kState);
    const numbers = Float64Array.from(buffer.GetView() as Float64Array);
    buffer.delete();
    const bounds = this.#drives.all.map(it => it.bound);
    const head = Buffer.from(JSON.stringify({ attached: [...this.#attached], bounds }));
    const length = Buffer.alloc(4);
    length.writeUInt32LE(head.length);
    return Buffer.concat([length, head, Buffer.from(numbers.buffer)]);
  }

  restore(bytes: Uint8Array, state: State): void {
    const all = Buffer.from(bytes);
    const end = 4 + all.readUInt32LE(0);
    const { attached, bounds } = JSON.parse(all.toString('utf8', 4, end)) as {
      attached: number[];
      bounds: (-1 | 0 | 1)[];
    };
    const isSame = attached.length === this.#attached.size && attached.every(j => this.#attached.has(j));
    this.#poses = state.poses;
    if (!isSame) {
      this.#attached = new Set(attached);
      this.#compile();
    }
    const numbers = new Float64Array(Uint8Array.from(all.subarray(end)).buffer);
    mujoco.mj_resetData(this.#model, this.#data);
    mujoco.mj_setState(this.#model, this.#data, numbers as unknown as number[], kState);
    this.#drives.all.forEach((it, a) => (it.bound = bounds[a]));
    this.#hasStepped = false;
    this.#findKinematics();
  }

  free(): void {
    for (const it of [this.#force, this.#efforts, this.#data, this.#model]) it?.delete();
  }
}
