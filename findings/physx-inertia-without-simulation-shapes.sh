#!/usr/bin/env bash
# PhysX 5.6.1 (physx-js-webidl 2.7.3): inertia 1 1 1, and success, for shapes without the simulation flag.
#
# setMassAndUpdateInertia() of a body whose shapes are for queries only sets the mass, leaves the inertia at 1 kg
# m^2 about each axis, and returns true. With includeNonSimShapes the inertia is that of the shape: (0.0333,
# 0.0283, 0.0083) for a box of 0.1 x 0.2 x 0.4 m and 2 kg.
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
const foundation = P.CreateFoundation(v, new P.PxDefaultAllocator(), new P.PxDefaultErrorCallback());
const physics = P.CreatePhysics(v, foundation, new P.PxTolerancesScale());
const here = () => new P.PxTransform(P.PxIDENTITYEnum.PxIdentity);
const material = physics.createMaterial(0.5, 0.5, 0);
const flags = P.PxShapeFlagEnum;
function inertia(what, flag, others) {
  const body = physics.createRigidDynamic(here());
  body.attachShape(physics.createShape(new P.PxBoxGeometry(0.05, 0.1, 0.2), material, true, new P.PxShapeFlags(flag)));
  const set = P.PxRigidBodyExt.prototype.setMassAndUpdateInertia;
  const done = others ? set(body, 2, null, true) : set(body, 2);
  const I = body.getMassSpaceInertiaTensor();
  console.log(`${what}: returns ${done}, mass ${body.getMass()}, inertia`, [I.x, I.y, I.z].map((i) => i.toFixed(4)).join(' '));
}
inertia('simulation shape', flags.eSIMULATION_SHAPE, false);
inertia('query shape', flags.eSCENE_QUERY_SHAPE, false);
inertia('query shape, includeNonSimShapes', flags.eSCENE_QUERY_SHAPE, true);
END

cat >expected <<'END'
PhysX 5.6.1
simulation shape: returns true, mass 2, inertia 0.0333 0.0283 0.0083
query shape: returns true, mass 2, inertia 1.0000 1.0000 1.0000
query shape, includeNonSimShapes: returns true, mass 2, inertia 0.0333 0.0283 0.0083
END

node run.mjs | tee seen
diff expected seen && echo "as seen before"
