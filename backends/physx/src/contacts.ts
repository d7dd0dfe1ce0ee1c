// What may touch, and what has touched in the last step.
import type { Contact, Scene } from './cogrsim_backend.mjs';
import { address, floats, P, type PhysX, wrap } from './engine.ts';

const kPoint = 12; // floats of a PxContactPairPoint
const kPoints = 256; // of a pair, at most
interface Shapes {
  get_shapes(side: number): unknown;
}

export class Contacts {
  readonly filter: PhysX.PassThroughFilterShader;
  readonly callback: PhysX.PxSimulationEventCallback;
  readonly #apart = new Set<number>();
  readonly #points = new P.Vector_PxContactPairPoint(kPoints);
  #reports: [pairs: number, count: number][] = []; // of the last step

  constructor(
    readonly scene: Scene,
    readonly shapes: Map<number, [number, number]>, // body and shape, by address
  ) {
    const count = scene.bodies.length;
    for (const [a, b] of scene.no_collide) this.#apart.add(a * count + b).add(b * count + a);
    const flag = P.PxPairFlagEnum as unknown as Record<string, number>;
    const flags =
      flag.eCONTACT_DEFAULT |
      flag.eNOTIFY_TOUCH_FOUND |
      flag.eNOTIFY_TOUCH_PERSISTS |
      flag.eNOTIFY_CONTACT_POINTS |
      (scene.options['ccd'] === true ? flag.eDETECT_CCD_CONTACT : 0);
    const filter = new P.PassThroughFilterShaderImpl();
    this.filter = filter as unknown as PhysX.PassThroughFilterShader;
    const { eKILL, eDEFAULT } = P.PxFilterFlagEnum as unknown as Record<string, number>;
    filter.filterShader = (_a0, a, _1, _2, _3, _a1, b) => {
      this.filter.outputPairFlags = flags;
      return this.#apart.has(a * count + b) ? eKILL : eDEFAULT;
    };
    const callback = new P.PxSimulationEventCallbackImpl();
    const nothing = (): void => undefined;
    // What it points to stays until the next step, and is read where somebody looks.
    const onContact = (_header: unknown, pairs: unknown, n: number): void =>
      void this.#reports.push([Number(pairs), n]);
    Object.assign(callback, {
      onContact,
      onConstraintBreak: nothing,
      onWake: nothing,
      onSleep: nothing,
      onTrigger: nothing,
    });
    this.callback = callback as unknown as PhysX.PxSimulationEventCallback;
  }

  begin(): void {
    this.#reports = [];
  }

  *read(dt: number): Iterable<Contact> {
    const buffer = this.#points.data();
    for (const [pairs, n] of this.#reports) {
      const base = wrap(pairs, P.PxContactPair);
      for (let i = 0; i < n; ++i) {
        const pair = P.NativeArrayHelpers.prototype.getContactPairAt(base, i);
        const count = pair.extractContacts(buffer, kPoints);
        if (count === 0) continue;
        const sides = [0, 1].map((side) =>
          this.shapes.get(address((pair as unknown as Shapes).get_shapes(side))),
        );
        if (!sides[0] || !sides[1]) continue;
        const [[a, shapeA], [b, shapeB]] = sides as [[number, number], [number, number]];
        const m = floats();
        for (let k = 0; k < count; ++k) {
          const at = (address(buffer) >> 2) + k * kPoint;
          const [x, y, z, separation, nx, ny, nz] = m.subarray(at, at + 7);
          const impulse = m.subarray(at + 8, at + 11);
          if (separation > 0 && impulse.every((p) => p === 0)) continue;
          // PhysX's normal and impulse are those of the first.
          const force = [...impulse].map((p) => -p / dt);
          yield [a, b, shapeA, shapeB, x, y, z, -nx, -ny, -nz, -separation, ...force];
        }
      }
    }
  }

  free(): void {
    for (const it of [this.callback, this.filter, this.#points]) P.destroy(it);
  }
}
