// Sky and grid: the background, in both themes.
import {
  BackSide,
  Color,
  DoubleSide,
  Group,
  Mesh,
  PlaneGeometry,
  ShaderMaterial,
  SphereGeometry,
  Vector3,
} from "three";
import { kSkies } from "./look";

const kSkyVertex = `
varying vec3 v_ray;
void main() {
  v_ray = position;
  vec4 p = projectionMatrix * mat4(mat3(viewMatrix)) * vec4(position, 1.0);
  gl_Position = p.xyww;
}`;
const kSkyFragment = `
varying vec3 v_ray;
uniform vec3 zenith;
uniform vec3 horizon;
uniform vec3 nadir;
void main() {
  float up = normalize(v_ray).z;
  // fast near the horizon, slow above; below, the haze ends within a few degrees
  float a = 1.0 - clamp(up, 0.0, 1.0);
  vec3 above = mix(horizon, zenith, 1.0 - a * a * a);
  gl_FragColor = vec4(mix(above, nadir, clamp(-8.0 * up, 0.0, 1.0)), 1.0);
  #include <colorspace_fragment>
}`;

const kGridVertex = `
varying vec2 v_position;
void main() {
  vec4 w = modelMatrix * vec4(position, 1.0);
  v_position = w.xy;
  gl_Position = projectionMatrix * viewMatrix * w;
}`;
// Lines one pixel wide, whatever the distance; the finer ones fade where they would run together.
const kGridFragment = `
varying vec2 v_position;
uniform float cell;
uniform vec2 middle;
uniform float radius;
uniform vec3 color;
float lines(float size) {
  vec2 at = v_position / size;
  vec2 width = fwidth(at);
  vec2 away = abs(fract(at - 0.5) - 0.5) / max(width, vec2(1e-6));
  float near = 1.0 - min(min(away.x, away.y), 1.0);
  return near * (1.0 - smoothstep(0.15, 0.5, max(width.x, width.y)));
}
void main() {
  float fade = 1.0 - smoothstep(0.08, 0.7, length(v_position - middle) / radius);
  float a = max(0.16 * lines(cell), 0.42 * lines(10.0 * cell)) * fade;
  if (a < 0.004) discard;
  gl_FragColor = vec4(color, a);
  #include <colorspace_fragment>
}`;

/** Distance of the finer lines [m]: a power of ten, at least a thirtieth of the visible extent. */
function gridCell(distance: number): number {
  return 10 ** Math.ceil(Math.log10(Math.max(distance, 1e-4) / 30));
}

export class Backdrop {
  readonly root = new Group();
  private theme: "light" | "dark" = "light";
  private readonly sky: Mesh<SphereGeometry, ShaderMaterial>;
  private readonly grid: Mesh<PlaneGeometry, ShaderMaterial>;

  constructor() {
    const color = () => ({ value: new Color() });
    this.sky = new Mesh(
      new SphereGeometry(1, 16, 12),
      new ShaderMaterial({
        vertexShader: kSkyVertex,
        fragmentShader: kSkyFragment,
        uniforms: { zenith: color(), horizon: color(), nadir: color() },
        side: BackSide,
        depthWrite: false,
        depthTest: false,
      }),
    );
    this.sky.frustumCulled = false;
    this.sky.renderOrder = -10;
    this.grid = new Mesh(
      new PlaneGeometry(2, 2),
      new ShaderMaterial({
        vertexShader: kGridVertex,
        fragmentShader: kGridFragment,
        uniforms: { cell: { value: 1 }, middle: { value: new Vector3() }, radius: { value: 1 }, color: color() },
        side: DoubleSide,
        transparent: true,
        depthWrite: false,
      }),
    );
    this.grid.frustumCulled = false;
    this.grid.renderOrder = -5;
    this.root.add(this.sky, this.grid);
    this.root.traverse((o) => (o.raycast = () => {}));
  }

  setTheme(theme: "light" | "dark", gridColor: string): void {
    this.theme = theme;
    const sky = kSkies[theme];
    for (const name of ["zenith", "horizon", "nadir"] as const) {
      const [r, g, b] = sky[name];
      (this.sky.material.uniforms[name]!.value as Color).setRGB(r, g, b, "srgb");
    }
    (this.grid.material.uniforms.color!.value as Color).set(gridColor);
  }

  /** Over a floor the sky has no ground of its own: the floor fades into the haze. */
  showGround(shown: boolean): void {
    const { uniforms } = this.sky.material;
    const [r, g, b] = kSkies[this.theme][shown ? "nadir" : "horizon"];
    (uniforms.nadir!.value as Color).setRGB(r, g, b, "srgb");
  }

  showGrid(shown: boolean): void {
    this.grid.visible = shown;
  }

  /** Puts the grid around the camera's target. */
  follow(distance: number, target: Vector3): void {
    const { cell, middle, radius } = this.grid.material.uniforms;
    cell!.value = gridCell(distance);
    radius!.value = 12 * distance;
    (middle!.value as Vector3).copy(target);
    this.grid.position.set(target.x, target.y, 0);
    this.grid.scale.setScalar(12 * distance);
    this.grid.updateMatrixWorld();
  }

  dispose(): void {
    for (const mesh of [this.sky, this.grid]) {
      mesh.geometry.dispose();
      mesh.material.dispose();
    }
  }
}
