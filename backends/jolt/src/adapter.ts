// The backend jolt: Jolt's rigid bodies, shapes, constraints and its step.
import { serve, type Support } from './cogrsim_backend.mjs';
import { version } from './engine.ts';
import { kOptions } from './options.ts';
import { surfacePairs } from './scene.ts';
import { JoltWorld } from './world.ts';

const kSingle = 'Jolt computes in single precision';
const kSurfaces: Support = ['unsupported', 'two surfaces: neither can be moved by forces'];
const kSpring: Support = ['approximate', "the motor of a constraint, Jolt's: implicit, in single precision"];
const kTypes: Support = ['unsupported', 'this adapter has fixed, hinge, slider, ball and free joints'];

const kCapabilities: Record<string, Support> = {
  'shape.*': ['approximate', `${kSingle}; edges are rounded by the convex radius`],
  'shape.sphere': ['approximate', kSingle],
  'shape.capsule': ['approximate', kSingle],
  'shape.plane': ['approximate', `${kSingle}; a plane ends 100 km from its middle`],
  'shape.mesh': ['approximate', kSingle],
  'shape.heightmap': ['approximate', `a mesh; ${kSingle}`],
  'pair.*': [
    'approximate',
    'nothing below 1 m/s bounces, see min-velocity-for-restitution; single precision',
  ],
  ...surfacePairs(kSurfaces),
  'joint.*': kTypes,
  'loop.*': kTypes,
  'joint.fixed': ['approximate', 'a constraint, solved by iterations'],
  'joint.hinge': [
    'approximate',
    'a constraint, solved by iterations; bodies turn at most 47.1 rad/s, see max-angular-velocity',
  ],
  'joint.slider': ['approximate', 'a constraint, solved by iterations'],
  'joint.ball': ['approximate', 'a constraint, solved by iterations'],
  'joint.free': 'exact',
  'loop.fixed': ['approximate', 'as in trees'],
  'loop.hinge': ['approximate', 'as in trees'],
  'loop.slider': ['approximate', 'as in trees'],
  'loop.ball': ['approximate', 'as in trees'],
  'loop.free': 'exact',
  'joint.limit.hinge': ['approximate', "Jolt's stops, which are of one turn, each in its turn"],
  'joint.limit.slider': ['approximate', "Jolt's stops"],
  'joint.damping.hinge': kSpring,
  'joint.damping.slider': kSpring,
  'joint.stiffness.hinge': kSpring,
  'joint.stiffness.slider': kSpring,
  'joint.friction.hinge': ['approximate', "Jolt's; beside a motor that of a second constraint"],
  'joint.friction.slider': ['approximate', "Jolt's; beside a motor that of a second constraint"],
  'joint.rotor-inertia.hinge': [
    'approximate',
    'a motor towards the speed at the start of the step, as soft as the inertia',
  ],
  'joint.rotor-inertia.slider': [
    'approximate',
    'a motor towards the speed at the start of the step, as soft as the inertia',
  ],
  'joint.coupling': [
    'approximate',
    "Jolt's gears turn speeds and not torques: efforts that CogRSim finds before each step",
  ],
  'joint.coupling-effort': ['approximate', 'as joint.coupling'],
  'motor.torque': ['approximate', 'a torque on both bodies over the step'],
  'motor.velocity': ['approximate', "Jolt's motor"],
  'motor.position': ['approximate', "Jolt's motor, its spring implicit"],
  'motor.servo': ['approximate', "Jolt's motor, its spring implicit"],
  'motor.dc': ['approximate', "Jolt's motor, its damper implicit"],
  'body.*': 'exact',
  'contact.*': ['unsupported', 'Jolt has no such property of contacts'],
  'contact.surface-velocity': 'exact',
  'runtime.*': ['approximate', 'the world is rebuilt: contacts and constraints lose their impulses'],
  'runtime.save': 'exact',
  'report.contact_force': ['approximate', 'friction is that of a manifold, shared by its points'],
  'report.joint_reaction': ['approximate', kSingle],
  'report.joint_effort': ['approximate', kSingle],
};

serve({
  version,
  coordinates: 'bodies',
  couplings: 'host',
  capabilities: kCapabilities,
  options: kOptions,
  provenance: (options) => ({
    engine: 'Jolt',
    solver: `sequential impulses, ${options['num-velocity-steps']} over velocities and ${options['num-position-steps']} over positions`,
    formulation: 'maximal coordinates, constraints',
    integrator:
      `semi-implicit Euler, damping ${options['linear-damping']} and ${options['angular-damping']} 1/s, ` +
      `at most ${options['max-angular-velocity']} rad/s, gyroscopic torque ${options['apply-gyroscopic-force'] ? 'on' : 'off'}`,
    stages: {
      'broad-phase': ['engine', 'BroadPhaseQuadTree'],
      'narrow-phase': ['engine', 'CollisionDispatch'],
      'contact-memory': ['engine', 'ContactConstraintManager: cached manifolds with their impulses'],
      'contact-law': ['engine', 'ContactConstraintManager::SolveVelocityConstraints'],
      friction: [
        'engine',
        'ContactConstraintManager (coefficients by ContactListener where they are not by its rules)',
      ],
      restitution: ['engine', 'ContactConstraintManager, mMinVelocityForRestitution'],
      joints: ['engine', 'FixedConstraint, HingeConstraint, SliderConstraint, PointConstraint'],
      limits: ['engine', 'HingeConstraint::SetLimits, SliderConstraint::SetLimits'],
      motors: ['engine', 'MotorSettings of constraints (torque motors by Body::AddTorque)'],
      integrator: ['engine', 'PhysicsSystem::Update'],
    },
  }),
  build: (scene, state) => new JoltWorld(scene, state),
});
