#!/usr/bin/env bash
# PhysX 5.6.1 (physx-js-webidl 2.7.3): a joint of an articulation to which no friction was given rubs.
#
# A hinge along the vertical carries 1 kg at 0.5 m and turns at 2 rad/s; drives, limits and damping are none, and the
# link's own dampings are set to 0. It should keep its speed. Its coefficient of friction is 0.05 by default and works on the
# load that the joint carries. Seen: after 0.5 s half of the speed is gone; with setFrictionCoefficient(0) it is kept.
#
# Needs Node.js 20 and npm. Exit status 0: as seen; 1: the behaviour has changed.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm install --silent --no-audit --no-fund --prefix . physx-js-webidl@2.7.3 >/dev/null

cat >run.mjs <<'END'
import fs from 'node:fs';
import vm from 'node:vm';
// The package refuses Node.js; it runs in a context that looks like a page.
const folder = new URL('./node_modules/physx-js-webidl/', import.meta.url);
const page = vm.createContext({ console, WebAssembly, TextDecoder, performance, setTimeout, URL,
  location: { href: 'http:' }, navigator: { languages: ['en'] } });
page.window = page.self = page;
page.document = { currentScript: null };
vm.runInContext(fs.readFileSync(new URL('physx-js-webidl.mjs', folder), 'utf8')
  .replace(/export default PhysX;?/, 'globalThis.PhysX = PhysX;').replace(/import\.meta\.url/g, '"file:///page"'), page);
const P = await page.PhysX({ wasmBinary: fs.readFileSync(new URL('physx-js-webidl.wasm', folder)) });
const v = P.PHYSICS_VERSION;
console.log('PhysX', [v >> 24, (v >> 16) & 255, (v >> 8) & 255].join('.'));
const scale = new P.PxTolerancesScale();
const physics = P.CreatePhysics(v, P.CreateFoundation(v, new P.PxDefaultAllocator(), new P.PxDefaultErrorCallback()), scale);
const about = new P.PxSceneDesc(scale);
about.set_gravity(new P.PxVec3(0, 0, -9.81));
about.set_cpuDispatcher(P.DefaultCpuDispatcherCreate(0));
about.set_filterShader(P.DefaultFilterShader());
const REVOLUTE = 2, TWIST = 0, FREE = 2;  // the enums of articulations are empty objects in the package
const place = (x, y, z, turned) => new P.PxTransform(new P.PxVec3(x, y, z),
  turned ? new P.PxQuat(0, -Math.SQRT1_2, 0, Math.SQRT1_2) : new P.PxQuat(0, 0, 0, 1));
for (const given of [false, true]) {
  const scene = physics.createScene(about);
  const arm = physics.createArticulationReducedCoordinate();
  arm.setArticulationFlag(P.PxArticulationFlagEnum.eFIX_BASE ?? 1, true);
  const base = arm.createLink(null, place(0, 0, 0));
  const link = arm.createLink(base, place(0.5, 0, 0));
  for (const each of [base, link]) {
    each.setMass(1);
    each.setMassSpaceInertiaTensor(new P.PxVec3(0.01, 0.01, 0.01));
    each.setLinearDamping(0);
    each.setAngularDamping(0);
  }
  const joint = link.getInboundJoint();
  joint.setJointType(REVOLUTE);
  joint.setMotion(TWIST, FREE);
  joint.setParentPose(place(0, 0, 0, true));
  joint.setChildPose(place(-0.5, 0, 0, true));
  if (given) joint.setFrictionCoefficient(0);
  scene.addArticulation(arm);
  joint.setJointVelocity(TWIST, 2);
  for (let i = 0; i < 500; ++i) {
    scene.simulate(0.001);
    scene.fetchResults(true);
  }
  console.log(`friction set to 0: ${given}; speed after 0.5 s:`, Math.abs(joint.getJointVelocity(TWIST)).toFixed(2));
}
END

cat >expected <<'END'
PhysX 5.6.1
friction set to 0: false; speed after 0.5 s: 1.05
friction set to 0: true; speed after 0.5 s: 2.00
END

node run.mjs | tee seen
diff expected seen && echo "as seen before"
