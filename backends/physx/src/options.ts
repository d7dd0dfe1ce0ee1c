// PhysX's options, with its own names and defaults.
import type { Option } from './cogrsim_backend.mjs';
import { P, physics, scale } from './engine.ts';

/** Read from objects that PhysX makes; they are released. */
function defaults(): Record<string, number> {
  const desc = new P.PxSceneDesc(scale);
  const here = new P.PxTransform(P.PxIDENTITYEnum.PxIdentity);
  const body = physics.createRigidDynamic(here);
  const articulation = physics.createArticulationReducedCoordinate();
  const root = articulation.createLink(null as never, here);
  const link = articulation.createLink(root, here);
  const joint = link.getInboundJoint();
  const material = physics.createMaterial(0.5, 0.5, 0);
  const sphere = new P.PxSphereGeometry(0.5);
  const shape = physics.createShape(sphere, material);
  const out = {
    bounceThreshold: desc.bounceThresholdVelocity,
    frictionOffset: desc.frictionOffsetThreshold,
    frictionCorrelation: desc.frictionCorrelationDistance,
    angular: body.getAngularDamping(),
    linear: body.getLinearDamping(),
    linkAngular: link.getAngularDamping(),
    linkLinear: link.getLinearDamping(),
    maxAngular: body.getMaxAngularVelocity(),
    maxLinear: body.getMaxLinearVelocity(),
    maxDepenetration: body.getMaxDepenetrationVelocity(),
    jointFriction: joint.getFrictionCoefficient(),
    jointSpeed: joint.getMaxJointVelocity(),
    contactOffset: shape.getContactOffset(),
    restOffset: shape.getRestOffset(),
  };
  for (const it of [shape, material, articulation, body]) it.release();
  for (const it of [sphere, here, desc]) P.destroy(it);
  return Object.fromEntries(Object.entries(out).map(([key, value]) => [key, Number(value.toPrecision(7))]));
}

const d = defaults();

export const kOptions: Option[] = [
  { name: 'solver-type', default: 'pgs', choices: ['pgs', 'tgs'], description: 'PxSolverType' },
  {
    name: 'position-iterations',
    type: 'integer',
    default: 4,
    minimum: 1,
    maximum: 255,
    description: 'of the solver',
  },
  {
    name: 'velocity-iterations',
    type: 'integer',
    default: 1,
    minimum: 0,
    maximum: 255,
    description: 'of the solver',
  },
  {
    name: 'bounce-threshold-velocity',
    default: d.bounceThreshold,
    minimum: 1e-6,
    unit: 'm/s',
    description: 'slower ones do not bounce',
  },
  {
    name: 'friction-offset-threshold',
    default: d.frictionOffset,
    minimum: 0,
    unit: 'm',
    description: 'friction begins at this distance',
  },
  {
    name: 'friction-correlation-distance',
    default: d.frictionCorrelation,
    minimum: 0,
    unit: 'm',
    description: 'contacts that are nearer share their friction',
  },
  {
    name: 'contact-offset',
    default: d.contactOffset,
    minimum: 1e-6,
    unit: 'm',
    description: 'distance at which contacts begin',
  },
  { name: 'rest-offset', default: d.restOffset, unit: 'm', description: 'distance at which shapes rest' },
  {
    name: 'linear-damping',
    default: d.linear,
    minimum: 0,
    unit: '1/s',
    description: 'of bodies without joints',
  },
  {
    name: 'angular-damping',
    default: d.angular,
    minimum: 0,
    unit: '1/s',
    description: 'of bodies without joints',
  },
  {
    name: 'link-linear-damping',
    default: d.linkLinear,
    minimum: 0,
    unit: '1/s',
    description: 'of bodies with joints',
  },
  {
    name: 'link-angular-damping',
    default: d.linkAngular,
    minimum: 0,
    unit: '1/s',
    description: 'of bodies with joints',
  },
  {
    name: 'max-linear-velocity',
    default: d.maxLinear,
    minimum: 0,
    unit: 'm/s',
    description: 'no body moves faster',
  },
  {
    name: 'max-angular-velocity',
    default: d.maxAngular,
    minimum: 0,
    unit: 'rad/s',
    description: 'no body turns faster',
  },
  {
    name: 'max-depenetration-velocity',
    default: d.maxDepenetration,
    minimum: 1e-6,
    unit: 'm/s',
    description: 'bodies are pushed apart no faster',
  },
  {
    name: 'max-joint-velocity',
    default: d.jointSpeed,
    minimum: 0,
    description: 'no joint is faster [rad/s] or [m/s]',
  },
  {
    name: 'friction-coefficient',
    default: d.jointFriction,
    minimum: 0,
    description: 'friction of joints over their load',
  },
  {
    name: 'gyroscopic-forces',
    default: false,
    description: 'the gyroscopic torque acts on bodies without joints',
  },
  { name: 'pcm', default: true, description: 'PxSceneFlag::eENABLE_PCM, contacts are remembered' },
  { name: 'ccd', default: false, description: 'continuous collision detection of all bodies' },
  { name: 'stabilization', default: false, description: 'PxSceneFlag::eENABLE_STABILIZATION' },
  { name: 'enhanced-determinism', default: false, description: 'PxSceneFlag::eENABLE_ENHANCED_DETERMINISM' },
];
