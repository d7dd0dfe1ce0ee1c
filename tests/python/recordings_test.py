"""Recordings, comparisons, and robots in other formats."""

import importlib.util
import os
import unittest

import numpy as np

import cogrsim as cg

from support import CART, YARD, Case, main

URDF = """<robot name="stick">
  <link name="base"><inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/>
  </inertial><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
  <link name="tip"><inertial><mass value="0.5"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/>
  </inertial></link>
  <joint name="elbow" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 1 0"/>
  <limit lower="-1" upper="1" effort="5" velocity="2"/></joint>
</robot>
"""


class Recordings(Case):
    def record(self):
        path = self.folder / "run.mcap"
        sim = cg.Simulation(cg.compile(self.write("yard.scene.xml", YARD)))
        frames = []
        with sim.record(path):
            sim.observe(lambda frame: frames.append(frame), contacts=True)
            sim.run_until(0.5)
        return path, frames

    def test_frames_are_those_of_the_run(self):
        path, frames = self.record()
        recording = cg.Recording(path)
        self.assertEqual(len(recording), len(frames))
        for i in (0, 100, -1):
            self.assertEqual(recording[i].state_hash, frames[i].state_hash)
        self.assertAlmostEqual(recording.at(0.2).time, 0.2)
        with self.assertRaisesRegex(IndexError, "501"):
            recording[501]
        self.assertEqual(len(list(recording)), 501)
        info = recording.info
        self.assertEqual((info["scene"], info["backend"], info["status"]), ("yard", "cogrsim", "completed"))
        self.assertEqual(info["attachments"]["yard.scene.xml"].decode(), YARD)

    def test_tables(self):
        path, frames = self.record()
        recording = cg.Recording(path)
        bodies = recording.table("bodies")
        ball = bodies[bodies["body"] == "ball"]
        self.assertEqual(len(ball), 501)
        np.testing.assert_array_equal(ball["z"], [frame["ball"].z for frame in frames])
        self.assertEqual(bodies.dtype.names[:4], ("time", "body", "x", "y"))
        joints = recording.table("joints")
        self.assertEqual(set(joints["joint"]), {"arm.elbow"})
        contacts = recording.table("contacts")
        self.assertEqual(len(contacts), sum(len(frame.contacts) for frame in frames))
        ticks = recording.table("arm.ticks")
        self.assertEqual(ticks.dtype.names, ("time", "sequence", "valid", "position", "velocity"))
        self.assertTrue(ticks["valid"].all())
        self.assertEqual(len(recording.table("frames")), 501)
        events = recording.table("events")  # without a row it has its columns all the same
        self.assertEqual((len(events), len(events["time"])), (0, 0))
        self.assertEqual([events.dtype[name].kind for name in ("time", "kind", "source", "subject", "message")],
                         ["f", "U", "U", "U", "U"])
        with self.assertRaisesRegex(KeyError, "did you mean 'bodies'"):
            recording.table("bodie")
        self.assertIn("arm.ticks", recording.tables)

    def test_signal(self):
        path, frames = self.record()
        times, values = cg.Recording(path).signal("ball.z")
        np.testing.assert_array_equal(values, [frame["ball"].z for frame in frames])
        np.testing.assert_array_equal(times, [frame.time for frame in frames])

    def test_no_recording(self):
        with self.assertRaises(cg.Error) as caught:
            cg.Recording(self.folder / "none.mcap")
        self.assertEqual([one.line for one in caught.exception.diagnostics], [0])
        with self.assertRaises(cg.Error):
            cg.Recording(self.write("text.mcap", "no recording"))
        with self.assertRaises(cg.Error):
            cg.Simulation(cg.compile_string(YARD)).record(self.folder / "no" / "such.mcap")


