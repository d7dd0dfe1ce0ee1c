"""64 carts on two engines learn to balance their poles, and are judged on a third (cross-entropy method)."""

import pathlib
import sys

import numpy as np
import numpy.typing as npt

import cogrsim as cg

SCENE = pathlib.Path(__file__).resolve().parent.parent / "070_batch" / "cart.scene.xml"
ACTIONS = ["cart.push"]
OBSERVATIONS = ["cart.rail.position", "cart.rail.velocity", "cart.pivot.position", "cart.pivot.velocity"]
DONE = "abs(cart.pivot.position) gt 20 deg or abs(cart.rail.position) gt 2 m"
CARTS, BEST, GENERATIONS = 64, 8, 12
STEPS, SKIP = 200, 10  # decisions of an episode, and engine steps per decision: 4 s

Floats = npt.NDArray[np.float64]


def try_out(env: cg.VectorEnv, gains: Floats, seed: int) -> Floats:
    """How long each cart balances with its own gains [decisions]."""
    seen, _ = env.reset(seed=seed)
    steps = np.zeros(env.num_envs)
    alive = np.ones(env.num_envs, dtype=bool)
    for _ in range(STEPS):
        force = (seen * gains).sum(axis=1, keepdims=True)
        seen, _, terminated, truncated, _ = env.step(force)
        alive &= ~(terminated | truncated)
        steps += alive
        if not alive.any():
            break
    return steps


def main(engines: list[str], judge: str, picture: str) -> int:
    # Each seed has its own pole and its own start.
    scenes = [cg.compile(SCENE, seed=seed) for seed in range(2 * CARTS)]
    carts = cg.VectorEnv(scenes[:CARTS], CARTS, actions=ACTIONS, observations=OBSERVATIONS, done=DONE,
                         backends=engines, frame_skip=SKIP, duration=1e6)
    random = np.random.default_rng(1)
    mean, spread = np.zeros(4), np.array([10.0, 10.0, 100.0, 20.0])
    curve = []
    for generation in range(GENERATIONS):
        gains = random.normal(mean, spread, (CARTS, 4))
        steps = try_out(carts, gains, seed=1000 * generation)
        best = gains[np.argsort(-steps, kind="stable")[:BEST]]
        mean, spread = best.mean(axis=0), best.std(axis=0) + 0.5
        curve.append(steps.mean())
        print(f"generation {generation + 1}: {steps.mean():5.1f} of {STEPS} decisions, best {steps.max():.0f}")
    judges = cg.VectorEnv(scenes[CARTS:], CARTS, actions=ACTIONS, observations=OBSERVATIONS, done=DONE,
                          backends=[judge], frame_skip=SKIP, duration=1e6)
    kept = int((try_out(judges, np.tile(mean, (CARTS, 1)), seed=10**6) == STEPS).sum())
    print(f"learned on {' and '.join(engines)}; on {judge} {kept} of {CARTS} new carts keep their poles up")
    figure = cg.figure({"mean": (range(1, GENERATIONS + 1), curve)}, x="generation",
                       y=f"decisions until the pole falls, mean of {CARTS} carts",
                       format="png" if picture.endswith(".png") else "svg")
    figure.save(picture, overwrite=True)
    print(f"learning curve: {picture}")
    return 0 if kept >= 0.9 * CARTS else 1


if __name__ == "__main__":
    sys.exit(main(["bullet", "mujoco"], "ode", sys.argv[1] if len(sys.argv) > 1 else "learning_curve.svg"))
