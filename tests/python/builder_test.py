"""SceneBuilder: scenes written in Python are those of the XML."""

import inspect
import unittest

import numpy as np

import cogrsim as cg

from support import YARD, Case, main


def yard():
    scene = cg.SceneBuilder("yard")
    scene.param(name="height", type="length", default="1 m", min="10 cm", max="5 m")
    scene.physics(backend="cogrsim", step="1 ms", duration=1.0)
    scene.plane("ground")
    scene.sphere("ball", radius="10 cm", mass=1, xyz="0 0 ${height}")
    scene.box("crate", size=np.array([0.2, 0.2, 0.2]), mass="2 kg", xyz=(1, 0, 0.1))
    with scene.assembly("arm", xyz=[0, 2, 1]) as arm:
        link = arm.box("link", size="5 5 40 cm", mass="1 kg")
        elbow = arm.hinge("elbow", child=link, axis=(0, 1, 0), frame=arm)
        arm.motor("turn", joint=elbow, mode="velocity", max_torque="5 N*m", max_speed="3 rad/s")
        arm.encoder("ticks", joint=elbow)
    scene.template("pebble").sphere("stone", radius="2 cm", mass="10 g")
    return scene


class Builder(Case):
    def test_it_is_the_scene_of_the_xml(self):
        built = cg.Simulation(yard().compile(), backend="cogrsim")
        written = cg.Simulation(cg.compile_string(YARD), backend="cogrsim")
        for sim in (built, written):
            sim.set_motor("arm.turn", 2.0)
            sim.run_until(0.5)
        self.assertEqual(built.state_hash, written.state_hash)

    def test_parameters_and_saving(self):
        self.assertEqual(yard().compile(set={"height": "2 m"}).body("ball")["position"][2], 2.0)
        path = self.folder / "yard.scene.xml"
        yard().save(path)
        self.assertEqual(cg.compile(path).bodies, yard().compile().bodies)
        with self.assertRaises(FileExistsError):
            yard().save(path)

    def test_elements_stand_for_their_names(self):
        scene = cg.SceneBuilder("names")
        with scene.assembly("outer") as outer, outer.assembly("inner") as inner:
            tip = inner.box("tip", size="1 1 1 cm")
            base = outer.box("base", size="1 1 1 cm")
            self.assertEqual(tip.path, "outer.inner.tip")
            self.assertIn('parent="base"', repr(outer.hinge("a", parent=base, child=tip)))
            self.assertIn('child="inner.tip"', repr(outer.hinge("b", parent=base, child=tip)))
        self.assertIn('between="outer.base outer.inner.tip"', repr(scene.collide(between=[base, tip], with_=False)))

    def test_words_of_python(self):
        scene = cg.SceneBuilder("loop")
        with scene.for_(var="i", in_="[0, 1, 2]") as loop:
            loop.box("crate_${i}", size="1 1 1 cm", xyz="${i} 0 0")
        self.assertEqual(len(scene.compile().bodies), 3)

    def test_wrong_names_and_values(self):
        scene = cg.SceneBuilder("wrong")
        with self.assertRaisesRegex(AttributeError, "did you mean 'sphere'"):
            scene.shpere("ball")
        with self.assertRaisesRegex(TypeError, "did you mean 'radius'"):
            scene.sphere("ball", raduis=1)
        with self.assertRaisesRegex(TypeError, "found dict"):
            scene.sphere("ball", radius={})
        with self.assertRaisesRegex(TypeError, "keyword"):
            scene.sphere("ball", "10 cm")
        with self.assertRaisesRegex(AttributeError, "may not stand here"):
            scene.sphere("ball", radius=1).hinge("axle")
        for value in (float("nan"), [1, 2, float("inf")], np.array([1, np.nan, 1])):
            with self.assertRaisesRegex(ValueError, "'size' of <box>: expected finite numbers"):
                scene.box("crate", size=value)
        for value in (b"1", {1, 2, 3}, np.array([1j, 1, 1]), np.array([None, 1, 1]), object()):
            with self.assertRaisesRegex(TypeError, "'size' of <box>: expected a text, a number"):
                scene.box("crate", size=value)
        with self.assertRaisesRegex(TypeError, "two names, 'a' and 'b'"):
            scene.sphere("a", name="b", radius=1)
        with self.assertRaisesRegex(TypeError, "'radius' twice"):
            scene.sphere("a", radius=1, radius_=2)
        for name in (["a"], 3, None):
            with self.assertRaisesRegex(TypeError, "expected a name"):
                scene.sphere(name, radius=1)
            with self.assertRaisesRegex(TypeError, "name: expected a text"):
                cg.SceneBuilder(name)
        with self.assertRaises(ValueError):
            scene.sphere("half of a pair: \ud800", radius=1)
        with self.assertRaisesRegex(ValueError, "has no name"):
            scene.hinge("axle", child=scene.physics(step=0.001))
        other = cg.SceneBuilder("other").sphere("ball", radius=1)
        with self.assertRaisesRegex(ValueError, "of another scene, 'other'"):
            scene.hinge("axle", child=other)
        # The partly wrong elements were not added.
        self.assertEqual(scene.xml.count("<sphere"), 1)
        self.assertNotIn("<box", scene.xml)
        with self.assertRaises(TypeError):
            scene.save(1)  # no number of an open file
        with self.assertRaises(TypeError):
            scene.compile(plugin_path="folder")

    def test_two_elements_of_one_name(self):
        scene = cg.SceneBuilder("contacts")
        scene.material("ice")
        scene.plane("floor", material="ice")
        scene.box("crate", size="1 1 1 m", material="ice", xyz="0 0 0.5")
        self.assertIn("friction", repr(scene.contact(between="ice ice", friction=0.1)))
        scene.contact("bumper", on="crate")
        self.assertEqual(scene.compile().sensors, ["bumper"])

    def test_a_diagnostic_names_the_line_of_python(self):
        scene = cg.SceneBuilder("faulty")
        scene.plane("floor")
        line = inspect.currentframe().f_lineno + 1
        scene.sphere("ball", radius="3 kg")
        with self.assertRaises(cg.CompileError) as caught:
            scene.compile()
        self.assertIn(f"{__file__}:{line}", str(caught.exception))
        self.assertEqual(caught.exception.diagnostics[0].line, 3)

    def test_text_is_escaped(self):
        scene = cg.SceneBuilder('a "b" <c> & d')
        scene.plane("floor")
        self.assertEqual(scene.compile().name, 'a "b" <c> & d')


if __name__ == "__main__":
    main()