class Comparisons(Case):
    def test_without_what_an_engine_lacks(self):
        scene = self.folder / "hang.scene.xml"
        scene.write_text("""<scene name="hang" version="1"><physics step="1 ms" duration="0.01 s"/>
            <sphere name="bob" radius="5 cm" mass="1 kg" xyz="0.3 0 0"/>
            <ball name="hang" child="bob" upper="30 deg"/>
            <test name="hangs"><expect that="bob.x" equals="0.3 m" tolerance="1 mm"/></test></scene>""")
        with self.assertRaisesRegex(cg.Error, "--without joint.limit.ball"):
            cg.Simulation(scene, backend="bullet")
        left_out = [{"feature": "joint.limit.ball", "of": "joint", "count": 1}]
        sim = cg.Simulation(scene, backend="bullet", without=["lacking"])
        self.assertEqual(sim.provenance["left_out"], left_out)
        again = cg.resume(sim.save_bytes(), scene, without=["limits"])
        self.assertEqual(again.provenance["left_out"], left_out)
        result = cg.compare(scene, backends=["cogrsim", "bullet"], without=["lacking"])
        self.assertEqual([run["provenance"]["left_out"] for run in result.runs], [[], left_out])
        self.assertEqual(cg.test(scene, ["bullet"], without=["lacking"])[0]["status"], "passed")
        self.assertEqual(cg.sweep(scene, backends=["bullet"], without=["lacking"])["status"][0], "completed")
        cg.map(scene, backend="bullet", without=["lacking"])
        with self.assertRaisesRegex(cg.Error, "did you mean 'couplings'"):
            cg.Simulation(scene, without=["coupling"])
        with self.assertRaisesRegex(TypeError, "list of names"):
            cg.compare(scene, without="lacking")

    def test_compare(self):
        result = cg.compare(CART, backends=["bullet", "cogrsim"], duration=0.2)
        self.assertEqual(result.backends, ["bullet", "cogrsim"])
        sim = cg.Simulation(cg.compile(CART), backend="cogrsim")
        self.assertEqual(result.runs[1]["state_hash"], sim.run_until(0.2).state_hash)
        # A scene that was compiled with a seed is compared with that seed.
        seeded = cg.compile(CART, seed=5)
        again = cg.compare(seeded, backends=["bullet", "cogrsim"], duration=0.1)
        self.assertEqual(again.runs[1]["state_hash"],
                         cg.Simulation(seeded, backend="cogrsim").run_until(0.1).state_hash)
        self.assertEqual(cg.sweep(seeded, backends=["cogrsim"], until=0.1)["state_hash"][0],
                         again.runs[1]["state_hash"])
        table = result.table("bodies")
        self.assertEqual(set(table["name"]), {"cart.base", "cart.pole"})
        self.assertTrue((table["position_max"] >= table["position_rms"]).all())
        curve = result.divergence.position["cart.pole", "cogrsim"]
        self.assertEqual(len(curve), len(result.divergence.times))
        with self.assertRaises(KeyError):
            result.table("body")
        picture = result.divergence.plot()
        if importlib.util.find_spec("matplotlib") is None:
            self.assertIn(b"distance to bullet", picture.data)

    def test_seeds(self):
        result = cg.compare(cg.compile(CART, set={"length": "0.5 m"}), backends=["bullet", "cogrsim"],
                            seeds=range(1, 4), duration=0.1)
        self.assertEqual(result.study["seeds"], [1, 2, 3])
        self.assertEqual(result.data["set"], {"length": "0.5 m"})

    def test_errors(self):
        with self.assertRaisesRegex(cg.Error, "bulet"):
            cg.compare(CART, backends=["bulet", "cogrsim"], duration=0.1)
        with self.assertRaisesRegex(ValueError, "scene file"):
            cg.compare(cg.compile_string(YARD))
        with self.assertRaises(TypeError):
            cg.compare(CART, backends="bullet")


