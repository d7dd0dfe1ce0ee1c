// An outline around the selection and the body under the pointer, visible through everything. Colours stay what they are.
import {
  AdditiveBlending,
  Color,
  DoubleSide,
  Mesh,
  MeshBasicMaterial,
  OrthographicCamera,
  PlaneGeometry,
  Scene,
  ShaderMaterial,
  Vector2,
  WebGLRenderTarget,
  type Camera,
  type WebGLRenderer,
} from "three";
import type { Batches } from "./batches";

// The things are drawn white into a picture of their own: selected ones into red, the hovered one into green. A pixel
// near its edge belongs to the outline.
const kFragment = `
varying vec2 v_uv;
uniform sampler2D mask;
uniform vec2 step_size;
uniform vec3 selected;
uniform vec3 hovered;
void main() {
  vec2 here = texture2D(mask, v_uv).rg;
  vec2 around = here;
  for (int i = 0; i < 8; i++) {
    float turn = 0.7853982 * float(i);
    around = max(around, texture2D(mask, v_uv + step_size * vec2(cos(turn), sin(turn))).rg);
  }
  vec2 edge = clamp(around - here, 0.0, 1.0);
  float s = edge.r;
  float h = 0.8 * edge.g * (1.0 - edge.r);
  float a = max(s, h);
  if (a < 0.01) discard;
  gl_FragColor = vec4(mix(hovered, selected, s / (s + h)), a);
  #include <colorspace_fragment>
}`;
const kVertex = `
varying vec2 v_uv;
void main() { v_uv = uv; gl_Position = vec4(position.xy, 0.0, 1.0); }`;

const kWidth = 2.5;

export class Highlight {
  private readonly scene = new Scene();
  private readonly quad: Mesh<PlaneGeometry, ShaderMaterial>;
  private readonly eye = new OrthographicCamera();
  private readonly materials: Record<"selected" | "hovered", MeshBasicMaterial>;
  private target: WebGLRenderTarget | null = null;

  constructor() {
    const material = (color: number) =>
      new MeshBasicMaterial({
        color,
        blending: AdditiveBlending,
        depthTest: false,
        depthWrite: false,
        side: DoubleSide,
      });
    this.materials = { selected: material(0xff0000), hovered: material(0x00ff00) };
    this.quad = new Mesh(
      new PlaneGeometry(2, 2),
      new ShaderMaterial({
        vertexShader: kVertex,
        fragmentShader: kFragment,
        uniforms: {
          mask: { value: null },
          step_size: { value: new Vector2() },
          selected: { value: new Color() },
          hovered: { value: new Color() },
        },
        transparent: true,
        depthTest: false,
        depthWrite: false,
      }),
    );
    this.quad.frustumCulled = false;
    this.scene.matrixAutoUpdate = false;
  }

  setColors(selected: string, hovered: string): void {
    const { uniforms } = this.quad.material;
    (uniforms.selected!.value as Color).set(selected);
    (uniforms.hovered!.value as Color).set(hovered);
  }

  /** Bodies by index; where they are now. */
  show(batches: Batches | null, selected: Iterable<number>, hovered: number): void {
    this.scene.clear();
    if (!batches) return;
    const add = (body: number, material: MeshBasicMaterial) => {
      for (const { geometry, matrix, plane } of batches.drawn(body)) {
        // what has no end has no outline
        if (plane) continue;
        const mesh = new Mesh(geometry, material);
        mesh.matrixAutoUpdate = false;
        mesh.matrix.copy(matrix);
        mesh.matrixWorldNeedsUpdate = true;
        mesh.frustumCulled = false;
        this.scene.add(mesh);
      }
    };
    for (const body of selected) add(body, this.materials.selected);
    if (hovered >= 0) add(hovered, this.materials.hovered);
  }

  get empty(): boolean {
    return this.scene.children.length === 0;
  }

  draw(renderer: WebGLRenderer, camera: Camera): void {
    if (this.empty) return;
    const size = renderer.getDrawingBufferSize(new Vector2());
    if (!this.target || this.target.width !== size.x || this.target.height !== size.y) {
      this.target?.dispose();
      this.target = new WebGLRenderTarget(size.x, size.y, { depthBuffer: false, samples: 4 });
    }
    const { uniforms } = this.quad.material;
    uniforms.mask!.value = this.target.texture;
    const width = kWidth * renderer.getPixelRatio();
    (uniforms.step_size!.value as Vector2).set(width / size.x, width / size.y);
    const clear = renderer.autoClear;
    renderer.setRenderTarget(this.target);
    renderer.setClearColor(0x000000, 0);
    renderer.clear();
    renderer.autoClear = false;
    renderer.render(this.scene, camera);
    renderer.setRenderTarget(null);
    renderer.render(this.quad, this.eye);
    renderer.autoClear = clear;
  }

  dispose(): void {
    this.target?.dispose();
    this.quad.geometry.dispose();
    this.quad.material.dispose();
    for (const material of Object.values(this.materials)) material.dispose();
  }
}
