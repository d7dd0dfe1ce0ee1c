#!/usr/bin/env bash
# Rapier 0.21.0 (@dimforge/rapier3d-compat): a stiff motor of a joint halves what the joint's body can do.
#
# A body of 1 kg and 0.02 kg m^2 hangs 0.5 m off a hinge: 0.27 kg m^2 about its axis. A second hinge of the same frames has
# a velocity motor (force based) with the damping of a rotor of 1 kg m^2 in a step of 1 ms, towards the speed at the start
# of the step: under 1 N m the axis should gain 1 / (0.27 + 1) of a radian per second and second. One sweep of projected Gauss-Seidel
# in a substep, the default, sees the motor beside the 0.02 kg m^2 of the body alone, and gains 45 % of that in each step, with no
# trend; 32 sweeps gain 99.8 %. A body whose centre is on the axis is right with one sweep.
#
# Needs Node.js 20 and npm. Exit status 0: as seen; 1: the behaviour has changed.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm install --silent --no-audit --no-fund --prefix . @dimforge/rapier3d-compat@0.21.0 >/dev/null

cat >run.mjs <<'END'
import RAPIER from '@dimforge/rapier3d-compat';
await RAPIER.init();
const dt = 0.001, substeps = 4, rotor = 1;
const zero = { x: 0, y: 0, z: 0 }, inertia = 0.02;
// What one free axis of inertia m gains under a damper c, implicit in each substep, is F/c (1 - (1 + c h/m)^-n).
const damping = m => {
  let [low, high] = [rotor / dt, (2 * rotor) / dt];
  for (let i = 0; i < 60; ++i) {
    const c = (low + high) / 2;
    if (1 - (1 + (c * dt) / (substeps * m)) ** -substeps > (c * dt) / (m + rotor)) low = c;
    else high = c;
  }
  return low;
};
for (const [arm, sweeps] of [[0, 1], [0.5, 1], [0.5, 32]]) {
  const world = new RAPIER.World(zero);
  world.timestep = dt;
  world.integrationParameters.numSolverIterations = substeps;
  world.integrationParameters.numInternalPgsIterations = sweeps;
  const ground = world.createRigidBody(RAPIER.RigidBodyDesc.fixed());
  const body = world.createRigidBody(RAPIER.RigidBodyDesc.dynamic().setTranslation(0, arm, 0)
    .setAdditionalMassProperties(1, zero, { x: inertia, y: inertia, z: inertia }, { x: 0, y: 0, z: 0, w: 1 }));
  const hinge = () => world.createImpulseJoint(
    RAPIER.JointData.revolute(zero, { x: 0, y: -arm, z: 0 }, { x: 1, y: 0, z: 0 }), ground, body, true);
  hinge();
  const motor = hinge();
  motor.configureMotorModel(RAPIER.MotorModel.ForceBased);
  const m = inertia + arm * arm;
  let gain = 0;
  for (let step = 0; step < 20; ++step) {
    const before = body.angvel().x;
    body.resetTorques(true);
    body.addTorque({ x: 1, y: 0, z: 0 }, true);
    motor.configureMotorVelocity(before, damping(m));
    world.step();
    gain = (body.angvel().x - before) / (dt / (m + rotor));
  }
  console.log(`arm ${arm} m, ${sweeps} sweeps: ${gain.toFixed(2)} of the acceleration`);
}
END

cat >expected <<'END'
arm 0 m, 1 sweeps: 1.00 of the acceleration
arm 0.5 m, 1 sweeps: 0.45 of the acceleration
arm 0.5 m, 32 sweeps: 1.00 of the acceleration
END

node run.mjs | tee seen
diff expected seen && echo "as seen before"
