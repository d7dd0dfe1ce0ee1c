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
 * Refuses pairs of materials that an engine without a table of pairs does not give: it multiplies the square roots
 * of friction, and of restitutions the larger holds.
 */
export function checkSurfaces(scene: Scene, engine: string): void {
  const used = new Set<number>();
  for (const body of scene.bodies) {
    if (body.removed) continue;
    for (const shape of body.shapes) if (shape.collides) used.add(shape.material);
  }
  for (const a of used) {
    for (const b of used) {
      const [own, other, pair] = [scene.surfaces[a][a], scene.surfaces[b][b], scene.surfaces[a][b]];
      const friction = Math.sqrt(own.friction * other.friction);
      const restitution = Math.max(own.restitution, other.restitution);
      const same =
        Math.abs(friction - pair.friction) <= 1e-6 * Math.max(1, friction) &&
        Math.abs(restitution - pair.restitution) <= 1e-6;
      if (same) continue;
      throw new Refusal(
        `${engine} combines coefficients by rules alone: the pair of materials ` +
          `'${scene.materials[a].name}' and '${scene.materials[b].name}' has another friction or ` +
          'restitution than the root of the product and the larger one',
      );
    }
  }
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
