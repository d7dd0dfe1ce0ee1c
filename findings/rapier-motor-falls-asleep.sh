#!/usr/bin/env bash
# Rapier 0.21.0: a motor that accelerates a joint slowly is put to sleep, and its joint never turns.
#
# A velocity motor of 10 rad/s, damping 0.005 N m s, on a hinge with 0.1 kg m^2 gives 0.5 rad/s^2 at the start: after a
# second the joint should have 0.49 rad/s. Within half a second it is slow enough to be put to sleep, and stays at rest
# for ever, the motor being on; a motor is no reason to stay awake. With setCanSleep(false) it turns as it should.
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
for (const canSleep of [true, false]) {
  const world = new R.World({ x: 0, y: 0, z: 0 });
  world.timestep = 0.001;
  const o = { x: 0, y: 0, z: 0 };
  const base = world.createRigidBody(R.RigidBodyDesc.fixed());
  const arm = world.createRigidBody(
    R.RigidBodyDesc.dynamic().setCanSleep(canSleep)
      .setAdditionalMassProperties(1, o, { x: 0.1, y: 0.1, z: 0.1 }, { x: 0, y: 0, z: 0, w: 1 }));
  const joint = world.createImpulseJoint(R.JointData.revolute(o, o, { x: 0, y: 0, z: 1 }), base, arm, true);
  joint.configureMotorModel(R.MotorModel.ForceBased);
  joint.configureMotorVelocity(10, 0.005);
  const seen = [];
  for (let i = 1; i <= 20000; ++i) {
    world.step();
    if (i === 400 || i === 1000 || i === 20000) seen.push(arm.angvel().z.toFixed(2));
  }
  console.log(`can sleep: ${canSleep}; rad/s after 0.4, 1 and 20 s:`, ...seen);
}
END

cat >expected <<'END'
version 0.21.0
can sleep: true; rad/s after 0.4, 1 and 20 s: 0.20 0.00 0.00
can sleep: false; rad/s after 0.4, 1 and 20 s: 0.20 0.49 6.34
END

node run.mjs | tee seen
diff expected seen && echo "as seen before"
