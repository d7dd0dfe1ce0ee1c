// The bodies of a scene as things to draw: shapes alike share one draw call, whatever their number.
import {
  BufferAttribute,
  BufferGeometry,
  Color,
  DoubleSide,
  DynamicDrawUsage,
  Group,
  InstancedMesh,
  type LineSegments,
  Matrix4,
  Mesh,
  MeshLambertMaterial,
  RepeatWrapping,
  SRGBColorSpace,
  TextureLoader,
  type Intersection,
  type Texture,
} from "three";
import type { Scene, SceneShape, Vec3 } from "../core/protocol";
import { kCasters } from "./contact";
import { compose, inverse, isFinite, poseAt, scaledMatrix, transform, writeMatrix } from "./pose";
import { edgeLines, edgeMaterial, fading, kDarkFloor, kFloorOrder, outlined } from "./surfaces";
import { box, cylinder, edgesOf, rectangle, round, textured, trianglesOf, type Triangles } from "./triangles";

/** A shape of a body, where it is drawn. */
interface Item {
  body: number;
  shape: SceneShape;
  /** scale and pose in the body, 4 x 4 column by column */
  local: Float64Array;
  mesh: Mesh | InstancedMesh;
  /** instance; -1: a mesh of its own */
  index: number;
}

interface BatchOptions {
  /** address of a texture */
  asset: (path: string) => string;
  /** called when a texture has come */
  changed: () => void;
  /** the other run of a comparison: all see-through, in this colour (sRGB), nothing that cannot move */
  ghost?: Color;
  /** fewer corners */
  slow: boolean;
}

const kGhostOpacity = 0.4;
const kManyRound = 300;

function geometryOf(t: Triangles): BufferGeometry {
  const made = new BufferGeometry();
  made.setAttribute("position", new BufferAttribute(new Float32Array(t.positions), 3));
  made.setAttribute("normal", new BufferAttribute(new Float32Array(t.normals), 3));
  if (t.uvs) made.setAttribute("uv", new BufferAttribute(new Float32Array(t.uvs), 2));
  made.setIndex(t.indices);
  made.computeBoundingSphere();
  return made;
}

export class Batches {
  readonly root = new Group();
  private readonly items: Item[] = [];
  private readonly byMesh = new Map<object, Item[]>();
  private readonly byBody = new Map<number, Item[]>();
  private readonly geometries = new Map<string, { whole: BufferGeometry; edges: number[] }>();
  private readonly lines: LineSegments[] = [];
  private readonly edges = edgeMaterial();
  private readonly materials = new Map<string, MeshLambertMaterial>();
  private readonly textures: Texture[] = [];
  private readonly segments: number;
  private gone = false;
  private dark = false;

  constructor(
    private readonly scene: Scene,
    private readonly options: BatchOptions,
  ) {
    const visible = scene.bodies.flatMap((body, b) => {
      if (body.removed || (options.ghost && body.kind === "fixed")) return [];
      return body.shapes.filter((s) => s.visual).map((shape) => ({ body: b, shape }));
    });
    const curved = new Set(["sphere", "cylinder", "capsule"]);
    const many = visible.filter((v) => curved.has(v.shape.type)).length > kManyRound;
    this.segments = (many ? 20 : 48) - (options.slow ? 8 : 0);

    const groups = new Map<string, { body: number; shape: SceneShape }[]>();
    for (const one of visible) {
      const key = this.isAlone(one.shape) ? `alone ${groups.size}` : this.groupKey(one.shape);
      const group = groups.get(key);
      if (group) group.push(one);
      else groups.set(key, [one]);
    }
    for (const members of groups.values()) this.addGroup(members);
    this.root.matrixAutoUpdate = false;
  }

  /** See-through things are drawn from far to near, each by itself. */
  private isAlone(shape: SceneShape): boolean {
    return !this.options.ghost && shape.color[3] < 1;
  }

  private geometryKey(shape: SceneShape): string {
    const by = shape.texture && !this.options.ghost ? ` ${shape.size.join(" ")} ${shape.tile.join(" ")}` : "";
    if (shape.type === "capsule") return `capsule ${shape.size.join(" ")}${by && shape.tile.join(" ")}`;
    if (shape.type === "mesh") return `mesh ${shape.mesh}${by}`;
    if (shape.type === "heightmap") return `heightmap ${shape.heightmap}${by}`;
    return shape.type + by;
  }

  private groupKey(shape: SceneShape): string {
    return `${this.geometryKey(shape)} | ${this.options.ghost ? "" : shape.texture}`;
  }

  /** Of size 1 where one size makes all others by scaling. */
  private isUnit(shape: SceneShape): boolean {
    const plain = !shape.texture || this.options.ghost !== undefined;
    return plain && ["box", "sphere", "cylinder", "plane"].includes(shape.type);
  }

