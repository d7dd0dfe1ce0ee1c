"""The installed module works as that of the build tree, with its own libraries and plugins."""

import importlib.util
import os
import pathlib
import subprocess
import sys
import unittest

from support import CART, ENGINES, ROOT, SANITIZED, Case, main

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


@unittest.skipIf(SANITIZED, "a wheel has no sanitizer")
class Wheel(Case):
    def call(self, *command, **environment):
        env = {key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "COGRSIM_PROGRAM")}
        done = subprocess.run([str(part) for part in command], env={**env, **environment}, cwd=self.folder,
                              capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_pip_installs_into_a_virtual_environment(self):
        missing = [name for name in ("pip", "setuptools", "venv", "wheel") if importlib.util.find_spec(name) is None]
        if missing:
            self.skipTest("not installed: " + ", ".join(missing))
        offline = ["--no-index", "--no-deps", "--no-cache-dir", "--disable-pip-version-check"]
        self.call(sys.executable, "-m", "pip", "wheel", *offline, "--no-build-isolation", "-w", self.folder, ROOT,
                  COGRSIM_BUILD_DIR=os.environ["COGRSIM_BUILD"])
        wheels = list(self.folder.glob("cogrsim-*.whl"))
        self.assertEqual(len(wheels), 1)
        self.assertNotIn("none-any", wheels[0].name)
        self.call(sys.executable, "-m", "venv", "--system-site-packages", "--without-pip", "venv")
        python = self.folder / "venv" / "bin" / "python"
        self.call(python, "-m", "pip", "install", *offline, wheels[0])
        for engine in ENGINES:
            file, state, library = self.call(python, "-c", USE, CART, engine).split()
            for path in (file, library):
                self.assertTrue(path.startswith(str(self.folder / "venv")), path)
            expected = self.call(sys.executable, "-c", USE, CART, engine, PYTHONPATH=os.environ["PYTHONPATH"])
            self.assertEqual(state, expected.split()[1])


if __name__ == "__main__":
    main()
