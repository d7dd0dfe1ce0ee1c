#!/usr/bin/env bash
# PhysX 5.6.1 (physx-js-webidl 2.7.3): a new body can be the JavaScript object of a released one.
#
# Objects of the package are kept by their address. A body that is created where a released one was is the same
# object, with the properties that a program gave the released one: what is kept at bodies, or in a Map by them, is
# taken for that of the new one. A new body must be a new object. Seen: the same, named as the released one.
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
const here = new P.PxTransform(P.PxIDENTITYEnum.PxIdentity);
const first = physics.createRigidDynamic(here);
first.label = 'the first';
const names = new Map([[first, 'the first']]);
first.release();
const second = physics.createRigidDynamic(here);
console.log('the second is the first:', second === first);
console.log('label of the second:', second.label, '/ name in the map:', names.get(second));
END

cat >expected <<'END'
PhysX 5.6.1
the second is the first: true
label of the second: the first / name in the map: the first
END

node run.mjs | tee seen
diff expected seen && echo "as seen before"
