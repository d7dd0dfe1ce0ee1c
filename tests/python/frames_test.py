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
