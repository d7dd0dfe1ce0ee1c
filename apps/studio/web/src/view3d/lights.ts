// The lights of a scene, as bright and as soft as in the pictures of the command line.
import {
  Color,
  DirectionalLight,
  Group,
  HemisphereLight,
  PointLight,
  ShaderChunk,
  SpotLight,
  SRGBColorSpace,
  Vector3,
  type Light,
} from "three";
import type { Scene, Vec3 } from "../core/protocol";
import { middleOf, radiusOf, type Bounds } from "./bounds";
import {
  kAmbientToward,
  kFill,
  kFillShare,
  kGroundLight,
  kKey,
  kLampRange,
  kLightShare,
  kSkyLight,
  kSpotEdge,
} from "./look";
import { transform } from "./pose";

const kMostLights = 16;
/** Each takes one of the 16 textures that a fragment may look at. */
const kMostShadows = 6;
/** Of the edges of shadows [texel]. */
const kSoftness = 2.5;
/** A floor gets shadows of what hangs over it up to so many times the size of everything. */
const kMostFall = 20;

// Lamps fade as 1 / (1 + r^2 / range^2): finite close by. The library's own law is infinite there. `decay` carries
// 1 / range^2.
const kFalloff = "float distanceFalloff = 1.0 / max( pow( lightDistance, decayExponent ), 0.01 );";
if (!ShaderChunk.lights_pars_begin.includes(kFalloff)) console.warn("lamps fade by another law than in pictures");
ShaderChunk.lights_pars_begin = ShaderChunk.lights_pars_begin.replace(
  kFalloff,
  "float distanceFalloff = 1.0 / ( 1.0 + decayExponent * lightDistance * lightDistance );",
);

export class Lights {
  readonly root = new Group();
  private readonly shining: { light: Light; direction: Vec3 }[] = [];
  private fitted: { middle: Vec3; radius: number } | null = null;

  /** `slow`: smaller shadow maps. */
  constructor(scene: Scene, slow: boolean) {
    // The library divides what matt matter throws back by pi.
    const sky = new HemisphereLight(0xffffff, 0xffffff, Math.PI);
    sky.color.setRGB(...kSkyLight);
    sky.groundColor.setRGB(...kGroundLight);
    sky.position.set(...kAmbientToward);
    this.root.add(sky);

    let shadows = 0;
    const add = (light: DirectionalLight | PointLight | SpotLight, position: Vec3, direction: Vec3, casts: boolean) => {
      light.position.set(...position);
      if (!(light instanceof PointLight)) {
        light.target.position.set(position[0] + direction[0], position[1] + direction[1], position[2] + direction[2]);
        this.root.add(light.target);
      }
      if (casts && shadows < kMostShadows) {
        shadows++;
        light.castShadow = true;
        const size = light instanceof DirectionalLight && !slow ? 2048 : 1024;
        light.shadow.mapSize.set(size, size);
        light.shadow.radius = kSoftness;
      }
      this.root.add(light);
      this.shining.push({ light, direction });
    };
    for (const source of scene.lights.slice(0, kMostLights)) {
      const [r = 1, g = 1, b = 1] = source.color;
      const color = new Color().setRGB(r, g, b, SRGBColorSpace);
      const intensity = Math.PI * kLightShare * source.intensity;
      const position: Vec3 = [source.pose[0], source.pose[1], source.pose[2]];
      const ahead = transform(source.pose, [1, 0, 0]);
      const direction: Vec3 = [ahead[0] - position[0], ahead[1] - position[1], ahead[2] - position[2]];
      const decay = 1 / (kLampRange * kLampRange);
      if (source.type === "directional") {
        add(new DirectionalLight(color, intensity), position, direction, source.shadows);
      } else if (source.type === "point") {
        add(new PointLight(color, intensity, 0, decay), position, direction, source.shadows);
      } else {
        const cone = Math.min(source.cone, 1.5);
        add(new SpotLight(color, intensity, 0, cone, 1 - kSpotEdge, decay), position, direction, source.shadows);
      }
    }
    if (scene.lights.length === 0) {
      const sun = (toward: Vec3, share: number, casts: boolean) => {
        const n = Math.hypot(...toward);
        const along: Vec3 = [toward[0] / n, toward[1] / n, toward[2] / n];
        // where it stands counts, as what it shines at is the origin
        add(new DirectionalLight(0xffffff, Math.PI * share), [-along[0], -along[1], -along[2]], along, casts);
      };
      sun(kKey, kLightShare, true);
      sun(kFill, kFillShare, false);
    }
  }

  /** Lets the shadow maps span everything that casts. Returns at once unless that changed enough to matter. */
  fit(bounds: Bounds, floor: number | null): void {
    const middle = middleOf(bounds);
    const radius = Math.max(radiusOf(bounds), 0.05);
    if (this.fitted) {
      const moved = Math.hypot(...middle.map((v, i) => v - this.fitted!.middle[i]!));
      const spans = moved + radius <= this.fitted.radius;
      if (spans && radius > 0.5 * this.fitted.radius) return;
    }
    // some margin, so that shadows do not shimmer while things move about
    this.fitted = { middle, radius: 1.15 * radius };
    const span = this.fitted.radius;
    for (const { light, direction } of this.shining) {
      if (!light.castShadow) continue;
      if (light instanceof DirectionalLight) {
        light.position.set(...middle).addScaledVector(new Vector3(...direction), -2 * span);
        light.target.position.set(...middle);
        light.target.updateMatrixWorld();
        const camera = light.shadow.camera;
        camera.left = camera.bottom = -span;
        camera.right = camera.top = span;
        camera.near = span;
        // as far as where a shadow meets the floor
        const [x, y, z] = direction;
        const fall = floor === null || z > -1e-3 ? 0 : (middle[2] + span - floor + span * Math.hypot(x, y)) / -z;
        camera.far = 2 * span + Math.max(span, Math.min(fall, kMostFall * span));
        // A texel seen edge-on is what a surface may be off by, and a soft edge looks some of them farther.
        light.shadow.normalBias = ((1.5 + kSoftness) * 2 * span) / light.shadow.mapSize.x;
        camera.updateProjectionMatrix();
      } else if (light instanceof PointLight || light instanceof SpotLight) {
        const camera = light.shadow.camera;
        const away = Math.hypot(
          light.position.x - middle[0],
          light.position.y - middle[1],
          light.position.z - middle[2],
        );
        camera.near = 0.02;
        camera.far = Math.max(away + span, 0.04);
        light.shadow.normalBias = (1.5 * 2 * Math.min(away, 10)) / light.shadow.mapSize.x;
        light.shadow.bias = -0.0005;
        camera.updateProjectionMatrix();
      }
      light.updateMatrixWorld();
    }
  }

  dispose(): void {
    this.root.removeFromParent();
    for (const { light } of this.shining) light.dispose();
  }
}
