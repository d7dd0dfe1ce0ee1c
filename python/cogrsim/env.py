"""Worlds for learning, by the conventions of Gymnasium; gymnasium itself is not needed."""

import math

import numpy

from . import _cogrsim, spaces

try:
    import gymnasium as _gymnasium
    from gymnasium.vector import VectorEnv as _VectorBase
    _Base = _gymnasium.Env
    try:
        from gymnasium.vector import AutoresetMode
        _SAME_STEP = AutoresetMode.SAME_STEP
    except ImportError:
        _SAME_STEP = "SameStep"
except ImportError:
    _VectorBase = _Base = object
    _SAME_STEP = "SameStep"


def _action_space(scene, names):
    low, high = [], []
    for name in names:
        motor = scene.motor(name)
        mode = motor["mode"]
        if mode in ("position", "servo"):
            bounds = (motor.get("lower", -math.inf), motor.get("upper", math.inf))
        else:
            most = motor[{"velocity": "max_speed", "torque": "max_effort", "dc": "max_voltage"}[mode]]
            bounds = (-most, most)
        low.append(bounds[0])
        high.append(bounds[1])
    return spaces.Box(numpy.array(low), numpy.array(high), dtype=numpy.float64)


def _check_names(**lists):
    for name, value in lists.items():
        if isinstance(value, str):
            raise TypeError(f"{name}: expected a list of names, given a str; write [{value!r}]")
        if name == "backends":
            continue
        seen = set()
        for one in value:
            if one in seen:
                raise ValueError(f"{name}: '{one}' is given twice")
            seen.add(one)


def _check_options(options, known=()):
    for key in options or ():
        if key not in known:
            there = "there are " + ", ".join(known) if known else "there are none"
            raise ValueError(f"options: there is no option {key!r}; {there}")


def _whole(value, name, least=0):
    if isinstance(value, (int, numpy.integer)) and not isinstance(value, bool) and value >= least:
        return int(value)
    raise TypeError(f"{name}: expected a whole number from {least}, given {value!r}")


