"""Frames: read-only views without a copy that keep the frame alive."""

import gc
import resource
import unittest

import numpy as np

import cogrsim as cg

from support import EXAMPLES, SANITIZED, YARD, Case, main


def frame_at(time):
    return cg.Simulation(cg.compile_string(YARD)).run_until(time)


class Arrays(Case):
    NAMES = {"position": 3, "orientation": 4, "orientation_xyzw": 4, "velocity": 3, "angular_velocity": 3}

    def test_shapes_and_no_copy(self):
        frame = frame_at(0.5)
        n = len(frame.bodies)
        for name, width in self.NAMES.items():
            array = getattr(frame, name)
            self.assertEqual((array.shape, array.dtype), ((n, width), np.float64), name)
            if name != "orientation":
                self.assertTrue(np.shares_memory(array, getattr(frame, name)), name)
        self.assertTrue(np.shares_memory(frame.position, frame["ball"].position))
        self.assertTrue(np.shares_memory(frame.contacts, frame.contacts))
        np.testing.assert_array_equal(frame.orientation, frame.orientation_xyzw[:, [3, 0, 1, 2]])
        self.assertEqual(frame.joint_position.shape, frame.joint_velocity.shape)

    def test_read_only(self):
        frame = frame_at(0.5)
        arrays = [getattr(frame, name) for name in self.NAMES]
        arrays += [frame.contacts, frame.joint_position, frame.motor_effort, frame["ball"].position,
                   frame.sensors["arm.ticks"].values]
        for array in arrays:
            self.assertFalse(array.flags.writeable)
            with self.assertRaises(ValueError):
                array[...] = 0
            with self.assertRaises(ValueError):
                array.flags.writeable = True

    def test_a_view_keeps_the_frame_and_is_never_stale(self):
        sim = cg.Simulation(cg.compile_string(YARD))
        frame = sim.run_until(0.2)
        view, before = frame.position, frame.position.copy()
        del frame
        gc.collect()
        sim.run_until(0.4)
        np.testing.assert_array_equal(view, before)
        del sim
        gc.collect()
        np.testing.assert_array_equal(view, before)
        self.assertFalse((frame_at(0.4).position == before).all())

    @unittest.skipIf(SANITIZED, "a sanitizer holds freed memory")
    def test_many_frames_do_not_grow(self):
        sim = cg.Simulation(cg.compile_string(YARD))

        def use(count):
            for _ in range(count):
                frame = sim.frame
                frame.position, frame.orientation, frame.contacts, frame["ball"].speed, frame.sensors
            return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss  # [KiB]

        first = use(20000)
        self.assertLess(use(100000) - first, 4096)
        first = use(1000)
        sim.step(1)
        for _ in range(20000):
            sim.step().position
        self.assertLess(use(1) - first, 4096)

    def test_contacts(self):
        frame = frame_at(0.9)
        contacts = frame.contacts
        self.assertGreater(len(contacts), 0)
        names = frame.bodies
        pairs = {(names[c["body_a"]], names[c["body_b"]]) for c in contacts}
        self.assertIn(("ground", "crate"), pairs)
        crate = contacts[[names[b] == "crate" for b in contacts["body_b"]]]
        self.assertAlmostEqual(crate["force"][:, 2].sum(), 2 * 9.81, delta=0.5)
        np.testing.assert_allclose(np.linalg.norm(contacts["normal"], axis=1), 1.0)


    def test_contents_that_nobody_asked_for(self):
        # An empty array would look like "no contact".
        frames, full = [], []
        sim = cg.Simulation(cg.compile_string(YARD))
        contacts = sim.signal("contacts(ground, crate)")
        sim.observe(frames.append)
        sim.run_until(0.01)
        frame = frames[-1]
        for use in (lambda: frame.contacts, lambda: frame.value("contacts(ground, crate)"), lambda: contacts(frame)):
            with self.assertRaisesRegex(cg.Error, "no contacts, .*contacts=True"):
                use()
        for name in ("acceleration", "angular_acceleration"):
            with self.assertRaisesRegex(cg.Error, name + ": .*accelerations=True"):
                getattr(frame, name)
        with self.assertRaisesRegex(cg.Error, "joint_reactions=True"):
            frame.joint_reaction
        self.assertNotIn("contacts", repr(frame))
        sim.observe(full.append, contacts=True, accelerations=True, joint_reactions=True)
        sim.step()
        self.assertEqual(full[-1].acceleration.shape, (len(frame.bodies), 3))
        self.assertEqual(full[-1].joint_reaction.shape[1], 6)
        self.assertGreater(contacts(full[-1]), 0)
        self.assertGreater(contacts(sim.frame), 0)
        self.assertIn("contacts", repr(sim.frame))
        # At the start there is no step to take a mean over.
        started = []
        sim = cg.Simulation(cg.compile_string(YARD))
        sim.observe(started.append, accelerations=True)
        sim.step()
        self.assertEqual(started[0].acceleration.shape, (0, 3))

    def test_a_recording_without_contacts(self):
        sim = cg.Simulation(cg.compile_string(YARD))
        with sim.record(str(self.folder / "run.mcap"), contacts=False):
            sim.run_until(0.01)
        recording = cg.Recording(str(self.folder / "run.mcap"))
        for use in (lambda: recording.table("contacts"), lambda: recording.signal("contacts(ground, crate)"),
                    lambda: recording[3].contacts):
            with self.assertRaisesRegex(cg.Error, "record\\(path, contacts=True\\)"):
                use()


