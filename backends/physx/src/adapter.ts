// The backend physx: PhysX's rigid bodies, articulations and its step.
import { serve, type Support } from './cogrsim_backend.mjs';
import { version } from './engine.ts';
import { kOptions } from './options.ts';
import { surfacePairs } from './scene.ts';
import { PhysxWorld } from './world.ts';

const kSingle = 'PhysX computes in single precision';
const kFixed: Support = ['unsupported', 'PhysX has meshes and planes on bodies that no forces move'];
const kTypes: Support = ['unsupported', 'this adapter has fixed, hinge, slider, ball and free joints'];
const kBare: Support = [
  'approximate',
  'a joint of iterations, without motor, limit, spring, damper, friction or rotor',
];
const kDamping: Support = ['approximate', "PhysX's drive, implicit; beside a motor that of a second joint"];
const kSpring: Support = ['approximate', "PhysX's drive, implicit; explicit beside a motor"];
const kFriction: Support = ['approximate', "PhysX's drive towards rest; beside a motor that of a second joint"];

const kCapabilities: Record<string, Support> = {
  'shape.*': ['approximate', kSingle],
  'shape.plane': ['approximate', `${kSingle}; on static bodies`],
  'shape.mesh': ['approximate', `${kSingle}; on static and kinematic bodies`],
  'shape.heightmap': ['approximate', `a mesh; ${kSingle}; on static and kinematic bodies`],
  'pair.*': ['approximate', 'nothing below 2 m/s bounces, see bounce-threshold-velocity; single precision'],
  ...surfacePairs(kFixed),
  'joint.*': kTypes,
  'loop.*': kTypes,
  'joint.fixed': ['approximate', `of an articulation; ${kSingle}`],
  'joint.hinge': [
    'approximate',
    'of an articulation, at most 100 rad/s, see max-joint-velocity; friction over its load, see friction-coefficient',
  ],
  'joint.slider': ['approximate', 'of an articulation; friction over its load, see friction-coefficient'],
  'joint.ball': ['approximate', `of an articulation; ${kSingle}`],
  'joint.free': 'exact',
  'loop.fixed': kBare,
  'loop.hinge': kBare,
  'loop.slider': kBare,
  'loop.ball': kBare,
  'loop.free': 'exact',
  'joint.limit.hinge': ['approximate', "PhysX's, at any angle"],
  'joint.limit.slider': ['approximate', "PhysX's"],
  'joint.damping.hinge': kDamping,
  'joint.damping.slider': kDamping,
  'joint.stiffness.hinge': kSpring,
  'joint.stiffness.slider': kSpring,
  'joint.friction.hinge': kFriction,
  'joint.friction.slider': kFriction,
  'joint.rotor-inertia.hinge': ['approximate', `armature; ${kSingle}`],
  'joint.rotor-inertia.slider': ['approximate', `armature; ${kSingle}`],
  'joint.coupling': ['approximate', 'efforts that CogRSim finds before each step'],
  'joint.coupling-effort': ['approximate', 'as joint.coupling'],
  'motor.torque': ['approximate', 'a torque on both bodies over the step'],
  'motor.velocity': ['approximate', "PhysX's drive"],
  'motor.position': ['approximate', "PhysX's drive"],
  'motor.servo': ['approximate', "PhysX's drive"],
  'motor.dc': ['approximate', "PhysX's drive"],
  'body.*': 'exact',
  'contact.*': ['unsupported', "PhysX's interface for JavaScript does not have it"],
  'runtime.*': ['approximate', 'the world is rebuilt: contacts are forgotten'],
  'runtime.attach': ['approximate', 'a joint of iterations, without motor, limit, spring, damper, friction or rotor'],
  'runtime.save': [
    'approximate',
    'what contacts remember is not saved: a pile is some 0.05 mm off after half a second',
  ],
  'report.contact_force': ['approximate', 'its part along the normal'],
  'report.joint_reaction': ['approximate', 'of joints in trees; zero for those that close loops'],
  'report.joint_effort': ['approximate', 'of joints in trees'],
};

serve({
  version,
  coordinates: 'bodies',
  couplings: 'host',
  capabilities: kCapabilities,
  options: kOptions,
  provenance: (options) => ({
    engine: 'PhysX',
    solver: `${String(options['solver-type']).toUpperCase()}, ${options['position-iterations']} iterations over positions and ${options['velocity-iterations']} over velocities`,
    formulation: 'bodies in maximal, articulations in reduced coordinates',
    integrator:
      `semi-implicit Euler, angular damping ${options['angular-damping']} 1/s, at most ` +
      `${options['max-angular-velocity']} rad/s, gyroscopic torque ${options['gyroscopic-forces'] ? 'on' : 'off'}`,
    stages: {
      'broad-phase': ['engine', 'PxScene::simulate, PxBroadPhaseType'],
      'narrow-phase': ['engine', 'PxScene::simulate, persistent contact manifolds'],
      'contact-memory': ['engine', 'PxScene::simulate, persistent contact manifolds'],
      'contact-law': ['engine', `PxScene::simulate, ${String(options['solver-type']).toUpperCase()} solver`],
      friction: ['engine', 'PxFrictionType::ePATCH, the PxCombineMode that gives all pairs'],
      restitution: ['engine', 'bounceThresholdVelocity, the PxCombineMode that gives all pairs'],
      joints: ['engine', 'PxArticulationReducedCoordinate; loops by PxJoint'],
      limits: ['engine', 'PxArticulationJointReducedCoordinate::setLimitParams'],
      motors: [
        'engine',
        'PxArticulationJointReducedCoordinate::setDriveParams (torque motors by PxRigidBody::addTorque)',
      ],
      integrator: ['engine', 'PxScene::simulate'],
    },
  }),
  build: (scene, state, previous) => new PhysxWorld(scene, state, previous as PhysxWorld | undefined),
});
