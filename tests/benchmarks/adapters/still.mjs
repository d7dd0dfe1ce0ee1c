// An adapter whose engine does nothing: what remains is the exchange.
import { serve } from './cogrsim_backend.mjs';

const still = ['engine', 'nothing'];
serve({
  version: '1.0',
  capabilities: { '*': 'exact' },
  provenance: () => ({
    engine: 'still',
    solver: 'none',
    formulation: 'none',
    integrator: 'none',
    stages: Object.fromEntries(
      ['broad-phase', 'narrow-phase', 'contact-memory', 'contact-law', 'friction', 'restitution',
        'joints', 'limits', 'motors', 'integrator'].map((stage) => [stage, still]),
    ),
  }),
  build(scene, state) {
    const contacts = scene.bodies
      .slice(1, 9)
      .map((_, i) => [0, i + 1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 9.81]);
    return {
      step() {},
      read(out) {
        out.poses.set(state.poses);
        out.twists.set(state.twists);
        out.positions.set(state.positions);
        out.speeds.set(state.speeds);
      },
      write(next) {
        state = next;
      },
      contacts: () => contacts,
      reactions() {},
      save: () => new Uint8Array(),
      restore() {},
    };
  },
});
