"""The installed module works as that of the build tree, with its own libraries and plugins."""

import os
import pathlib
import subprocess
import sys
import unittest

from support import CART, Case, main

USE = """
import sys
import cogrsim as cg
sim = cg.Simulation(cg.compile(sys.argv[1]), backend=sys.argv[2])
print(cg.__file__)
print(sim.run_until(0.05).state_hash)
print([line.split()[-1] for line in open("/proc/self/maps") if "libcogrsim.so" in line or "/cogrsim/backends/" in line][0])
"""


class Install(Case):
    def use(self, path):
        environment = {**os.environ, "PYTHONPATH": str(path)}
        done = subprocess.run([sys.executable, "-c", USE, str(CART), "cogrsim"], env=environment,
                              capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.split()

    def test_installed_tree(self):
        build = os.environ["COGRSIM_BUILD"]
        prefix = self.folder / "prefix"
        for part in ("sdk", "dsl", "backends/cogrsim", "python"):
            script = pathlib.Path(build) / part / "cmake_install.cmake"
            self.assertTrue(script.exists(), script)
            done = subprocess.run(["cmake", f"-DCMAKE_INSTALL_PREFIX={prefix}", "-P", script],
                                  capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)
        package = next(prefix.rglob("cogrsim/__init__.py")).parent
        self.assertTrue((package / "py.typed").exists())
        self.assertTrue(list(package.glob("*.pyi")))
        file, state, library = self.use(package.parent)
        self.assertEqual(pathlib.Path(file).parent, package)
        self.assertTrue(library.startswith(str(prefix)), library)
        self.assertEqual(self.use(os.environ["PYTHONPATH"])[1], state)


if __name__ == "__main__":
    main()
