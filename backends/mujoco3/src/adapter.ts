// The backend mujoco3: MuJoCo 3 as its package for JavaScript ships it.
import { serve, type Support } from './cogrsim_backend.mjs';
import { mujoco } from './engine.ts';
import { kElementOptions, kWorldOptions } from './options.ts';
import { MujocoWorld } from './world.ts';

const kSoft = 'soft contact: rests in penetration, creeps under friction that should hold, bounces approximately';
const kLoop = 'MuJoCo closes loops by points and welds: let a plain hinge, ball or fixed joint close it';
const kSource = 'an explicit actuator with the gain that stops the axis in a step: lags by load over gain';
const kHulls = 'MuJoCo has meshes as their convex hulls; use convex meshes';

const kCapabilities: Record<string, Support> = {
  'shape.*': 'exact',
  'shape.convex-mesh': ['approximate', 'MuJoCo stores corners as floats'],
  'shape.heightmap': ['approximate', 'MuJoCo stores heights as floats'],
  'shape.mesh': ['unsupported', kHulls],
  'pair.*': ['approximate', kSoft],
  'pair.*-mesh': ['unsupported', kHulls],
  'pair.*-convex-mesh': ['approximate', kSoft],
  'pair.mesh-*': ['unsupported', kHulls],
  'pair.plane-plane': ['unsupported', 'two surfaces: neither can be moved'],
  'pair.plane-heightmap': ['unsupported', 'two surfaces: neither can be moved'],
  'pair.heightmap-heightmap': ['unsupported', 'two surfaces: neither can be moved'],
  'joint.*': 'exact',
  'joint.screw': ['approximate', 'its travel is tied to its angle by a soft constraint, see solrefequality'],
  'joint.limit.*': ['approximate', 'a soft stop, see solreflimit'],
  'joint.friction.*': ['approximate', 'creeps under loads that it should hold, see solreffriction'],
  'joint.stiffness.*': ['approximate', 'an explicit spring'],
  'joint.*.fixed': ['unsupported', 'this joint has no axes'],
  'joint.*.free': ['unsupported', 'this joint has no axes'],
  'joint.coupling': ['approximate', 'a soft constraint, see solrefequality; its effort is not reported'],
  'joint.coupling-effort': ['unsupported', "MuJoCo's equalities have no bound of their effort"],
  'loop.*': ['unsupported', kLoop],
  'loop.hinge': ['approximate', 'a soft constraint, see solrefequality'],
  'loop.ball': ['approximate', 'a soft constraint, see solrefequality'],
  'loop.fixed': ['approximate', 'a soft constraint, see solrefequality'],
  'loop.free': 'exact',
  'motor.*': 'exact',
  'motor.velocity': ['approximate', kSource],
  'motor.position': ['approximate', kSource],
  'contact.*': ['unsupported', "MuJoCo's contacts yield by acceleration and have no velocity of surfaces"],
  'contact.rolling-friction': ['approximate', 'one pyramid with sliding; creeps'],
  'contact.spinning-friction': ['approximate', 'one pyramid with sliding; creeps'],
  'body.*': 'exact',
  'runtime.*': ['approximate', 'compiled again: motions go on to rounding, forces of contacts start again'],
  'runtime.save': 'exact',
  'runtime.attach': ['approximate', 'a soft constraint, see solrefequality, by plain hinges, balls and fixed joints'],
  'runtime.body_kind': ['approximate', 'what is jointed to a body made static keeps its joint speeds'],
  'report.contact_force': 'exact',
  'report.joint_effort': 'exact',
  'report.joint_reaction': ['approximate', 'of joints in trees; zero for those that close loops or attach'],
};

serve({
  version: mujoco.mj_versionString(),
  coordinates: 'bodies',
  couplings: 'engine',
  capabilities: kCapabilities,
  options: kWorldOptions,
  elementOptions: kElementOptions,
  provenance: options => {
    const { integrator, solver, cone } = options as Record<string, string>;
    const methods: Record<string, string> = {
      Newton: "Newton's method",
      CG: 'conjugate gradients',
      PGS: 'projected Gauss-Seidel',
    };
    const integrators: Record<string, string> = {
      Euler: 'semi-implicit Euler',
      RK4: 'Runge-Kutta 4',
      implicit: 'implicit in velocity',
      implicitfast: 'implicit in velocity, symmetric',
    };
    return {
      engine: 'MuJoCo',
      solver: `${methods[solver]}, ${cone} cones`,
      formulation: 'generalized coordinates, soft constraints',
      integrator: integrators[integrator],
      stages: {
        'broad-phase': ['engine', 'mj_collision'],
        'narrow-phase': ['engine', 'mj_collision'],
        'contact-memory': ['engine', 'mjData.qacc_warmstart'],
        'contact-law': ['engine', `mj_makeConstraint, solver ${solver}`],
        friction: ['engine', `mj_makeConstraint, solver ${solver}`],
        restitution: ['engine', 'solref of a damped spring'],
        joints: ['engine', 'joints of mjModel; connect, weld and joint equalities'],
        limits: ['engine', `mjCNSTR_LIMIT_JOINT, solver ${solver}`],
        motors: ['engine', 'mj_fwdActuation; stiff laws as dof_damping, bounded by CogRSim'],
        integrator: ['engine', `mj_step, ${integrator}`],
      },
    };
  },
  build: (scene, state, previous) => new MujocoWorld(scene, state, previous as MujocoWorld | undefined),
});
