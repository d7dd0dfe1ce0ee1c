// How surfaces are drawn: dark outlines and edges, and floors that fade into the sky.
import {
  InstancedBufferGeometry,
  LineSegments,
  ShaderMaterial,
  Vector2,
  type BufferGeometry,
  type InstancedMesh,
  type MeshLambertMaterial,
} from "three";

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

const after = (chunk: string, source: string, more: string) => source.replace(chunk, `${chunk}\n${more}`);

export function outlined(material: MeshLambertMaterial): void {
  material.onBeforeCompile = (shader) => {
    shader.fragmentShader = after("#include <opaque_fragment>", shader.fragmentShader, kOutline);
  };
  material.customProgramCacheKey = () => "outlined";
}

/** Where floors begin to fade into the sky, and are gone [m from the eye]: of all of them. */
const fade = { value: new Vector2(1e6, 2e6) };
export function fadeFloors(far: number): void {
  fade.value.set(0.2 * far, 0.9 * far);
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
    shader.uniforms.fade = fade;
    shader.fragmentShader = after("#include <common>", shader.fragmentShader, "uniform vec2 fade;");
    shader.fragmentShader = after("#include <opaque_fragment>", shader.fragmentShader, kFade);
  };
  material.customProgramCacheKey = () => "fading";
}

// A little nearer than they are, so that they are seen on their own surface; the edges of what is nearly black are lighter.
const kEdgeVertex = `
attribute mat4 i_matrix;
attribute vec3 i_color;
varying vec3 v_shade;
void main() {
  vec4 v = viewMatrix * modelMatrix * i_matrix * vec4(position, 1.0);
  gl_Position = projectionMatrix * vec4(0.999 * v.xyz, 1.0);
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
