// The axes of a joint in the world.
import type { Pose, Vec3 } from "../core/protocol";
import { rotate } from "./pose";

/** Unit directions of the axes of a joint, world. Of a universal joint: x of the parent's frame, y of the child's.
 * Of a gimbal: x of the parent's frame, z of the child's, and the one at right angles to both. */
export function jointAxes(type: string, parent: Pose, child: Pose): Vec3[] {
  switch (type) {
    case "hinge":
    case "slider":
    case "screw":
    case "cylindrical":
    case "planar":
      return [rotate(parent, [0, 0, 1])];
    case "universal":
      return [rotate(parent, [1, 0, 0]), rotate(child, [0, 1, 0])];
    case "gimbal": {
      const x = rotate(parent, [1, 0, 0]);
      const z = rotate(child, [0, 0, 1]);
      const y: Vec3 = [z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]];
      const size = Math.hypot(...y);
      return size > 1e-9 ? [x, y.map((v) => v / size) as unknown as Vec3, z] : [x, z];
    }
    case "ball":
      return [rotate(parent, [1, 0, 0]), rotate(parent, [0, 1, 0]), rotate(parent, [0, 0, 1])];
    default:
      return [];
  }
}