class Sensors(Case):
    SCENE = """<scene name="sensors" version="1">
      <physics backend="cogrsim" step="1 ms"/>
      <plane name="floor"/>
      <box name="wall" size="10 100 100 cm" xyz="1.05 0 0.5" static="true"/>
      <box name="cart" size="20 20 20 cm" mass="2 kg" xyz="0 0 0.1"/>
      <box name="arm" size="4 4 40 cm" mass="1 kg" xyz="0 3 1"/>
      <hinge name="elbow" child="arm" axis="0 1 0" frame="arm" xyz="0 0 20 cm" position="30 deg"/>
      <encoder name="encoder" joint="elbow"/>
      <pose name="pose" on="cart"/>
      <imu name="imu" on="cart"/>
      <infrared name="infrared" on="cart" range="1 cm .. 5 m"/>
      <lidar name="lidar" on="cart" rays="3" fov="20 deg" range="1 cm .. 5 m"/>
      <contact name="contact" on="cart"/>
      <force-torque name="load" joint="elbow"/>
      <camera name="camera" on="cart" xyz="11 0 0 cm" resolution="16 12" fov="10 deg" depth="true"/>
    </scene>"""

    def test_names_as_in_cpp(self):
        frame = cg.Simulation(cg.compile_string(self.SCENE)).run_until(0.2)
        of = frame.sensors
        self.assertEqual(of["encoder"].position, of["encoder"]["position"])
        self.assertEqual(of["encoder"].velocity, of["encoder"]["velocity"])
        position, orientation = of["pose"].pose
        np.testing.assert_allclose(position, [0, 0, 0.1], atol=1e-3)
        np.testing.assert_allclose(orientation, [1, 0, 0, 0], atol=1e-3)
        self.assertEqual([part.shape for part in of["pose"].twist], [(3,), (3,)])
        np.testing.assert_allclose(of["imu"].specific_force, [0, 0, 9.80665], atol=0.05)
        self.assertEqual(of["imu"].angular_velocity.shape, (3,))
        # Rays begin in the middle of the cart, and do not see it.
        self.assertAlmostEqual(of["infrared"].distance, 1.0, places=3)
        self.assertEqual(of["infrared"].body, "wall")
        self.assertTrue(np.isnan(of["infrared"].volts))
        self.assertEqual(of["lidar"].size, 3)
        np.testing.assert_allclose(of["lidar"].ranges, 1 / np.cos(np.radians([10, 0, 10])), atol=1e-3)
        np.testing.assert_allclose(of["lidar"].directions[2], [np.cos(np.radians(10)), np.sin(np.radians(10)), 0])
        self.assertTrue(of["contact"].touching)
        self.assertEqual(of["contact"].bodies, ["floor"])
        self.assertAlmostEqual(of["contact"].force[2], 2 * 9.80665, delta=0.1)
        self.assertEqual((of["load"].force.shape, of["load"].torque.shape), ((3,), (3,)))
        np.testing.assert_allclose(of["lidar"].sensor_pose[0], [0, 0, 0.1], atol=1e-3)

    def test_a_name_of_another_sensor(self):
        sensors = cg.Simulation(cg.compile_string(self.SCENE)).run_until(0.01).sensors
        with self.assertRaisesRegex(AttributeError, "'lidar' is of type 'lidar', .* no 'position'; it has directions"):
            sensors["lidar"].position

    def test_before_the_first_reading(self):
        sensors = cg.Simulation(cg.compile_string(self.SCENE)).frame.sensors
        self.assertTrue(np.isnan(sensors["encoder"].position))
        self.assertTrue(np.isnan(sensors["imu"].specific_force).all())
        self.assertEqual(len(sensors["lidar"].ranges), 0)
        self.assertEqual((sensors["infrared"].body, sensors["contact"].bodies), ("", []))
        self.assertIsNone(sensors["lidar"].sensor_pose)

    def test_camera(self):
        camera = cg.Simulation(cg.compile_string(self.SCENE)).run_until(0.01).sensors["camera"]
        if not camera.valid:
            self.skipTest("no renderer")
        self.assertTrue(0 < camera.brightness <= 1)
        self.assertAlmostEqual(camera.nearest, 0.89, places=2)


