"""The names that readings have by the type of their sensor, as those of the handles in C++."""

import math


def _vector(self, first, count):
    import numpy
    values = self.values
    return values[first:first + count] if self.valid else numpy.full(count, math.nan)


def _number(index):
    def get(self):
        there = self.valid and index < len(self.values)  # volts only with a response
        return float(self.values[index]) if there else math.nan
    return get


def _triple(first):
    return lambda self: _vector(self, first, 3)


def _pose(self):
    return _vector(self, 0, 3), _vector(self, 3, 4)


def _twist(self):
    return _vector(self, 7, 3), _vector(self, 10, 3)


def _ranges(self):
    return self.values[:self.size] if self.valid else self.values[:0]


def _only(self, name, types):
    """Raises AttributeError for a sensor of another type."""
    if self.type in types:
        return
    known = sorted(key for key, (_, of) in _NAMES.items() if self.type in of)
    there = "it has " + ", ".join(known) if known else "its values are in `values`"
    raise AttributeError(f"sensor '{self.name}' is of type '{self.type}', which has no '{name}'; {there}")


# name: docstring, {type of sensor: value}
_NAMES = {
    "position": ("Of an encoder [rad] or [m]; NaN: not valid", {"encoder": _number(0)}),
    "velocity": ("Of an encoder [rad/s] or [m/s]; NaN: not valid", {"encoder": _number(1)}),
    "pose": ("Of a pose sensor, in the world: position (3,) [m], quaternion (4,) w x y z; NaN: not valid",
             {"pose": _pose}),
    "twist": ("Of a pose sensor, in world axes: linear (3,) [m/s], angular (3,) [rad/s]; NaN: not valid",
              {"pose": _twist}),
    "specific_force": ("Of an IMU, in its axes: (3,) [m/s^2]; NaN: not valid", {"imu": _triple(0)}),
    "angular_velocity": ("Of an IMU, in its axes: (3,) [rad/s]; NaN: not valid", {"imu": _triple(3)}),
    "distance": ("Of an infrared sensor [m]; inf: nothing within the range; -inf: too near; NaN: not valid",
                 {"infrared": _number(0)}),
    "body": ("Of an infrared sensor: dotted name of the detected body; '': none", {"infrared": lambda s: s._body()}),
    "volts": ("Of an infrared sensor: output of the device that the scene selects [V]; NaN: none",
              {"infrared": _number(2)}),
    "size": ("Of a lidar: number of rays in all rings", {"lidar": lambda s: len(s._directions())}),
    "ranges": ("Of a lidar: (size,) [m], the lowest ring first, from right to left; empty: not valid",
               {"lidar": _ranges}),
    "directions": ("Of a lidar: (size, 3) unit directions of the rays in the sensor frame",
                   {"lidar": lambda s: s._directions()}),
    "brightness": ("Of a camera: mean of all colour values, 0 to 1; NaN: not valid", {"camera": _number(0)}),
    "nearest": ("Of a camera with depth: the smallest depth [m]; otherwise NaN", {"camera": _number(1)}),
    "touching": ("Of a contact sensor: whether it touches anything",
                 {"contact": lambda s: bool(s.valid and s.values[0] > 0.0)}),
    "bodies": ("Of a contact sensor: dotted names of the touching bodies, each once",
               {"contact": lambda s: s._bodies()}),
    "force": ("(3,) [N]: of a contact sensor, in its axes; of a force-torque sensor, in the joint axes of the child",
              {"contact": _triple(2), "force-torque": _triple(0)}),
    "torque": ("Of a force-torque sensor, about the joint origin: (3,) [N m]", {"force-torque": _triple(3)}),
}


def _property(name, doc, of):
    def get(self):
        _only(self, name, of)
        return of[self.type](self)
    return property(get, doc=doc + ". Raises AttributeError: of another sensor.")


def name_readings(*classes):
    """Gives classes of readings, which have name, type, valid and values, the names of all types."""
    for cls in classes:
        for name, (doc, of) in _NAMES.items():
            setattr(cls, name, _property(name, doc, of))
