"""Wall-clock time of one exchange with a controller in another program: socket_cost.py PROGRAM EXAMPLE_FOLDER"""

import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile
import time


def seconds(program, scene, client, folder):
    run = subprocess.Popen([program, "run", str(scene), "--duration", "20s"], cwd=folder,
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    other = subprocess.Popen(client, cwd=folder, stdout=subprocess.DEVNULL) if client else None
    start = time.monotonic()
    run.wait()
    elapsed = time.monotonic() - start
    if other:
        other.wait()
    return elapsed


def main():
    program, example = sys.argv[1], pathlib.Path(sys.argv[2])
    text = (example / "pendulum.scene.xml").read_text(encoding="utf-8")
    connect = '<controller connect="unix:run.sock" rate="500 Hz"/>'
    clients = {"Python": [sys.executable, str(example / "client.py")]}
    if shutil.which("node"):
        clients["JavaScript"] = ["node", str(example / "client.mjs")]
    with tempfile.TemporaryDirectory() as folder:
        scene, library = pathlib.Path(folder) / "run.scene.xml", pathlib.Path(folder) / "library.scene.xml"
        scene.write_text(text, encoding="utf-8")
        library.write_text(text.replace(connect, '<controller plugin="joint_pid" rate="500 Hz"><set motors="torque" '
                                        'target="30 deg" kp="8" ki="0" kd="0.4"/></controller>'), encoding="utf-8")
        for name, client in clients.items():
            rounds = [(seconds(program, scene, client, folder) - seconds(program, library, None, folder)) / 10000
                      for _ in range(5)]
            print(f"{name}: {1e6 * statistics.median(rounds):.0f} microseconds per exchange")


if __name__ == "__main__":
    main()
