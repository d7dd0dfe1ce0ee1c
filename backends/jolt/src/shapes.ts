// Shapes of the scene as Jolt's.
import { type Body, Refusal, type Scene, type Shape } from './cogrsim_backend.mjs';
import { J, type Jolt, needMemory, quat, vec, xyz } from './engine.ts';
import { multiply, plus, type Q4, type V3 } from './math.ts';
import { heightMesh } from './scene.ts';

/** Jolt's capsules and cylinders have their axis along y, those of scenes along z. */
const kYToZ: Q4 = [Math.SQRT1_2, Math.SQRT1_2, 0, 0];
/** From the middle of a plane to where Jolt's ends [m]; its own is 1000. */
export const kPlane = 1e5;
const kTriangle = 400; // [byte], while a mesh is built

function created(settings: Jolt.ShapeSettings, name: string): Jolt.Shape {
  settings.AddRef();
  const result = settings.Create();
  if (result.HasError()) {
    const problem = result.GetError().c_str();
    settings.Release();
    throw new Refusal(`shape '${name}': Jolt: ${problem}`);
  }
  const shape = result.Get();
  shape.AddRef();
  settings.Release();
  return shape;
}

function meshOf(name: string, points: number[], corners: number[]): Jolt.Shape {
  needMemory((corners.length / 3) * kTriangle, `shape '${name}' of ${corners.length / 3} triangles`);
  const vertices = new J.VertexList();
  const triangles = new J.IndexedTriangleList();
  const materials = new J.PhysicsMaterialList();
  const [point, triangle] = [new J.Float3(0, 0, 0), new J.IndexedTriangle(0, 0, 0, 0)];
  vertices.reserve(points.length / 3);
  triangles.reserve(corners.length / 3);
  for (let i = 0; i < points.length; i += 3) {
    [point.x, point.y, point.z] = points.slice(i, i + 3);
    vertices.push_back(point);
  }
  for (let i = 0; i < corners.length; i += 3) {
    for (let k = 0; k < 3; ++k) triangle.set_mIdx(k, corners[i + k]);
    triangles.push_back(triangle);
  }
  const settings = new J.MeshShapeSettings(vertices, triangles, materials);
  for (const it of [point, triangle, vertices, triangles, materials]) J.destroy(it);
  return created(settings, name);
}

function describe(scene: Scene, shape: Shape, most: number): Jolt.Shape {
  const mesh = scene.meshes[shape.mesh];
  // What rounds edges fits into the shape.
  const round = (smallest: number): number => Math.min(most, smallest / 2);
  const kept = <T extends Jolt.Shape>(it: T): T => {
    it.AddRef();
    return it;
  };
  switch (shape.type) {
    case 'box': {
      const half = shape.size.map((x) => x / 2);
      return kept(new J.BoxShape(vec(half), round(Math.min(...half))));
    }
    case 'sphere':
      return kept(new J.SphereShape(shape.radius));
    case 'cylinder':
      return kept(
        new J.CylinderShape(shape.length / 2, shape.radius, round(Math.min(shape.length / 2, shape.radius))),
      );
    case 'capsule':
      // Jolt has none without a length.
      if (!(shape.length > 0)) return kept(new J.SphereShape(shape.radius));
      return kept(new J.CapsuleShape(shape.length / 2, shape.radius));
    case 'plane': {
      const plane = new J.Plane(vec([0, 0, 1]), 0);
      const it = new J.PlaneShape(plane, undefined, kPlane);
      J.destroy(plane);
      return kept(it);
    }
    case 'convex-mesh': {
      const settings = new J.ConvexHullShapeSettings();
      settings.mMaxConvexRadius = most;
      for (let i = 0; i < mesh.vertices.length; i += 3) settings.mPoints.push_back(vec(mesh.vertices, i));
      return created(settings, shape.name);
    }
    case 'mesh':
      return meshOf(shape.name, mesh.vertices, mesh.triangles);
    case 'heightmap':
      return meshOf(shape.name, ...heightMesh(scene, shape.heightmap));
  }
}

/** What collides of a body, with `com` as its centre of mass; the caller releases it. */
export function shapeOf(scene: Scene, body: Body, com: V3): Jolt.Shape {
  const most = Number(scene.options['convex-radius']);
  const parts = body.shapes.flatMap((shape, s) => (shape.collides ? [{ shape, s }] : []));
  let whole: Jolt.Shape;
  const [first] = parts;
  if (!first) {
    whole = new J.EmptyShape(vec([0, 0, 0]));
    whole.AddRef();
  } else {
    const turned = ({ type }: Shape): boolean => type === 'capsule' || type === 'cylinder';
    const isPlain =
      parts.length === 1 && !turned(first.shape) && first.shape.X_BS.every((x, i) => x === (i === 3 ? 1 : 0));
    const made = parts.map(({ shape, s }) => {
      const one = describe(scene, shape, most);
      one.SetUserData(s);
      return one;
    });
    if (isPlain) [whole] = made;
    else {
      const settings = new J.StaticCompoundShapeSettings();
      parts.forEach(({ shape }, i) => {
        const q = shape.X_BS.slice(3) as Q4;
        const rotation = turned(shape) ? multiply(q, kYToZ) : q;
        settings.AddShapeShape(vec(shape.X_BS), quat(rotation), made[i], 0);
      });
      whole = created(settings, body.name);
      made.forEach((one) => one.Release());
    }
  }
  const offset = plus(com, xyz(whole.GetCenterOfMass()), -1);
  if (offset.every((x) => Math.abs(x) < 1e-9)) return whole;
  const moved = new J.OffsetCenterOfMassShape(whole, vec(offset));
  moved.AddRef();
  whole.Release();
  return moved;
}
