#!/usr/bin/env bash
# Rapier 0.21.0: bodies are limited to 400 m/s and an eighth of a turn a step, and no field says so.
#
# A free body set to 1000 m/s and 1000 rad/s has 400 m/s after one step, whatever the step, and pi/4 divided by
# the step in rad/s: 785 rad/s at 1 ms, 78.5 rad/s at 10 ms. Neither the integration parameters nor the body have
# a field for it. A spindle of 10,000 rpm at 1 ms is within reach of it, a bullet is not.
#
# Needs Node.js 20 and npm. Exit status 0: as seen; 1: the behaviour has changed.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm install --silent --no-audit --no-fund --prefix . @dimforge/rapier3d-compat@0.21.0 >/dev/null

cat >run.mjs <<'END'
import R from '@dimforge/rapier3d-compat';
await R.init();
console.log('version', R.version());
for (const step of [0.001, 0.01]) {
  const world = new R.World({ x: 0, y: 0, z: 0 });
  world.timestep = step;
  const body = world.createRigidBody(
    R.RigidBodyDesc.dynamic().setLinvel(1000, 0, 0).setAngvel({ x: 0, y: 0, z: 1000 })
      .setAdditionalMassProperties(1, { x: 0, y: 0, z: 0 }, { x: 0.1, y: 0.1, z: 0.1 }, { x: 0, y: 0, z: 0, w: 1 }));
  world.step();
  console.log(`step ${step} s: ${body.linvel().x.toFixed(0)} m/s, ${(body.angvel().z * step).toFixed(4)} rad a step`);
}
const fields = (o) => Object.getOwnPropertyNames(Object.getPrototypeOf(o)).concat(Object.keys(o));
const world = new R.World({ x: 0, y: 0, z: 0 });
console.log('fields that name a greatest speed:',
  fields(world.integrationParameters).filter((f) => /max.*(vel|speed|linvel|angvel)/i.test(f)).length);
END

cat >expected <<'END'
version 0.21.0
step 0.001 s: 400 m/s, 0.7854 rad a step
step 0.01 s: 400 m/s, 0.7854 rad a step
fields that name a greatest speed: 0
END

node run.mjs | tee seen
diff expected seen && echo "as seen before"
