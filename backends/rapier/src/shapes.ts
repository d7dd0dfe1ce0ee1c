// Shapes of the scene as Rapier's colliders.
import RAPIER from '@dimforge/rapier3d-compat';

import { Refusal, type Scene, type Shape } from './cogrsim_backend.mjs';
import { multiply, type Q4, xyzw } from './math.ts';

/** Rapier's capsules and cylinders have their axis along y, those of scenes along z. */
const kYToZ: Q4 = [Math.SQRT1_2, Math.SQRT1_2, 0, 0];

/** Both triangles of each cell, with the diagonal of scenes. */
function heightMesh(scene: Scene, index: number): [Float32Array, Uint32Array] {
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
  return [Float32Array.from(points), Uint32Array.from(corners)];
}

function describe(scene: Scene, shape: Shape): RAPIER.ColliderDesc {
  const mesh = scene.meshes[shape.mesh];
  switch (shape.type) {
    case 'box':
      return RAPIER.ColliderDesc.cuboid(shape.size[0] / 2, shape.size[1] / 2, shape.size[2] / 2);
    case 'sphere':
      return RAPIER.ColliderDesc.ball(shape.radius);
    case 'cylinder':
      return RAPIER.ColliderDesc.cylinder(shape.length / 2, shape.radius);
    case 'capsule':
      return RAPIER.ColliderDesc.capsule(shape.length / 2, shape.radius);
    case 'plane':
      return new RAPIER.ColliderDesc(new RAPIER.HalfSpace({ x: 0, y: 0, z: 1 }));
    case 'convex-mesh': {
      const hull = RAPIER.ColliderDesc.convexHull(Float32Array.from(mesh.vertices));
      if (!hull) throw new Refusal(`shape '${shape.name}': Rapier finds no convex hull of its mesh`);
      return hull;
    }
    case 'mesh':
      return RAPIER.ColliderDesc.trimesh(
        Float32Array.from(mesh.vertices),
        Uint32Array.from(mesh.triangles),
      );
    case 'heightmap':
      return RAPIER.ColliderDesc.trimesh(...heightMesh(scene, shape.heightmap));
  }
}

/**
 * A collider without mass. Rapier has rules for the coefficients of a pair, and no table: the square
 * roots are multiplied, which is what scenes mean by friction, and of restitutions the larger holds.
 */
export function colliderOf(scene: Scene, shape: Shape): RAPIER.ColliderDesc {
  const [x, y, z, ...rotation] = shape.X_BS;
  const turned = shape.type === 'capsule' || shape.type === 'cylinder';
  const surface = scene.surfaces[shape.material][shape.material];
  return describe(scene, shape)
    .setTranslation(x, y, z)
    .setRotation(xyzw(turned ? multiply(rotation, kYToZ) : rotation))
    .setDensity(0)
    .setFriction(Math.sqrt(surface.friction))
    .setFrictionCombineRule(RAPIER.CoefficientCombineRule.Multiply)
    .setRestitution(surface.restitution)
    .setRestitutionCombineRule(RAPIER.CoefficientCombineRule.Max);
}

/** Refuses pairs of materials that these rules do not give. */
export function checkSurfaces(scene: Scene): void {
  const used = new Set<number>();
  for (const body of scene.bodies) {
    if (body.removed) continue;
    for (const shape of body.shapes) if (shape.collides) used.add(shape.material);
  }
  for (const a of used) {
    for (const b of used) {
      const [own, other, pair] = [
        scene.surfaces[a][a],
        scene.surfaces[b][b],
        scene.surfaces[a][b],
      ];
      const friction = Math.sqrt(own.friction * other.friction);
      const restitution = Math.max(own.restitution, other.restitution);
      const same =
        Math.abs(friction - pair.friction) <= 1e-6 * Math.max(1, friction) &&
        Math.abs(restitution - pair.restitution) <= 1e-6;
      if (same) continue;
      throw new Refusal(
        `Rapier combines coefficients by rules alone: the pair of materials ` +
          `'${scene.materials[a].name}' and '${scene.materials[b].name}' has another friction or ` +
          'restitution than the root of the product and the larger one',
      );
    }
  }
}

