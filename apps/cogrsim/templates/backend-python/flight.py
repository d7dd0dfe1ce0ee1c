"""The engine: rigid bodies in free flight under gravity. It does not know CogRSim. To connect an
engine that exists, replace this file by its package."""

import math


def add(a, b, factor=1.0):
    return [x + factor * y for x, y in zip(a, b)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def norm(a):
    return math.sqrt(sum(x * x for x in a))


def normalized(a):
    length = norm(a)
    return [x / length for x in a]


def multiply(a, b):
    """Product of two quaternions w x y z."""
    w = a[0] * b[0] - sum(x * y for x, y in zip(a[1:], b[1:]))
    v = cross(a[1:], b[1:])
    return [w] + [v[i] + a[0] * b[i + 1] + b[0] * a[i + 1] for i in range(3)]


def turn(q, v):
    """Vector v turned by the unit quaternion q."""
    t = [2.0 * x for x in cross(q[1:], v)]
    return add(add(v, t, q[0]), cross(q[1:], t))


def conjugate(q):
    return [q[0], -q[1], -q[2], -q[3]]


def times(m, v):
    return [sum(m[row + i] * v[i] for i in range(3)) for row in (0, 3, 6)]


def inverse(m):
    """Inverse of a symmetric 3 x 3 matrix."""
    rows = [m[0:3], m[3:6], m[6:9]]
    columns = [cross(rows[1], rows[2]), cross(rows[2], rows[0]), cross(rows[0], rows[1])]
    determinant = sum(x * y for x, y in zip(rows[0], columns[0]))
    return [column[row] / determinant for row in range(3) for column in columns]


class Body:
    """As in most engines, position and velocity are those of the centre of mass, in world axes.

    motion: "still", "carried" by its velocities, or "free". The inertia is about the centre of mass,
    in body axes.
    """

    def __init__(self, motion, inertia, position, orientation, velocity, spin):
        self.motion = motion
        self.position, self.orientation = position, orientation
        self.velocity, self.spin = velocity, spin
        if motion == "free":
            self.inverse = inverse(inertia)
            self.momentum = turn(orientation, times(inertia, turn(conjugate(orientation), spin)))

    def spin_at(self, q):
        """The angular velocity for the momentum of the body at the orientation q."""
        return turn(q, times(self.inverse, turn(conjugate(q), self.momentum)))

    def rate_at(self, at):
        """dq/dt = (0, w) q / 2."""
        q = normalized(at)
        return [0.5 * x for x in multiply([0.0] + self.spin_at(q), q)]

    def advance(self, gravity, dt):
        """Advances the body by `dt` [s] under `gravity` [m/s^2]. Position and velocity of a free one
        are exact, its angular momentum is constant, and its orientation is integrated by the classical
        Runge-Kutta method of fourth order."""
        if self.motion == "still":
            return
        if self.motion == "carried":
            self.position = add(self.position, self.velocity, dt)
            angle = norm(self.spin) * dt
            if angle > 0.0:
                axis = normalized(self.spin)
                step = [math.cos(angle / 2)] + [x * math.sin(angle / 2) for x in axis]
                self.orientation = normalized(multiply(step, self.orientation))
            return
        self.position = add(add(self.position, self.velocity, dt), gravity, dt * dt / 2)
        self.velocity = add(self.velocity, gravity, dt)
        q = self.orientation
        k1 = self.rate_at(q)
        k2 = self.rate_at(add(q, k1, dt / 2))
        k3 = self.rate_at(add(q, k2, dt / 2))
        k4 = self.rate_at(add(q, k3, dt))
        total = [a + 2 * b + 2 * c + d for a, b, c, d in zip(k1, k2, k3, k4)]
        self.orientation = normalized(add(q, total, dt / 6))
        self.spin = self.spin_at(self.orientation)
