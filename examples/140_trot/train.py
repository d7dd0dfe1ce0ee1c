"""A quadruped learns to walk: augmented random search (H. Mania, A. Guy, B. Recht, 2018) on 24 worlds.

    python3 train.py [--iterations N] [--out trot.onnx] [--curve curve.svg]

The same arguments give the same bits: every random number comes from the seed. Exit status 0: robots that were not
learned on gain more than chance.
"""

import argparse
import pathlib
import sys

import numpy as np
import numpy.typing as npt

import cogrsim as cg
import network as net

HERE = pathlib.Path(__file__).resolve().parent
SCENE = HERE / "walk.scene.xml"
ROBOT = "robot"
PLACES = ["z", "roll", "pitch", "yaw", "vx", "vy", "vz", "wx", "wy", "wz"]  # of the trunk
SIGNALS = ([f"{ROBOT}.trunk.{each}" for each in PLACES]
           + [f"{ROBOT}.{joint}.position" for joint in net.JOINTS]
           + [f"{ROBOT}.{joint}.velocity" for joint in net.JOINTS])
MOTORS = [f"{ROBOT}.{joint.removesuffix('_joint')}" for joint in net.JOINTS]
FALLEN = "robot.trunk.z lt 18 cm or abs(robot.trunk.roll) gt 45 deg or abs(robot.trunk.pitch) gt 45 deg"
DECISION = 5                    # steps of the engine in one decision: 20 ms
LENGTH = 125                    # decisions of an episode: 2.5 s
DIRECTIONS, BEST = 12, 6        # tried in an iteration, both ways, and those that count
RATE, SPREAD = 0.06, 0.05       # of a step, and of what is tried
ROBOTS, JUDGES = 32, 10**6      # that judge, and their first seed

Floats = npt.NDArray[np.float64]


def turned_back(seen: Floats) -> tuple[Floats, Floats, Floats]:
    """The angular velocity and the direction of gravity in the axes of the trunk, and the velocity in those of its
    heading; each (n, 3)."""
    _, roll, pitch, yaw, *_ = seen[:, :len(PLACES)].T
    velocity, spin = seen[:, 4:7], seen[:, 7:10]
    cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (np.cos, np.sin))
    gravity = np.stack([sp, -sr * cp, -cr * cp], axis=1)

    def to_heading(v: Floats) -> Floats:
        return np.stack([cy * v[:, 0] + sy * v[:, 1], cy * v[:, 1] - sy * v[:, 0], v[:, 2]], axis=1)

    # R = Rz(yaw) Ry(pitch) Rx(roll), so R' v turns back by yaw, then pitch, then roll.
    a = to_heading(spin)
    b = np.stack([cp * a[:, 0] - sp * a[:, 2], a[:, 1], sp * a[:, 0] + cp * a[:, 2]], axis=1)
    c = np.stack([b[:, 0], cr * b[:, 1] + sr * b[:, 2], cr * b[:, 2] - sr * b[:, 1]], axis=1)
    return c, gravity, to_heading(velocity)


def observations(seen: Floats, command: Floats, decision: int) -> Floats:
    """What the card says, (n, 35)."""
    spin, gravity, _ = turned_back(seen)
    turn = 2 * np.pi * decision * net.PERIOD * net.FREQUENCY
    phase = np.tile([np.sin(turn), np.cos(turn)], (len(seen), 1))
    joints = len(net.JOINTS)
    position, velocity = seen[:, len(PLACES):-joints], seen[:, -joints:]
    return np.concatenate([0.25 * spin, gravity, position - net.POSE, 0.05 * velocity, command, phase], axis=1)


def reward(seen: Floats, command: Floats, change: Floats) -> Floats:
    """Of one decision, at most 1.5: for the velocity and the turning that were asked for, less what is ugly."""
    spin, gravity, velocity = turned_back(seen)
    missed = (velocity[:, 0] - command[:, 0]) ** 2 + (velocity[:, 1] - command[:, 1]) ** 2
    out: Floats = (np.exp(-missed / 0.1) + 0.5 * np.exp(-(seen[:, 9] - command[:, 2]) ** 2 / 0.1)
                   - 0.5 * velocity[:, 2] ** 2 - 0.02 * (spin[:, :2] ** 2).sum(axis=1)
                   - 1.0 * (gravity[:, :2] ** 2).sum(axis=1) - 0.05 * (change ** 2).sum(axis=1))
    return out


