"""Adapters of engines in Python: what every one needs, so that it holds its engine's code alone.

An adapter is a program that CogRSim starts. It calls serve() with what it can do and a function
that builds a world, and answers until CogRSim ends it. Standard output is free: frames go over a
socket of their own. The page is docs/plugins/backends-in-any-language.md.

Arrays are memoryviews of doubles: numpy.asarray(view) shares their memory. SI units, right-handed
frames, world axes where nothing else is said; poses are x y z [m] and the quaternion w x y z.
"""

import json
import math
import os
import re
import socket
import struct
import sys
import traceback
from types import SimpleNamespace

PROTOCOL = 1

_CHANNEL = 3
_MARK = 0x53524743
_HEAD = struct.Struct("<IIQ")  # mark, kind, length of the content [byte]
(_HELLO, _PROVENANCE, _SCENE, _BUILD, _STEP, _REPORT, _WRITE, _SAVE, _RESTORE,
 _FREE) = range(1, 11)
_ERROR = 255
# Flags of a step and a report.
_HAS_EFFORTS, _HAS_FORCES, _WANTS_CONTACTS, _WANTS_REACTIONS = 1, 2, 4, 8
_CONTACT_NUMBERS = 14
_CONTACT = struct.Struct("<14d")


class Refusal(Exception):
    """What the adapter cannot do for this scene, in words for its user; the adapter goes on."""


class Diverged(Exception):
    """Raised by step(): the state has left all bounds. `body`: its index."""

    def __init__(self, message, body=-1):
        super().__init__(message)
        self.body = body


class World:
    """What an adapter's build() returns; derive from it.

    A world may also have, for what its adapter declares: write(state); contacts(), which yields of
    the last step 14 numbers each: body, body, shape, shape (within its body), point, normal from
    the first to the second, depth, and the force on the second; reactions(out), which fills in six
    numbers for each joint: force and torque on the child about the origin of M; save(), which
    returns bytes, and restore(bytes, state); free().
    """

    def step(self, step):
        """Advances by step.dt [s].

        step.drives: six for each motor: bias, kp, position, kd, velocity, max_effort. The effort is
        clamp(bias + kp (position - q) + kd (velocity - u), +-max_effort); an infinite kd is a source
        of speed. step.efforts: along the speeds of joints, beside the drives, or None.
        step.forces: six for each body, force through the centre of mass and torque, or None.
        step.twists: six for each body; those of kinematic ones hold.
        """
        raise NotImplementedError

    def read(self, out):
        """Fills in out.poses (seven for each body), out.twists (six: velocity of the origin, angular
        velocity), out.positions and out.speeds (of joints; empty with coordinates "bodies"), and
        the means over the last step out.joint_efforts and out.motor_efforts. All are 0 before."""
        raise NotImplementedError


class Adapter:
    """What an adapter can do; derive from it and pass an object to serve()."""

    #: Version of the engine, asked of it.
    version = ""
    #: By feature (`cogrsim plugins` lists them) or by a pattern with *, later ones overrule:
    #: "exact", or ("approximate" or "unsupported", "why").
    capabilities = {}
    #: Attributes of <NAME .../>: dicts with name, default, and maybe type ("integer"), unit, description,
    #: minimum, maximum, choices.
    options = []
    #: The same by "assembly", "material", "joint" and "couple".
    element_options = {}
    #: "bodies": the engine has no coordinates, and CogRSim finds them from the motions of bodies.
    coordinates = "joints"
    #: "host": CogRSim finds the efforts of couplings, and step() applies them.
    couplings = "engine"
    #: Time of a step at which forces are evaluated, 0 to 1.
    force_time = 0.0

    def provenance(self, options):
        """A dict: engine, solver, formulation, integrator, and stages: by stage ("broad-phase",
        "narrow-phase", "contact-memory", "contact-law", "friction", "restitution", "joints",
        "limits", "motors", "integrator") ("engine", "cogrsim" or "none", its class or function)."""
        raise NotImplementedError

    def build(self, scene, state, previous):
        """A world of `scene`, objects with the members that the page lists, in `state`. `previous`:
        the world that it follows after a change of the scene, or None."""
        raise NotImplementedError


