// What adapters of several engines make of a scene.
import { Refusal, type Scene, type Support } from './cogrsim_backend.mjs';

/** Both triangles of each cell of a heightmap, with the diagonal of scenes: points, and three of them each. */
export function heightMesh(scene: Scene, index: number): [number[], number[]] {
  const { columns, rows, size_x, size_y, heights } = scene.heightmaps[index];
  const points: number[] = [];
  const corners: number[] = [];
  for (let r = 0; r < rows; ++r) {
    for (let c = 0; c < columns; ++c) {
      const x = (c / (columns - 1) - 0.5) * size_x;
      points.push(x, (r / (rows - 1) - 0.5) * size_y, heights[r * columns + c]);
      if (r + 1 === rows || c + 1 === columns) continue;
      const low = r * columns + c;
      const high = low + columns;
      corners.push(low, low + 1, high + 1, low, high + 1, high);
    }
  }
  return [points, corners];
}

/**
 * What makes one coefficient of two values, as engines without a table of pairs do; `own`: the value of a material from
 * the coefficients of its pairs, for `multiply` and `average` of that with itself. Maxima of pairs need the least of them: a value is at most
 * that, and with the largest that may be each pair reaches its own. Minima likewise.
 */
const kRules = {
  multiply: { own: ([self]: number[]): number => Math.sqrt(self), of: (a: number, b: number): number => a * b },
  max: { own: (pairs: number[]): number => Math.min(...pairs), of: Math.max },
  min: { own: (pairs: number[]): number => Math.max(...pairs), of: Math.min },
  average: { own: ([self]: number[]): number => self, of: (a: number, b: number): number => (a + b) / 2 },
};
export type Rule = keyof typeof kRules;
export type Rules = Record<'friction' | 'restitution', { rule: Rule; own: (material: number) => number }>;

/** Pairs of materials that may touch: of two bodies, of which forces move one. */
function touching({ bodies }: Scene): [number, number][] {
  const of = new Map<number, Set<number>>(); // bodies, by material
  bodies.forEach((body, b) => {
    if (body.removed) return;
    for (const shape of body.shapes) {
      if (shape.collides) of.set(shape.material, (of.get(shape.material) ?? new Set()).add(b));
    }
  });
  const meet = (a: Set<number>, b: Set<number>): boolean =>
    [...a].some((i) => bodies[i].kind === 'dynamic' && (b.size > 1 || !b.has(i)));
  const all = [...of];
  return all.flatMap(([a, with_a], i) =>
    all.slice(i).flatMap(([b, with_b]) => (meet(with_a, with_b) || meet(with_b, with_a) ? [[a, b]] : [])),
  ) as [number, number][];
}

/**
 * The rules of an engine that give all pairs of materials that may touch the coefficients of the scene; refused where
 * none does: such engines have no table of pairs.
 */
export function combineRules(scene: Scene, engine: string): Rules {
  const pairs = touching(scene);
  const nameOf = (material: number): string => {
    const shape = scene.bodies.flatMap((body) => body.shapes).find((it) => it.material === material);
    const { name } = scene.materials[material];
    return name ? `'${name}'` : `that of shape '${shape?.name}'`;
  };
  const find = (what: 'friction' | 'restitution', rules: Rule[]): { rule: Rule; own: (m: number) => number } => {
    const touched = scene.materials.map((): number[] => []); // the coefficients of a material's pairs
    for (const [a, b] of pairs) {
      for (const m of new Set([a, b])) touched[m].push(scene.surfaces[a][b][what]);
    }
    const own = (rule: Rule, m: number): number => {
      const isExtreme = (rule === 'max' || rule === 'min') && touched[m].length > 0;
      return kRules[rule].own(isExtreme ? touched[m] : [scene.surfaces[m][m][what]]);
    };
    const misses = (rule: Rule): [number, number] | undefined =>
      pairs.find(([a, b]) => {
        const wanted = scene.surfaces[a][b][what];
        const given = kRules[rule].of(own(rule, a), own(rule, b));
        return !(Math.abs(given - wanted) <= 1e-6 * Math.max(1, wanted));
      });
    const rule = rules.find((it) => misses(it) === undefined);
    if (rule) return { rule, own: (m) => own(rule, m) };
    const [a, b] = misses(rules[0])!;
    throw new Refusal(
      `${engine} makes the ${what} of a pair from values of its two materials, as their root product, maximum, ` +
        `minimum or mean: none of these gives the ${what} of all pairs, as of ${nameOf(a)} and ${nameOf(b)}, ` +
        `${scene.surfaces[a][b][what]}`,
    );
  };
  return {
    friction: find('friction', ['multiply', 'max', 'min', 'average']),
    restitution: find('restitution', ['max', 'multiply', 'min', 'average']),
  };
}

/** The motors on a joint, by their index. */
export const motorsOf = (scene: Scene, joint: number): number[] =>
  scene.motors.flatMap((motor, m) => (motor.joint === joint && !motor.removed ? [m] : []));

/** Of pairs of shapes that are surfaces, of which neither moves. */
export const surfacePairs = (support: Support): Record<string, Support> => {
  const surfaces = ['plane', 'mesh', 'heightmap'];
  const pairs = surfaces.flatMap((a, i) => surfaces.slice(i).map((b) => `pair.${a}-${b}`));
  return Object.fromEntries(pairs.map((pair) => [pair, support]));
};
