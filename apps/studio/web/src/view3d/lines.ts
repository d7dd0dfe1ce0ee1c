// Many lines in one draw call, changed as often as frames come.
import { BufferAttribute, BufferGeometry, Color, type InstancedInterleavedBuffer, Points, PointsMaterial } from "three";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";

export type Rgb = readonly [number, number, number];

/** sRGB to the drawing's colour space. */
export function linearColor(color: Rgb | string): Rgb {
  const c = typeof color === "string" ? new Color(color) : new Color().setRGB(color[0], color[1], color[2], "srgb");
  return [c.r, c.g, c.b];
}

export class Lines {
  readonly mesh: LineSegments2;
  private count = 0;
  private points = new Float32Array(6 * 64);
  private colors = new Float32Array(6 * 64);
  private made = 0;

  /** `width` in pixels; `onTop`: seen through everything; `opacity` 0 to 1. */
  constructor(width: number, onTop: boolean, opacity = 1) {
    const material = new LineMaterial({ linewidth: width, vertexColors: true, worldUnits: false });
    material.depthTest = !onTop;
    material.depthWrite = false;
    material.toneMapped = false;
    material.transparent = true;
    material.opacity = opacity;
    material.polygonOffset = true;
    material.polygonOffsetFactor = -2;
    this.mesh = new LineSegments2(new LineSegmentsGeometry(), material);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = onTop ? 5 : 2;
    this.mesh.raycast = () => {};
    this.mesh.visible = false;
  }

  begin(): void {
    this.count = 0;
  }

  add(from: ArrayLike<number>, to: ArrayLike<number>, color: Rgb, a = 0, b = 0): void {
    const at = 6 * this.count++;
    if (at + 6 > this.points.length) {
      const grow = (old: Float32Array) => {
        const wider = new Float32Array(2 * old.length);
        wider.set(old);
        return wider;
      };
      this.points = grow(this.points);
      this.colors = grow(this.colors);
    }
    for (let i = 0; i < 3; i++) {
      this.points[at + i] = from[a + i]!;
      this.points[at + 3 + i] = to[b + i]!;
      this.colors[at + i] = this.colors[at + 3 + i] = color[i]!;
    }
  }

  end(): void {
    this.mesh.visible = this.count > 0;
    if (this.count === 0) return;
    const { geometry } = this.mesh;
    if (this.made !== this.points.length) {
      geometry.dispose();
      geometry.setPositions(this.points);
      geometry.setColors(this.colors);
      this.made = this.points.length;
    } else {
      for (const name of ["instanceStart", "instanceColorStart"]) {
        const attribute = geometry.getAttribute(name) as unknown as { data: InstancedInterleavedBuffer };
        attribute.data.needsUpdate = true;
      }
    }
    geometry.instanceCount = this.count;
  }

  dispose(): void {
    this.mesh.removeFromParent();
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
  }
}

export class Dots {
  readonly mesh: Points<BufferGeometry, PointsMaterial>;
  private points: number[] = [];
  private colors: number[] = [];

  constructor(size: number, onTop: boolean) {
    const material = new PointsMaterial({ size, sizeAttenuation: false, vertexColors: true, depthTest: !onTop });
    material.depthWrite = false;
    material.toneMapped = false;
    material.transparent = true;
    this.mesh = new Points(new BufferGeometry(), material);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = onTop ? 6 : 3;
    this.mesh.raycast = () => {};
    this.mesh.visible = false;
  }

  begin(): void {
    this.points = [];
    this.colors = [];
  }
  add(point: ArrayLike<number>, color: Rgb): void {
    this.points.push(point[0]!, point[1]!, point[2]!);
    this.colors.push(...color);
  }
  end(): void {
    this.mesh.visible = this.points.length > 0;
    if (!this.mesh.visible) return;
    const { geometry } = this.mesh;
    const put = (name: string, values: number[]) => {
      const now = geometry.getAttribute(name) as BufferAttribute | undefined;
      if (now && now.array.length >= values.length) {
        (now.array as Float32Array).set(values);
        now.needsUpdate = true;
      } else {
        geometry.dispose();
        const larger = new Float32Array(Math.max(192, 2 * values.length));
        larger.set(values);
        geometry.setAttribute(name, new BufferAttribute(larger, 3));
      }
    };
    put("position", this.points);
    put("color", this.colors);
    geometry.setDrawRange(0, this.points.length / 3);
  }

  dispose(): void {
    this.mesh.removeFromParent();
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
  }
}
