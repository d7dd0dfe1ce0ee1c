"""A robot's MJCF on bare MuJoCo, and its import on our engines: robot.py MODEL.xml [--keyframe NAME] [--rounds N]

The original file runs in MuJoCo by its C library, the import in `mujoco`, our adapter, and in `cogrsim`, our dynamics, all from
the keyframe with the controls of it, in the steps of the file. They step 0.2 s by turns; reported are medians of processor
time, and of the ratios of neighbouring rounds to bare MuJoCo, so that whatever else the machine does hits all.
"""

import argparse
import ctypes
import ctypes.util
import statistics
import sys
import tempfile
import time

import cogrsim as cg

ENGINES = ("mujoco", "cogrsim")
SECONDS = 0.2  # of a round


class Original:
    """The file in MuJoCo's own library."""

    def __init__(self, path, keyframe):
        name = ctypes.util.find_library("mujoco")
        if not name:
            sys.exit("robot.py: MuJoCo's library is not installed: apt install libmujoco-dev")
        self.lib = ctypes.CDLL(name)
        pointer, text = ctypes.c_void_p, ctypes.c_char_p
        self.lib.mj_loadXML.restype = self.lib.mj_makeData.restype = pointer
        self.lib.mj_loadXML.argtypes = [text, pointer, text, ctypes.c_int]
        self.lib.mj_makeData.argtypes = [pointer]
        self.lib.mj_name2id.argtypes = [pointer, ctypes.c_int, text]
        self.lib.mj_resetDataKeyframe.argtypes = [pointer, pointer, ctypes.c_int]
        self.lib.mj_step.argtypes = [pointer, pointer]
        error = ctypes.create_string_buffer(1000)
        self.model = self.lib.mj_loadXML(str(path).encode(), None, error, len(error))
        if not self.model:
            sys.exit(f"robot.py: MuJoCo {self.lib.mj_version()} does not read {path}: {error.value.decode()}")
        self.data = self.lib.mj_makeData(self.model)
        if keyframe:
            key = 22  # mjOBJ_KEY
            self.lib.mj_resetDataKeyframe(self.model, self.data,
                                          max(self.lib.mj_name2id(self.model, key, keyframe.encode()), 0))

    def run(self, steps):
        for _ in range(steps):
            self.lib.mj_step(self.model, self.data)


def main():
    parser = argparse.ArgumentParser(prog="scripts/benchmark robot", description=__doc__.split("\n\n")[0])
    parser.add_argument("model", help="an MJCF file")
    parser.add_argument("--keyframe", help="the pose to start in, and its controls")
    parser.add_argument("--rounds", type=int, default=15)
    arguments = parser.parse_args()
    sides = {"mujoco's own": Original(arguments.model, arguments.keyframe)}
    with tempfile.TemporaryDirectory() as folder:
        path = f"{folder}/robot.scene.xml"
        cg.import_model(arguments.model, keyframe=arguments.keyframe or "").write(path)
        sides.update((engine, cg.Simulation(path, backend=engine)) for engine in ENGINES)
    dt = sides[ENGINES[0]].dt
    steps = max(1, round(SECONDS / dt))
    times = {name: [] for name in sides}
    for turn in range(arguments.rounds + 1):
        for name, side in sides.items():
            start = time.process_time()
            side.run(steps) if isinstance(side, Original) else side.run_until(side.time + steps * dt)
            if turn:  # the first warms up
                times[name].append((time.process_time() - start) / steps)
    own = times["mujoco's own"]
    print(f"{arguments.model}: steps of {1e3 * dt:g} ms, medians of {arguments.rounds} rounds\n")
    print(f"{'':<14} {'us a step':>10} {'of bare MuJoCo':>15}")
    for name, measured in times.items():
        ratio = statistics.median(a / b for a, b in zip(measured, own))
        print(f"{name:<14} {1e6 * statistics.median(measured):>10.1f} {ratio:>15.2f}")


if __name__ == "__main__":
    main()
