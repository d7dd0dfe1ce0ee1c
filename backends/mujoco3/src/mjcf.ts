// A scene in MuJoCo's language: trees of joints as its trees, other joints as equalities.
import { type Geom, writeSurfaces } from './contacts.ts';
import { type Body, type Joint, type Options, Refusal, type Scene, type Shape } from './cogrsim_backend.mjs';
import {
  conjugate,
  inverse,
  kHere,
  multiply,
  plus,
  type Pose,
  poseOf,
  scale,
  turn,
  type V3,
  v3,
} from './math.ts';
import { listOf, optionElement, over } from './options.ts';

/** A joint of a tree: MuJoCo moves its child, or reversed its parent. */
export interface Branch {
  joint: number;
  reversed: boolean;
  axis: number[]; // by the scene's axis: which of MuJoCo's
}

export interface Program {
  xml: string;
  origins: V3[]; // by body: MuJoCo's frame in the scene's
  free: boolean[]; // by body: it has a free joint
  branches: (Branch | undefined)[]; // by the body that is moved
  moved: number[]; // by joint: the body that it moves, or -1
  geoms: Geom[];
  motors: number[]; // by motor: its actuator, or -1
  loops: number[]; // joints that are equalities
}

/** What a kinematic body weighs against all others together, and its lever [m]: no force moves it. */
const kHeavier = 1e8;
const kLever = 10;

/** [m] MuJoCo has no numbers beyond 1e10: what stands further away meets nothing. */
const kFarthest = 1e9;

/** MuJoCo's joints of one axis: type, the scene's axis (of a screw both are 0), direction in M. */
type Axis = ['hinge' | 'slide' | 'ball', number, V3];
const [x, y, z]: V3[] = [
  [1, 0, 0],
  [0, 1, 0],
  [0, 0, 1],
];
const kAxes: Record<string, Axis[]> = {
  hinge: [['hinge', 0, z]],
  slider: [['slide', 0, z]],
  screw: [
    ['hinge', 0, z],
    ['slide', 0, z],
  ],
  cylindrical: [
    ['hinge', 0, z],
    ['slide', 1, z],
  ],
  universal: [
    ['hinge', 0, x],
    ['hinge', 1, y],
  ],
  gimbal: [
    ['hinge', 0, x],
    ['hinge', 1, y],
    ['hinge', 2, z],
  ],
  planar: [
    ['slide', 0, x],
    ['slide', 1, y],
    ['hinge', 2, z],
  ],
  ball: [['ball', 0, z]],
};

/** Without the rounding of axes and turns that are those of the body. */
const cleaned = <T extends number[]>(v: T): T =>
  v.map(a => (Math.abs(a - Math.round(a)) < 1e-15 ? Math.round(a) : a)) as T;

/** The child of a joint in its parent, where its coordinate is 0. */
export function reference(joint: Joint): Pose {
  const [F, M] = [poseOf(joint.X_PF), poseOf(joint.X_CM)];
  const q = cleaned(multiply(F.q, conjugate(M.q)));
  return { p: plus(F.p, turn(q, M.p), -1), q };
}

const solved = (options: Options, where: string, ...names: string[]): string =>
  names.map(name => `${name}="${listOf(options, name, where).join(' ')}"`).join(' ');

class Writer implements Program {
  xml = '';
  readonly origins: V3[];
  readonly free: boolean[];
  readonly branches: (Branch | undefined)[];
  readonly moved: number[];
  readonly geoms: Geom[] = [];
  readonly motors: number[];
  readonly loops: number[] = [];
  readonly #children: number[][];
  readonly #tree: string[] = [];
  readonly #assets: string[] = [];
  readonly #equalities: string[] = [];
  readonly #tendons: string[] = [];

  constructor(
    readonly scene: Scene,
    readonly poses: Float64Array,
    readonly attached: Set<number>,
  ) {
    this.origins = scene.bodies.map(() => [0, 0, 0]);
    this.free = scene.bodies.map(() => false);
    this.branches = scene.bodies.map(() => undefined);
    this.#children = scene.bodies.map(() => []);
    this.moved = scene.joints.map(() => -1);
    this.motors = scene.motors.map(() => -1);
  }

