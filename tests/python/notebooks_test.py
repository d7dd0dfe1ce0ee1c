"""The notebooks of docs/notebooks run as they stand, show what is stored in them, and are typed.

`notebooks_test.py --store` runs them and stores what they show.
"""

import ast
import base64
import contextlib
import io
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from support import ROOT, Case, main

BOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
os.environ["MPLBACKEND"] = "Agg"  # if matplotlib is there


def cells(book, kind):
    data = json.loads(book.read_text(encoding="utf-8"))
    assert data["nbformat"] == 4
    return ["".join(cell["source"]) for cell in data["cells"] if cell["cell_type"] == kind]


def shown(value):
    """What a notebook shows of the last line of a cell: data by their type."""
    bundle = dict(value._repr_mimebundle_()) if hasattr(value, "_repr_mimebundle_") else {}
    for method, kind in (("_repr_html_", "text/html"), ("_repr_svg_", "image/svg+xml"), ("_repr_png_", "image/png")):
        data = getattr(value, method)() if hasattr(value, method) else None
        if data is not None:
            bundle[kind] = data
    return {**{kind: base64.b64encode(data).decode() if isinstance(data, bytes) else data
               for kind, data in bundle.items()}, "text/plain": repr(value)}


def lines(text):
    return text.splitlines(keepends=True)


def run_cell(source, name, names):
    """Runs a cell; what it shows, as a notebook stores it."""
    code = ast.parse(source)
    last = code.body.pop() if isinstance(code.body[-1], ast.Expr) else None
    value = None
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        exec(compile(code, name, "exec"), names)
        if last is not None:
            value = eval(compile(ast.Expression(last.value), name, "eval"), names)
    outputs = []
    if printed.getvalue():
        outputs.append({"name": "stdout", "output_type": "stream", "text": lines(printed.getvalue())})
    if value is not None:
        data = {kind: text if kind == "image/png" else lines(text) for kind, text in shown(value).items()}
        outputs.append({"data": data, "execution_count": None, "metadata": {}, "output_type": "execute_result"})
    return outputs


def compared(outputs):
    """What is the same on each machine: texts, and of images the kinds."""
    def of(data):
        return sorted(data) if any(kind.startswith("image/") for kind in data) else data
    return [output["text"] if "text" in output else of(output["data"]) for output in outputs]


def store():
    for book in BOOKS:
        data = json.loads(book.read_text(encoding="utf-8"))
        names = {"__name__": "__main__"}
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            for cell in data["cells"]:
                if cell["cell_type"] == "code":
                    cell["outputs"] = run_cell("".join(cell["source"]), book.name, names)
        book.write_text(json.dumps(data, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        print("stored", book)


class Notebooks(Case):
    def test_there_are_all(self):
        index = (ROOT / "docs" / "notebooks" / "README.md").read_text(encoding="utf-8")
        self.assertEqual(re.findall(r"\((\d-[\w-]+\.ipynb)\)", index), [book.name for book in BOOKS])
        self.assertEqual(len(BOOKS), 4)

    def test_nothing_large_is_stored(self):
        for book in BOOKS:
            stored = [cell.get("outputs", []) for cell in json.loads(book.read_text(encoding="utf-8"))["cells"]]
            for outputs in stored:
                self.assertLess(len(json.dumps(outputs)), 150_000, book.name)

    def test_links_exist(self):
        for book in BOOKS:
            for link in re.findall(r"\]\(([^):]+)\)", "\n".join(cells(book, "markdown"))):
                self.assertTrue((book.parent / link).exists(), f"{book.name}: {link}")

    def run_book(self, number):
        book = BOOKS[number - 1]
        before = os.getcwd()
        os.chdir(self.folder)
        self.addCleanup(os.chdir, before)
        names = {"__name__": "__main__"}
        out = []
        for cell in json.loads(book.read_text(encoding="utf-8"))["cells"]:
            if cell["cell_type"] != "code":
                continue
            outputs = run_cell("".join(cell["source"]), book.name, names)
            # What depends on installed libraries such as PyTorch is tagged.
            if cell["outputs"] and "varies" not in cell["metadata"].get("tags", []):
                self.assertEqual(compared(outputs), compared(cell["outputs"]), "".join(cell["source"]))
            out += [output["data"] for output in outputs if "data" in output]
        return names, out

    def test_1_first_steps(self):
        names, out = self.run_book(1)
        # 1.5 m of fall onto the crate's top at 0.4 m, and up again with a quarter of the energy; the ball's
        # centre is 0.1 m above, and the peak is seen at the next of the frames, which are 10 ms apart.
        self.assertAlmostEqual(names["heights"][names["times"] > 0.6].max(), 0.5 + 0.25, delta=0.01)
        self.assertIn("image/svg+xml", out[-1])

    def test_2_compare_engines(self):
        names, out = self.run_book(2)
        self.assertIn("<td>bullet</td><td>completed</td>", "".join("".join(part.get("text/html", "")) for part in out))
        self.assertLess(names["largest"](names["result"], "swing.lower", "cogrsim"), 1e-6)

    def test_3_learn_to_balance(self):
        names, _ = self.run_book(3)
        self.assertGreater(names["curve"][-1], 2 * names["curve"][0])

    def test_4_fit_friction(self):
        names, _ = self.run_book(4)
        self.assertEqual(set(names["results"]), {"bullet", "ode", "cogrsim"})

    def test_types(self):
        mypy = shutil.which("mypy")
        if mypy is None:
            self.skipTest("mypy is not installed")
        for book in BOOKS:
            path = self.folder / (book.stem.replace("-", "_") + "_book.py")
            # A line that only shows its value is no statement of a program.
            path.write_text("\n\n".join(cells(book, "code")), encoding="utf-8")
            with self.subTest(book.name):
                done = subprocess.run([mypy, "--strict", "--ignore-missing-imports", str(path)], cwd=self.folder,
                                      env={**os.environ, "MYPYPATH": os.environ["PYTHONPATH"]}, check=False,
                                      capture_output=True, text=True)
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    if sys.argv[1:] == ["--store"]:
        store()
    else:
        main()
