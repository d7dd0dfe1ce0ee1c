// The module of Jolt, and what every world of it needs.
import { createRequire } from 'node:module';

import Jolt from 'jolt-physics/wasm-compat';

import { Refusal } from './cogrsim_backend.mjs';
import { type Q4, scale, type V3 } from './math.ts';

export type { Jolt };
/** Its memory is 128 MiB, and does not grow. */
export const J = await Jolt();

export const version = (createRequire(import.meta.url)('jolt-physics/package.json') as { version: string })
  .version;

export const kStatic = 0; // layers
export const kMoving = 1;

// Wrappers that are filled again for each call: Jolt copies what it takes.
const pool = { v: new J.Vec3(), r: new J.RVec3(), q: new J.Quat() };
const set = <T extends { Set(x: number, y: number, z: number): void }>(
  to: T,
  a: ArrayLike<number>,
  at: number,
): T => {
  to.Set(a[at], a[at + 1], a[at + 2]);
  return to;
};
export const vec = (a: ArrayLike<number>, at = 0): Jolt.Vec3 => set(pool.v, a, at);
export const rvec = (a: ArrayLike<number>, at = 0): Jolt.RVec3 => set(pool.r, a, at);
/** From w x y z. */
export function quat(a: ArrayLike<number>, at = 0): Jolt.Quat {
  pool.q.Set(a[at + 1], a[at + 2], a[at + 3], a[at]);
  return pool.q;
}

interface Components {
  GetX(): number;
  GetY(): number;
  GetZ(): number;
}
export const xyz = (v: Components): V3 => [v.GetX(), v.GetY(), v.GetZ()];
export const wxyz = (q: Jolt.Quat): Q4 => [q.GetW(), q.GetX(), q.GetY(), q.GetZ()];

const kSpare = 4 << 20; // [byte], for what a step takes
const freeMemory = (): number => J.JoltInterface.prototype.sGetFreeMemory();

/** Refuses what does not fit: where Jolt has no memory left, it ends the program. */
export function needMemory(bytes: number, what: string): void {
  if (freeMemory() >= bytes + kSpare) return;
  throw new Refusal(
    `${what} does not fit into the memory of Jolt's package, ${J.JoltInterface.prototype.sGetTotalMemory() >> 20} ` +
      'MiB that do not grow: use fewer bodies or triangles',
  );
}

/** Bytes that Jolt writes of its state. */
export function record(write: (recorder: Jolt.StateRecorder) => void): Buffer {
  const pieces: Buffer[] = [];
  const recorder = new J.StateRecorderJS();
  Object.assign(recorder, {
    WriteBytes: (at: number, size: number) => pieces.push(Buffer.from(J.HEAPU8.slice(at, at + size))),
    ReadBytes: () => undefined,
    IsEOF: () => false,
    IsFailed: () => false,
  });
  write(recorder);
  J.destroy(recorder);
  return Buffer.concat(pieces);
}

/** Has Jolt read such bytes; false: they are of another world. */
export function replay(bytes: Uint8Array, read: (recorder: Jolt.StateRecorder) => boolean): boolean {
  let at = 0;
  const recorder = new J.StateRecorderJS();
  Object.assign(recorder, {
    WriteBytes: () => undefined,
    ReadBytes: (to: number, size: number) => {
      J.HEAPU8.set(bytes.subarray(at, at + size), to);
      at += size;
    },
    IsEOF: () => at > bytes.length,
    IsFailed: () => at > bytes.length,
  });
  const good = read(recorder);
  J.destroy(recorder);
  return good && at === bytes.length;
}

/** As Vec3::GetNormalizedPerpendicular of Jolt. */
export function perpendicular([x, y, z]: V3): V3 {
  if (Math.abs(x) > Math.abs(y)) return scale(1 / Math.hypot(x, z), [z, 0, -x]);
  return scale(1 / Math.hypot(y, z), [0, z, -y]);
}
