// The backend @NAME@: what it can do, and its worlds. cogrsim_backend.mjs does the rest.
import { Diverged, serve } from './cogrsim_backend.mjs';
import { add, advance, cross, makeBody, norm, turn } from './flight.mjs';

// Beyond these a body has diverged: 1000 km, 100 km/s, 1e6 rad/s.
const kFarthest = 1e6;
const kFastest = 1e5;
const kFastestSpin = 1e6;

const kMotions = { static: 'still', kinematic: 'carried', dynamic: 'free' };

/** The point that the engine moves, in body axes: the centre of mass; of a carried body its origin. */
const movedPoint = (body) => (body.kind === 'dynamic' ? body.com : [0, 0, 0]);

/** Body `b` of the scene with its motion in `state`, as the engine has it. */
function bodyIn(scene, state, b) {
  const model = scene.bodies[b];
  const [x, y, z, ...orientation] = state.poses.subarray(7 * b, 7 * b + 7);
  const twist = [...state.twists.subarray(6 * b, 6 * b + 6)];
  const arm = turn(orientation, movedPoint(model));
  const spin = twist.slice(3);
  return makeBody({
    motion: kMotions[model.kind],
    inertia: model.inertia,
    position: add([x, y, z], arm),
    orientation,
    velocity: add(twist.slice(0, 3), cross(spin, arm)),
    spin,
  });
}

class FlightWorld {
  constructor(scene, state, previous) {
    this.scene = scene;
    this.bodies = scene.bodies.map((model, b) => {
      // After a change of the scene, bodies that stay what they were keep their last digits.
      const old = previous?.bodies[b];
      const stays = old && (model.removed || old.motion === kMotions[model.kind]);
      return stays ? old : bodyIn(scene, state, b);
    });
  }

  step({ dt, twists }) {
    const { gravity, options } = this.scene;
    // A failed step leaves the world as it was.
    this.bodies = this.bodies.map((old, b) => {
      const model = this.scene.bodies[b];
      if (model.removed) return old;
      let body = old;
      if (model.kind === 'kinematic') {
        const twist = [...twists.subarray(6 * b, 6 * b + 6)];
        body = { ...body, velocity: twist.slice(0, 3), spin: twist.slice(3) };
      }
      for (let part = 0; part < options.substeps; ++part) {
        body = advance(body, gravity, dt / options.substeps);
      }
      // This form of the comparison also finds NaN.
      const fine =
        norm(body.position) < kFarthest &&
        norm(body.velocity) < kFastest &&
        norm(body.spin) < kFastestSpin;
      if (!fine) throw new Diverged(`body '${model.name}' left all bounds (1000 km, 100 km/s)`, b);
      return body;
    });
  }

  read(out) {
    this.bodies.forEach((body, b) => {
      const arm = turn(body.orientation, movedPoint(this.scene.bodies[b]));
      out.poses.set([...add(body.position, arm, -1), ...body.orientation], 7 * b);
      if (body.motion === 'still') return;
      const velocity = add(body.velocity, cross(body.spin, arm), -1);
      out.twists.set([...velocity, ...body.spin], 6 * b);
    });
  }

  write(state) {
    this.bodies = this.scene.bodies.map((_, b) => bodyIn(this.scene, state, b));
  }

  save() {
    return Buffer.from(JSON.stringify(this.bodies));
  }

  restore(bytes) {
    this.bodies = JSON.parse(Buffer.from(bytes).toString());
  }
}

serve({
  // Ask the package of your engine, so that the version is that of the package in use.
  version: '0.1',
  // CogRSim refuses scenes by this table before build() is called, with the reason given here, so it
  // must be right. What is not named is unsupported.
  capabilities: {
    'shape.*': 'exact', // a shape alone is drawn only; collisions are features of pairs
    'pair.*': ['unsupported', 'collisions are not computed'],
    'contact.*': ['unsupported', 'collisions are not computed'],
    'joint.*': ['unsupported', 'bodies fly freely, there are no joints'],
    'loop.*': ['unsupported', 'bodies fly freely, there are no joints'],
    'motor.*': ['unsupported', 'there are no joints to drive'],
    'runtime.*': 'exact',
    'runtime.attach': ['unsupported', 'there are no joints'],
    'runtime.joint_axes': ['unsupported', 'there are no joints'],
    'body.static': 'exact',
    'body.kinematic': 'exact',
    'body.force': ['unsupported', 'forces from outside are not applied'],
    'report.contact_force': ['unsupported', 'collisions are not computed'],
    'report.joint_*': ['unsupported', 'there are no joints'],
  },
  options: [
    {
      name: 'substeps',
      type: 'integer',
      default: 1,
      minimum: 1,
      maximum: 1000,
      description: 'number of equal parts of each step',
    },
  ],
  // Every result states which code computed it: the engine, or code of this folder ("cogrsim").
  provenance() {
    const none = ['none', 'bodies fly freely'];
    return {
      engine: 'flight',
      solver: 'none',
      formulation: 'none',
      integrator: 'exact free flight',
      stages: {
        'broad-phase': none,
        'narrow-phase': none,
        'contact-memory': none,
        'contact-law': none,
        friction: none,
        restitution: none,
        joints: none,
        limits: none,
        motors: none,
        integrator: ['engine', 'flight.advance'],
      },
    };
  },
  build: (scene, state, previous) => new FlightWorld(scene, state, previous),
});
