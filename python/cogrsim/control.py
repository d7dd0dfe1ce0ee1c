"""Controllers, supervisors and sensors in Python.

A scene names a class as ``plugin="py:MODULE.CLASS"``. The module is imported as by ``import MODULE``, where
the folders of ``plugin_path`` come first. Controllers run in the simulation's process, or with
``isolation="process"`` in a Python process of their own; supervisors and sensors in the simulation's.
"""

import math
import re
from dataclasses import dataclass

from . import _cogrsim


@dataclass(frozen=True)
class Parameter:
    """Declaration of a parameter, see parameter()."""

    name: str
    default: object
    unit: str = ""
    description: str = ""
    minimum: float = -math.inf
    maximum: float = math.inf
    choices: tuple = ()
    required: bool = False


@dataclass(frozen=True)
class Output:
    """Declaration of a number that a controller publishes, see output()."""

    name: str
    unit: str = "1"
    description: str = ""


@dataclass(frozen=True)
class Channel:
    """One number of the readings of a sensor, see channel()."""

    name: str
    unit: str = "1"
    noisy: bool = True
    group: int = 0


def _checked(kind, name, unit, description):
    """Raises TypeError and ValueError for a name, unit or description that no declaration has."""
    for what, value in (("name", name), ("unit", unit), ("description", description)):
        if not isinstance(value, str):
            raise TypeError(f"{kind}: expected a {what} of type str, given {type(value).__name__}")
    if not re.fullmatch("[A-Za-z_][A-Za-z0-9_-]*", name):
        raise ValueError(f"{kind} {name!r}: a name has letters, digits, '_' and '-', and begins with a letter or '_'")
    if unit and not _cogrsim._is_unit(unit):
        raise ValueError(f"{kind} '{name}': '{unit}' is not a unit; expected one such as 'm/s', 'rad' or '1'")


def parameter(name, default, unit="", description="", *, range=None, choices=(), required=False):
    """Declare a parameter of a class.

    The type of the default is the type of the parameter: 0.2 is a number, 3 an integer, True a boolean,
    "left" a text, [0.0] a list of numbers. unit: SI unit as in a scene ("m/s"); "": none. range: (lowest,
    highest), inclusive, in that unit. choices: allowed values of a text. required: the scene must set it.
    Raises TypeError for a default of another type, ValueError for one that is not allowed, and for a name
    or unit that no parameter has.
    """
    _checked("parameter", name, unit, description)
    if isinstance(default, (list, tuple)):
        default = [float(value) for value in default]
    elif not isinstance(default, (bool, int, float, str)):
        raise TypeError(
            f"parameter '{name}': expected a default of type bool, int, float, str or list of float, "
            f"given {type(default).__name__}")
    lowest, highest = (-math.inf, math.inf) if range is None else map(float, range)
    if not lowest <= highest:
        raise ValueError(f"parameter '{name}': expected a range (lowest, highest), given {range!r}")
    if range is not None and isinstance(default, (bool, str)):
        raise TypeError(f"parameter '{name}': a {type(default).__name__} has no range")
    if isinstance(choices, str) or (choices and not isinstance(default, str)):
        raise TypeError(f"parameter '{name}': choices are a list of texts, and the default is one of them")
    if not required:
        for value in default if isinstance(default, list) else [default]:
            if range is not None and not lowest <= value <= highest:
                raise ValueError(f"parameter '{name}': the default {value!r} is outside of {lowest} to {highest}")
            if choices and value not in choices:
                raise ValueError(f"parameter '{name}': the default {value!r} is none of {list(choices)}")
    return Parameter(name, default, unit, description, lowest, highest, tuple(choices), required)


def output(name, unit="1", description=""):
    """Declare a number that a controller or supervisor publishes: the signal ROBOT.CONTROLLER.NAME."""
    _checked("output", name, unit, description)
    return Output(name, unit, description)


def channel(name, unit="1", *, noisy=True, group=0):
    """Declare one number of the readings of a sensor. noisy: the noise terms of the scene apply to it."""
    _checked("channel", name, unit, "")
    if not isinstance(group, int) or isinstance(group, bool) or group < 0:
        raise ValueError(f"channel '{name}': expected a group from 0, given {group!r}")
    return Channel(name, unit, noisy, group)


class Controller:
    """A controller of a robot.

    Derive from it, declare `parameters` and `outputs`, and define configure() and update(). All calls of an
    object are made by one thread at a time, between two steps. An exception stops this controller, or the
    run if the scene says on-fault="end-run", and is in Simulation.messages with robot, time and traceback.
    """

    parameters = ()
    outputs = ()

    def configure(self, robot):
        """Called once before the run, and on a new object after every restart. robot: a Robot."""

    def update(self, tick):
        """Called at the rate of the controller. tick: a Tick with time [s], period [s] and count."""
        raise NotImplementedError(f"{type(self).__name__}.update(tick) is not defined")

    def save(self):
        """The complete inner state as str, for snapshots in files; None: it restarts when one is loaded."""
        return None

    def restore(self, memory):
        """Called after configure() with the result of save()."""


class Supervisor:
    """Observes the whole world and changes it by commands.

    contacts, joint_reactions, accelerations: what the frames of update() contain beside state, readings and
    events.
    """

    parameters = ()
    outputs = ()
    contacts = False
    joint_reactions = False
    accelerations = False

    def configure(self, context):
        """Called before the run, and on a new object after every restart. context: a SupervisorContext."""

    def update(self, tick, context):
        """Called at the rate of the supervisor."""
        raise NotImplementedError(f"{type(self).__name__}.update(tick, context) is not defined")

    def save(self):
        """As Controller.save()."""
        return None

    def restore(self, memory):
        """As Controller.restore()."""


class Sensor:
    """A sensor model: the ideal measurement; noise, rate and switching are the simulation's.

    channels: what read() returns, in order; constant after configure().
    """

    parameters = ()
    channels = ()
    contacts = False
    joint_reactions = False
    accelerations = False

    def configure(self, sensor, parameters):
        """Called once. sensor: dict with name, body, joint, position, orientation and rate; parameters: dict
        of complete values in SI units. Raise an exception if the sensor cannot work there."""

    def read(self, context):
        """The values of the channels in context.frame; NaN: not available. context: a SensorContext."""
        raise NotImplementedError(f"{type(self).__name__}.read(context) is not defined")


for _class in (Parameter, Output, Channel, Controller, Supervisor, Sensor):
    _class.__module__ = "cogrsim"
