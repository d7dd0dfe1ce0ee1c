// MuJoCo's options by its own names, and as attributes of MJCF.
import { type Option, type Options, Refusal } from './cogrsim_backend.mjs';

const kRef = '0.02 1';
const kImp = '0.9 0.95 0.001 0.5 2';
const ref = (name: string, what: string): Option => ({
  name,
  default: kRef,
  description: `${what}: timeconst [s] and dampratio, or -stiffness and -damping`,
});
const imp = (name: string, what: string): Option => ({
  name,
  default: kImp,
  description: `${what}: dmin, dmax, width, midpoint, power`,
});
const flag = (name: string, description: string): Option => ({ name, default: true, description });
const choice = (name: string, description: string, ...choices: string[]): Option => ({
  name,
  default: choices[0],
  choices,
  description,
});
const number = (name: string, initial: number, minimum: number, maximum: number, description: string): Option => ({
  name,
  default: initial,
  minimum,
  maximum,
  description,
});
const count = (...of: Parameters<typeof number>): Option => ({ ...number(...of), type: 'integer' });
const length = (...of: Parameters<typeof number>): Option => ({ ...number(...of), unit: 'm' });

const kLimits = [ref('solreflimit', 'of limits of joints'), imp('solimplimit', 'of limits of joints')];
const kFriction = [
  ref('solreffriction', 'of dry friction in joints'),
  imp('solimpfriction', 'of dry friction in joints'),
];
const kEquality = [
  ref('solrefequality', 'of loops, screws and couplings'),
  imp('solimpequality', 'of loops, screws and couplings'),
];
const kContact = [
  ref('solref', 'of contacts that do not bounce'),
  imp('solimp', 'of contacts'),
  length('margin', 0, 0, 1, 'distance at which a contact begins'),
];

export const kWorldOptions: Option[] = [
  choice(
    'integrator',
    'semi-implicit Euler, Runge-Kutta of fourth order, or implicit in the velocity',
    ...['Euler', 'RK4', 'implicit', 'implicitfast'],
  ),
  choice('solver', 'of constraints; CG for heaps of more than 100 free bodies', 'Newton', 'CG', 'PGS'),
  choice('cone', 'of friction; the pyramid turns what slides', 'pyramidal', 'elliptic'),
  choice('jacobian', 'how matrices of constraints are held', 'auto', 'dense', 'sparse'),
  count('iterations', 100, 1, 1e5, 'of the solver'),
  number('tolerance', 1e-8, 0, 1, 'at which the solver stops'),
  count('noslip-iterations', 0, 0, 1e5, 'sweeps after the solver against slip'),
  number('impratio', 1, 1e-6, 1e6, 'impedance of friction over that of the normal'),
  flag('multiccd', 'several points where convex shapes meet'),
  flag('nativeccd', "MuJoCo's own distance of convex shapes; else libccd's"),
  flag('island', 'constraints are solved by islands'),
  ...[...kContact, ...kLimits, ...kFriction, ...kEquality],
];

export const kElementOptions = {
  material: [
    ...kContact,
    length('gap', 0, 0, 1, 'part of the margin without force'),
    number('solmix', 1, 0, 1e10, 'weight where two are mixed'),
    count('priority', 0, -1000, 1000, 'the higher one has its solref and solimp'),
  ],
  joint: [...kLimits, ...kFriction, ...kEquality],
  couple: kEquality,
};

/** Numbers of an option like solref; `where` is for the message. */
export function listOf(options: Options, name: string, where: string): number[] {
  const text = String(options[name]);
  const list = text
    .trim()
    .split(/[\s,]+/)
    .map(Number);
  const isRef = name.startsWith('solref');
  if (list.length !== (isRef ? 2 : 5) || !list.every(Number.isFinite)) {
    throw new Refusal(`${where}: ${name}="${text}" must be ${isRef ? 'two' : 'five'} numbers`);
  }
  const [a, b] = list;
  if (isRef && !((a > 0 && b > 0) || (a <= 0 && b <= 0))) {
    throw new Refusal(
      `${where}: ${name}="${text}" must be both positive (timeconst, dampratio) or both not ` +
        'positive (-stiffness, -damping)',
    );
  }
  return list;
}

/** Those of the world, overruled by those of an element. */
export const over = (world: Options, own: Options): Options => ({ ...world, ...own });

export function optionElement(options: Options, dt: number, gravity: readonly number[]): string {
  for (const { name } of [...kContact, ...kLimits, ...kFriction, ...kEquality]) {
    if (name !== 'margin') listOf(options, name, '<physics>');
  }
  const same = ['integrator', 'solver', 'cone', 'jacobian', 'iterations', 'tolerance', 'impratio'];
  const given = same.map(name => `${name}="${options[name]}"`).join(' ');
  const flags = ['multiccd', 'nativeccd', 'island']
    .map(name => `${name}="${options[name] ? 'enable' : 'disable'}"`)
    .join(' ');
  // A state that has left all bounds is not to be replaced by the first one.
  return (
    `<option timestep="${dt}" gravity="${gravity.join(' ')}" ${given} ` +
    `noslip_iterations="${options['noslip-iterations']}">` +
    `<flag filterparent="disable" autoreset="disable" ${flags}/></option>\n`
  );
}
