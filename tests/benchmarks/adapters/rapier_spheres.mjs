// Our whole step on the backend rapier over a raw program's, see spheres.mjs.
//   node rapier_spheres.mjs COGRSIM ADAPTERS [ROUNDS]
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';

import { adapters, balls, kMass, kMeasured, kRadius, kWarmUp, measure, now, walls } from './spheres.mjs';

const engine = 'rapier/node_modules/@dimforge/rapier3d-compat/dist/rapier.mjs';
const { default: RAPIER } = await import(pathToFileURL(join(adapters, engine)));
await RAPIER.init();

/** Positions at the end, and the time of a step after the warm-up [s]; `look`: states are read, too. */
function raw(look) {
  const zero = { x: 0, y: 0, z: 0 };
  const upright = { x: 0, y: 0, z: 0, w: 1 };
  const world = new RAPIER.World({ x: 0, y: 0, z: -9.81 });
  world.timestep = 0.001;
  const { Multiply, Max } = RAPIER.CoefficientCombineRule;
  const touching = (desc) =>
    desc.setDensity(0).setFriction(Math.sqrt(0.5)).setFrictionCombineRule(Multiply).setRestitution(0)
      .setRestitutionCombineRule(Max);
  const fixed = (at, desc) =>
    world.createCollider(
      touching(desc),
      world.createRigidBody(RAPIER.RigidBodyDesc.fixed().setTranslation(...at)),
    );
  fixed([0, 0, 0], new RAPIER.ColliderDesc(new RAPIER.HalfSpace({ x: 0, y: 0, z: 1 })));
  for (const { size, at } of walls) fixed(at, RAPIER.ColliderDesc.cuboid(...size.map((x) => x / 2)));
  const moment = 0.4 * kMass * kRadius * kRadius;
  const bodies = balls.map((at) => {
    const body = world.createRigidBody(
      RAPIER.RigidBodyDesc.dynamic()
        .setTranslation(...at)
        .setCanSleep(false)
        .setAdditionalMassProperties(kMass, zero, { x: moment, y: moment, z: moment }, upright),
    );
    world.createCollider(touching(RAPIER.ColliderDesc.ball(kRadius)), body);
    return body;
  });
  for (let step = 0; step < kWarmUp; ++step) world.step();
  const begin = now();
  for (let step = 0; step < kMeasured; ++step) {
    world.step();
    if (look) for (const b of bodies) [b.translation(), b.rotation(), b.linvel(), b.angvel()];
  }
  const took = (now() - begin) / kMeasured;
  const ends = bodies.map((b) => b.translation()).map((p) => [p.x, p.y, p.z]);
  world.free();
  return { took, ends };
}

measure('rapier', raw);
