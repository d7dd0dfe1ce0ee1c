// Contacts of the last step, read from the state that Jolt saves: its listener has no impulses.
import type { Contact } from './cogrsim_backend.mjs';
import { J, type Jolt, perpendicular } from './engine.ts';
import type { Motion } from './joints.ts';
import { cross, dot, plus, scale, turn, type V3 } from './math.ts';

interface Side {
  body: number;
  motion: Motion; // as the step had it
  shape: Jolt.Shape;
}

/** The numbers in the order in which ManifoldCache::SaveState writes them. */
class Reader {
  #at = 0;
  constructor(readonly bytes: Buffer) {}

  byte(): number {
    return this.bytes.readUInt8((this.#at += 1) - 1);
  }
  short(): number {
    return this.bytes.readUInt16LE((this.#at += 2) - 2);
  }
  word(): number {
    return this.bytes.readUInt32LE((this.#at += 4) - 4);
  }
  float(): number {
    return this.bytes.readFloatLE((this.#at += 4) - 4);
  }
  vector(): V3 {
    return [this.float(), this.float(), this.float()];
  }
}

function shapeOf({ shape }: Side, value: number): number {
  const id = new J.SubShapeID();
  id.SetValue(value);
  const out = shape.GetSubShapeUserData(id);
  J.destroy(id);
  return Number(out);
}

/**
 * Jolt has friction in the middle of the points of a manifold, and against turning about its normal: the
 * points share both, so that they have the same force and torque.
 */
function* manifold(
  read: Reader,
  dt: number,
  sides: [Side, Side],
  shapes: [number, number],
): Iterable<Contact> {
  const count = read.short();
  const [one, two] = sides.map((side) => side.motion);
  const n = turn(two.q, read.vector());
  const t1 = perpendicular(n);
  const slip = plus(scale(read.float(), t1), cross(n, t1), read.float());
  const spin = read.float();
  const points = Array.from({ length: count }, () => {
    const p1 = plus(one.p, turn(one.q, read.vector()));
    const p2 = plus(two.p, turn(two.q, read.vector()));
    return { at: scale(0.5, plus(p1, p2)), depth: dot(n, plus(p1, p2, -1)), lambda: read.float() };
  });
  const middle = scale(
    1 / count,
    points.reduce<V3>((sum, { at }) => plus(sum, at), [0, 0, 0]),
  );
  const arms = points.map(({ at }) => cross(n, plus(at, middle, -1)));
  const spread = arms.reduce((sum, arm) => sum + dot(arm, arm), 0);
  for (const [i, { at, depth, lambda }] of points.entries()) {
    if (lambda === 0 && depth < 0) continue;
    let impulse = plus(scale(lambda, n), slip, 1 / count);
    if (spread > 0) impulse = plus(impulse, arms[i], spin / spread);
    yield [sides[0].body, sides[1].body, ...shapes, ...at, ...n, depth, ...scale(1 / dt, impulse)];
  }
}

/** `bytes`: of EStateRecorderState_Contacts; `sideOf` by Jolt's number of a body. */
export function* readContacts(bytes: Buffer, dt: number, sideOf: (id: number) => Side): Iterable<Contact> {
  const read = new Reader(bytes);
  read.byte(); // what was saved
  for (let pairs = read.word(); pairs > 0; --pairs) {
    const sides: [Side, Side] = [sideOf(read.word()), sideOf(read.word())];
    read.vector(); // how the pair has moved
    read.vector();
    for (let manifolds = read.word(); manifolds > 0; --manifolds) {
      const shapes = [0, 0] as [number, number];
      for (const i of [0, 1]) {
        read.word();
        shapes[i] = shapeOf(sides[i], read.word());
      }
      yield* manifold(read, dt, sides, shapes);
    }
  }
}
