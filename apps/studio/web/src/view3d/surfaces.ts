// How surfaces are drawn: dark outlines and edges, and floors that fade into the sky.
import {
  InstancedBufferGeometry,
  LineSegments,
  ShaderChunk,
  ShaderMaterial,
  Vector2,
  type BufferGeometry,
  type InstancedMesh,
  type MeshLambertMaterial,
} from "three";
import { contactUniforms } from "./contact";
import { kKnee } from "./look";

// On a round surface the cosine of the view angle falls with the root of the distance to the outline; divided by twice its
// change from pixel to pixel it is that distance in pixels.
const kOutline = `
  float facing = abs(dot(normalize(normal), normalize(vViewPosition)));
  float inside = facing / max(2.0 * fwidth(facing), 1e-6);
  gl_FragColor.rgb *= mix(0.3, 1.0, smoothstep(0.3, 1.3, inside));
`;
const kFade = `
  gl_FragColor.a *= 1.0 - smoothstep(fade.x, fade.y, length(vViewPosition));
`;

const kContactPars = `
uniform vec2 fade;
uniform sampler2D contact_map;
uniform vec4 contact_area;
uniform vec2 contact_ground;
varying vec3 v_ground;
`;
// The picture from below is seen from the other side.
const kContactLoss = `
  vec2 contact_at = 0.5 + vec2(-1.0, 1.0) * (v_ground.xy - contact_area.xy) * contact_area.z;
  float contact_lost = contact_area.w * texture2D(contact_map, contact_at).r;
  contact_lost *= step(max(abs(contact_at.x - 0.5), abs(contact_at.y - 0.5)), 0.5);
  gl_FragColor.rgb *= 1.0 - contact_lost * step(abs(v_ground.z - contact_ground.x), contact_ground.y);
`;
const kGroundPosition = `
  vec4 ground_at = vec4(transformed, 1.0);
  #ifdef USE_INSTANCING
    ground_at = instanceMatrix * ground_at;
  #endif
  v_ground = (modelMatrix * ground_at).xyz;
`;

// What is brighter than the knee approaches white ever more slowly, and keeps its hue.
const kNoToneMapping = "vec3 CustomToneMapping( vec3 color ) { return color; }";
if (!ShaderChunk.tonemapping_pars_fragment.includes(kNoToneMapping)) console.warn("bright colours are cut off");
ShaderChunk.tonemapping_pars_fragment = ShaderChunk.tonemapping_pars_fragment.replace(
  kNoToneMapping,
  `vec3 CustomToneMapping( vec3 color ) {
    float knee = ${kKnee.toFixed(3)};
    float most = max(color.r, max(color.g, color.b));
    if (most <= knee) return color;
    float to = knee + (1.0 - knee) * (1.0 - exp((knee - most) / (1.0 - knee)));
    return color * (to / most);
  }`,
);

const after = (chunk: string, source: string, more: string) => source.replace(chunk, `${chunk}\n${more}`);

export function outlined(material: MeshLambertMaterial): void {
  material.onBeforeCompile = (shader) => {
    shader.fragmentShader = after("#include <opaque_fragment>", shader.fragmentShader, kOutline);
  };
  material.customProgramCacheKey = () => "outlined";
}

/** Where floors begin to fade into the sky, and are gone [m from the eye]: of all of them. */
const fade = { value: new Vector2(1e6, 2e6) };
/** How much nearer edges are drawn than they are, as a share of the distance. */
const lift = { value: 1e-3 };
/** `before`: what an eye without perspective is farther off than one with it [m], `reach`: how far floors go [m]. */
export function fadeFloors(before: number, reach: number, narrow: number): void {
  fade.value.set(before + 0.2 * reach, before + 0.9 * reach);
  lift.value = 1e-3 * narrow;
}

/** Draws before everything else that is see-through. */
export const kFloorOrder = -6;
export function fading(material: MeshLambertMaterial): void {
  material.transparent = true;
  // drawn behind what is opaque and before the grid, which lies in it
  material.depthWrite = false;
  // both sides in one go
  material.forceSinglePass = true;
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, { fade }, contactUniforms);
    shader.vertexShader = after("#include <common>", shader.vertexShader, "varying vec3 v_ground;");
    shader.vertexShader = after("#include <project_vertex>", shader.vertexShader, kGroundPosition);
    shader.fragmentShader = after("#include <common>", shader.fragmentShader, kContactPars);
    shader.fragmentShader = after("#include <opaque_fragment>", shader.fragmentShader, kContactLoss + kFade);
  };
  material.customProgramCacheKey = () => "fading";
}

// A little nearer than they are, so that they are seen on their own surface; the edges of what is nearly black are lighter.
const kEdgeVertex = `
attribute mat4 i_matrix;
attribute vec3 i_color;
uniform float lift;
varying vec3 v_shade;
void main() {
  vec4 v = viewMatrix * modelMatrix * i_matrix * vec4(position, 1.0);
  gl_Position = projectionMatrix * vec4((1.0 - lift) * v.xyz, 1.0);
  float bright = dot(i_color, vec3(0.2126, 0.7152, 0.0722));
  v_shade = bright > 0.03 ? 0.2 * i_color : i_color + vec3(0.1);
}`;
const kEdgeFragment = `
varying vec3 v_shade;
void main() {
  gl_FragColor = vec4(v_shade, 0.85);
  #include <colorspace_fragment>
}`;

export const edgeMaterial = (): ShaderMaterial =>
  new ShaderMaterial({
    vertexShader: kEdgeVertex,
    fragmentShader: kEdgeFragment,
    uniforms: { lift },
    transparent: true,
    depthWrite: false,
  });

/** Lines along the edges of all instances of a mesh, in shades of their colours; they move with it. */
export function edgeLines(mesh: InstancedMesh, shape: BufferGeometry, edges: number[], material: ShaderMaterial) {
  const geometry = new InstancedBufferGeometry();
  geometry.setAttribute("position", shape.getAttribute("position"));
  geometry.setIndex(edges);
  geometry.setAttribute("i_matrix", mesh.instanceMatrix);
  geometry.setAttribute("i_color", mesh.instanceColor!);
  geometry.instanceCount = mesh.count;
  const lines = new LineSegments(geometry, material);
  lines.frustumCulled = false;
  lines.raycast = () => {};
  return lines;
}

/** Of the light that a floor throws back in the light, how much in the dark. */
export const kDarkFloor = 0.06;