  #isGround(b: number): boolean {
    return b < 0 || this.scene.bodies[b].kind !== 'dynamic';
  }

  /** Trees from the world and what stands or is driven, then from bodies that are nobody's child. */
  grow(): void {
    const { bodies, joints } = this.scene;
    const usable = (joint: Joint, j: number): boolean =>
      !joint.removed && !joint.closes_loop && joint.type !== 'free' && !this.attached.has(j);
    const at = new Map<number, number[]>();
    joints.forEach((joint, j) => {
      if (!usable(joint, j)) return;
      for (const b of [joint.parent, joint.child]) at.set(b, [...(at.get(b) ?? []), j]);
    });
    const seen = new Set<number>();
    const from = (root: number): void => {
      seen.add(root);
      for (const queue = [root]; queue.length > 0;) {
        const b = queue.shift()!;
        for (const j of at.get(b) ?? []) {
          const reversed = joints[j].child === b;
          const next = reversed ? joints[j].parent : joints[j].child;
          if (this.#isGround(next) || seen.has(next)) continue;
          seen.add(next);
          this.branches[next] = { joint: j, reversed, axis: [] };
          this.moved[j] = next;
          if (b >= 0) this.#children[b].push(next);
          queue.push(next);
        }
      }
    };
    from(-1);
    const present = bodies.flatMap((body, b) => (body.removed ? [] : [b]));
    for (const b of present) if (this.#isGround(b)) from(b);
    const children = new Set(joints.filter(usable).map(joint => joint.child));
    for (const b of present) if (!seen.has(b) && !children.has(b)) from(b);
    for (const b of present) if (!seen.has(b)) from(b);
    for (const b of present) {
      this.free[b] = !this.branches[b] && bodies[b].kind !== 'static';
      // MuJoCo has the path of a free body's frame: where it can be, that of its centre of mass.
      const alone = this.#children[b].length === 0 && bodies[b].kind === 'dynamic';
      if (this.free[b] && alone) this.origins[b] = bodies[b].com;
    }
  }

  write(): void {
    const { scene } = this;
    const option = optionElement(scene.options, scene.step, scene.gravity);
    this.grow();
    scene.bodies.forEach((body, b) => {
      const branch = this.branches[b];
      const isRoot = !branch || this.#above(branch) < 0;
      if (!body.removed && isRoot) this.#body(b);
    });
    scene.joints.forEach((joint, j) => {
      const held = this.#isGround(joint.parent) && this.#isGround(joint.child);
      if (joint.removed || joint.type === 'free' || this.moved[j] >= 0 || held) return;
      this.#loop(j);
    });
    this.#couplings();
    const actuators = this.#actuators();
    const apart = new Set(scene.no_collide.map(([a, b]) => `${a} ${b}`));
    const mayTouch = (a: number, b: number): boolean => !apart.has(`${Math.min(a, b)} ${Math.max(a, b)}`);
    const present = (b: number): boolean => !scene.bodies[b].removed;
    const excludes = [...apart]
      .map(pair => pair.split(' ').map(Number))
      .filter(([a, b]) => a !== b && present(a) && present(b))
      .map(([a, b]) => `<exclude body1="b${a}" body2="b${b}"/>\n`);
    const surfaces = writeSurfaces(scene, this.geoms, mayTouch);
    this.xml =
      '<mujoco><compiler angle="radian" inertiafromgeom="false"/>\n' +
      option +
      `<default>\n${surfaces.classes}</default>\n<asset>\n${this.#assets.join('')}</asset>\n` +
      `<worldbody>\n${this.#tree.join('')}</worldbody>\n` +
      `<contact>\n${excludes.join('')}${surfaces.pairs}</contact>\n` +
      `<equality>\n${this.#equalities.join('')}</equality>\n` +
      `<tendon>\n${this.#tendons.join('')}</tendon>\n<actuator>\n${actuators}</actuator></mujoco>\n`;
  }

  #above({ joint, reversed }: Branch): number {
    return reversed ? this.scene.joints[joint].child : this.scene.joints[joint].parent;
  }

  #isNear(b: number): boolean {
    return [...v3(this.poses, 7 * b), ...v3(this.scene.bodies[b].X_WB)].every(x => Math.abs(x) < kFarthest);
  }

  /** The pose of a body in that above it, where the coordinates of its joint are 0. */
  #pose(b: number): Pose {
    const branch = this.branches[b];
    if (!branch) {
      // What moves freely is compiled where it was drawn: constants of the model depend on nothing else.
      const { kind, X_WB } = this.scene.bodies[b];
      return this.#isNear(b) ? (kind === 'static' ? poseOf(this.poses, 7 * b) : poseOf(X_WB)) : kHere;
    }
    const joint = this.scene.joints[branch.joint];
    const X_PC = reference(joint);
    const X = branch.reversed ? inverse(X_PC) : X_PC;
    const above = this.#above(branch);
    return above < 0 ? X : { p: plus(X.p, this.origins[above], -1), q: X.q };
  }

  #body(b: number): void {
    const body = this.scene.bodies[b];
    const X = this.#pose(b);
    const p = plus(X.p, turn(X.q, this.origins[b]));
    const lift = body.kind === 'kinematic' ? 1 : 1 - body.gravity_scale;
    const without = lift !== 0 && body.kind !== 'static' ? ` gravcomp="${lift}"` : '';
    this.#tree.push(`<body name="b${b}" pos="${p.join(' ')}" quat="${X.q.join(' ')}"${without}>\n`);
    if (this.branches[b]) this.#joint(b);
    else if (this.free[b]) this.#tree.push(`<freejoint name="f${b}"/>\n`);
    if (body.kind !== 'static') this.#tree.push(this.#inertial(body, b));
    body.shapes.forEach((shape, s) => {
      if (shape.collides && this.#isNear(b)) this.#geom(b, s, shape);
    });
    for (const child of this.#children[b]) this.#body(child);
    this.#tree.push('</body>\n');
  }

  #inertial(body: Body, b: number): string {
    if (body.kind === 'kinematic') {
      const others = this.scene.bodies.filter(it => it.kind === 'dynamic' && !it.removed);
      const mass = kHeavier * others.reduce((sum, it) => sum + it.mass, 1);
      const moment = mass * kLever * kLever;
      return `<inertial pos="0 0 0" mass="${mass}" diaginertia="${moment} ${moment} ${moment}"/>\n`;
    }
    const at = plus(body.com, this.origins[b], -1).join(' ');
    const [xx, xy, xz, , yy, yz, , , zz] = body.inertia;
    if (xy !== 0 || xz !== 0 || yz !== 0) {
      const six = [xx, yy, zz, xy, xz, yz].join(' ');
      return `<inertial pos="${at}" mass="${body.mass}" fullinertia="${six}"/>\n`;
    }
    // Of what is flat, rounding may make the largest moment more than the sum of the others.
    const moments = [xx, yy, zz];
    const largest = moments.indexOf(Math.max(...moments));
    const rest = xx + yy + zz - moments[largest];
    if (moments[largest] > rest) moments[largest] = rest * (1 - 1e-15);
    return `<inertial pos="${at}" mass="${body.mass}" diaginertia="${moments.join(' ')}"/>\n`;
  }

  #geom(b: number, s: number, shape: Shape): void {
    const { scene } = this;
    const body = scene.bodies[b];
    const isSurface = shape.type === 'plane' || shape.type === 'heightmap';
    if (isSurface && body.kind !== 'static') {
      throw new Refusal(`body '${body.name}': MuJoCo has a ${shape.type} on static bodies alone`);
    }
    const g = this.geoms.length;
    let { p, q } = poseOf(shape.X_BS);
    const half = shape.length / 2;
    const forms: Partial<Record<Shape['type'], () => string>> = {
      box: () => `type="box" size="${shape.size.map(a => a / 2).join(' ')}"`,
      sphere: () => `type="sphere" size="${shape.radius}"`,
      cylinder: () => `type="cylinder" size="${shape.radius} ${half}"`,
      capsule: () =>
        half > 0 ? `type="capsule" size="${shape.radius} ${half}"` : `type="sphere" size="${shape.radius}"`,
      plane: () => 'type="plane" size="0 0 1"',
      'convex-mesh': () => {
        const { vertices } = scene.meshes[shape.mesh];
        this.#assets.push(`<mesh name="m${g}" inertia="convex" vertex="${vertices.join(' ')}"/>\n`);
        return `type="mesh" mesh="m${g}"`;
      },
      heightmap: () => {
        const map = scene.heightmaps[shape.heightmap];
        const low = map.heights.reduce((a, h) => Math.min(a, h), Infinity);
        const rise = Math.max(map.heights.reduce((a, h) => Math.max(a, h), -Infinity) - low, 1e-6);
        p = plus(p, turn(q, [0, 0, low]));
        this.#assets.push(
          `<hfield name="h${g}" nrow="${map.rows}" ncol="${map.columns}" ` +
            `size="${map.size_x / 2} ${map.size_y / 2} ${rise} ${Math.max(1, rise)}"/>\n`,
        );
        return `type="hfield" hfield="h${g}"`;
      },
    };
    const form = forms[shape.type];
    if (!form) throw new Refusal(`shape '${shape.name}': MuJoCo has meshes as their convex hulls alone`);
    const text = form();
    const mobile = body.kind === 'dynamic';
    this.geoms.push({ body: b, shape: s, material: shape.material, mobile });
    // What does not move does not meet its like.
    const bits = mobile ? 'contype="1" conaffinity="3"' : 'contype="2" conaffinity="1"';
    const at = plus(p, this.origins[b], -1);
    this.#tree.push(
      `<geom name="g${g}" class="s${shape.material}" ${text} pos="${at.join(' ')}" quat="${q.join(' ')}" ${bits}/>\n`,
    );
  }

  #joint(b: number): void {
    const { scene } = this;
    const branch = this.branches[b]!;
    const joint = scene.joints[branch.joint];
    const back = branch.reversed;
    const X = poseOf(back ? joint.X_PF : joint.X_CM); // M in the body that is moved
    let axes = kAxes[joint.type] ?? [];
    // From the child they come in the other order.
    if (back && joint.type === 'planar') axes = [axes[2], axes[0], axes[1]];
    else if (back && joint.type !== 'screw' && joint.type !== 'cylindrical') axes = [...axes].reverse();
    const options = over(scene.options, joint.options);
    const where = `joint '${joint.name}'`;
    const soft = solved(options, where, 'solreflimit', 'solimplimit', 'solreffriction', 'solimpfriction');
    axes.forEach(([type, coordinate, direction], i) => {
      const follows = joint.type === 'screw' && type === 'slide';
      let attributes = `name="j${branch.joint}_${i}" type="${type}" pos="${X.p.join(' ')}"`;
      if (type !== 'ball') attributes += ` axis="${cleaned(scale(back ? -1 : 1, turn(X.q, direction))).join(' ')}"`;
      if (follows) {
        const rise = joint.pitch / (2 * Math.PI);
        this.#equalities.push(
          `<joint joint1="j${branch.joint}_1" joint2="j${branch.joint}_0" polycoef="0 ${rise} 0 0 0" ` +
            `${this.#equality(joint.options, where)}/>\n`,
        );
      } else {
        branch.axis[coordinate] = i;
        const law = joint.axes[coordinate];
        attributes +=
          ` damping="${law.damping}" frictionloss="${law.friction}" stiffness="${law.stiffness}" ` +
          `armature="${law.rotor_inertia}" ${soft}`;
        if (type !== 'ball') attributes += ` springref="${law.rest}"`;
        // The bounds may be infinite, or one number: they are set in the compiled model.
        if (law.lower > -Infinity || law.upper < Infinity) attributes += ' limited="true" range="0 1"';
      }
      this.#tree.push(`<joint ${attributes}/>\n`);
    });
  }

  #equality(own: Options, where: string): string {
    const options = over(this.scene.options, own);
    const [ref, imp] = ['solrefequality', 'solimpequality'].map(name => listOf(options, name, where));
    return `solref="${ref.join(' ')}" solimp="${imp.join(' ')}"`;
  }

  #loop(j: number): void {
    const { scene } = this;
    const joint = scene.joints[j];
    const plain = joint.axes.every(
      a =>
        a.lower === -Infinity && a.upper === Infinity && !(a.damping || a.friction || a.stiffness || a.rotor_inertia),
    );
    const driven = scene.motors.some(motor => !motor.removed && motor.joint === j);
    if (!['hinge', 'ball', 'fixed'].includes(joint.type) || !plain || driven) {
      throw new Refusal(
        `joint '${joint.name}': MuJoCo closes loops and attaches bodies by plain hinges, balls and fixed ` +
          'joints, without limits, springs, dampers, friction or motors',
      );
    }
    const name = (b: number): string => (b < 0 ? 'world' : `b${b}`);
    const ends =
      `body1="${name(joint.parent)}" body2="${name(joint.child)}" ` +
      this.#equality(joint.options, `joint '${joint.name}'`);
    this.loops.push(j);
    if (joint.type === 'fixed') this.#equalities.push(`<weld name="e${j}_0" ${ends}/>\n`);
    else
      for (const i of joint.type === 'ball' ? [0] : [0, 1]) {
        this.#equalities.push(`<connect name="e${j}_${i}" ${ends} anchor="0 0 0"/>\n`);
      }
  }

  /** q = offset + sum of ratio q: of two joints MuJoCo's equality, of more a tendon that is held. */
  #couplings(): void {
    const { scene } = this;
    scene.couplings.forEach((it, k) => {
      const all = [it.joint, ...it.terms.map(term => term.joint)];
      if (it.removed || all.some(j => this.moved[j] < 0)) return;
      const name = (j: number): string => `j${j}_${this.branches[this.moved[j]]!.axis[0]}`;
      const soft = this.#equality(it.options, `coupling '${it.name}'`);
      if (it.terms.length === 1) {
        const [{ joint, ratio }] = it.terms;
        this.#equalities.push(
          `<joint joint1="${name(it.joint)}" joint2="${name(joint)}" polycoef="${it.offset} ${ratio} 0 0 0" ${soft}/>\n`,
        );
        return;
      }
      const terms = [{ joint: it.joint, ratio: -1 }, ...it.terms]
        .map(term => `<joint joint="${name(term.joint)}" coef="${-term.ratio}"/>`)
        .join('');
      this.#tendons.push(`<fixed name="t${k}">${terms}</fixed>\n`);
      this.#equalities.push(`<tendon tendon1="t${k}" polycoef="${it.offset} 0 0 0 0" ${soft}/>\n`);
    });
  }

  #actuators(): string {
    let [out, count] = ['', 0];
    this.scene.motors.forEach((motor, m) => {
      const b = motor.removed ? -1 : this.moved[motor.joint];
      if (b < 0) return;
      // Gains and bounds are set before each step.
      const name = `j${motor.joint}_${this.branches[b]!.axis[motor.axis]}`;
      out += `<general joint="${name}" biastype="affine" forcelimited="true" forcerange="-1 1"/>\n`;
      this.motors[m] = count++;
    });
    return out;
  }
}

