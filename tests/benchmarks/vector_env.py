"""What cogrsim.VectorEnv costs beside the C++ batch that it calls: vector_env.py [ROUNDS]

Both step the carts of examples/070_batch on one thread, by turns: VectorEnv.step() with actions, observations and rewards, and
Batch::step() alone. Processor time, and ratios of neighbouring rounds, so that whatever else the machine does hits both.
"""

import pathlib
import statistics
import sys
import time

import numpy as np

import cogrsim as cg

SCENE = pathlib.Path(__file__).resolve().parents[2] / "examples" / "070_batch" / "cart.scene.xml"
WORLDS = 64


def seconds(work, calls):
    start = time.process_time()
    for _ in range(calls):
        work()
    return time.process_time() - start


def main():
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 31
    scene = cg.compile(SCENE)
    print(f"{WORLDS} worlds; medians of {rounds} rounds\n")
    print(f"{'engine':<10} {'steps a call':>12} {'world steps/s':>14} {'of the batch alone':>19}")
    for engine in ("bullet", "cogrsim", "mujoco", "ode"):
        for steps in (1, 10):
            made = [cg.VectorEnv(scene, WORLDS, actions=["cart.push"], reward="1 - abs(cart.pivot.position) / 1 rad",
                                 observations=["cart.rail.position", "cart.pivot.position"], backends=[engine],
                                 frame_skip=steps, duration=1e9, threads=1) for _ in range(2)]
            env, batch = made[0], made[1]._batch
            still = np.zeros((WORLDS, 1))
            both = lambda: env.step(still), lambda: batch.step(None, steps)
            for one in made:
                one.reset(seed=0)
            calls = max(1, int(0.1 / (seconds(both[1], 10) / 10)))
            times = [[seconds(one, calls) for one in both] for _ in range(rounds)]
            ratio = statistics.median(alone / with_python for with_python, alone in times)
            rate = calls * steps * WORLDS / statistics.median(with_python for with_python, _ in times)
            print(f"{engine:<10} {steps:>12} {rate:>14.0f} {100 * ratio:>17.1f} %")


if __name__ == "__main__":
    main()
