// Our whole step on the backend physx over a raw program's, see spheres.mjs.
//   node physx_spheres.mjs COGRSIM ADAPTERS [ROUNDS]
import { join } from 'node:path';
import { adapters, balls, kMass, kMeasured, kRadius, kWarmUp, measure, now, walls } from './spheres.mjs';
import { loadPhysx } from '../../support/physx.mjs';

const P = await loadPhysx(join(adapters, 'physx'));
const scale = new P.PxTolerancesScale();
const foundation = P.CreateFoundation(P.PHYSICS_VERSION, new P.PxDefaultAllocator(), new P.PxDefaultErrorCallback());
const physics = P.CreatePhysics(P.PHYSICS_VERSION, foundation, scale);
const dispatcher = P.DefaultCpuDispatcherCreate(0);

/** Positions at the end, and the time of a step after the warm-up [s]; `look`: states are read, too. */
function raw(look) {
  const desc = new P.PxSceneDesc(scale);
  desc.gravity = new P.PxVec3(0, 0, -9.81);
  desc.cpuDispatcher = dispatcher;
  desc.filterShader = P.DefaultFilterShader();
  const world = physics.createScene(desc);
  const material = physics.createMaterial(Math.sqrt(0.5), Math.sqrt(0.5), 0);
  material.setFrictionCombineMode(P.PxCombineModeEnum.eMULTIPLY);
  material.setRestitutionCombineMode(P.PxCombineModeEnum.eMAX);
  const all = new P.PxFilterData(1, 1, 0, 0); // what the default filter of the package lets touch
  const flags = new P.PxShapeFlags(P.PxShapeFlagEnum.eSIMULATION_SHAPE);
  const place = ([x, y, z], q = [0, 0, 0, 1]) => new P.PxTransform(new P.PxVec3(x, y, z), new P.PxQuat(...q));
  const put = (actor, geometry, local) => {
    const shape = physics.createShape(geometry, material, true, flags);
    if (local) shape.setLocalPose(local);
    shape.setSimulationFilterData(all);
    actor.attachShape(shape);
    return actor;
  };
  const plane = put(physics.createRigidStatic(place([0, 0, 0])), new P.PxPlaneGeometry(),
    place([0, 0, 0], [0, -Math.SQRT1_2, 0, Math.SQRT1_2]));
  world.addActor(plane);
  const fixed = walls.map(({ size, at }) => {
    const box = new P.PxBoxGeometry(...size.map((x) => x / 2));
    return put(physics.createRigidStatic(place(at)), box);
  });
  for (const actor of fixed) world.addActor(actor);
  const moment = 0.4 * kMass * kRadius * kRadius;
  const bodies = balls.map((at) => {
    const body = put(physics.createRigidDynamic(place(at)), new P.PxSphereGeometry(kRadius));
    body.setMass(kMass);
    body.setMassSpaceInertiaTensor(new P.PxVec3(moment, moment, moment));
    body.setSleepThreshold(0);
    body.setStabilizationThreshold(0);
    world.addActor(body);
    return body;
  });
  const step = () => {
    world.simulate(0.001);
    world.fetchResults(true);
  };
  for (let i = 0; i < kWarmUp; ++i) step();
  const begin = now();
  const read = ({ x, y, z }) => [x, y, z];
  for (let i = 0; i < kMeasured; ++i) {
    step();
    if (!look) continue;
    for (const b of bodies) {
      const { p, q } = b.getGlobalPose();
      [read(p), read(q), q.w, read(b.getLinearVelocity()), read(b.getAngularVelocity())];
    }
  }
  const took = (now() - begin) / kMeasured;
  const ends = bodies.map((b) => read(b.getGlobalPose().p));
  for (const actor of [plane, ...fixed, ...bodies]) actor.release();
  world.release();
  return { took, ends };
}

measure('physx', raw);
