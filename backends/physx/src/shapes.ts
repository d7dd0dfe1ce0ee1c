// Shapes of the scene as PhysX's geometries, and what materials have with each other.
import { type Body, Refusal, type Scene, type Shape } from './cogrsim_backend.mjs';
import { P, type PhysX, physics, said, scale, transform, vec } from './engine.ts';
import { multiply, poseOf, type Q4 } from './math.ts';
import { combineRules, heightMesh, type Rules } from './scene.ts';

/** PhysX's capsules and cylinders have their axis along x, and its planes look along it; those of scenes along z. */
const kXToZ: Q4 = [Math.SQRT1_2, 0, -Math.SQRT1_2, 0];

function points(of: number[]): PhysX.PxArray_PxVec3 {
  const out = new P.PxArray_PxVec3();
  for (let i = 0; i < of.length; i += 3) out.pushBack(vec(of, i));
  return out;
}

function hull(name: string, vertices: number[]): PhysX.PxGeometry {
  const all = points(vertices);
  const desc = new P.PxConvexMeshDesc();
  desc.flags = new P.PxConvexFlags(P.PxConvexFlagEnum.eCOMPUTE_CONVEX);
  desc.points.count = vertices.length / 3;
  desc.points.stride = 12;
  desc.points.data = all.begin();
  const params = new P.PxCookingParams(scale);
  said();
  const mesh = P.CreateConvexMesh(params, desc);
  for (const it of [all, desc, params]) P.destroy(it);
  if ((mesh as unknown as { ptr: number }).ptr === 0) {
    throw new Refusal(
      `shape '${name}': PhysX makes no convex hull of its mesh: ${said() || 'at most 255 corners'}`,
    );
  }
  return new P.PxConvexMeshGeometry(mesh);
}

function mesh(name: string, vertices: number[], triangles: number[]): PhysX.PxGeometry {
  const all = points(vertices);
  const corners = new P.PxArray_PxU32();
  for (const corner of triangles) corners.pushBack(corner);
  const desc = new P.PxTriangleMeshDesc();
  desc.points.count = vertices.length / 3;
  desc.points.stride = 12;
  desc.points.data = all.begin();
  desc.triangles.count = triangles.length / 3;
  desc.triangles.stride = 12;
  desc.triangles.data = corners.begin();
  const params = new P.PxCookingParams(scale);
  said();
  const made = P.CreateTriangleMesh(params, desc);
  for (const it of [all, corners, desc, params]) P.destroy(it);
  if ((made as unknown as { ptr: number }).ptr === 0) {
    throw new Refusal(`shape '${name}': PhysX does not take its mesh: ${said()}`);
  }
  return new P.PxTriangleMeshGeometry(made);
}

function geometryOf(scene: Scene, shape: Shape): PhysX.PxGeometry {
  const of = scene.meshes[shape.mesh];
  switch (shape.type) {
    case 'box':
      return new P.PxBoxGeometry(shape.size[0] / 2, shape.size[1] / 2, shape.size[2] / 2);
    case 'sphere':
      return new P.PxSphereGeometry(shape.radius);
    case 'cylinder': {
      const core = new P.PxConvexCoreCylinder(shape.length, shape.radius);
      // Its types have it at the class, and the package at objects.
      const factory = P.PxConvexCoreGeometryFactory
        .prototype as unknown as typeof P.PxConvexCoreGeometryFactory;
      return factory.createFromCylinder(core, 0);
    }
    case 'capsule':
      return new P.PxCapsuleGeometry(shape.radius, shape.length / 2);
    case 'plane':
      return new P.PxPlaneGeometry();
    case 'convex-mesh':
      return hull(shape.name, of.vertices);
    case 'mesh':
      return mesh(shape.name, of.vertices, of.triangles);
    case 'heightmap':
      return mesh(shape.name, ...heightMesh(scene, shape.heightmap));
  }
}

const kSurfaces = new Set(['plane', 'mesh', 'heightmap']);

/** Materials and shapes of a world, which it releases. */
export class Shapes {
  readonly #materials = new Map<number, PhysX.PxMaterial>();
  readonly of = new Map<number, [number, number]>(); // body and shape, by PhysX's address

  readonly #rules: Rules;

  constructor(readonly scene: Scene) {
    this.#rules = combineRules(scene, 'PhysX');
  }

  #material(m: number): PhysX.PxMaterial {
    const known = this.#materials.get(m);
    if (known) return known;
    const { eMULTIPLY, eMAX, eMIN, eAVERAGE } = P.PxCombineModeEnum;
    const modes = { multiply: eMULTIPLY, max: eMAX, min: eMIN, average: eAVERAGE };
    const { friction, restitution } = this.#rules;
    const material = physics.createMaterial(friction.own(m), friction.own(m), restitution.own(m));
    material.setFrictionCombineMode(modes[friction.rule]);
    material.setRestitutionCombineMode(modes[restitution.rule]);
    this.#materials.set(m, material);
    return material;
  }

  attach(actor: PhysX.PxRigidActor, model: Body, b: number): void {
    const flags = new P.PxShapeFlags(P.PxShapeFlagEnum.eSIMULATION_SHAPE);
    model.shapes.forEach((shape, s) => {
      if (!shape.collides) return;
      if (kSurfaces.has(shape.type) && model.kind === 'dynamic') {
        throw new Refusal(
          `shape '${shape.name}': PhysX has no ${shape.type} on bodies that forces move: use convex meshes`,
        );
      }
      if (shape.type === 'plane' && model.kind === 'kinematic') {
        throw new Refusal(`shape '${shape.name}': PhysX has planes on static bodies alone`);
      }
      const geometry = geometryOf(this.scene, shape);
      const it = physics.createShape(geometry, this.#material(shape.material), true, flags);
      const { options } = this.scene;
      it.setContactOffset(Number(options['contact-offset']));
      it.setRestOffset(Number(options['rest-offset']));
      const pose = poseOf(shape.X_BS);
      const isTurned = ['capsule', 'cylinder', 'plane'].includes(shape.type);
      it.setLocalPose(transform(isTurned ? { p: pose.p, q: multiply(pose.q, kXToZ) } : pose));
      const data = new P.PxFilterData(b, 0, 0, 0);
      it.setSimulationFilterData(data);
      P.destroy(data);
      if (!actor.attachShape(it))
        throw new Refusal(`shape '${shape.name}': PhysX does not take it: ${said()}`);
      this.of.set((it as unknown as { ptr: number }).ptr, [b, s]);
      it.release();
      P.destroy(geometry);
    });
    P.destroy(flags);
  }

  free(): void {
    for (const material of this.#materials.values()) material.release();
  }
}
