// What materials have with each other. Jolt has coefficients by bodies, friction as the root of their
// product and the larger restitution; where that is not what the scene says, its listener of contacts has
// them by pairs.
import type { Body, Scene, Shape } from './cogrsim_backend.mjs';
import { J, type Jolt } from './engine.ts';
import type { Motion } from './joints.ts';
import { plus, turn, type Q4 } from './math.ts';

const materials = (body: Body): number[] => [
  ...new Set(body.shapes.filter((shape) => shape.collides && !body.removed).map((shape) => shape.material)),
];
const isMoving = (shape: Shape): boolean => shape.surface_velocity.some((x) => x !== 0);

/** Jolt's rules give what the scene says. */
function rulesHold(scene: Scene): boolean {
  const used = new Set<number>();
  for (const body of scene.bodies) {
    const own = materials(body);
    if (own.length > 1 || body.shapes.some(isMoving)) return false;
    own.forEach((m) => used.add(m));
  }
  const { surfaces } = scene;
  const near = (a: number, b: number): boolean => Math.abs(a - b) <= 1e-6 * Math.max(1, Math.abs(b));
  return [...used].every((a) =>
    [...used].every(
      (b) =>
        near(Math.sqrt(surfaces[a][a].friction * surfaces[b][b].friction), surfaces[a][b].friction) &&
        near(Math.max(surfaces[a][a].restitution, surfaces[b][b].restitution), surfaces[a][b].restitution),
    ),
  );
}

/** Manifolds of a step for which Jolt has room; it drops others without a word. */
const kManifolds = new J.JoltSettings().mMaxContactConstraints;

export class Surfaces {
  #seen = 0; // manifolds in the step
  #motions: Motion[] = [];
  #failed: unknown;
  readonly #listener: Jolt.ContactListenerJS;

  private constructor(
    readonly scene: Scene,
    system: Jolt.PhysicsSystem,
    readonly numbers: Map<number, number>,
  ) {
    const isRuled = rulesHold(scene);
    const set = (one: number, two: number, manifold: number, settings: number): void => {
      ++this.#seen;
      if (isRuled) return;
      // Nothing may be thrown through Jolt.
      try {
        this.#set(one, two, manifold, settings);
      } catch (error) {
        this.#failed ??= error;
      }
    };
    this.#listener = new J.ContactListenerJS();
    Object.assign(this.#listener, {
      OnContactValidate: () => J.ValidateResult_AcceptAllContactsForThisBodyPair,
      OnContactAdded: set,
      OnContactPersisted: set,
      OnContactRemoved: () => undefined,
    });
    system.SetContactListener(this.#listener);
  }

  static of(scene: Scene, system: Jolt.PhysicsSystem, numbers: Map<number, number>): Surfaces | undefined {
    const shapes = scene.bodies.reduce((sum, body) => sum + body.shapes.length, 0);
    const isFew = 8 * shapes < kManifolds;
    return isFew && rulesHold(scene) ? undefined : new Surfaces(scene, system, numbers);
  }

  /** Those of a body by itself. */
  static setOwn(settings: Jolt.BodyCreationSettings, scene: Scene, body: Body): void {
    const [m] = materials(body);
    if (m === undefined) return;
    settings.mFriction = scene.surfaces[m][m].friction;
    settings.mRestitution = scene.surfaces[m][m].restitution;
  }

  #set(one: number, two: number, manifoldAt: number, settingsAt: number): void {
    const manifold = J.wrapPointer(manifoldAt, J.ContactManifold);
    const settings = J.wrapPointer(settingsAt, J.ContactSettings);
    const sides = [
      this.#side(J.wrapPointer(one, J.Body), manifold.mSubShapeID1),
      this.#side(J.wrapPointer(two, J.Body), manifold.mSubShapeID2),
    ];
    const [a, b] = sides.map((side) => side.shape);
    const surface = this.scene.surfaces[a.material][b.material];
    settings.mCombinedFriction = surface.friction;
    settings.mCombinedRestitution = surface.restitution;
    if (!isMoving(a) && !isMoving(b)) return;
    // Jolt wants the surface of 2 against that of 1.
    const [u1, u2] = sides.map(({ shape, q }) =>
      turn(q, turn(shape.X_BS.slice(3) as Q4, shape.surface_velocity)),
    );
    const u = plus(u2, u1, -1);
    settings.mRelativeLinearSurfaceVelocity.Set(...u);
  }

  #side(body: Jolt.Body, id: Jolt.SubShapeID): { shape: Shape; q: Q4 } {
    const b = this.numbers.get(body.GetID().GetIndexAndSequenceNumber())!;
    const s = Number(body.GetShape().GetSubShapeUserData(id));
    return { shape: this.scene.bodies[b].shapes[s], q: this.#motions[b].q };
  }

  begin(motions: Motion[]): void {
    this.#motions = motions;
    this.#seen = 0;
  }

  end(): void {
    const failed = this.#failed;
    this.#failed = undefined;
    if (failed !== undefined) throw failed;
    if (this.#seen < kManifolds) return;
    throw new Error(
      `Jolt has room for ${kManifolds} pairs of shapes that touch, and there are more: use fewer bodies`,
    );
  }

  free(): void {
    J.destroy(this.#listener);
  }
}
