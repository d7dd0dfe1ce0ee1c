// What materials have with each other, as MuJoCo's geoms and pairs.
import type { Scene } from './cogrsim_backend.mjs';
import { listOf, over } from './options.ts';

export interface Geom {
  body: number;
  shape: number;
  material: number;
  mobile: boolean;
}

interface Law {
  friction: number[]; // sliding, spinning, rolling
  solref: number[];
  solimp: number[];
  margin: number;
  gap: number;
  bounces: boolean;
}
interface Own extends Law {
  solmix: number;
  priority: number;
}

/** Below it a spring and dashpot has no damping ratio of at most 1. */
const kLeastRestitution = Math.exp(-2);

/** Damping ratio of a spring and dashpot that only pushes, by which a body leaves it with `restitution`
 * times its speed (Schwager and Poeschel, Phys. Rev. E 75, 051304). */
function dampingRatio(restitution: number): number {
  let [low, high] = [0, 1];
  for (let i = 0; i < 60; ++i) {
    const z = (low + high) / 2;
    const s = Math.sqrt(1 - z * z);
    const left = Math.exp((-z / s) * Math.atan2(2 * z * s, 2 * z * z - 1));
    if (left > restitution) low = z;
    else high = z;
  }
  return low;
}

/** MuJoCo's rule for two geoms, as its manual has it. */
function combined(a: Own, b: Own): Law {
  const common = { margin: Math.max(a.margin, b.margin), gap: Math.max(a.gap, b.gap) };
  if (a.priority !== b.priority) return { ...(a.priority > b.priority ? a : b), ...common };
  const sum = a.solmix + b.solmix;
  const share = sum > 0 ? a.solmix / sum : 0.5;
  const mix = (x: number[], y: number[]): number[] => x.map((v, i) => share * v + (1 - share) * y[i]);
  const timed = a.solref[0] > 0 && b.solref[0] > 0;
  return {
    ...common,
    friction: a.friction.map((x, i) => Math.max(x, b.friction[i])),
    solref: timed ? mix(a.solref, b.solref) : a.solref.map((x, i) => Math.min(x, b.solref[i])),
    solimp: mix(a.solimp, b.solimp),
    bounces: a.bounces && b.bounces,
  };
}

const isSame = (a: Law, b: Law): boolean =>
  (['friction', 'solref', 'solimp'] as const).every(key => a[key].every((x, i) => x === b[key][i])) &&
  a.margin === b.margin &&
  a.gap === b.gap;

/** Without friction a contact has one row, with sliding alone three. */
function attributes(law: Law, ofPair: boolean): string {
  const [slide, spin, roll] = law.friction;
  const condim = roll > 0 ? 6 : spin > 0 ? 4 : slide > 0 ? 3 : 1;
  const friction = ofPair ? [slide, slide, spin, roll, roll] : [slide, spin, roll];
  return (
    `condim="${condim}" friction="${friction.join(' ')}" solref="${law.solref.join(' ')}" ` +
    `solimp="${law.solimp.join(' ')}" margin="${law.margin}" gap="${law.gap}"`
  );
}

/** MJCF: a default class for each material, and a pair of geoms where their rule gives something else. */
export function writeSurfaces(
  scene: Scene,
  geoms: Geom[],
  mayTouch: (a: number, b: number) => boolean,
): { classes: string; pairs: string } {
  // A bounce takes some dozen steps.
  const frequency = 1 / (4 * scene.step);
  const withSurface = (law: Law, a: number, b: number): Law => {
    const surface = scene.surfaces[a][b];
    const friction = [surface.friction, surface.spinning_friction, surface.rolling_friction];
    if (!(surface.restitution > kLeastRestitution)) return { ...law, friction, bounces: false };
    const damping = 2 * dampingRatio(surface.restitution) * frequency;
    return { ...law, friction, solref: [-(frequency ** 2), -damping], bounces: true };
  };
  const own = scene.materials.map((material, m): Own => {
    const options = over({ gap: 0, solmix: 1, priority: 0, ...scene.options }, material.options);
    const where = `material '${material.name}'`;
    const law = {
      friction: [],
      solref: listOf(options, 'solref', where),
      solimp: listOf(options, 'solimp', where),
      margin: Number(options.margin),
      gap: Number(options.gap),
      bounces: false,
    };
    return { ...withSurface(law, m, m), solmix: Number(options.solmix), priority: Number(options.priority) };
  });
  const used = [...new Set(geoms.map(geom => geom.material))].sort((a, b) => a - b);
  let [classes, pairs] = ['', ''];
  used.forEach((a, at) => {
    classes +=
      `<default class="s${a}"><geom priority="${own[a].priority}" solmix="${own[a].solmix}" ` +
      `${attributes(own[a], false)}/></default>\n`;
    for (const b of used.slice(at)) {
      const rule = combined(own[a], own[b]);
      const wanted = withSurface(rule, a, b);
      if (isSame(rule, wanted) && !wanted.bounces) continue;
      // What bounces has next to no damping, and friction would have that, too; MuJoCo has the
      // damping of friction by itself in pairs of geoms, with elliptic cones.
      const slip = wanted.bounces ? ` solreffriction="${listOf(scene.options, 'solref', 'physics').join(' ')}"` : '';
      geoms.forEach((one, i) =>
        geoms.forEach((two, k) => {
          const ofThese = one.material === a && two.material === b && (a !== b || i < k);
          if (!ofThese || one.body === two.body || !(one.mobile || two.mobile)) return;
          if (!mayTouch(one.body, two.body)) return;
          pairs += `<pair geom1="g${Math.min(i, k)}" geom2="g${Math.max(i, k)}" ${attributes(wanted, true)}${slip}/>\n`;
        }),
      );
    }
  });
  return { classes, pairs };
}
