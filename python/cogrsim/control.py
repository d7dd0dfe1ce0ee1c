"""Controllers, supervisors and sensors in Python.

A scene names a class as ``plugin="py:MODULE.CLASS"``. The module is imported as by ``import MODULE``, where
the folders of ``plugin_path`` come first. Controllers run in the simulation's process, or with
``isolation="process"`` in a Python process of their own; supervisors and sensors in the simulation's.
"""

import math
from dataclasses import dataclass


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


def parameter(name, default, unit="", description="", *, range=None, choices=(), required=False):
    """Declare a parameter of a class.

    The type of the default is the type of the parameter: 0.2 is a number, 3 an integer, True a boolean,
    "left" a text, [0.0] a list of numbers. unit: SI unit as in a scene ("m/s"); "": none. range: (lowest,
    highest), inclusive, in that unit. choices: allowed values of a text. required: the scene must set it.
    Raises TypeError for a default of another type.
    """
    if isinstance(default, (list, tuple)):
        default = [float(value) for value in default]
    elif not isinstance(default, (bool, int, float, str)):
        raise TypeError(
            f"parameter '{name}': expected a default of type bool, int, float, str or list of float, "
            f"given {type(default).__name__}")
    lowest, highest = (-math.inf, math.inf) if range is None else map(float, range)
    return Parameter(name, default, unit, description, lowest, highest, tuple(choices), required)


def output(name, unit="1", description=""):
    """Declare a number that a controller or supervisor publishes: the signal ROBOT.CONTROLLER.NAME."""
    return Output(name, unit, description)


def channel(name, unit="1", *, noisy=True, group=0):
    """Declare one number of the readings of a sensor. noisy: the noise terms of the scene apply to it."""
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
