// The scenes on raw MuJoCo 3: a model in its own language, its defaults.
import { conjugate, engineModule, main, multiply, placeIn, scale, turn } from './program.mjs';

const { default: load } = await engineModule('mujoco3/node_modules/@mujoco/mujoco/mujoco.js');
const mujoco = await load();

const list = (numbers) => numbers.join(' ');
/** As a person would write them. */
const rounded = (numbers) => numbers.map((x) => (Math.abs(x - Math.round(x)) < 1e-15 ? Math.round(x) : x));
const axisIn = (thing, axis) => rounded(turn(conjugate(thing.turn), axis));
const moves = (thing) => thing.mass > 0;

/** The manual's chapter on restitution, see tests/benchmarks/raw_mujoco.cpp. */
function solref(restitution, step) {
  if (restitution === 0) return '0.02 1';
  let [low, high] = [0, 1];
  for (let i = 0; i < 60; ++i) {
    const z = (low + high) / 2;
    const s = Math.sqrt(1 - z * z);
    if (Math.exp((-z / s) * Math.atan2(2 * z * s, 2 * z * z - 1)) > restitution) low = z;
    else high = z;
  }
  const frequency = 1 / (4 * step);
  return `${-(frequency ** 2)} ${-(2 * low * frequency)}`;
}

/** Half sizes and the like. */
const forms = {
  box: (size) => `type="box" size="${list(scale(0.5, size))}"`,
  sphere: ([radius]) => `type="sphere" size="${radius}"`,
  cylinder: ([radius, length]) => `type="cylinder" size="${radius} ${length / 2}"`,
  capsule: ([radius, length]) => `type="capsule" size="${radius} ${length / 2}"`,
  plane: () => 'type="plane" size="0 0 1"',
};

function geoms(scene, thing) {
  // Of a pair the larger friction holds, unless one has priority: what moves has that of the pair. What is slick
  // has contacts without friction.
  const ground = scene.things[0];
  const friction = moves(thing) ? Math.sqrt(thing.friction * (scene.contact ? ground.friction : 0)) : thing.friction;
  const bounce = solref(Math.max(thing.restitution, ground.restitution), scene.step);
  const priority = !moves(thing) ? 0 : friction > 0 ? 1 : 2;
  return thing.parts.map(({ form, size, at }) => {
    const off = scene.contact ? '' : 'contype="0" conaffinity="0"';
    return (
      `<geom ${forms[form](size)} pos="${list(moves(thing) ? at : thing.place)}" friction="${friction} 0 0" ` +
      `condim="${friction > 0 ? 3 : 1}" solref="${bounce}" priority="${priority}" ${off}/>`
    );
  });
}

function describe(scene) {
  const { things, hinges } = scene;
  const inTree = new Map(hinges.filter((it) => it.parent < it.child).map((it) => [it.child, it]));
  const [motors, loops, apart] = [[], [], []];
  for (const { parent, child, anchor, axis } of hinges.filter((it) => it.parent > it.child)) {
    // Outside of the tree: two points of its pin are held together.
    const half = Math.sqrt(Math.max(...things[child].moments) / things[child].mass);
    for (const side of [half, -half]) {
      const at = placeIn(things[parent], anchor).map((x, i) => x + side * axisIn(things[parent], axis)[i]);
      loops.push(`<connect body1="t${parent}" body2="t${child}" anchor="${list(at)}"/>`);
    }
  }
  things.forEach((a, i) =>
    things.forEach((b, k) => {
      if (i < k && a.family >= 0 && a.family === b.family) apart.push(`<exclude body1="t${i}" body2="t${k}"/>`);
    }),
  );
  const body = (i, above) => {
    const thing = things[i];
    const place = above ? placeIn(above, thing.place) : thing.place;
    const q = above ? rounded(multiply(conjugate(above.turn), thing.turn)) : thing.turn;
    const hinge = inTree.get(i);
    let joint = '<freejoint/>';
    if (hinge) {
      const at = placeIn(thing, hinge.anchor);
      joint = `<joint name="j${i}" type="hinge" pos="${list(at)}" axis="${list(axisIn(thing, hinge.axis))}"/>`;
      if (hinge.driven) {
        const range = `${-hinge.max_torque} ${hinge.max_torque}`;
        motors.push(`<general joint="j${i}" biastype="affine" forcelimited="true" forcerange="${range}"/>`);
      }
    }
    const below = things.flatMap((_, k) => (inTree.get(k)?.parent === i ? body(k, thing) : []));
    return [
      `<body name="t${i}" pos="${list(place)}" quat="${list(q)}">${joint}`,
      `<inertial pos="0 0 0" mass="${thing.mass}" diaginertia="${list(thing.moments)}"/>`,
      ...geoms(scene, thing),
      ...below,
      '</body>',
    ];
  };
  const moving = things.filter(moves).length;
  // Its manual has conjugate gradients for heaps.
  const solver = hinges.length > 0 || moving <= 100 ? 'Newton' : 'CG';
  return [
    '<mujoco><compiler angle="radian"/>',
    `<option timestep="${scene.step}" gravity="${list(scene.gravity)}" solver="${solver}"/><worldbody>`,
    ...things.filter((thing) => !moves(thing)).flatMap((thing) => geoms(scene, thing)),
    ...things.flatMap((thing, i) => (moves(thing) && !(inTree.get(i)?.parent >= 0) ? body(i) : [])),
    `</worldbody><contact>${apart.join('')}</contact><equality>${loops.join('')}</equality>`,
    `<actuator>${motors.join('')}</actuator></mujoco>`,
  ].join('\n');
}

function make(scene) {
  const model = mujoco.MjModel.from_xml_string(describe(scene));
  const data = new mujoco.MjData(model);
  const bodies = scene.things.map((_, i) => mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY.value, `t${i}`));
  scene.things.forEach((thing, i) => {
    const joint = bodies[i] < 0 ? -1 : model.body_jntadr[bodies[i]];
    if (joint < 0 || model.jnt_type[joint] !== mujoco.mjtJoint.mjJNT_FREE.value) return;
    // Free joints turn in the body's frame.
    data.qvel.set([...thing.velocity, ...turn(conjugate(thing.turn), thing.spin)], model.jnt_dofadr[joint]);
  });
  // Explicit: no more gain than stops the wheel within a step.
  const driven = scene.hinges.filter((hinge) => hinge.driven);
  const stride = model.actuator_biasprm.length / Math.max(1, driven.length);
  driven.forEach((hinge, motor) => {
    const gain = 1 / (scene.step * model.dof_invweight0[model.jnt_dofadr[model.actuator_trnid[2 * motor]]]);
    model.actuator_biasprm[stride * motor + 2] = -gain;
    data.ctrl[motor] = gain * hinge.speed;
  });
  const see = () => {
    // MuJoCo normalises quaternions in place; what is looked at must continue unchanged.
    const qpos = data.qpos.slice();
    mujoco.mj_kinematics(model, data);
    data.qpos.set(qpos);
  };
  return {
    step: () => mujoco.mj_step(model, data),
    states: () => {
      see();
      const { xpos, xquat } = data;
      return scene.things.map((thing, i) =>
        bodies[i] < 0
          ? [...thing.place, ...thing.turn]
          : [...xpos.slice(3 * bodies[i], 3 * bodies[i] + 3), ...xquat.slice(4 * bodies[i], 4 * bodies[i] + 4)],
      );
    },
  };
}

await main({ engine: 'mujoco3', version: mujoco.mj_versionString() }, make);
