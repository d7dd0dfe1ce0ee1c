"""Builds the Python module with CMake, for pip: it, its libraries, engines and plugins in one folder.

COGRSIM_BUILD_DIR names a configured build folder to use instead of one of its own.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py

HERE = pathlib.Path(__file__).resolve().parent
GIVEN = os.environ.get("COGRSIM_BUILD_DIR")
# setuptools would write into build/, which is CMake's.
BASE = pathlib.Path(GIVEN, "python-package").resolve() if GIVEN else HERE / "build-python"
BUILD = pathlib.Path(GIVEN).resolve() if GIVEN else BASE / sys.implementation.cache_tag


def run(*command):
    try:
        subprocess.run(command, check=True)
    except FileNotFoundError:
        sys.exit(f"error: {command[0]} is needed to build cogrsim and is not installed")
    except subprocess.CalledProcessError as error:
        sys.exit(f"error: {' '.join(command)}: exit status {error.returncode}")


class Build(build_py):
    def run(self):
        if getattr(self, "editable_mode", False):
            sys.exit("error: cogrsim cannot be installed as editable; build it with CMake and name its folder "
                     "lib/python3/dist-packages in PYTHONPATH")
        if not GIVEN:
            run("cmake", "-S", str(HERE), "-B", str(BUILD), "-DCMAKE_BUILD_TYPE=Release",
                "-DCMAKE_UNITY_BUILD=ON", "-DCMAKE_CXX_FLAGS_RELEASE=-O2", "-DCOGRSIM_BUILD_TESTS=OFF",
                "-DCOGRSIM_PARTS=dsl;backends;renderers;plugins;python", f"-DPython_EXECUTABLE={sys.executable}",
                *(["-GNinja"] if shutil.which("ninja") else []))
        run("cmake", "--build", str(BUILD), "--target", "cogrsim_python_package", "--parallel",
            os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL", str(os.cpu_count() or 1)))
        # Files of an earlier build must not remain.
        package = pathlib.Path(self.build_lib, "cogrsim")
        shutil.rmtree(package, ignore_errors=True)
        super().run()
        name = "_cogrsim" + sysconfig.get_config_var("EXT_SUFFIX")
        module = BUILD / "lib/python3/dist-packages/cogrsim" / name
        if not module.exists():
            sys.exit(f"error: {module} is missing: the build folder is for another Python than {sys.executable}, or "
                     "Python's headers, pybind11 or numpy were not found")
        shutil.copy(module, package)
        libraries = package / "lib"
        for path in [*BUILD.glob("lib/libcogrsim.so.[0-9]"), *BUILD.glob("lib/libcogrsim_dsl.so.[0-9]"),
                     BUILD / "lib/cogrsim/cogrsim_controller_host", *BUILD.glob("lib/cogrsim/backends/*.so"),
                     *BUILD.glob("lib/cogrsim/plugins/*.so")]:
            to = libraries / path.relative_to(BUILD / "lib")
            to.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, to)
        shutil.copy(BUILD / "third-party-notices.txt", package)


class Binary(Distribution):
    """Of one platform and one version of Python."""

    def has_ext_modules(self):
        return True


BASE.mkdir(parents=True, exist_ok=True)
setup(version=re.search(r"project\(CogRSim VERSION ([0-9.]+)", (HERE / "CMakeLists.txt").read_text())[1],
      packages=["cogrsim"], package_dir={"cogrsim": "python/cogrsim"},
      package_data={"cogrsim": ["*.pyi", "py.typed"]}, cmdclass={"build_py": Build}, distclass=Binary,
      options={"build": {"build_base": str(BASE)}, "egg_info": {"egg_base": str(BASE)},
               "bdist_wheel": {"bdist_dir": str(BASE / "wheel")}})
