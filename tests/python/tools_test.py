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

    def test_page(self):
        page = cg.bundle(self.record())
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


if __name__ == "__main__":
    main()