class VectorEnv(_VectorBase):
    """n worlds of one scene that are stepped together, in several threads.

    scene: a Scene or the path of a scene file; or n of them, one for each world, for parameters that differ
        (`[cg.compile(path, seed=i) for i in range(n)]`). All must have the named motors and signals.
    n: number of worlds.
    actions: dotted names of motors; their targets are the columns of the actions, in the units of their
        modes. Bounds of the space are those of the motors.
    observations: signals ("cart.pivot.position", "distance(robot, wall)"), the columns of the observations.
    done: condition that ends an episode (terminated), checked after every step of the engine.
    reward: signal; its value at the end of each step() of this class.
    backends: engines, taken in turn by the worlds: world i runs on backends[i % len(backends)]; empty: that
        of the scene.
    frame_skip: engine steps per step(). duration: length of an episode at most [s] (truncated); None: that
        of the scene, if it has one. step: time step of the engine [s]; 0: that of the scene.
    threads: 0: one per core. missing: value of a signal without a value. without: features of the scene that
        are left out, as Simulation has them.

    Same-step autoreset: the observations of a world whose episode ended are those of its next episode;
    infos["final_obs"][i] is the last of the old one, infos["_final_obs"] says where. The results do not
    depend on the number of threads or of worlds. Raises Error if the scene, a motor, a signal or an engine
    is wrong.
    """

    metadata = {"render_modes": ["rgb_array"], "autoreset_mode": _SAME_STEP}
    render_mode = "rgb_array"
    spec = None

    def __init__(self, scene, n, *, actions=(), observations=(), done="", reward="", backends=(),
                 frame_skip=1, duration=None, step=0.0, threads=0, missing=0.0, without=()):
        _check_names(actions=actions, observations=observations, backends=backends, without=without)
        self.num_envs = _whole(n, "n")
        given = list(scene) if isinstance(scene, (list, tuple)) else [scene]
        if len(given) not in (1, self.num_envs):
            raise ValueError(f"scene: expected 1 or {self.num_envs} scenes, given {len(given)}")
        given = [one if isinstance(one, _cogrsim.Scene) else _cogrsim.compile(one) for one in given]
        self.scene = scene = given[0]
        self.frame_skip = _whole(frame_skip, "frame_skip", 1)
        if duration is None:
            duration = scene.duration if scene.duration is not None else math.inf
        self._batch = _cogrsim._Batch(
            given, self.num_envs, list(actions), list(observations), done, reward, list(backends), step,
            threads, [], float(duration), True, missing, list(without))
        self.single_action_space = _action_space(scene, actions)
        self.single_observation_space = spaces.Box(
            -math.inf, math.inf, shape=(len(observations),), dtype=numpy.float64)
        self.action_space = spaces.batch_space(self.single_action_space, self.num_envs)
        self.observation_space = spaces.batch_space(self.single_observation_space, self.num_envs)
        self._fresh = True
        self.closed = False

    @property
    def dt(self):
        """Simulated time of one step() [s]."""
        return self._batch.dt * self.frame_skip

    @property
    def backends(self):
        """The engine of each world."""
        return [self._batch.backend(i) for i in range(self.num_envs)]

    @property
    def np_random_seed(self):
        """The seed of the present episode of each world."""
        return tuple(self._batch.seed(i) for i in range(self.num_envs))

    def observe_into(self, buffer):
        """Write observations into a float64 array (n, nobservation) of the caller from now on, which reset()
        and step() then return, without a copy; None: into new arrays. Raises TypeError, ValueError."""
        self._batch.observe_into(buffer)

    def reset(self, *, seed=None, options=None):
        """Start the next episode of all worlds: (observations (n, nobservation), infos).

        seed: world i gets seed + i; a list gives each world its own (None: the next of its own). options:
        {"reset_mask": (n,) bool} resets only these worlds.
        """
        _check_options(options, ("reset_mask",))
        worlds = list(range(self.num_envs))
        if options and options.get("reset_mask") is not None:
            mask = numpy.asarray(options["reset_mask"])
            if mask.shape != (self.num_envs,) or mask.dtype != bool:
                raise ValueError(f"reset_mask: expected a bool array of the shape ({self.num_envs},), given "
                                 f"{mask.dtype} {mask.shape}")
            worlds = [i for i in worlds if mask[i]]
        if seed is None:
            if not self._fresh or len(worlds) < self.num_envs:
                self._batch.reset([], worlds)
        elif isinstance(seed, (list, tuple, numpy.ndarray)):
            if len(seed) != self.num_envs:
                raise ValueError(f"seed: expected {self.num_envs} seeds, given {len(seed)}")
            given = [i for i in worlds if seed[i] is not None]
            rest = [i for i in worlds if seed[i] is None]
            self._batch.reset([_whole(seed[i], "seed") for i in given], given)
            if rest:
                self._batch.reset([], rest)
        else:
            first = _whole(seed, "seed")
            self._batch.reset([first + i for i in worlds], worlds)
        self._fresh = False
        return self._batch.observations(), {}

    def step(self, actions):
        """Step every world: (observations (n, nobservation), rewards (n,), terminated (n,), truncated (n,),
        infos). actions: (n, naction), finite; clamped to the limits of the motors. Ctrl-C raises
        KeyboardInterrupt when the step has ended.

        Errors of worlds that go on, such as the fault of a controller, are shown as RunWarning. infos has, where an
        episode ended, final_obs (n,) of arrays, final_info with "end" (why) and
        "message" of each, and the masks _final_obs and _final_info.
        """
        self._fresh = False
        observations, rewards, terminated, truncated, any_ended = self._batch.advance(actions, self.frame_skip)
        infos = {}
        if any_ended:
            ended = terminated | truncated
            final = self._batch.final_observations()
            names = self._batch.ends()
            obs = numpy.full(self.num_envs, None, dtype=object)
            end = numpy.full(self.num_envs, None, dtype=object)
            message = numpy.full(self.num_envs, None, dtype=object)
            for i in numpy.flatnonzero(ended):
                obs[i] = final[i]
                end[i] = names[i]
                message[i] = self._batch.end_message(int(i))
            infos = {"final_obs": obs, "_final_obs": ended,
                     "final_info": {"end": end, "_end": ended, "message": message, "_message": ended},
                     "_final_info": ended}
        return observations, rewards, terminated, truncated, infos

    def frame(self, world):
        """The present Frame of a world."""
        return self._batch.frame(world)

    def messages(self, world):
        """list of Message of the present episode of a world."""
        return self._batch.messages(world)

    def render(self):
        """Images of all worlds: a tuple of (height, width, 3) uint8."""
        from . import render
        return tuple(render(self.frame(i)) for i in range(self.num_envs))

    def close(self, **_):
        """Nothing has to be closed; further calls still work."""
        self.closed = True

    def __repr__(self):
        return f"<VectorEnv '{self.scene.name}': {self.num_envs} worlds>"


