"""The program's commands as functions, and what a notebook shows."""

import struct
import unittest
import zlib

import cogrsim as cg

from support import ROBOT, YARD, Case, main


class Tools(Case):
    def record(self):
        sim = cg.Simulation(cg.compile_string(YARD), backend="cogrsim")
        path = self.folder / "run.mcap"
        with sim.record(path, every=0.01):
            sim.run_until(0.3)
        return path

    def page(self, source):
        try:
            return cg.bundle(source)
        except cg.Error as error:
            if "the studio is not installed" not in str(error):
                raise
            self.skipTest("the program has no studio")

    def test_scene_tests(self):
        cases = cg.test(ROBOT, ["cogrsim"])
        self.assertEqual([case["status"] for case in cases], ["passed"])
        self.assertEqual(cases[0]["backends"], ["cogrsim"])
        with self.assertRaisesRegex(cg.Error, "no such test"):
            cg.test(ROBOT, ["cogrsim"], filter="no such test")
        with self.assertRaises(TypeError):
            cg.test(ROBOT, "cogrsim")
        missing = cg.test(self.folder / "missing.scene.xml")
        self.assertEqual(missing[0]["status"], "error")
        self.assertIn("CG0101", missing[0]["message"])

    def test_sweep(self):
        scene = self.write("yard.scene.xml", YARD)
        table = cg.sweep(scene, {"height": ["0.5 m", "0.8 m"]}, backends=["cogrsim"], until=0.2,
                         measure={"z": "ball.z@last"}, jobs=1)
        self.assertEqual(len(table), 2)
        # A free fall from each height; the step's error is below g t dt.
        fall = 0.5 * 9.81 * 0.2**2
        for z, height in zip(sorted(table["z"]), (0.5, 0.8)):
            self.assertAlmostEqual(z, height - fall, delta=9.81 * 0.2 * 0.001)
        with self.assertRaisesRegex(cg.Error, "hight"):
            cg.sweep(scene, {"hight": "1 m"}, until=0.1)

    def test_map_and_plot(self):
        path = self.record()
        drawing = cg.map(path, at=0.1)
        self.assertTrue(drawing.data.lstrip().startswith(b"<"))
        self.assertIn("image/svg+xml", drawing._repr_mimebundle_())
        drawing.save(self.folder / "map.svg")
        with self.assertRaises(FileExistsError):
            drawing.save(self.folder / "map.svg")
        figure = cg.plot(cg.Recording(path), "ball.z", title="fall")
        self.assertIn(b"fall", figure.data)
        with self.assertRaisesRegex(cg.Error, "bal"):
            cg.plot(path, "bal.z")

    def test_figure_of_arrays(self):
        picture = cg.figure({"up": ([0, 1, 2], [1.0, float("nan"), 3.0])}, x="update", y="height [m]", title="Learning")
        for text in (b"update", b"height [m]", b"Learning"):
            self.assertIn(text, picture.data)
        path = self.folder / "up.png"
        cg.figure({"up": (range(3), range(3))}, format="png").save(path)
        self.assertEqual(path.read_bytes()[:4], b"\x89PNG")
        with self.assertRaises(FileExistsError):
            picture.save(path)
        picture.save(path, overwrite=True)
        self.assertEqual(path.read_bytes(), picture.data)
        for series, text in ((None, "dict"), ({"up": 1}, "two arrays"), ({"up": (["a"], ["b"])}, "numbers"),
                             ({"up": ([1], [1, 2])}, r"\(1,\), \(2,\)"), ({1: ([1], [2])}, "texts")):
            with self.assertRaisesRegex((TypeError, ValueError), text):
                cg.figure(series)

    def test_page(self):
        page = self.page(self.record())
        self.assertIn("<html", page.html[:2000])
        shown = page._repr_html_()
        self.assertTrue(shown.startswith("<iframe srcdoc="))
        self.assertNotIn("<script", shown)  # all of it is escaped inside the attribute

    def test_a_frame_shows_itself(self):
        sim = cg.Simulation(cg.compile_string(YARD), backend="cogrsim")
        png = sim.frame._repr_png_()
        if png is None:
            self.skipTest("no renderer")
        self.assertEqual(png[:8], b"\x89PNG\r\n\x1a\n")
        self.assertEqual(struct.unpack(">2I", png[16:24]), (640, 400))
        start = png.index(b"IDAT") + 4
        size = struct.unpack(">I", png[start - 8:start - 4])[0]
        rows = zlib.decompress(png[start:start + size])
        self.assertEqual(len(rows), 400 * (1 + 3 * 640))
        self.assertGreater(len(set(rows)), 10)
        self.assertEqual(sim._repr_png_(), png)


    def test_wrong_arguments(self):
        scene = self.write("yard.scene.xml", YARD)
        run = self.record()
        for expected, call in (
                ("scenes: expected a list", lambda: cg.test(3)),
                ("timeout: expected a time", lambda: cg.test(scene, timeout="1 s")),
                ("filter: expected a text", lambda: cg.test(scene, filter=3)),
                ("set: expected a dict of parameters", lambda: cg.test(scene, set="height")),
                ("plugin_path: expected a list of folders", lambda: cg.test(scene, plugin_path="folder")),
                ("seeds: expected a whole number", lambda: cg.test(scene, seeds=[1.5])),
                ("seeds: expected a list of whole numbers", lambda: cg.test(scene, seeds=3)),
                ("vary: expected a dict of values", lambda: cg.sweep(scene, ["height"])),
                (r"vary\['height'\]: expected a list", lambda: cg.sweep(scene, {"height": 1})),
                ("measure: expected a dict", lambda: cg.sweep(scene, measure="ball.z")),
                ("jobs: expected a whole number", lambda: cg.sweep(scene, jobs=1.5)),
                ("until: expected a time", lambda: cg.sweep(scene, until=[1])),
                ("output: expected a path", lambda: cg.sweep(scene, output=3)),
                ("backends: expected a list of names", lambda: cg.sweep(scene, backends=[1])),
                ("y: expected a list of signals", lambda: cg.plot(run, 3)),
                ("title: expected a text", lambda: cg.plot(run, "ball.z", title=3)),
                ("source: expected a scene or a recording", lambda: cg.map(None)),
                ("area: expected a list of numbers", lambda: cg.map(run, area="0,0,1,1")),
                ("width: expected a whole number", lambda: cg.map(run, width="wide")),
                ("height: expected a whole number", lambda: cg.bundle(run, height="tall")),
                ("threshold: expected a text", lambda: cg.compare(scene, threshold=0.005)),
                ("shake: expected a length", lambda: cg.compare(scene, shake="1 mm")),
                ("seed: expected a whole number", lambda: cg.compare(scene, seed="x")),
                ("data: expected bytes", lambda: cg.Picture("svg", "<svg/>")),
                ("html: expected a text", lambda: cg.Page(3))):
            with self.subTest(expected), self.assertRaisesRegex(TypeError, expected):
                call()
        for expected, call in (
                ("scenes: expected at least one", lambda: cg.test([])),
                ("timeout: .*finite", lambda: cg.test(scene, timeout=float("nan"))),
                ("format: expected one of 'svg', 'png'", lambda: cg.plot(run, "ball.z", format="pdf")),
                ("format: expected one of 'svg', 'png'", lambda: cg.map(run, format="gif")),
                ("source: expected at least one", lambda: cg.plot([])),
                ("area: .*finite", lambda: cg.map(run, area=(0, 0, 1, float("inf")))),
                ("set: only a scene takes it", lambda: cg.map(run, set={"height": 1})),
                ("backend: only a scene takes it", lambda: cg.bundle(run, backend="bullet")),
                ("kind: expected one of", lambda: cg.Picture("gif", b""))):
            with self.subTest(expected), self.assertRaisesRegex(ValueError, expected):
                call()

    def test_names_are_no_options(self):
        self.assertEqual(cg.test("-o")[0]["status"], "error")

    def test_a_comparison_shows_itself(self):
        scene = self.write("yard.scene.xml", YARD.replace('"yard"', '"&lt;b&gt;"'))
        shown = cg.compare(scene, ["cogrsim", "bullet"], duration=0.1)._repr_html_()
        self.assertIn("<td>cogrsim</td><td>completed</td><td>0.1 s</td><td>reference</td>", shown)
        self.assertIn("<td>bullet</td><td>completed</td><td>0.1 s</td><td>never</td>", shown)
        self.assertIn("&lt;b&gt;", shown)
        self.assertNotIn("<b>", shown)
        # The ball is 0.9 m above the floor: it falls by g t^2 / 2, and engines differ by g t dt.
        over = cg.compare(scene, ["cogrsim", "bullet"], duration=0.1, threshold="0.01 mm")
        self.assertIn(f"<td>{over.first_over:.4g} s</td>", over._repr_html_())

    def test_an_imported_model_shows_its_report(self):
        path = self.write("robot.urdf", '<robot name="r"><link name="a&lt;i&gt;"/><script/></robot>')
        shown = cg.import_model(path)._repr_html_()
        self.assertIn("&lt;script&gt;", shown)
        self.assertIn("left out", shown)
        self.assertNotIn("<script", shown)
        self.assertNotIn("<i>", shown)

    def test_a_recording_without_its_file_shows_its_text(self):
        recording = cg.Recording(self.record())
        self.page(recording)
        self.assertTrue(recording._repr_html_().startswith("<iframe"))
        (self.folder / "run.mcap").unlink()
        self.assertIsNone(recording._repr_html_())


if __name__ == "__main__":
    main()
