#!/usr/bin/env bash
# Rapier 0.21.0: what lies on a turntable creeps outward, however rough the table is.
#
# A box of 10 cm lies 0.5 m from the middle of a kinematic table that turns at 2 rad/s, and starts with the table's
# velocity. A friction coefficient of w^2 r / g = 0.2 holds it; with 0.7 it is at 0.64 m after a second, with 5 at 0.58
# m. Neither a smaller step nor more iterations change that, nor how the table is moved. Under the same acceleration on
# a table that circles without turning the box stays where it is.
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
// How far from the middle of the table [m] a box is after a second that began at 0.5 m. The table turns at 2
// rad/s, or moves as that one does below the box, without turning.
function ride({ turning = true, kind = 'kinematicVelocityBased', step = 0.001, iterations = 4, friction = 0.7 }) {
  const world = new R.World({ x: 0, y: 0, z: -9.81 });
  world.timestep = step;
  world.numSolverIterations = iterations;
  const w = 2, r = 0.5;
  const table = world.createRigidBody(R.RigidBodyDesc[kind]());
  world.createCollider(R.ColliderDesc.cuboid(5, 5, 0.05).setTranslation(0, 0, -0.05).setFriction(friction), table);
  const box = world.createRigidBody(
    R.RigidBodyDesc.dynamic().setTranslation(r, 0, 0.05).setLinvel(0, w * r, 0)
      .setAngvel({ x: 0, y: 0, z: turning ? w : 0 }).setCanSleep(false));
  world.createCollider(R.ColliderDesc.cuboid(0.05, 0.05, 0.05).setDensity(1000).setFriction(friction), box);
  for (let i = 0; i < Math.round(1 / step); ++i) {
    const angle = w * (i + 1) * step, half = angle / 2;
    if (!turning) {
      const middle = angle - w * step / 2;
      table.setLinvel({ x: -w * r * Math.sin(middle), y: w * r * Math.cos(middle), z: 0 }, true);
    } else if (kind === 'kinematicPositionBased') {
      table.setNextKinematicRotation({ x: 0, y: 0, z: Math.sin(half), w: Math.cos(half) });
    } else {
      table.setAngvel({ x: 0, y: 0, z: w }, true);
    }
    world.step();
  }
  const p = box.translation(), t = table.translation();
  return Math.hypot(p.x - t.x, p.y - t.y).toFixed(2);
}
console.log('table that circles without turning:', ride({ turning: false }));
console.log('table that turns:                  ', ride({}));
for (const step of [0.0001, 0.01]) console.log(`  step ${step} s:`, ride({ step }));
for (const iterations of [1, 32]) console.log(`  ${iterations} solver iterations:`, ride({ iterations }));
for (const friction of [0.25, 5]) console.log(`  friction ${friction}:`, ride({ friction }));
console.log('  moved by positions:', ride({ kind: 'kinematicPositionBased' }));
END

cat >expected <<'END'
version 0.21.0
table that circles without turning: 0.50
table that turns:                   0.64
  step 0.0001 s: 0.64
  step 0.01 s: 0.65
  1 solver iterations: 0.64
  32 solver iterations: 0.64
  friction 0.25: 0.70
  friction 5: 0.58
  moved by positions: 0.64
END

node run.mjs | tee seen
diff expected seen && echo "as seen before"
