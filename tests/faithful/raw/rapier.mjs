// The scenes on raw Rapier, as its manual would write them.
import { conjugate, cross, engineModule, main, multiply, placeIn } from './program.mjs';

const { default: RAPIER } = await engineModule('rapier/node_modules/@dimforge/rapier3d-compat/dist/rapier.mjs');
await RAPIER.init();

const xyz = ([x, y, z]) => ({ x, y, z });
const xyzw = ([w, x, y, z]) => ({ w, x, y, z });
const none = [0, 0, 0];

/** Rapier's capsules and cylinders have their axis along y. */
const kYToZ = [Math.SQRT1_2, Math.SQRT1_2, 0, 0];
const forms = {
  box: (size) => RAPIER.ColliderDesc.cuboid(size[0] / 2, size[1] / 2, size[2] / 2),
  sphere: ([radius]) => RAPIER.ColliderDesc.ball(radius),
  cylinder: ([radius, length]) => RAPIER.ColliderDesc.cylinder(length / 2, radius).setRotation(xyzw(kYToZ)),
  capsule: ([radius, length]) => RAPIER.ColliderDesc.capsule(length / 2, radius).setRotation(xyzw(kYToZ)),
  plane: () => new RAPIER.ColliderDesc(new RAPIER.HalfSpace({ x: 0, y: 0, z: 1 })),
};

/** The turn that brings z to an axis of the world. */
function zTo(axis) {
  const q = [1 + axis[2], ...cross([0, 0, 1], axis)];
  const length = Math.hypot(...q);
  return length > 0 ? q.map((x) => x / length) : [0, 1, 0, 0];
}
/** Rapier's hinges turn about x of their frames. */
const kXToZ = [Math.SQRT1_2, 0, -Math.SQRT1_2, 0];

function make(scene) {
  const world = new RAPIER.World(xyz(scene.gravity));
  world.timestep = scene.step;
  const { Multiply, Max } = RAPIER.CoefficientCombineRule;
  const ground = world.createRigidBody(RAPIER.RigidBodyDesc.fixed());
  const families = new Map();
  const bodies = scene.things.map((thing) => {
    const kind = thing.mass > 0 ? RAPIER.RigidBodyDesc.dynamic() : RAPIER.RigidBodyDesc.fixed();
    kind.setTranslation(...thing.place).setRotation(xyzw(thing.turn)).setCanSleep(false);
    if (thing.mass > 0) {
      kind.setAdditionalMassProperties(thing.mass, xyz(none), xyz(thing.moments), xyzw([1, 0, 0, 0]));
      kind.setLinvel(...thing.velocity).setAngvel(xyz(thing.spin));
    }
    const body = world.createRigidBody(kind);
    families.set(body.handle, thing.family);
    if (!scene.contact) return body;
    for (const { form, size, at } of thing.parts) {
      const desc = forms[form](size).setTranslation(...at).setDensity(0);
      desc.setFriction(Math.sqrt(thing.friction)).setFrictionCombineRule(Multiply);
      desc.setRestitution(thing.restitution).setRestitutionCombineRule(Max);
      if (thing.family >= 0) desc.setActiveHooks(RAPIER.ActiveHooks.FILTER_CONTACT_PAIRS);
      world.createCollider(desc, body);
    }
    return body;
  });
  for (const hinge of scene.hinges) {
    const q = zTo(hinge.axis);
    const frame = (i) => {
      const thing = i < 0 ? { place: none, turn: [1, 0, 0, 0] } : scene.things[i];
      const inBody = multiply(multiply(conjugate(thing.turn), q), kXToZ);
      return [xyz(placeIn(thing, hinge.anchor)), xyzw(inBody)];
    };
    const data = RAPIER.JointData.revolute(xyz(none), xyz(none), { x: 1, y: 0, z: 0 });
    const of = (i) => (i < 0 ? ground : bodies[i]);
    const joint = world.createImpulseJoint(data, of(hinge.parent), of(hinge.child), true);
    joint.setLocalFrame1(...frame(hinge.parent));
    joint.setLocalFrame2(...frame(hinge.child));
    joint.setContactsEnabled(false);
    joint.configureMotorModel(RAPIER.MotorModel.ForceBased);
    if (!hinge.driven) continue;
    joint.setMotorMaxForce(hinge.max_torque);
    joint.configureMotor(0, hinge.speed, 0, 1e9);
  }
  const hooks = {
    filterContactPair: (_a, _b, one, two) =>
      families.get(one) >= 0 && families.get(one) === families.get(two) ? null : RAPIER.SolverFlags.COMPUTE_IMPULSE,
    filterIntersectionPair: () => false,
  };
  const events = new RAPIER.EventQueue(true);
  const apart = scene.things.some((thing) => thing.family >= 0);
  return {
    // Hooks are asked only in steps with a queue of events.
    step: () => (apart ? world.step(events, hooks) : world.step()),
    states: () =>
      bodies.map((body, i) => {
        const [p, q] = [body.translation(), body.rotation()];
        const { mass, place, turn: rotation } = scene.things[i];
        return mass > 0 ? [p.x, p.y, p.z, q.w, q.x, q.y, q.z] : [...place, ...rotation];
      }),
  };
}

await main({ engine: 'rapier', version: RAPIER.version() }, make);