class Imports(Case):
    def test_urdf(self):
        model = cg.import_model(self.write("stick.urdf", URDF), drives="velocity", fixed_base=True)
        self.assertEqual(model.format, "URDF")
        self.assertGreater(model.count("exact"), 0)
        self.assertEqual(len(model.report), sum(map(model.count, ("exact", "approximate", "left out"))))
        self.assertIn("joint", " ".join(entry.element for entry in model.report))
        path = self.folder / "stick.scene.xml"
        model.write(path)
        scene = cg.compile(path)
        self.assertTrue(any(name.endswith("elbow") for name in scene.joints))
        cg.Simulation(scene).run_until(0.01)
        model.write(path, overwrite=True)
        with self.assertRaisesRegex(cg.Error, "made from"):
            model.write(self.folder / "stick.urdf", overwrite=True)
        self.assertEqual((self.folder / "stick.urdf").read_text(), URDF)

    def test_a_scene_in_another_folder_finds_its_meshes(self):
        mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
        (self.folder / "source" / "parts").mkdir(parents=True)
        (self.folder / "source" / "parts" / "part.obj").write_text(mesh)
        model = self.folder / "source" / "r.urdf"
        model.write_text('<robot name="r"><link name="l"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/>'
                         '</inertial><collision><geometry><mesh filename="parts/part.obj"/></geometry></collision></link></robot>')
        (self.folder / "elsewhere").mkdir()
        imported = cg.import_model(model)
        for to in (self.folder / "elsewhere" / "r.scene.xml", self.folder / "source" / "r.scene.xml"):
            imported.write(to)
            self.assertEqual(len(cg.Simulation(to, backend="cogrsim").frame.bodies), 2)
        self.assertTrue((self.folder / "elsewhere" / "meshes" / "part.obj").exists())

    def test_nothing_that_was_read_is_replaced(self):
        mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
        self.write("part.obj", mesh)
        self.write("sizes.yaml", "mass: 2\n")
        robot = ('<robot name="r" xmlns:xacro="x"><link name="l"><inertial><mass value="'
                 '${xacro.load_yaml(\'sizes.yaml\')[\'mass\']}"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
                 '<collision><geometry><mesh filename="part.obj"/></geometry></collision></link></robot>')
        model = cg.import_model(self.write("r.urdf", robot))
        scene = cg.compile(self.write("s.scene.xml", '<scene name="s" version="1"><import href="r.urdf"/>'
                                      '<instance of="R"/></scene>'))
        sim = cg.Simulation(scene)
        for name in ("part.obj", "sizes.yaml", "r.urdf"):
            before = (self.folder / name).read_bytes()
            (self.folder / "again").mkdir(exist_ok=True)
            link = self.folder / "again" / ("hard_" + name)
            os.link(self.folder / name, link)
            for path in (self.folder / name, self.folder / "again" / ".." / name, link):
                for use in (lambda to: model.write(to, overwrite=True),
                            lambda to: cg.export_model(scene, 'urdf').write(to, overwrite=True),
                            lambda to: sim.write_snapshot(to, overwrite=True),
                            lambda to: sim.record(to, overwrite=True)):
                    with self.assertRaisesRegex(cg.Error, "made from"):
                        use(path)
            self.assertEqual((self.folder / name).read_bytes(), before)
            self.assertEqual(os.listdir(self.folder / "again").count("meshes"), 0)

    def test_errors(self):
        with self.assertRaises(cg.CompileError) as caught:
            cg.import_model(self.write("bad.urdf", "<robot><link/></robot>"))
        self.assertTrue(caught.exception.diagnostics)
        with self.assertRaisesRegex(ValueError, "drives"):
            cg.import_model(self.folder / "x.urdf", drives="steam")
        with self.assertRaises(KeyError):
            cg.import_model(self.write("stick.urdf", URDF)).count("good")

    def test_keyframe(self):
        path = self.write("pole.xml", """<mujoco><worldbody><body><joint name="hinge" axis="0 1 0"/>
<geom type="box" size="0.1 0.1 0.3"/></body></worldbody>
<keyframe><key name="up" qpos="0"/><key name="tilted" qpos="0.25"/></keyframe></mujoco>""")
        for keyframe, start in (("", 0.0), ("tilted", 0.25)):
            model = cg.import_model(path, keyframe=keyframe, floor=False)
            frame = cg.Simulation(cg.compile_string(model.scene)).frame
            self.assertAlmostEqual(frame.joint_position[0], start, places=12)
        with self.assertRaisesRegex(cg.CompileError, "upright"):
            cg.import_model(path, keyframe="upright")


class Exports(Case):
    def test_round_trip(self):
        scene = cg.compile(CART)
        for format, name in (("urdf", "cart.urdf"), ("sdf", "cart.sdf"), ("mjcf", "cart.xml")):
            model = cg.export_model(scene, format)
            self.assertEqual(len(model.report), sum(map(model.count, ("exact", "approximate", "left out"))))
            self.assertIn("<td>", model._repr_html_())
            model.write(self.folder / name)
            back = cg.compile_string(cg.import_model(self.folder / name, floor=False).scene)
            self.assertEqual(sum(1 for j in back.joints), sum(1 for j in scene.joints), format)
            with self.assertRaises(cg.Error):
                model.write(self.folder / name)

    def test_errors(self):
        with self.assertRaisesRegex(ValueError, "'urdf', 'sdf', 'mjcf', given 'stl'"):
            cg.export_model(CART, "stl")
        path = self.write("own.scene.xml", YARD)
        with self.assertRaisesRegex(cg.Error, "made from"):
            cg.export_model(path, "sdf").write(path, overwrite=True)
        self.assertEqual(path.read_text(), YARD)
        with self.assertRaisesRegex(cg.Error, "cartt"):
            cg.export_model(CART, "urdf", assembly="cartt")


if __name__ == "__main__":
    main()