class Env(_Base):
    """One world, with the arguments of VectorEnv; without autoreset.

    backend: the engine; None: that of the scene.
    """

    metadata = {"render_modes": ["rgb_array"]}
    render_mode = "rgb_array"
    spec = None

    def __init__(self, scene, *, actions=(), observations=(), done="", reward="", backend=None,
                 frame_skip=1, duration=None, step=0.0, missing=0.0, without=()):
        if not isinstance(scene, _cogrsim.Scene):
            scene = _cogrsim.compile(scene)
        _check_names(actions=actions, observations=observations, without=without)
        self.scene = scene
        self.frame_skip = _whole(frame_skip, "frame_skip", 1)
        if duration is None:
            duration = scene.duration if scene.duration is not None else math.inf
        self._batch = _cogrsim._Batch(
            [scene], 1, list(actions), list(observations), done, reward,
            [] if backend is None else [backend], step, 1, [], float(duration), False, missing,
            list(without))
        self.action_space = _action_space(scene, actions)
        self.observation_space = spaces.Box(
            -math.inf, math.inf, shape=(len(observations),), dtype=numpy.float64)
        self._fresh = True
        self._ended = False

    @property
    def dt(self):
        """Simulated time of one step() [s]."""
        return self._batch.dt * self.frame_skip

    @property
    def frame(self):
        """The present Frame."""
        return self._batch.frame(0)

    @property
    def messages(self):
        """list of Message of the present episode."""
        return self._batch.messages(0)

    def reset(self, *, seed=None, options=None):
        """Start the next episode: (observation (nobservation,), info). options: there are none."""
        _check_options(options)
        if _Base is not object:
            super().reset(seed=seed)
        if seed is not None:
            self._batch.reset([_whole(seed, "seed")], [0])
        elif not self._fresh:
            self._batch.reset([], [0])
        self._fresh = self._ended = False
        return self._batch.observations()[0], {}

    def step(self, action):
        """Step: (observation (nobservation,), reward, terminated, truncated, info). After the end of an
        episode reset() must be called; otherwise RuntimeError."""
        if self._ended:
            raise RuntimeError("the episode has ended; call reset()")
        self._fresh = False
        action = numpy.asarray(action)
        if action.shape != self.action_space.shape:
            raise ValueError(f"action: expected the shape {self.action_space.shape}, given {action.shape}")
        observations, rewards, terminated, truncated, self._ended = self._batch.advance(
            action[numpy.newaxis], self.frame_skip)
        info = {}
        if self._ended:
            info = {"end": self._batch.ends()[0], "message": self._batch.end_message(0)}
        return observations[0], float(rewards[0]), bool(terminated[0]), bool(truncated[0]), info

    def render(self):
        """An image: (height, width, 3) uint8."""
        from . import render
        return render(self.frame)

    def close(self):
        """Nothing has to be closed."""

    def __repr__(self):
        return f"<Env '{self.scene.name}'>"


VectorEnv.__module__ = Env.__module__ = "cogrsim"
