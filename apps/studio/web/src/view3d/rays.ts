// Lines of sight of the ranging sensors, from their readings.
import type { Frame } from "../core/frame";
import type { Scene, Vec3 } from "../core/protocol";
import { compose, isFinite, poseAt, transform } from "./pose";

interface Ray {
  from: Vec3;
  /** where the reading says the ray ended, or its full range [m] */
  to: Vec3;
  hit: boolean;
  /** of a lidar: one of so many that they are drawn as a pale fan */
  fan: boolean;
  sensor: number;
}

const kRanging = new Set(["infrared", "lidar"]);

/**
 * Of all infrared sensors and lidars that have a reading. A reading of null is no number: beyond the range nothing was
 * seen, and the ray is drawn in full as a miss. Where any of them says `show`, only those that do.
 */
export function rayEnds(scene: Scene, frame: Frame): Ray[] {
  const rays: Ray[] = [];
  const someShown = scene.sensors.some((s) => s.show && kRanging.has(s.type));
  for (const reading of frame.tail.readings ?? []) {
    const sensor = scene.sensors[reading.sensor];
    if (!sensor || (someShown && !sensor.show)) continue;
    if (!kRanging.has(sensor.type) || reading.values.length === 0) continue;
    if (sensor.body >= 0 && 7 * sensor.body + 6 >= frame.poses.length) continue;
    // where it measured, if that is known: its body has moved on
    const now = () => (sensor.body < 0 ? sensor.pose : compose(poseAt(frame.poses, sensor.body), sensor.pose));
    const pose = reading.pose ?? now();
    if (!isFinite(pose)) continue;
    // the cone of an infrared sensor has one distance, drawn along its middle
    const lines = reading.values.length === 1 ? middleRay(sensor.rays) : sensor.rays;
    lines.forEach((line, k) => {
      const value = reading.values[k];
      if (value === undefined) return;
      const [ox = 0, oy = 0, oz = 0, dx = 1, dy = 0, dz = 0, range = 0] = line;
      const hit = value !== null && value < range;
      const length = value === null ? range : Math.min(Math.max(value, 0), range);
      rays.push({
        from: transform(pose, [ox, oy, oz]),
        to: transform(pose, [ox + length * dx, oy + length * dy, oz + length * dz]),
        hit,
        fan: sensor.type === "lidar",
        sensor: reading.sensor,
      });
    });
  }
  return rays;
}

/** The one ray of a sensor that measures one distance: that nearest to its +x. */
function middleRay(rays: number[][]): number[][] {
  if (rays.length <= 1) return rays;
  const first = rays[0]!;
  return [[first[0]!, first[1]!, first[2]!, 1, 0, 0, Math.max(...rays.map((r) => r[6] ?? 0))]];
}
