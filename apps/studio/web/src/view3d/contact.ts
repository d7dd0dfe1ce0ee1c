// Contact shadows: a floor is darker under what stands on it or hangs low over it. The things are drawn from below, the
// darker the lower, and blurred; floors look that picture up.
import {
  DoubleSide,
  LinearFilter,
  OrthographicCamera,
  RedFormat,
  ShaderMaterial,
  Vector2,
  Vector4,
  WebGLRenderTarget,
  type Scene as ThreeScene,
  type WebGLRenderer,
} from "three";
import { FullScreenQuad } from "three/examples/jsm/postprocessing/Pass.js";
import type { Scene } from "../core/protocol";
import { floorOf, middleOf, radiusOf, visibleBounds, type Bounds } from "./bounds";
import { kContact, kContactBlur, kContactReach } from "./look";

/** Layer of what casts them. */
export const kCasters = 1;

const kHeightVertex = `
varying float v_height;
void main() {
  vec4 p = vec4(position, 1.0);
  #ifdef USE_INSTANCING
    p = instanceMatrix * p;
  #endif
  vec4 w = modelMatrix * p;
  v_height = w.z;
  gl_Position = projectionMatrix * viewMatrix * w;
}`;
const kHeightFragment = `
varying float v_height;
uniform float ground;
uniform float reach;
void main() { gl_FragColor = vec4(1.0 - clamp((v_height - ground) / reach, 0.0, 1.0)); }`;
const kBlurVertex = `
varying vec2 v_uv;
void main() { v_uv = uv; gl_Position = vec4(position.xy, 0.0, 1.0); }`;
// A bell of 17 samples out to two and a half times its width.
const kBlurFragment = `
varying vec2 v_uv;
uniform sampler2D from;
uniform vec2 width;
void main() {
  float sum = 0.0;
  float weights = 0.0;
  for (int i = -8; i <= 8; i++) {
    float x = 2.5 * float(i) / 8.0;
    float w = exp(-0.5 * x * x);
    sum += w * texture2D(from, v_uv + x * width).r;
    weights += w;
  }
  gl_FragColor = vec4(sum / weights);
}`;

/** What floors look up: of the one scene that a page draws at a time. */
export const contactUniforms = {
  contact_map: { value: null as unknown },
  /** middle, 1 / width, and how much light is lost */
  contact_area: { value: new Vector4(0, 0, 0, 0) },
  /** height of the floor, and from it how far planes may be and still be it */
  contact_ground: { value: new Vector2(0, 0) },
};

const median = (values: number[]): number => values.sort((a, b) => a - b)[Math.floor(values.length / 2)] ?? 0;

export class ContactShadows {
  private readonly camera = new OrthographicCamera();
  private readonly height = new ShaderMaterial({
    vertexShader: kHeightVertex,
    fragmentShader: kHeightFragment,
    uniforms: { ground: { value: 0 }, reach: { value: 1 } },
    side: DoubleSide,
  });
  private readonly blur = new FullScreenQuad(
    new ShaderMaterial({
      vertexShader: kBlurVertex,
      fragmentShader: kBlurFragment,
      uniforms: { from: { value: null }, width: { value: new Vector2() } },
      depthTest: false,
      depthWrite: false,
    }),
  );
  private targets: [WebGLRenderTarget, WebGLRenderTarget] | null = null;
  private ground: number | null = null;
  private usual = 0;
  private width = 0;

  constructor() {
    this.camera.layers.set(kCasters);
    this.camera.up.set(0, 1, 0);
  }

  /** Of another scene. */
  adopt(scene: Scene): void {
    this.ground = floorOf(scene);
    const sizes = scene.bodies.flatMap((body, i) => {
      const box = body.kind === "fixed" ? null : visibleBounds(scene, [], [i]);
      return box ? [2 * radiusOf(box)] : [];
    });
    this.usual = median(sizes);
    contactUniforms.contact_area.value.w = 0;
  }

  /** Spans all that is there. */
  fit(bounds: Bounds): void {
    if (this.ground === null || this.usual <= 0) return;
    const reach = kContactReach * this.usual;
    const [x, y] = middleOf(bounds);
    const side = Math.max(bounds.high[0] - bounds.low[0], bounds.high[1] - bounds.low[1]);
    this.width = side + 6 * kContactBlur * this.usual;
    const { camera } = this;
    camera.position.set(x, y, this.ground - 0.25 * reach);
    camera.lookAt(x, y, this.ground + 1);
    camera.left = camera.bottom = -this.width / 2;
    camera.right = camera.top = this.width / 2;
    camera.near = 0;
    camera.far = 1.25 * reach;
    camera.updateProjectionMatrix();
    this.height.uniforms.ground!.value = this.ground;
    this.height.uniforms.reach!.value = reach;
    contactUniforms.contact_area.value.set(x, y, 1 / this.width, kContact);
    contactUniforms.contact_ground.value.set(this.ground, 0.02 * this.usual);
  }

  draw(renderer: WebGLRenderer, stage: ThreeScene, slow: boolean): void {
    if (this.width <= 0 || contactUniforms.contact_area.value.w === 0) return;
    if (!this.targets) {
      const make = (depthBuffer: boolean) => {
        const size = slow ? 128 : 256;
        const options = { format: RedFormat, minFilter: LinearFilter, magFilter: LinearFilter, depthBuffer };
        return new WebGLRenderTarget(size, size, options);
      };
      this.targets = [make(true), make(false)];
    }
    const [one, other] = this.targets;
    renderer.setRenderTarget(one);
    renderer.setClearColor(0x000000, 0);
    renderer.clear();
    stage.overrideMaterial = this.height;
    renderer.render(stage, this.camera);
    stage.overrideMaterial = null;
    const { from, width } = (this.blur.material as ShaderMaterial).uniforms;
    const share = (kContactBlur * this.usual) / this.width;
    for (const [source, into, x, y] of [
      [one, other, share, 0],
      [other, one, 0, share],
    ] as const) {
      from!.value = source.texture;
      (width!.value as Vector2).set(x, y);
      renderer.setRenderTarget(into);
      this.blur.render(renderer);
    }
    renderer.setRenderTarget(null);
    contactUniforms.contact_map.value = one.texture;
  }

  dispose(): void {
    this.targets?.forEach((target) => target.dispose());
    this.targets = null;
    contactUniforms.contact_map.value = null;
    contactUniforms.contact_area.value.w = 0;
    this.height.dispose();
    this.blur.material.dispose();
    this.blur.dispose();
  }
}
