// Shapes of the scene as Rapier's colliders.
import RAPIER from '@dimforge/rapier3d-compat';

import { Refusal, type Scene, type Shape } from './cogrsim_backend.mjs';
import { xyzw } from './convert.ts';
import { multiply, type Q4 } from './math.ts';
import { heightMesh, type Rule, type Rules } from './scene.ts';

/** Rapier's capsules and cylinders have their axis along y, those of scenes along z. */
const kYToZ: Q4 = [Math.SQRT1_2, Math.SQRT1_2, 0, 0];

const trimesh = (points: number[], corners: number[]): RAPIER.ColliderDesc =>
  RAPIER.ColliderDesc.trimesh(Float32Array.from(points), Uint32Array.from(corners));

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
      return trimesh(mesh.vertices, mesh.triangles);
    case 'heightmap':
      return trimesh(...heightMesh(scene, shape.heightmap));
  }
}

const kCombine: Record<Rule, RAPIER.CoefficientCombineRule> = {
  multiply: RAPIER.CoefficientCombineRule.Multiply,
  max: RAPIER.CoefficientCombineRule.Max,
  min: RAPIER.CoefficientCombineRule.Min,
  average: RAPIER.CoefficientCombineRule.Average,
};

/** A collider without mass. */
export function colliderOf(scene: Scene, rules: Rules, shape: Shape): RAPIER.ColliderDesc {
  const [x, y, z, ...rotation] = shape.X_BS;
  const turned = shape.type === 'capsule' || shape.type === 'cylinder';
  const { friction, restitution } = rules;
  return describe(scene, shape)
    .setTranslation(x, y, z)
    .setRotation(xyzw(turned ? multiply(rotation, kYToZ) : rotation))
    .setDensity(0)
    .setFriction(friction.own(shape.material))
    .setFrictionCombineRule(kCombine[friction.rule])
    .setRestitution(restitution.own(shape.material))
    .setRestitutionCombineRule(kCombine[restitution.rule]);
}
