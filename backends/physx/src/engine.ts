// The module of PhysX, and what every world of it needs.
import fs from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import vm from 'node:vm';

import type PhysX from 'physx-js-webidl';

import type { Pose, Q4, V3 } from './math.ts';

export type { PhysX };
type Module = Awaited<ReturnType<typeof PhysX>>;
type Load = (options: { wasmBinary: Uint8Array }) => Promise<Module>;

/**
 * The package is a build for debugging. It writes messages for checks that hold in each call, and takes each
 * argument of a call back apart: more time than a step of a heap. Calls are made plainly, and so are those
 * back whose arguments are few integers, as those of contacts.
 */
const kPlainly = new Map([
  [
    'function createExportWrapper(name, nargs) {',
    'let f; return (...args) => (f ??= wasmExports[name])(...args);',
  ],
  [
    'var runEmAsmFunction = (code, sigPtr, argbuf) => {',
    `let n = 0;
     while (HEAPU8[sigPtr + n] === 105 || HEAPU8[sigPtr + n] === 112) ++n; // i, p
     const i = argbuf >> 2;
     if (n <= 4 && HEAPU8[sigPtr + n] === 0)
       return ASM_CONSTS[code](HEAP32[i], HEAP32[i + 1], HEAP32[i + 2], HEAP32[i + 3]);`,
  ],
]);

/** The package refuses Node.js: it runs in a context that looks like a page, with what it would fetch. */
async function load(): Promise<Module> {
  const file = createRequire(import.meta.url).resolve('physx-js-webidl');
  const page = vm.createContext({
    console,
    WebAssembly,
    TextDecoder,
    performance,
    setTimeout,
    URL,
    location: { href: 'http:' },
    navigator: { languages: ['en'] },
    document: { currentScript: null },
  });
  Object.assign(page, { window: page, self: page });
  let source = fs
    .readFileSync(file, 'utf8')
    .replace(/export default PhysX;?/, 'globalThis.PhysX = PhysX;')
    .replace(/import\.meta\.url/g, '"file:///page"');
  for (const [where, plainly] of kPlainly) source = source.replace(where, `${where}\n${plainly}`);
  vm.runInContext(source, page);
  const wasmBinary = fs.readFileSync(path.join(path.dirname(file), 'physx-js-webidl.wasm'));
  return (page['PhysX'] as Load)({ wasmBinary });
}

export const P = await load();

const number = P.PHYSICS_VERSION;
export const version = [number >> 24, (number >> 16) & 255, (number >> 8) & 255].join('.');

function text(ptr: number): string {
  const end = P.HEAPU8.indexOf(0, ptr);
  return Buffer.from(P.HEAPU8.subarray(ptr, end)).toString('utf8');
}

/** What PhysX has said since it was last asked; beside that it only says no. */
let messages: string[] = [];
const errors = new P.PxErrorCallbackImpl();
errors.reportError = (_code, message) => void messages.push(text(Number(message)));
export function said(): string {
  const out = messages.join('; ');
  messages = [];
  return out;
}

export const scale = new P.PxTolerancesScale();
const foundation = P.CreateFoundation(
  number,
  new P.PxDefaultAllocator(),
  errors as unknown as PhysX.PxErrorCallback,
);
export const physics = P.CreatePhysics(number, foundation, scale);
P.InitExtensions(physics);
export const dispatcher = P.DefaultCpuDispatcherCreate(0);

// Wrappers that are filled again for each call: PhysX copies what it takes.
const v = new P.PxVec3(0, 0, 0);
const x = new P.PxTransform(P.PxIDENTITYEnum.PxIdentity);

export function vec(a: ArrayLike<number>, at = 0): PhysX.PxVec3 {
  v.x = a[at];
  v.y = a[at + 1];
  v.z = a[at + 2];
  return v;
}
export function transform({ p, q }: Pose): PhysX.PxTransform {
  [x.p.x, x.p.y, x.p.z] = p;
  const length = Math.hypot(...q);
  [x.q.w, x.q.x, x.q.y, x.q.z] = q.map((e) => e / length);
  return x;
}

/** The object at an address. */
export const wrap = <T>(ptr: number, of: new (...args: never[]) => T): T =>
  (P as unknown as { wrapPointer(ptr: number, of: unknown): T }).wrapPointer(ptr, of);
const ptrOf = (it: unknown): number => (it as { ptr: number }).ptr;
export const address = ptrOf;

let heap = new Float32Array(P.HEAPU8.buffer);
/** The memory as floats; it may have grown. */
export function floats(): Float32Array {
  if (heap.buffer !== P.HEAPU8.buffer) heap = new Float32Array(P.HEAPU8.buffer);
  return heap;
}
export function vectorAt(ptr: number): V3 {
  const m = floats();
  const i = ptr >> 2;
  return [m[i], m[i + 1], m[i + 2]];
}
export const read = (it: PhysX.PxVec3): V3 => vectorAt(ptrOf(it));
/** PhysX has the rotation first, as x y z w. */
export function readPose(it: PhysX.PxTransform): Pose {
  const i = ptrOf(it) >> 2;
  const m = floats();
  return { p: [m[i + 4], m[i + 5], m[i + 6]], q: [m[i + 3], m[i], m[i + 1], m[i + 2]] as Q4 };
}
