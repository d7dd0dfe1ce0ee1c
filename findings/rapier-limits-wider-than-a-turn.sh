#!/usr/bin/env bash
# Rapier 0.21.0: revolute limits that span more than a full turn do nothing, without a word.
#
# A revolute joint with limits -1 .. 5 rad (6 rad in all) stops at 5 rad; with -4 .. 4 or 0 .. 7 rad (more than 2
# pi in all) it turns for ever. No error, no warning, and the limits read back as they were set. A body that turns
# at 1 rad/s for 12 s without load should stand at the upper limit.
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
// The angle [rad] after 12 s of a body that starts at 1 rad/s on a joint with these limits [rad].
function turned(lower, upper) {
  const world = new R.World({ x: 0, y: 0, z: 0 });
  world.timestep = 0.001;
  const o = { x: 0, y: 0, z: 0 };
  const base = world.createRigidBody(R.RigidBodyDesc.fixed());
  const arm = world.createRigidBody(
    R.RigidBodyDesc.dynamic().setCanSleep(false)
      .setAdditionalMassProperties(1, o, { x: 0.1, y: 0.1, z: 0.1 }, { x: 0, y: 0, z: 0, w: 1 })
      .setAngvel({ x: 0, y: 0, z: 1 }));
  const joint = world.createImpulseJoint(R.JointData.revolute(o, o, { x: 0, y: 0, z: 1 }), base, arm, true);
  joint.setLimits(lower, upper);
  let sum = 0, last = 0;
  for (let i = 0; i < 12000; ++i) {
    world.step();
    const q = arm.rotation();
    const now = 2 * Math.atan2(q.z, q.w);
    const d = now - last;
    sum += d - 2 * Math.PI * Math.round(d / (2 * Math.PI));
    last = now;
  }
  return sum;
}
for (const [lower, upper] of [[-1, 3], [-1, 5], [-0.5, 5.5], [-3.5, 3.5], [-4, 4], [0, 7]]) {
  const angle = turned(lower, upper);
  console.log(`limits ${lower} .. ${upper}:`, Math.abs(angle - upper) < 0.01 ? 'stops' : angle > 11.9 ? 'never stops' : angle);
}
END

cat >expected <<'END'
version 0.21.0
limits -1 .. 3: stops
limits -1 .. 5: stops
limits -0.5 .. 5.5: stops
limits -3.5 .. 3.5: never stops
limits -4 .. 4: never stops
limits 0 .. 7: never stops
END

node run.mjs | tee seen
diff expected seen && echo "as seen before"