class Elements(Case):
    def test_quantities(self):
        frame = frame_at(0.2)
        ball = frame["ball"]
        self.assertAlmostEqual(ball.speed, 0.2 * 9.81, places=2)
        self.assertAlmostEqual(ball.speed, np.linalg.norm(ball.velocity))
        self.assertEqual(ball.z, ball.position[2])
        np.testing.assert_array_equal(ball.orientation, [1, 0, 0, 0])
        self.assertEqual(frame["arm"].kind, "assembly")
        self.assertEqual(frame["arm"].position.shape, (3,))
        self.assertEqual(frame["arm.elbow"].kind, "joint")
        self.assertIsInstance(frame["arm.elbow"].position, float)
        self.assertIsInstance(frame["arm.turn"].effort, float)
        self.assertEqual(frame["arm.ticks"].position, frame.sensors["arm.ticks"]["position"])

    def test_a_quantity_that_an_element_has_not(self):
        frame = frame_at(0.0)
        for name, quantity in (("arm.turn", "position"), ("arm.elbow", "angular_velocity"), ("arm.elbow", "orientation")):
            with self.assertRaisesRegex(AttributeError, quantity):
                getattr(frame[name], quantity)
        self.assertTrue(np.isnan(cg.Simulation(cg.compile_string(YARD)).frame.sensors["arm.ticks"]["velocity"]))

    def test_unknown_names(self):
        frame = frame_at(0.01)
        with self.assertRaisesRegex(KeyError, "did you mean 'arm.elbow'"):
            frame["arm.elbw"]
        with self.assertRaisesRegex(AttributeError, "sped"):
            frame["ball"].sped
        with self.assertRaises(AttributeError):
            frame["arm.elbow"].orientation
        with self.assertRaisesRegex(KeyError, "position"):
            frame.sensors["arm.ticks"]["postion"]

    def test_energy_and_momentum(self):
        frame = frame_at(0.2)
        kinetic, potential = frame.energy
        self.assertGreater(kinetic, 0)
        linear, angular = frame.momentum
        self.assertAlmostEqual(linear[2], -0.2 * 9.81, delta=0.1)


class Images(Case):
    def test_camera_and_render(self):
        sim = cg.Simulation(cg.compile(EXAMPLES / "045_eyes" / "eyes.scene.xml"))
        frame = sim.run_until(0.2)
        images = [r.image for r in frame.sensors.values() if r.image is not None]
        self.assertTrue(images)
        height, width, channels = images[0].shape
        self.assertEqual((images[0].dtype, channels), (np.uint8, 3))
        self.assertFalse(images[0].flags.writeable)
        out = cg.render(frame, "iso", width=64, height=48, depth=True, labels=True)
        self.assertEqual(out["color"].shape, (48, 64, 3))
        self.assertEqual((out["depth"].shape, out["depth"].dtype), ((48, 64), np.float32))
        self.assertEqual((out["labels"].shape, out["labels"].dtype), ((48, 64), np.int32))
        self.assertGreater(out["labels"].max(), -1)
        self.assertGreater(len(np.unique(out["color"])), 3)
        with self.assertRaisesRegex(KeyError, "iso"):
            cg.render(frame, "isso")
        with self.assertRaises(cg.Error):
            cg.render(frame, width=0)


if __name__ == "__main__":
    main()
