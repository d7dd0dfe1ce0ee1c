// The engine: rigid bodies in free flight under gravity. It does not know CogRSim. To connect an
// engine that exists, replace this file by its package.

export const add = (a, b, factor = 1) => a.map((x, i) => x + factor * b[i]);
export const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
export const norm = (a) => Math.hypot(...a);
const normalized = (a) => a.map((x) => x / norm(a));

/** Product of two quaternions w x y z. */
export function multiply([aw, ...a], [bw, ...b]) {
  const w = aw * bw - (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
  const v = cross(a, b).map((x, i) => x + aw * b[i] + bw * a[i]);
  return [w, ...v];
}

/** Vector v turned by the unit quaternion q. */
export function turn([w, ...u], v) {
  const t = cross(u, v).map((x) => 2 * x);
  return add(add(v, t, w), cross(u, t));
}

const conjugate = ([w, x, y, z]) => [w, -x, -y, -z];

const times = (m, v) => [0, 3, 6].map((row) => m[row] * v[0] + m[row + 1] * v[1] + m[row + 2] * v[2]);

/** Inverse of a symmetric 3 x 3 matrix. */
function inverse(m) {
  const rows = [m.slice(0, 3), m.slice(3, 6), m.slice(6, 9)];
  const columns = [cross(rows[1], rows[2]), cross(rows[2], rows[0]), cross(rows[0], rows[1])];
  const determinant = rows[0][0] * columns[0][0] + rows[0][1] * columns[0][1] + rows[0][2] * columns[0][2];
  return [0, 1, 2].flatMap((row) => columns.map((column) => column[row] / determinant));
}

/**
 * A body. As in most engines, position and velocity are those of the centre of mass, in world axes.
 * `motion`: "still", "carried" by its velocities, or "free". The inertia is about the centre of mass,
 * in body axes.
 */
export function makeBody({ motion, inertia, position, orientation, velocity, spin }) {
  const body = { motion, position, orientation, velocity, spin };
  if (motion !== 'free') return body;
  body.inverse = inverse(inertia);
  body.momentum = turn(orientation, times(inertia, turn(conjugate(orientation), spin)));
  return body;
}

/** The angular velocity for the momentum of the body at the orientation q. */
function spinAt(body, q) {
  return turn(q, times(body.inverse, turn(conjugate(q), body.momentum)));
}

/** dq/dt = (0, w) q / 2. */
function rateAt(body, at) {
  const q = normalized(at);
  return multiply([0, ...spinAt(body, q)], q).map((x) => 0.5 * x);
}

/**
 * Advances a body by `dt` [s] under `gravity` [m/s^2]. Position and velocity of a free one are exact,
 * its angular momentum is constant, and its orientation is integrated by the classical Runge-Kutta
 * method of fourth order. Returns the body afterwards.
 */
export function advance(body, gravity, dt) {
  if (body.motion === 'still') return body;
  if (body.motion === 'carried') {
    const angle = norm(body.spin) * dt;
    const axis = angle > 0 ? normalized(body.spin) : [0, 0, 1];
    const step = [Math.cos(angle / 2), ...axis.map((x) => x * Math.sin(angle / 2))];
    return {
      ...body,
      position: add(body.position, body.velocity, dt),
      orientation: angle > 0 ? normalized(multiply(step, body.orientation)) : body.orientation,
    };
  }
  const q = body.orientation;
  const k1 = rateAt(body, q);
  const k2 = rateAt(body, add(q, k1, dt / 2));
  const k3 = rateAt(body, add(q, k2, dt / 2));
  const k4 = rateAt(body, add(q, k3, dt));
  const sum = k1.map((k, i) => k + 2 * k2[i] + 2 * k3[i] + k4[i]);
  const orientation = normalized(add(q, sum, dt / 6));
  return {
    ...body,
    position: add(add(body.position, body.velocity, dt), gravity, (dt * dt) / 2),
    velocity: add(body.velocity, gravity, dt),
    orientation,
    spin: spinAt(body, orientation),
  };
}