  private geometry(shape: SceneShape): { whole: BufferGeometry; edges: number[] } {
    const key = this.geometryKey(shape);
    let made = this.geometries.get(key);
    if (made) return made;
    let t: Triangles;
    if (!this.isUnit(shape)) {
      t = trianglesOf(this.scene, shape, this.segments);
      if (shape.texture && !this.options.ghost) t = textured(this.scene, shape, t);
    } else if (shape.type === "sphere") t = round(1, 0, this.segments);
    else if (shape.type === "cylinder") t = cylinder(1, 1, this.segments);
    else if (shape.type === "plane") t = rectangle(1, 1);
    else t = box([1, 1, 1]);
    const smoothAll = shape.type === "sphere" || shape.type === "capsule";
    made = { whole: geometryOf(t), edges: this.options.ghost || smoothAll || shape.type === "plane" ? [] : edgesOf(t) };
    this.geometries.set(key, made);
    return made;
  }

  private localMatrix(shape: SceneShape): Float64Array {
    const [a = 1, b = 1, c = 1] = shape.size;
    let scale: Vec3 = [1, 1, 1];
    if (this.isUnit(shape)) {
      if (shape.type === "box") scale = [a, b, c];
      else if (shape.type === "sphere") scale = [a, a, a];
      else if (shape.type === "cylinder") scale = [a, a, b / 2];
      else if (shape.type === "plane") scale = [a, b, 1];
    }
    return scaledMatrix(shape.pose, scale);
  }

  private material(shape: SceneShape): MeshLambertMaterial {
    const { ghost } = this.options;
    const alone = this.isAlone(shape);
    const plane = shape.type === "plane";
    const texture = ghost ? "" : shape.texture;
    const key = ghost ? "ghost" : `${texture} ${plane} ${alone ? shape.color.join(" ") : ""}`;
    let made = this.materials.get(key);
    if (made) return made;
    made = new MeshLambertMaterial({ side: DoubleSide });
    if (plane) fading(made);
    else if (!ghost) outlined(made);
    if (ghost) {
      made.color = ghost;
      made.transparent = true;
      made.opacity = kGhostOpacity;
      // Where both runs agree the solid one is seen, not a pattern of both.
      made.polygonOffset = true;
      made.polygonOffsetFactor = 1;
      made.polygonOffsetUnits = 4;
      made.depthWrite = false;
    } else if (alone) {
      made.color.setRGB(shape.color[0], shape.color[1], shape.color[2], SRGBColorSpace);
      made.transparent = true;
      made.opacity = shape.color[3];
      made.depthWrite = false;
    }
    // the grid and flat things on the ground shall be seen on it
    if (plane) Object.assign(made, { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 4 });
    this.materials.set(key, made);
    if (texture) this.load(texture, made);
    return made;
  }

  private load(path: string, material: MeshLambertMaterial): void {
    const address = this.options.asset(path);
    if (!address) return;
    const texture = new TextureLoader().load(
      address,
      () => {
        if (this.gone) return;
        material.map = texture;
        material.needsUpdate = true;
        this.options.changed();
      },
      undefined,
      () => console.warn(`the texture ${address} cannot be loaded`),
    );
    texture.colorSpace = SRGBColorSpace;
    texture.wrapS = texture.wrapT = RepeatWrapping;
    texture.anisotropy = 8;
    this.textures.push(texture);
  }

  private colorOf(shape: SceneShape): Color {
    const [r, g, b] = shape.color;
    const color = new Color().setRGB(r, g, b, SRGBColorSpace);
    return this.dark && shape.type === "plane" && !shape.texture ? color.multiplyScalar(kDarkFloor) : color;
  }

  /** Floors are dark where the page is. */
  setTheme(theme: "light" | "dark"): void {
    if (this.dark === (theme === "dark")) return;
    this.dark = theme === "dark";
    for (const { mesh, index, shape } of this.items) {
      if (shape.type !== "plane" || index < 0 || this.options.ghost) continue;
      (mesh as InstancedMesh).setColorAt(index, this.colorOf(shape));
      (mesh as InstancedMesh).instanceColor!.needsUpdate = true;
    }
  }

