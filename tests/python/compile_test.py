"""Compiling: scenes, parameters, and errors that say what, where and how to correct it."""

import os
import subprocess
import sys
import unittest

import cogrsim as cg

from support import CART, YARD, Case, main

BROKEN = """<scene name="broken" version="1">
  <box name="crate" size="20 20 20 cm" mas="1 kg"/>
</scene>
"""


class Compile(Case):
    def test_a_list_that_contains_itself(self):
        values = []
        values.append(values)
        with self.assertRaisesRegex(TypeError, "given list"):
            cg.compile_string(YARD, set={"length": values})

    def test_objects_without_their_constructor(self):
        from cogrsim import _cogrsim as compiled

        for name, kind in vars(compiled).items():
            if type(kind) is not type(compiled.Frame):
                continue
            try:
                made = kind.__new__(kind)
            except TypeError as error:
                self.assertIn("made by functions of cogrsim", str(error))
                continue
            for method in dir(kind):
                if method.startswith("_"):
                    continue
                for arguments in ((), (0,), ("a",), ("a", 1), ([], [])):
                    with self.assertRaises((TypeError, RuntimeError), msg=f"{name}.{method}"):
                        getattr(made, method)(*arguments)

    def test_scene_from_a_file(self):
        scene = cg.compile(CART)
        self.assertEqual(scene.name, "cart and pole")
        self.assertIn("cart.base", scene.bodies)
        self.assertEqual(scene.motors, ["cart.push"])
        self.assertEqual(scene.path, str(CART))
        self.assertEqual(scene.dt, 0.002)

    def test_scene_from_a_text(self):
        scene = cg.compile_string(YARD)
        self.assertEqual(scene.body("ball")["position"], (0.0, 0.0, 1.0))
        self.assertEqual(scene.body("ball")["mass"], 1.0)

    def test_parameters(self):
        scene = cg.compile_string(YARD, set={"height": "40 cm"})
        self.assertEqual(scene.body("ball")["position"][2], 0.4)
        self.assertEqual(scene.set, {"height": "40 cm"})
        self.assertEqual(cg.compile_string(YARD, seed=7).seed, 7)

    def test_parameter_with_a_wrong_name_unit_value_or_type(self):
        with self.assertRaises(cg.CompileError) as caught:
            cg.compile_string(YARD, set={"hight": "1 m"})
        self.assertIn("height", str(caught.exception))
        for value in ("3 kg", "7 m", 0.05):
            with self.assertRaises(cg.CompileError) as caught:
                cg.compile_string(YARD, set={"height": value})
            self.assertIn("height", str(caught.exception))
        with self.assertRaises(TypeError) as caught:
            cg.compile_string(YARD, set={"height": object()})
        self.assertIn("height", str(caught.exception))
        with self.assertRaises(TypeError):
            cg.compile_string(YARD, set=[("height", "1 m")])

    def test_error_has_place_code_message_and_remedy(self):
        path = self.write("broken.scene.xml", BROKEN)
        with self.assertRaises(cg.CompileError) as caught:
            cg.compile(path)
        first = caught.exception.diagnostics[0]
        self.assertEqual((first.severity, first.file, first.line), ("error", str(path), 2))
        self.assertGreater(first.column, 0)
        text = str(caught.exception)
        self.assertIn(f"{path}:{first.line}:{first.column}", text)
        self.assertTrue(first.code.startswith("CG"))
        self.assertIn(first.code, text)
        self.assertIn(first.message, text)
        self.assertIn("mass", first.remedy)
        self.assertIn(first.remedy, text)
        self.assertIn(first.code, cg.explain(first.code))
        self.assertIsInstance(caught.exception, cg.Error)

    def test_names_of_files_that_are_no_text(self):
        for path in (b"\xff.scene.xml", os.fsdecode(b"\xff.scene.xml")):
            with self.assertRaisesRegex(cg.CompileError, "\ufffd.scene.xml"):
                cg.compile(path)
        for path in ("cart.scene.xml\0", "\ud800.scene.xml"):
            with self.assertRaises(ValueError):
                cg.compile(path)

    def test_file_that_is_not_there(self):
        with self.assertRaises(cg.CompileError) as caught:
            cg.compile(self.folder / "none.scene.xml")
        self.assertIn("none.scene.xml", str(caught.exception))
        with self.assertRaises(TypeError):
            cg.compile(3)

    def test_check_does_not_raise(self):
        self.assertEqual(cg.check(CART), [])
        found = cg.check(self.write("broken.scene.xml", BROKEN))
        self.assertEqual(found[0].severity, "error")

    def test_warnings_are_on_the_scene(self):
        text = YARD.replace("</scene>", '<box name="inside" size="1 1 1 m" mass="1 kg" xyz="1 0 0.1"/></scene>')
        scene = cg.compile_string(text)
        self.assertTrue(scene.diagnostics)
        self.assertNotIn("error", {one.severity for one in scene.diagnostics})

    def test_unknown_names(self):
        scene = cg.compile_string(YARD)
        with self.assertRaisesRegex(KeyError, "did you mean 'ball'"):
            scene.body("bal")
        with self.assertRaisesRegex(KeyError, "arm.turn"):
            scene.motor("arm.tun")
        with self.assertRaises(KeyError):
            cg.explain("CG9999999")

    def test_import_is_quick_and_loads_no_engine(self):
        code = ("import sys, time; start = time.perf_counter(); import cogrsim; "
                "print('numpy' in sys.modules, 'subprocess' in sys.modules, 'backends' in open('/proc/self/maps').read())")
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        self.assertEqual(done.stdout.split(), ["False", "False", "False"])


if __name__ == "__main__":
    main()