export function writeMjcf(scene: Scene, poses: Float64Array, attached: Set<number>): Program {
  const writer = new Writer(scene, poses, attached);
  writer.write();
  return writer;
}

/** Numbers of the equalities of a loop, which MuJoCo would take from where the bodies are at 0. */
export function loopData(program: Program, scene: Scene, j: number): number[][] {
  const joint = scene.joints[j];
  const origin = (b: number): V3 => (b < 0 ? [0, 0, 0] : program.origins[b]);
  const [F, M] = [poseOf(joint.X_PF), poseOf(joint.X_CM)];
  const [inParent, inChild] = [plus(F.p, origin(joint.parent), -1), plus(M.p, origin(joint.child), -1)];
  if (joint.type === 'fixed') {
    return [[...inChild, ...inParent, ...reference(joint).q]];
  }
  if (joint.type === 'ball') return [[...inParent, ...inChild]];
  // A hinge is held at two points of its pin, as far apart as the body is large.
  const held =
    scene.bodies[joint.child >= 0 && scene.bodies[joint.child].kind === 'dynamic' ? joint.child : joint.parent];
  const half = Math.sqrt(Math.max(held.inertia[0], held.inertia[4], held.inertia[8]) / held.mass);
  return [half, -half].map(along => {
    const on = (X: Pose, at: V3): V3 => plus(at, turn(X.q, [0, 0, along]));
    return [...on(F, inParent), ...on(M, inChild)];
  });
}
