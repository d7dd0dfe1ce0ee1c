"""What a decision of cg.Policy costs: a network with three hidden layers of 512, for one world and for 64.

    scripts/benchmark policy [ROUNDS]
"""

import pathlib
import statistics
import sys
import tempfile
import time

import numpy as np

import cogrsim as cg

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "python"))
from support import constant, model, node, port  # noqa: E402


def network(sizes=(48, 512, 512, 512, 12)):
    rng, parts, before = np.random.default_rng(0), [port(11, "obs", (1, sizes[0])), port(12, "out", (1, sizes[-1]))], "obs"
    for i, (n, m) in enumerate(zip(sizes, sizes[1:])):
        last = i == len(sizes) - 2
        parts += [constant(f"w{i}", rng.uniform(-1, 1, (m, n)) / n**0.5), constant(f"b{i}", rng.uniform(-1, 1, m)),
                  node("Gemm", [before, f"w{i}", f"b{i}"], ["out" if last else f"h{i}"], transB=1)]
        if not last:
            parts.append(node("Elu", [f"h{i}"], [f"a{i}"]))
            before = f"a{i}"
    return model(*parts)


def median(action, rounds):
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        action()
        times.append(time.perf_counter() - start)
    return 1000 * statistics.median(times)


rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 500
with tempfile.TemporaryDirectory() as folder:
    path = pathlib.Path(folder) / "net.onnx"
    path.write_bytes(network())
    policy = cg.Policy(path)
    one, many = np.zeros(48, "f4"), np.zeros((64, 48), "f4")
    print(f"one decision {median(lambda: policy.act(one), rounds):.3f} ms, 64 worlds "
          f"{median(lambda: policy.act(many), rounds // 10):.2f} ms")
