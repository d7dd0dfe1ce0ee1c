// Jolt's options, with its own names and defaults.
import type { Option, Options } from './cogrsim_backend.mjs';
import { J, type Jolt } from './engine.ts';

const bodies = new J.BodyCreationSettings();
const settings = new J.PhysicsSettings();

/** Those of PhysicsSettings, by their members there. */
const kSettings = {
  mNumVelocitySteps: {
    type: 'integer',
    minimum: 2,
    maximum: 1000,
    description: 'iterations over velocities',
  },
  mNumPositionSteps: { type: 'integer', minimum: 0, maximum: 1000, description: 'iterations over positions' },
  mBaumgarte: {
    minimum: 0,
    maximum: 1,
    description: 'share of an error of position that is taken back in a step',
  },
  mSpeculativeContactDistance: { minimum: 0, unit: 'm', description: 'distance at which contacts begin' },
  mPenetrationSlop: { minimum: 0, unit: 'm', description: 'penetration that is not pushed out' },
  mMinVelocityForRestitution: { minimum: 0, unit: 'm/s', description: 'slower ones do not bounce' },
  mConstraintWarmStart: { description: 'impulses begin with those of the last step' },
  mUseBodyPairContactCache: { description: 'pairs that have hardly moved keep their contacts' },
  mUseManifoldReduction: { description: 'contacts of one pair with nearly the same normal are one' },
} as const satisfies Record<string, Partial<Option>>;

type Name = keyof typeof kSettings;
const names = Object.keys(kSettings) as Name[];

/** mNumVelocitySteps is num-velocity-steps. */
const optionOf = (member: string): string =>
  member
    .replace(/^m/, '')
    .replace(/[A-Z]/g, (letter, at: number) => (at > 0 ? '-' : '') + letter.toLowerCase());
/** Of a float: the shortest number that it stands for. */
const plain = (value: number | boolean): number | boolean =>
  typeof value === 'number' ? Number(Math.fround(value).toPrecision(7)) : value;

const ofBody = (member: keyof Jolt.BodyCreationSettings & string, more: Partial<Option>): Option => ({
  name: optionOf(member),
  default: plain(bodies[member] as number | boolean),
  ...more,
});

export const kOptions: Option[] = [
  ...names.map((name): Option => ({
    name: optionOf(name),
    default: plain(settings[name]),
    ...kSettings[name],
  })),
  ofBody('mLinearDamping', { minimum: 0, unit: '1/s', description: 'of all bodies' }),
  ofBody('mAngularDamping', { minimum: 0, unit: '1/s', description: 'of all bodies' }),
  ofBody('mMaxLinearVelocity', { minimum: 0, unit: 'm/s', description: 'no body moves faster' }),
  ofBody('mMaxAngularVelocity', { minimum: 0, unit: 'rad/s', description: 'no body turns faster' }),
  ofBody('mApplyGyroscopicForce', { description: 'the gyroscopic torque acts on bodies' }),
  ofBody('mEnhancedInternalEdgeRemoval', { description: 'bodies do not catch on edges between triangles' }),
  {
    name: 'motion-quality',
    default: 'discrete',
    choices: ['discrete', 'linear-cast'],
    description: 'linear-cast: continuous collision detection',
  },
  {
    name: 'convex-radius',
    default: 0.05,
    minimum: 0,
    unit: 'm',
    description: 'edges of boxes, cylinders and hulls are rounded, by half of their smallest size at most',
  },
];

export function setSettings(to: Jolt.PhysicsSettings, options: Options): void {
  for (const name of names) Object.assign(to, { [name]: options[optionOf(name)] });
}
