"""Spaces of actions and observations: those of gymnasium, or small ones of the same interface."""

import numpy

try:
    from gymnasium.spaces import Box
    from gymnasium.vector.utils import batch_space
except ImportError:

    class Box:
        """All arrays between two bounds; what gymnasium.spaces.Box offers that VectorEnv needs."""

        def __init__(self, low, high, shape=None, dtype=numpy.float64, seed=None):
            shape = numpy.broadcast(low, high).shape if shape is None else tuple(shape)
            self.shape = shape
            self.dtype = numpy.dtype(dtype)
            self.low = numpy.broadcast_to(numpy.asarray(low, dtype), shape).copy()
            self.high = numpy.broadcast_to(numpy.asarray(high, dtype), shape).copy()
            self.seed(seed)

        def seed(self, seed=None):
            """Restart the random numbers of sample()."""
            self._random = numpy.random.default_rng(seed)
            return seed

        def sample(self):
            """A random array of the space; normal where a side has no bound."""
            bounded = numpy.isfinite(self.low) & numpy.isfinite(self.high)
            low = numpy.where(bounded, self.low, 0.0)
            high = numpy.where(bounded, self.high, 0.0)
            free = numpy.clip(self._random.normal(size=self.shape), self.low, self.high)
            return numpy.where(bounded, self._random.uniform(low, high), free).astype(self.dtype)

        def contains(self, x):
            """Whether x is an array of the space."""
            return (isinstance(x, numpy.ndarray) and x.shape == self.shape
                    and numpy.can_cast(x.dtype, self.dtype)
                    and bool(numpy.all(x >= self.low) and numpy.all(x <= self.high)))

        __contains__ = contains

        def __eq__(self, other):
            return (isinstance(other, Box) and self.shape == other.shape and self.dtype == other.dtype
                    and numpy.array_equal(self.low, other.low)
                    and numpy.array_equal(self.high, other.high))

        def __repr__(self):
            return f"Box({self.low.min(initial=0.0)}, {self.high.max(initial=0.0)}, {self.shape}, {self.dtype})"

    def batch_space(space, n=1):
        """The space of n arrays of `space`."""
        return Box(numpy.broadcast_to(space.low, (n,) + space.shape),
                   numpy.broadcast_to(space.high, (n,) + space.shape), dtype=space.dtype)
