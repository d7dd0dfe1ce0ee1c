// Raw programs of PhysX, written as its manual would, and the backend physx run the same scenes: a box slides over
// a plane at 45 degrees to its axes and a ball falls beside it; an articulation of two links swings. Their positions
// after a second are equal bit for bit.
//   node physx.mjs COGRSIM ADAPTERS SCRATCH
import { join } from 'node:path';
import { loadPhysx } from '../support/physx.mjs';
import { adapters, beside } from './beside.mjs';

const P = await loadPhysx(join(adapters, 'physx'));
const scale = new P.PxTolerancesScale();
const foundation = P.CreateFoundation(P.PHYSICS_VERSION, new P.PxDefaultAllocator(), new P.PxDefaultErrorCallback());
const physics = P.CreatePhysics(P.PHYSICS_VERSION, foundation, scale);
const dispatcher = P.DefaultCpuDispatcherCreate(0);
const flags = new P.PxShapeFlags(P.PxShapeFlagEnum.eSIMULATION_SHAPE);
const all = new P.PxFilterData(1, 1, 0, 0); // what the default filter of the package lets touch
const material = physics.createMaterial(Math.sqrt(0.5), Math.sqrt(0.5), 0);
material.setFrictionCombineMode(P.PxCombineModeEnum.eMULTIPLY);
material.setRestitutionCombineMode(P.PxCombineModeEnum.eMAX);

function makeWorld(gravity) {
  const desc = new P.PxSceneDesc(scale);
  desc.gravity = new P.PxVec3(...gravity);
  desc.cpuDispatcher = dispatcher;
  desc.filterShader = P.DefaultFilterShader();
  return physics.createScene(desc);
}
const place = ([x, y, z], q = [0, 0, 0, 1]) => new P.PxTransform(new P.PxVec3(x, y, z), new P.PxQuat(...q));
function put(actor, geometry, local = place([0, 0, 0])) {
  const shape = physics.createShape(geometry, material, true, flags);
  shape.setLocalPose(local);
  shape.setSimulationFilterData(all);
  actor.attachShape(shape);
}
function weigh(body, moment) {
  body.setMass(1);
  body.setMassSpaceInertiaTensor(new P.PxVec3(moment, moment, moment));
}

// 1 kg each: m (a^2 + a^2) / 12 of the box, 2/5 m r^2 of the ball.
const ofBox = (0.125 * 0.125 + 0.125 * 0.125) / 12;
const ofBall = 0.4 * 0.05 * 0.05;
const kUnwrapped = 3; // PxArticulationJointType::eREVOLUTE_UNWRAPPED
const cases = {
  sliding: {
    gravity: '0 0 -9.81',
    make: (world) => {
      const floor = physics.createRigidStatic(place([0, 0, 0]));
      put(floor, new P.PxPlaneGeometry(), place([0, 0, 0], [0, -Math.SQRT1_2, 0, Math.SQRT1_2]));
      world.addActor(floor);
      const body = (at, velocity, geometry, moment) => {
        const it = physics.createRigidDynamic(place(at));
        put(it, geometry);
        weigh(it, moment);
        it.setSleepThreshold(0);
        it.setStabilizationThreshold(0);
        it.setLinearVelocity(new P.PxVec3(...velocity));
        world.addActor(it);
        return it;
      };
      return {
        box: body([0, 0, 0.0625], [1, 1, 0], new P.PxBoxGeometry(0.0625, 0.0625, 0.0625), ofBox),
        ball: body([1, 0, 0.5], [0.3, 0.1, 0], new P.PxSphereGeometry(0.05), ofBall),
      };
    },
    scene: `<plane name="floor"/>
  <box name="box" size="0.125 0.125 0.125" mass="1 kg" xyz="0 0 0.0625" linear-velocity="1 1 0 m/s"/>
  <sphere name="ball" radius="5 cm" mass="1 kg" xyz="1 0 0.5" linear-velocity="0.3 0.1 0 m/s"/>`,
  },
  swinging: {
    gravity: '0 -9.81 0',
    make: (world) => {
      const arm = physics.createArticulationReducedCoordinate();
      arm.setArticulationFlag(P.PxArticulationFlagEnum.eFIX_BASE, true);
      arm.setSolverIterationCounts(4, 1);
      arm.setSleepThreshold(0);
      arm.setStabilizationThreshold(0);
      const link = (parent, x, from, to) => {
        const it = arm.createLink(parent, place([x, 0, 0]));
        put(it, new P.PxSphereGeometry(0.05));
        weigh(it, ofBall);
        const joint = it.getInboundJoint();
        joint.setJointType(kUnwrapped);
        joint.setMotion(P.PxArticulationAxisEnum.eTWIST, P.PxArticulationMotionEnum.eFREE);
        const alongZ = [0, -Math.SQRT1_2, 0, Math.SQRT1_2];
        joint.setParentPose(place([from, 0, 0], alongZ));
        joint.setChildPose(place([to, 0, 0], alongZ));
        return it;
      };
      const base = arm.createLink(null, place([0, 0, 0]));
      const upper = link(base, 0.5, 0, -0.5);
      const lower = link(upper, 0.75, 0, -0.25);
      world.addArticulation(arm);
      return { upper, lower };
    },
    scene: `<sphere name="upper" radius="5 cm" mass="1 kg" xyz="0.5 0 0"/>
  <sphere name="lower" radius="5 cm" mass="1 kg" xyz="0.75 0 0"/>
  <hinge name="shoulder" child="upper" xyz="0 0 0" axis="0 0 1"/>
  <hinge name="elbow" parent="upper" child="lower" xyz="0.5 0 0" axis="0 0 1"/>`,
  },
};

beside('physx', cases, ({ gravity, make }) => {
  const world = makeWorld(gravity.split(' ').map(Number));
  const made = make(world);
  for (let step = 0; step < 1000; ++step) {
    world.simulate(0.001);
    world.fetchResults(true);
  }
  const positions = Object.entries(made).map(([body, it]) => {
    const { x, y, z } = it.getGlobalPose().p;
    return [body, [x, y, z]];
  });
  return Object.fromEntries(positions);
});
