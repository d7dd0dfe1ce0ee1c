// Viewpoints that show everything, with the same directions as the pictures of the command line.
import type { Pose, Vec3 } from "../core/protocol";
import { cornersOf, middleOf, type Bounds } from "./bounds";

export const kViews = ["front", "back", "left", "right", "top", "bottom", "iso"] as const;
export type ViewName = (typeof kViews)[number];

/** Horizontal field of view [rad], and the one of an eye so far off that lines which are parallel look so. */
export const kFieldOfView = 0.8;
export const kFlatField = 0.02;
const kMargin = 1.05;
/** Straight down or up leaves open where the picture's top is; this little aside settles it. */
const kAside = 1e-4;

export const unit = (v: Vec3): Vec3 => {
  const n = Math.hypot(...v);
  return [v[0] / n, v[1] / n, v[2] / n];
};

/** Unit vector from the middle of the view towards the eye. */
export function directionOf(view: ViewName): Vec3 {
  switch (view) {
    case "front":
      return [1, 0, 0];
    case "back":
      return [-1, 0, 0];
    case "left":
      return [0, 1, 0];
    case "right":
      return [0, -1, 0];
    case "top":
      return unit([0, -kAside, 1]);
    case "bottom":
      return unit([0, kAside, -1]);
    case "iso":
      return unit([1, 0.7, 0.8]);
  }
}

/** Vertical field of view [rad] of a picture that is `aspect` times as wide as high. */
export function verticalFov(aspect: number, field = kFieldOfView): number {
  // of a narrow picture the greater angle is the vertical one, or little would be seen
  return aspect >= 1 ? 2 * Math.atan(Math.tan(field / 2) / aspect) : field;
}

export function horizontalFov(aspect: number, field = kFieldOfView): number {
  return 2 * Math.atan(Math.tan(verticalFov(aspect, field) / 2) * aspect);
}

export const cross = (a: Vec3, b: Vec3): Vec3 => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
export const dot = (a: Vec3, b: Vec3): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** Axes of an eye that looks against `direction` (unit), z up: forward, left, up. */
export function axesOf(direction: Vec3): [Vec3, Vec3, Vec3] {
  const forward: Vec3 = [-direction[0], -direction[1], -direction[2]];
  const left = unit(cross([0, 0, 1], forward));
  return [forward, left, cross(forward, left)];
}

/** How far from the middle of `bounds` an eye in `direction` shows all of it with a margin of 5 % [m]. */
export function distanceFor(bounds: Bounds, direction: Vec3, aspect: number, field = kFieldOfView): number {
  const [forward, left, up] = axesOf(direction);
  const tanY = Math.tan(verticalFov(aspect, field) / 2) / kMargin;
  const tanX = tanY * aspect;
  const middle = middleOf(bounds);
  let back = 1e-3;
  for (const corner of cornersOf(bounds)) {
    const p: Vec3 = [corner[0] - middle[0], corner[1] - middle[1], corner[2] - middle[2]];
    const along = dot(p, forward);
    back = Math.max(back, Math.abs(dot(p, left)) / tanX - along, Math.abs(dot(p, up)) / tanY - along);
  }
  return back;
}

/** Pose of the server's camera (looks along +x, z up) for an eye there that looks at `target`. */
export function cameraPose(eye: Vec3, target: Vec3): Pose {
  const [x, y, z] = axesOf(unit([eye[0] - target[0], eye[1] - target[1], eye[2] - target[2]]));
  // columns x, y, z of the rotation; its quaternion by the greatest of the four (Shepperd)
  const trace = x[0] + y[1] + z[2];
  let q: [number, number, number, number];
  if (trace >= Math.max(x[0], y[1], z[2])) {
    q = [1 + trace, y[2] - z[1], z[0] - x[2], x[1] - y[0]];
  } else if (x[0] >= y[1] && x[0] >= z[2]) {
    q = [y[2] - z[1], 1 + x[0] - y[1] - z[2], y[0] + x[1], z[0] + x[2]];
  } else if (y[1] >= z[2]) {
    q = [z[0] - x[2], y[0] + x[1], 1 + y[1] - x[0] - z[2], z[1] + y[2]];
  } else {
    q = [x[1] - y[0], z[0] + x[2], z[1] + y[2], 1 + z[2] - x[0] - y[1]];
  }
  const n = Math.hypot(...q);
  return [eye[0], eye[1], eye[2], q[0] / n, q[1] / n, q[2] / n, q[3] / n];
}
