"""The stubs name what the module has, and every public object has a docstring."""

import ast
import inspect
import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

import cogrsim as cg

from support import EXAMPLES, ROOT, Case, main

STUBS = ast.parse((pathlib.Path(cg.__file__).parent / "__init__.pyi").read_text(encoding="utf-8"))
CLASSES = {node.name: node for node in STUBS.body if isinstance(node, ast.ClassDef)}
FUNCTIONS = {node.name: node for node in STUBS.body if isinstance(node, ast.FunctionDef)}


def members(node):
    """The public members of a class in the stubs, with those of its bases there."""
    out = {}
    for base in node.bases:
        if isinstance(base, ast.Name) and base.id in CLASSES:
            out.update(members(CLASSES[base.id]))
    for child in node.body:
        if isinstance(child, ast.FunctionDef):
            out[child.name] = child
        elif isinstance(child, ast.AnnAssign):
            out[child.target.id] = child
    return {name: child for name, child in out.items() if not name.startswith("_")}


def arguments(function):
    names = [a.arg for a in function.args.args + function.args.kwonlyargs]
    return [name for name in names if name != "self"]


def runtime_arguments(function):
    """Names of the arguments; pybind11 writes them into the first line of the docstring."""
    try:
        return [n for n in inspect.signature(function).parameters if n != "self"]
    except (TypeError, ValueError):
        first = function.__doc__.splitlines()[0]
        inside = first[first.index("(") + 1:first.rindex(") ->")]
        return [name for name in re.findall(r"(?:^|, )(\w+): ", inside) if name != "self"]


class Stubs(Case):
    def test_names(self):
        public = {name for name in cg.__all__ if not inspect.ismodule(getattr(cg, name))}
        stubbed = {name for name in {**CLASSES, **FUNCTIONS} if not name.startswith("_")}
        self.assertEqual(public, stubbed)

    def test_members(self):
        for name, node in CLASSES.items():
            if name.startswith("_"):
                continue
            cls = getattr(cg, name)
            with self.subTest(name):
                given = {key for key in dir(cls) if not key.startswith("_")}
                stubbed = set(members(node))
                assigned = {key for key, child in members(node).items() if isinstance(child, ast.AnnAssign)}
                if issubclass(cls, BaseException):
                    given -= set(dir(BaseException))
                self.assertEqual(given - stubbed, set())
                self.assertEqual(stubbed - given - assigned, set())

    def test_arguments(self):
        for name, node in FUNCTIONS.items():
            self.assertEqual(runtime_arguments(getattr(cg, name)), arguments(node), name)
        for name, node in CLASSES.items():
            if name.startswith("_"):
                continue
            for key, child in members(node).items():
                plain = isinstance(child, ast.FunctionDef) and not child.decorator_list
                if not plain or child.args.kwarg:
                    continue
                with self.subTest(f"{name}.{key}"):
                    self.assertEqual(runtime_arguments(getattr(getattr(cg, name), key)), arguments(child))

    def test_docstrings(self):
        for name in {**CLASSES, **FUNCTIONS}:
            if not name.startswith("_"):
                self.assertTrue(getattr(cg, name).__doc__, name)
        for name in CLASSES:
            if name.startswith("_"):
                continue
            for key, member in vars(getattr(cg, name)).items():
                if key.startswith("_") or not (callable(member) or isinstance(member, property)):
                    continue
                text = member.__doc__ or ""
                # pybind11 writes the signature of a function first.
                self.assertTrue(text.split("\n", 1)[-1].strip() if text.startswith(key + "(") else text, f"{name}.{key}")

    def test_everything_shows_itself(self):
        derived = {"Controller", "Supervisor", "Sensor"}  # shown with the name of the user's class
        for name in set(CLASSES) - derived:
            if not name.startswith("_"):
                own = [cls for cls in getattr(cg, name).__mro__ if cls is not object and "__repr__" in vars(cls)]
                self.assertTrue(own and own[0].__module__ != "pybind11_builtins", name)

    def test_typed_example(self):
        mypy = shutil.which("mypy")
        if mypy is None:
            self.skipTest("mypy is not installed")
        subprocess.run([mypy, "--strict", str(ROOT / "examples" / "080_python")], check=True,
                       env={**os.environ, "MYPYPATH": os.environ["PYTHONPATH"]}, cwd=self.folder)


if __name__ == "__main__":
    main()