class _Channel:
    """The frames over the socket."""

    def __init__(self):
        self._socket = socket.socket(fileno=_CHANNEL)
        self._in = memoryview(bytearray(1 << 16))
        self._out = memoryview(bytearray(1 << 16))
        self._numbers_in = self._in[_HEAD.size:].cast("d")
        self._numbers_out = self._out[_HEAD.size:].cast("d")

    def next(self):
        """Waits for a request: its call and the length of its content; None: there are no more."""
        got, whole, call = 0, _HEAD.size, None
        while got < whole:
            now = self._socket.recv_into(self._in[got:])
            if now == 0:
                return None
            got += now
            if got < _HEAD.size or call is not None:
                continue
            mark, call, size = _HEAD.unpack_from(self._in)
            if mark != _MARK:
                raise RuntimeError("a request that is no frame")
            whole += size
            if whole > len(self._in):
                larger = memoryview(bytearray((2 * whole + 7) // 8 * 8))
                larger[:got] = self._in[:got]
                self._in = larger
                self._numbers_in = self._in[_HEAD.size:].cast("d")
        return call, whole - _HEAD.size

    def text(self, size):
        return str(self.bytes(0, size), "utf-8")

    def numbers(self):
        """Numbers of the request, valid until the next one; there may be more behind them."""
        return self._numbers_in

    def bytes(self, begin, size):
        return bytes(self._in[_HEAD.size + begin:_HEAD.size + size])

    def room(self, count):
        """Room for an answer of so many numbers, all 0; it may be longer."""
        size = _HEAD.size + 8 * count
        if size > len(self._out):
            self._out = memoryview(bytearray(16 * size))
            self._numbers_out = self._out[_HEAD.size:].cast("d")
        self._out[_HEAD.size:size] = bytes(8 * count)
        return self._numbers_out

    def answer(self, call, count):
        """Sends what stands in room()."""
        _HEAD.pack_into(self._out, 0, _MARK, call, 8 * count)
        self._socket.sendall(self._out[:_HEAD.size + 8 * count])

    def answer_bytes(self, call, content):
        self._socket.sendall(_HEAD.pack(_MARK, call, len(content)) + content)

    def answer_json(self, call, value):
        self.answer_bytes(call, json.dumps(value).encode())


_INFINITIES = {"inf": math.inf, "-inf": -math.inf, "nan": math.nan}


def _named(value):
    """Objects with members for dicts; options have names that users see, and stay dicts."""
    if isinstance(value, list):
        return [_named(item) for item in value]
    if not isinstance(value, dict):
        return value
    return SimpleNamespace(
        **{key: item if key == "options" else _named(item) for key, item in value.items()})


def _read_scene(text):
    """The scene of a request. JSON has no infinity: limits have it as a text."""
    scene = json.loads(text)
    axes = [axis for joint in scene["joints"] for axis in joint["axes"]]
    for item in scene["motors"] + scene["couplings"] + axes:
        for key, value in item.items():
            if key != "name" and isinstance(value, str):
                item[key] = _INFINITIES.get(value, value)
    return _named(scene)


def _support_of(capabilities, feature):
    """The support of a feature by the last pattern that matches it."""
    support = "unsupported"
    for pattern, value in capabilities.items():
        if re.fullmatch(".*".join(map(re.escape, pattern.split("*"))), feature):
            support = value if isinstance(value, str) else value[0]
    return support


def _check_world(world, capabilities):
    """Whether a world has what its adapter declares."""
    for feature, method in (("runtime.save", "save"), ("runtime.save", "restore"),
                            ("runtime.set_state", "write"), ("report.contact_force", "contacts"),
                            ("report.joint_reaction", "reactions")):
        if _support_of(capabilities, feature) != "unsupported" and not hasattr(world, method):
            raise TypeError(
                f"the adapter declares '{feature}', and its world has no {method}()")


def _cut(numbers, at, *counts):
    """Parts of an array, one after the other from `at`."""
    out = []
    for count in counts:
        out.append(numbers[at:at + count])
        at += count
    return out


class _Hosted:
    """A world and the places of its numbers in frames."""

    def __init__(self, scene, world, jointless):
        self.scene, self.world = scene, world
        bodies, speeds = len(scene.bodies), scene.joint_speeds
        self._counts = (7 * bodies, 6 * bodies, 0 if jointless else scene.joint_positions,
                        0 if jointless else speeds, speeds, len(scene.motors))
        self._size = sum(self._counts)
        # Parts of the arrays of the last frames, which stay the same from step to step.
        self._out_array = self._out = self._in_array = self._in = self._in_flags = None
        self._kinematic = [b for b, body in enumerate(scene.bodies) if body.kind == "kinematic"]
        self._twists = memoryview(bytearray(48 * bodies)).cast("d")

    @staticmethod
    def count(scene):
        return 13 * len(scene.bodies) + scene.joint_positions + scene.joint_speeds

    @staticmethod
    def state_in(scene, numbers, at):
        """A copy of the state in a request."""
        bodies = len(scene.bodies)
        copy = memoryview(bytearray(numbers[at:at + _Hosted.count(scene)].tobytes())).cast("d")
        poses, twists, positions, speeds = _cut(copy, 0, 7 * bodies, 6 * bodies,
                                                scene.joint_positions, scene.joint_speeds)
        return SimpleNamespace(poses=poses, twists=twists, positions=positions, speeds=speeds)

    def answer(self, channel, call, wanted, with_state):
        """Sends state and reports."""
        contacts = ()
        if wanted & _WANTS_CONTACTS and hasattr(self.world, "contacts"):
            contacts = list(self.world.contacts())
        joints = 6 * len(self.scene.joints) if wanted & _WANTS_REACTIONS else 0
        at = self._size if with_state else 0
        count = at + joints + _CONTACT_NUMBERS * len(contacts)
        out = channel.room(count)
        if with_state:
            if out is not self._out_array:
                self._out_array = out
                poses, twists, positions, speeds, efforts, motors = _cut(out, 0, *self._counts)
                self._out = SimpleNamespace(poses=poses, twists=twists, positions=positions,
                                            speeds=speeds, joint_efforts=efforts,
                                            motor_efforts=motors)
            self.world.read(self._out)
        if joints and hasattr(self.world, "reactions"):
            self.world.reactions(out[at:at + joints])
        at += joints
        for contact in contacts:
            if len(contact) != _CONTACT_NUMBERS:
                raise ValueError("a contact needs 14 numbers")
            _CONTACT.pack_into(out, 8 * at, *contact)
            at += _CONTACT_NUMBERS
        channel.answer(call, count)

    def step(self, numbers):
        """Advances the world; returns what is wanted of it."""
        flags = int(numbers[1])
        if numbers is not self._in_array or flags & 3 != self._in_flags:
            self._in_array, self._in_flags = numbers, flags & 3
            drives, efforts, forces, twists = _cut(
                numbers, 2, 6 * len(self.scene.motors),
                self.scene.joint_speeds if flags & _HAS_EFFORTS else 0,
                6 * len(self.scene.bodies) if flags & _HAS_FORCES else 0,
                6 * len(self._kinematic))
            self._in = SimpleNamespace(
                dt=0.0, drives=drives, efforts=efforts if flags & _HAS_EFFORTS else None,
                forces=forces if flags & _HAS_FORCES else None, twists=self._twists, given=twists)
        for i, body in enumerate(self._kinematic):
            self._twists[6 * body:6 * body + 6] = self._in.given[6 * i:6 * i + 6]
        self._in.dt = numbers[0]
        self.world.step(self._in)
        return flags


class _Server:
    """Answers one request after the other."""

    def __init__(self, adapter):
        self._adapter = adapter
        self._channel = _Channel()
        self._scene = None  # for the next build
        self._hosted = None
        self._answers = {
            _HELLO: self._hello, _PROVENANCE: self._provenance, _SCENE: self._take_scene,
            _BUILD: self._take_build, _STEP: self._step, _REPORT: self._report,
            _WRITE: self._write, _SAVE: self._save, _RESTORE: self._restore, _FREE: self._free}

    def run(self):
        while (request := self._channel.next()) is not None:
            try:
                self._answers[request[0]](*request)
            except Exception as error:  # pylint: disable=broad-except
                kind = "refused" if isinstance(error, Refusal) else (
                    "diverged" if isinstance(error, Diverged) else "thrown")
                message = str(error)
                if kind == "thrown":
                    traceback.print_exc()
                    message = f"{type(error).__name__}: {error}"
                self._channel.answer_json(_ERROR, {"kind": kind, "message": message,
                                                   "body": getattr(error, "body", -1)})

    def _hello(self, call, size):
        protocol = json.loads(self._channel.text(size))["protocol"]
        if protocol != PROTOCOL:
            raise Refusal(f"its library speaks version {PROTOCOL} of the protocol, and this CogRSim "
                          f"{protocol}: `cogrsim new backend --language python` writes the right one")
        own = self._adapter
        self._channel.answer_json(call, {
            "version": own.version, "capabilities": own.capabilities, "options": own.options,
            "element_options": own.element_options, "coordinates": own.coordinates,
            "couplings": own.couplings, "force_time": own.force_time})

    def _provenance(self, call, size):
        options = json.loads(self._channel.text(size))
        self._channel.answer_json(call, self._adapter.provenance(options))

    def _take_scene(self, call, size):
        self._scene = _read_scene(self._channel.text(size))
        self._channel.answer_bytes(call, b"")

    def _take_build(self, call, size):
        numbers = self._channel.numbers()
        previous = self._hosted.world if numbers[0] != 0 and self._hosted else None
        self._build(_Hosted.state_in(self._scene, numbers, 1), previous)
        self._hosted.answer(self._channel, call, 0, True)

    def _build(self, state, previous):
        """The old world stays where this fails."""
        world = self._adapter.build(self._scene, state, previous)
        _check_world(world, self._adapter.capabilities)
        self._free_world()
        self._hosted = _Hosted(self._scene, world, self._adapter.coordinates == "bodies")

    def _step(self, call, size):
        self._hosted.answer(self._channel, call, self._hosted.step(self._channel.numbers()), True)

    def _report(self, call, size):
        self._hosted.answer(self._channel, call, int(self._channel.numbers()[0]), False)

    def _write(self, call, size):
        if not hasattr(self._hosted.world, "write"):
            raise Refusal("its adapter cannot set a state")
        numbers = self._channel.numbers()
        self._hosted.world.write(_Hosted.state_in(self._hosted.scene, numbers, 0))
        self._hosted.answer(self._channel, call, 0, True)

    def _save(self, call, size):
        if not hasattr(self._hosted.world, "save"):
            raise Refusal("its adapter cannot save a state")
        self._channel.answer_bytes(call, bytes(self._hosted.world.save()))

    def _restore(self, call, size):
        count = 8 * _Hosted.count(self._scene)
        content = self._channel.bytes(count, size)
        state = _Hosted.state_in(self._scene, self._channel.numbers(), 0)
        if self._hosted is None or self._hosted.scene is not self._scene:
            self._build(state, None)
        if not hasattr(self._hosted.world, "restore"):
            raise Refusal("its adapter cannot restore a state")
        self._hosted.world.restore(content, state)
        self._hosted.answer(self._channel, call, 0, True)

    def _free(self, call, size):
        self._free_world()
        self._channel.answer_bytes(call, b"")

    def _free_world(self):
        if self._hosted is not None and hasattr(self._hosted.world, "free"):
            self._hosted.world.free()
        self._hosted = None


def serve(adapter):
    """Answers CogRSim until it ends this program."""
    try:
        os.fstat(_CHANNEL)
    except OSError:
        sys.exit("this program is a backend: CogRSim starts it, see backend.json beside it")
    _Server(adapter).run()