  private addGroup(members: { body: number; shape: SceneShape }[]): void {
    const first = members[0]!.shape;
    const alone = this.isAlone(first);
    const { whole: geometry, edges } = this.geometry(first);
    const material = this.material(first);
    let mesh: Mesh | InstancedMesh;
    if (alone) {
      mesh = new Mesh(geometry, material);
      mesh.matrixAutoUpdate = false;
    } else {
      const many = new InstancedMesh(geometry, material, members.length);
      many.instanceMatrix.setUsage(DynamicDrawUsage);
      if (!this.options.ghost) members.forEach(({ shape }, i) => many.setColorAt(i, this.colorOf(shape)));
      if (edges.length > 0) {
        const lines = edgeLines(many, geometry, edges, this.edges);
        this.lines.push(lines);
        this.root.add(lines);
      }
      mesh = many;
    }
    // instances are scattered: culling them is not worth its cost
    mesh.frustumCulled = false;
    mesh.castShadow = !this.options.ghost && !alone && first.type !== "plane";
    if (mesh.castShadow) mesh.layers.enable(kCasters);
    mesh.receiveShadow = !this.options.ghost;
    if (this.options.ghost) mesh.renderOrder = 1;
    else if (first.type === "plane") mesh.renderOrder = kFloorOrder;
    const items = members.map(({ body, shape }, i): Item => {
      return { body, shape, local: this.localMatrix(shape), mesh, index: alone ? -1 : i };
    });
    this.byMesh.set(mesh, items);
    for (const item of items) {
      this.items.push(item);
      const ofBody = this.byBody.get(item.body);
      if (ofBody) ofBody.push(item);
      else this.byBody.set(item.body, [item]);
    }
    this.root.add(mesh);
  }

  /** Puts everything at the poses of a frame; what has no pose is not drawn. */
  moveTo(poses: ArrayLike<number>): void {
    const own = new Float32Array(16);
    for (const item of this.items) {
      const from = 7 * item.body;
      const sound = from + 6 < poses.length && Number.isFinite(poses[from]! + poses[from + 3]! + poses[from + 6]!);
      if (item.index >= 0) {
        const array = (item.mesh as InstancedMesh).instanceMatrix.array as Float32Array;
        if (sound) writeMatrix(array, 16 * item.index, poses, from, item.local);
        else array.fill(0, 16 * item.index, 16 * item.index + 16);
        continue;
      }
      item.mesh.visible = sound;
      if (!sound) continue;
      writeMatrix(own, 0, poses, from, item.local);
      item.mesh.matrix.fromArray(own);
      item.mesh.matrixWorldNeedsUpdate = true;
    }
    for (const mesh of this.byMesh.keys()) {
      if (!(mesh instanceof InstancedMesh)) continue;
      mesh.instanceMatrix.needsUpdate = true;
      mesh.boundingSphere = null;
    }
  }

  /** Floors reach as far as one sees from around `target`, and no farther: the depths of larger ones would be off by more
   *  than what stands on them. A picture on them stays where it is: they move by whole copies of it. */
  spreadFloors(poses: ArrayLike<number>, target: Vec3, extent: number): void {
    for (const { body, shape, mesh, index } of this.items) {
      if (shape.type !== "plane" || index < 0 || this.options.ghost) continue;
      const pose = compose(poseAt(poses, body), shape.pose);
      if (!isFinite(pose)) continue;
      const at = transform(inverse(pose), target);
      const scale: Vec3 = [2 * extent, 2 * extent, 1];
      if (shape.texture) {
        const { position, uv } = mesh.geometry.attributes as Record<string, BufferAttribute>;
        for (const axis of [0, 1]) {
          const tile = shape.tile[axis] || 1;
          at[axis] = tile * Math.round(at[axis]! / tile);
          scale[axis] = (2 * extent + tile) / shape.size[axis]!;
          for (let i = 0; i < position!.count; ++i)
            uv!.setComponent(i, axis, (scale[axis] * position!.getComponent(i, axis)) / tile);
        }
        uv!.needsUpdate = true;
      }
      const matrix = scaledMatrix(compose(pose, [at[0], at[1], 0, 1, 0, 0, 0]), scale);
      const many = mesh as InstancedMesh;
      many.instanceMatrix.array.set(matrix, 16 * index);
      many.instanceMatrix.needsUpdate = true;
    }
  }

  /** The body a ray met; -1: something else. */
  bodyAt(hit: Intersection): number {
    const items = this.byMesh.get(hit.object);
    if (!items) return -1;
    return items[hit.instanceId ?? 0]?.body ?? -1;
  }

  /** The meshes of a body, for drawing it once more. */
  drawn(body: number): { geometry: BufferGeometry; matrix: Matrix4; plane: boolean }[] {
    return (this.byBody.get(body) ?? []).map((item) => {
      const matrix = new Matrix4();
      if (item.index >= 0) (item.mesh as InstancedMesh).getMatrixAt(item.index, matrix);
      else matrix.copy(item.mesh.matrix);
      return { geometry: item.mesh.geometry, matrix, plane: item.shape.type === "plane" };
    });
  }

  dispose(): void {
    this.gone = true;
    this.root.removeFromParent();
    for (const mesh of this.byMesh.keys()) if (mesh instanceof InstancedMesh) mesh.dispose();
    for (const made of this.geometries.values()) made.whole.dispose();
    for (const lines of this.lines) lines.geometry.dispose();
    this.edges.dispose();
    for (const made of this.materials.values()) made.dispose();
    for (const made of this.textures) made.dispose();
  }
}