def try_out(env: cg.VectorEnv, weights: Floats, command: Floats, seeds: list[int],
            random: np.random.Generator) -> tuple[Floats, Floats]:
    """The mean reward of a decision, and the share of an episode before the fall, (n,) each, of n networks."""
    seen, _ = env.reset(seed=seeds)
    n = env.num_envs
    total, lasted = np.zeros(n), np.zeros(n)
    alive = np.ones(n, dtype=bool)
    before = np.zeros((n, len(net.JOINTS)))
    for decision in range(LENGTH):
        read = observations(seen, command, decision)
        read[:, net.MEASURED] += random.normal(0.0, 0.02, read[:, net.MEASURED].shape)
        action = net.act(weights, read)
        seen, _, terminated, truncated, _ = env.step(net.POSE + net.SCALE * action)
        alive &= ~(terminated | truncated)
        total += np.where(alive, reward(seen, command, action - before), 0.0)
        lasted += alive
        before = action
        if not alive.any():
            break
    return total / LENGTH, lasted / LENGTH


def worlds(count: int, first_seed: int, each: int = 1) -> cg.VectorEnv:
    """Worlds of different robots on different grounds, every one `each` times."""
    scenes = [cg.compile(SCENE, set={"varied": "true"}, seed=first_seed + i // each) for i in range(count)]
    return cg.VectorEnv(scenes, count, actions=MOTORS, observations=SIGNALS, done=FALLEN, frame_skip=DECISION, duration=1e6)


def commands(count: int, random: np.random.Generator) -> Floats:
    """Ahead [m/s], to the left [m/s], and turning [rad/s]; one of eight stands still."""
    out = np.stack([random.uniform(-0.1, 0.6, count), np.zeros(count), random.uniform(-0.6, 0.6, count)], axis=1)
    out[::8] = 0.0
    return out


def judge(free: Floats) -> tuple[Floats, Floats]:
    """As try_out(), of robots, grounds and commands that were not learned on."""
    random = np.random.default_rng(JUDGES)
    seeds = list(range(JUDGES, JUDGES + ROBOTS))
    return try_out(worlds(ROBOTS, JUDGES), np.tile(net.weights(free), (ROBOTS, 1, 1)), commands(ROBOTS, random), seeds,
                   random)


def train(iterations: int, seed: int = 1) -> tuple[Floats, list[float]]:
    random = np.random.default_rng(seed)
    env = worlds(2 * DIRECTIONS, first_seed=1, each=2)
    free, curve = net.start(), []
    for iteration in range(iterations):
        # A direction is tried both ways, by the same robot with the same command and push.
        tried = random.normal(size=(DIRECTIONS, *free.shape))
        both = np.stack([free + SPREAD * tried, free - SPREAD * tried], axis=1).reshape(-1, *free.shape)
        asked = np.repeat(commands(DIRECTIONS, random), 2, axis=0)
        seeds = [1000 * (iteration + 1) + i // 2 for i in range(2 * DIRECTIONS)]
        gained, lasted = try_out(env, net.weights(both), asked, seeds, random)
        pairs = gained.reshape(-1, 2)
        best = np.argsort(-pairs.max(axis=1), kind="stable")[:BEST]
        slope = np.einsum("d,dij->ij", pairs[best, 0] - pairs[best, 1], tried[best])
        step = RATE * (1.0 - 0.8 * iteration / iterations)
        free = free + step / (BEST * (pairs[best].std() + 1e-6)) * slope
        curve.append(float(gained.mean()))
        print(f"iteration {iteration + 1:3} of {iterations}: reward {gained.mean():6.3f}, "
              f"{100 * (lasted == 1.0).mean():3.0f} % stand", flush=True)
    return free, curve


def main() -> int:
    parser = argparse.ArgumentParser(description="Train a quadruped to walk, and write its network as ONNX.")
    parser.add_argument("--iterations", type=int, default=150)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", default="trot.onnx", help="the network; must end with .onnx")
    parser.add_argument("--curve", help="a picture of the learning curve, .svg or .png")
    given = parser.parse_args()
    if given.iterations < 1:
        parser.error("--iterations must be at least 1")
    before, _ = judge(net.start())
    free, curve = train(given.iterations, given.seed)
    after, lasted = judge(free)
    # The same robots before and after, so pairs; 2.04 is Student's for 32 of them and 95 %.
    gain = after - before
    half = 2.04 * gain.std(ddof=1) / np.sqrt(ROBOTS)
    print(f"{ROBOTS} new robots: reward {before.mean():.3f} before, {after.mean():.3f} after training, "
          f"{gain.mean():.3f} ± {half:.3f} more; {(lasted == 1.0).sum()} stand")
    net.write(net.weights(free), given.out)
    print(given.out)
    if given.curve:
        cg.figure({"mean of 24 worlds": (range(1, len(curve) + 1), curve)}, x="iteration", y="reward of a decision",
                  format="png" if given.curve.endswith(".png") else "svg").save(given.curve, overwrite=True)
        print(given.curve)
    return 0 if gain.mean() > half else 1


if __name__ == "__main__":
    sys.exit(main())
