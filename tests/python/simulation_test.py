"""Simulations: stepping, commands, snapshots, signals, observers."""

import contextlib
import gc
import io
import pickle
import unittest
import unittest.mock
import warnings
import weakref
from pathlib import Path

import numpy as np

import cogrsim as cg

from support import YARD, Case, main


CARRIER = Path(__file__).parents[2] / "examples" / "010_two_wheels" / "two_wheels.scene.xml"


def yard(**options):
    return cg.Simulation(cg.compile_string(YARD), **options)


class Stepping(Case):
    def test_step_run_until_and_run_for_agree(self):
        a, b, c = yard(), yard(), yard()
        a.step(100)
        b.run_until(0.1)
        for _ in range(10):
            c.run_for(0.01)
        self.assertEqual((a.step_count, b.step_count, c.step_count), (100, 100, 100))
        self.assertAlmostEqual(a.time, 0.1)
        self.assertEqual(a.state_hash, b.state_hash)
        self.assertEqual(a.state_hash, c.state_hash)
        self.assertEqual(a.frame.state_hash, a.state_hash)
        self.assertNotEqual(a.state_hash, yard().state_hash)

    def test_seed_step_and_backend(self):
        sim = yard(seed=5, step=0.002)
        self.assertEqual((sim.seed, sim.dt, sim.backend), (5, 0.002, "cogrsim"))
        self.assertEqual(sim.provenance["backend"], "cogrsim")
        with self.assertRaises(cg.Error) as caught:
            yard(backend="bulet")
        self.assertIn("bulet", str(caught.exception))
        self.assertEqual(caught.exception.diagnostics[0].severity, "error")
        for step in (1e-320, -0.001, float("nan"), float("inf")):
            with self.assertRaisesRegex(cg.Error, "from 1e-9 s"):
                yard(step=step)
        with self.assertRaises(TypeError):
            cg.Simulation(3)
        with self.assertRaisesRegex(ValueError, "isolation"):
            yard(isolation="box")
        for time in (float("nan"), float("inf")):
            with self.assertRaises(ValueError):
                yard().run_until(time)
        with self.assertRaises(ValueError):
            yard().step(-1)

    def test_the_run_ends(self):
        sim = yard()
        sim.end_run("enough")
        frame = sim.run_until(0.5)
        self.assertEqual(sim.status, "stopped")
        self.assertLess(frame.time, 0.01)
        other = yard()
        other.stop()
        other.run_until(0.5)
        self.assertEqual(other.status, "stopped")

    def test_pause(self):
        sim = yard()
        sim.pause()
        sim.run_until(0.1)
        self.assertTrue(sim.paused)
        sim.step_once()
        sim.step()
        self.assertEqual(sim.step_count, 1)
        sim.resume()
        sim.run_until(0.1)
        self.assertEqual(sim.step_count, 100)


class Commands(Case):
    def test_motor_moves_the_arm(self):
        sim = yard()
        sim.set_motor("arm.turn", 1.5)
        frame = sim.run_until(0.5)
        self.assertAlmostEqual(frame["arm.elbow"].velocity, 1.5, places=2)

    def test_spawn_and_remove(self):
        sim = yard()
        sim.spawn("pebble", "p1", position=(0, 0, 3))
        sim.spawn("pebble", position=[0, 1, 3], lifetime=0.05)
        frame = sim.run_until(0.01)
        self.assertAlmostEqual(frame["p1"].z, 3, places=2)
        self.assertEqual(frame.position.shape[0], len(frame.bodies))
        sim.remove("p1")
        with self.assertRaises(KeyError):
            sim.run_until(0.1)["p1"]

    def test_attach_detach_static_limits_and_sensors(self):
        sim = yard()
        sim.attach("weld", "ball", "crate", type="fixed")
        sim.set_static("crate")
        sim.enable_sensor("arm.ticks", False)
        sim.set_joint_limits("arm.elbow", -0.1, 0.1)
        sim.set_motor("arm.turn", 3.0)
        frame = sim.run_until(0.5)
        self.assertAlmostEqual(frame["ball"].z, 1.0, places=2)
        self.assertLess(frame["arm.elbow"].position, 0.2)
        self.assertFalse(frame.sensors["arm.ticks"].enabled)
        sim.detach("weld")
        self.assertLess(sim.run_until(0.9)["ball"].z, 0.9)

    def test_a_command_that_cannot_be_carried_out_is_reported(self):
        sim = yard()
        sim.remove("nobody")
        events = []
        sim.observe(lambda frame: events.extend(frame.events))
        with self.assertWarnsRegex(cg.RunWarning, "nobody"):
            sim.step()
        self.assertIn("refused", [event.kind for event in events])
        self.assertIn("nobody", sim.messages[-1].message)

    def test_other_commands(self):
        sim = yard()
        sim.log("a line")
        sim.set_step(0.002)
        sim.set_speed(float("inf"))
        sim.add_assembly(cg.compile_string(YARD.replace('<plane name="ground"/>', "")), "second",
                         position=(5, 0, 0))
        events = []
        sim.observe(lambda frame: events.extend(frame.events))
        frame = sim.run_until(0.01)
        self.assertEqual(sim.dt, 0.002)
        self.assertAlmostEqual(frame["second.ball"].x, 5.0)
        self.assertIn("a line", [message.message for message in sim.messages])
        sim.restart(seed=9)
        sim.step()
        self.assertEqual((sim.seed, sim.step_count), (9, 1))

    def test_force(self):
        sim = yard()
        # The weight of the ball and 2 N along its x, for 0.1 s.
        sim.apply_force("ball", [2, 0, 9.81], duration=0.1)
        sim.run_until(0.1)
        velocity = [sim.signal("ball.v" + axis).value for axis in "xyz"]
        np.testing.assert_allclose(velocity, [0.2, 0, 0], atol=1e-9)
        sim.apply_force("ball", torque=[0, 0, 0.004], axes="own")
        sim.step()
        # 2/5 m r^2 = 0.004 kg m^2, one step of 1 ms.
        np.testing.assert_allclose(sim.signal("ball.wz").value, 0.001, rtol=1e-6)
        with self.assertRaisesRegex(ValueError, "axes: expected 'world' or 'own'"):
            sim.apply_force("ball", [1, 0, 0], axes="body")

    def test_state_of_the_whole_world(self):
        sim = yard()
        position = sim.frame.position.copy()
        ball = sim.frame.bodies.index("ball")
        position[ball] = (0, 0, 2)
        velocity = np.zeros_like(position)
        velocity[ball] = (1, 0, 0)
        sim.set_state(position=position, velocity=velocity)
        frame = sim.step()
        self.assertAlmostEqual(frame["ball"].z, 2.0, places=2)
        self.assertAlmostEqual(frame["ball"].vx, 1.0)
        with self.assertRaisesRegex(ValueError, r"position: expected the shape \(\d+, 3\), given \(2, 3\)"):
            sim.set_state(position=np.zeros((2, 3)))
        with self.assertRaisesRegex(TypeError, "complex"):
            sim.set_state(position=position.astype(complex))
        with self.assertRaisesRegex(TypeError, "position"):
            sim.spawn("pebble", position="here")
        with self.assertRaisesRegex(ValueError, r"position: expected the shape \(3,\), given \(2,\)"):
            sim.spawn("pebble", position=(1, 2))
        with self.assertRaisesRegex(ValueError, "length is not 0"):
            sim.spawn("pebble", orientation=(0, 0, 0, 0))


class Snapshots(Case):
    def test_the_scene_is_never_replaced(self):
        path = self.write("own.scene.xml", YARD)
        sim = cg.Simulation(path)
        with self.assertRaisesRegex(cg.Error, "made from it"):
            sim.record(path, overwrite=True)
        with self.assertRaisesRegex(cg.Error, "made from it"):
            sim.write_snapshot(path, overwrite=True)
        self.assertEqual(path.read_text(encoding="utf-8"), YARD)

    def test_in_memory(self):
        sim = yard()
        sim.run_until(0.2)
        saved = sim.save()
        first = sim.run_until(0.6).state_hash
        sim.restore(saved)
        self.assertAlmostEqual(sim.time, 0.2)
        self.assertEqual(sim.run_until(0.6).state_hash, first)

    def test_as_bytes_and_in_a_file(self):
        sim = yard()
        sim.run_until(0.2)
        data = sim.save_bytes()
        path = self.folder / "run.snapshot"
        sim.write_snapshot(path)
        self.assertIsInstance(data, bytes)
        start, end = sim.state_hash, sim.run_until(0.6)
        hashes = set()
        for snapshot in (data, path):
            other = cg.resume(snapshot, cg.compile_string(YARD))
            self.assertAlmostEqual(other.time, 0.2)
            self.assertEqual((other.state_hash, other.notes), (start, []))
            frame = other.run_until(0.6)
            np.testing.assert_allclose(frame.position, end.position, atol=1e-3)
            hashes.add(frame.state_hash)
        self.assertEqual(len(hashes), 1)
        with self.assertRaises(cg.Error):
            cg.resume(data[:100], cg.compile_string(YARD))
        with self.assertRaises(cg.Error):
            cg.resume(data, cg.compile_string(YARD.replace('name="yard"', 'name="other"')))

    def test_of_another_scene(self):
        saved = cg.Simulation(cg.compile_string(YARD.replace('name="crate"', 'name="box"'))).save()
        with self.assertRaises(cg.Error):
            yard().restore(saved)


class Signals(Case):
    def test_signal(self):
        sim = yard()
        height = sim.signal("ball.z")
        self.assertEqual((height.text, height.unit), ("ball.z", "m"))
        self.assertAlmostEqual(height.value, 1.0)
        frame = sim.run_until(0.1)
        self.assertEqual(height.value, height(frame))
        self.assertAlmostEqual(frame.value("distance(ball, ground)"), frame["ball"].z - 0.1, places=6)
        with self.assertRaisesRegex(ValueError, "ball"):
            sim.signal("bal.z")
        del sim
        gc.collect()
        self.assertEqual(height(frame), frame["ball"].z)
        with self.assertRaisesRegex(RuntimeError, "pass a frame"):
            height.value


class Observers(Case):
    def test_every_frame_once(self):
        sim = yard()
        times = []
        handle = sim.observe(lambda frame: times.append(frame.time))
        sim.step(3)
        handle.end()
        sim.step(3)
        self.assertEqual(len(times), 4)  # with the start
        self.assertEqual(times, sorted(times))

    def test_exception_is_raised_by_the_call_that_steps(self):
        sim = yard()

        def fail(frame):
            if frame.step == 5:
                raise ZeroDivisionError("at step 5")

        sim.observe(fail)
        with self.assertRaisesRegex(ZeroDivisionError, "at step 5"):
            sim.run_until(0.5)
        self.assertEqual(sim.step_count, 5)
        sim.run_until(0.1)
        self.assertEqual(sim.step_count, 100)

    def test_contents(self):
        sim = yard()
        counts = []
        sim.observe(lambda frame: counts.append((len(frame.contacts), len(frame.acceleration))),
                    contacts=True, accelerations=True)
        sim.run_until(0.02)
        self.assertGreater(counts[-1][0], 0)
        self.assertEqual(counts[-1][1], len(sim.frame.bodies))

    def test_the_observed_simulation_is_refused_inside(self):
        sim = yard()
        seen = []

        def greedy(_):
            for use in (lambda: sim.step(), lambda: sim.frame, lambda: sim.save()):
                try:
                    use()
                except RuntimeError as error:
                    seen.append(str(error))

        sim.observe(greedy)
        sim.step()
        self.assertEqual(len(seen), 6)
        self.assertIn("in the middle of a step", seen[0])

    def test_objects_that_were_never_made(self):
        for name in ("Frame", "Scene", "Motor", "Snapshot", "Diagnostic", "SupervisorContext"):
            cls = getattr(cg, name)
            for make in (cls, lambda cls=cls: cls.__new__(cls)):
                with self.assertRaisesRegex(TypeError, name):
                    make()
        empty = cg.Simulation.__new__(cg.Simulation)
        for use in (empty.step, empty.pause, empty.save, empty.save_bytes, lambda: empty.frame, lambda: empty.notes,
                    empty.set_state):
            with self.assertRaises((RuntimeError, TypeError)):
                use()

    def test_arguments_of_another_type(self):
        sim = cg.Simulation(cg.compile_string(YARD))
        for call, text in ((lambda: sim.set_state(True), "expected a Frame, given bool"),
                           (lambda: cg.Simulation(sim.scene, backend=5), "backend: expected a text, given int")):
            with self.assertRaisesRegex(TypeError, text):
                call()

    def test_nothing_is_pickled(self):
        sim = cg.Simulation(cg.compile_string(YARD))
        for thing in (sim, sim.frame, sim.scene, sim.save(), sim.frame["ball"], cg.VectorEnv(sim.scene, 1)):
            for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
                with self.assertRaisesRegex(TypeError, "cannot be pickled"):
                    pickle.dumps(thing, protocol)

    def test_errors_are_pickled(self):
        with self.assertRaises(cg.CompileError) as caught:
            cg.compile_string('<scene name="s" version="1"><spher name="b"/></scene>')
        again = pickle.loads(pickle.dumps(caught.exception))
        self.assertEqual(str(again), str(caught.exception))
        self.assertEqual([str(one) for one in again.diagnostics], [str(one) for one in caught.exception.diagnostics])
        self.assertEqual(again.diagnostics[0].remedy, caught.exception.diagnostics[0].remedy)

    def test_names_that_no_assembly_has(self):
        sim = cg.Simulation(cg.compile_string(YARD))
        for name in ("a.b", "1st", "two words", "a\n"):
            with self.subTest(name), self.assertWarnsRegex(cg.RunWarning, "an assembly cannot be named"):
                sim.spawn("pebble", name, position=(3, 3, 3))
                sim.step()

    def test_deleting_in_any_order(self):
        sim = yard()
        frames = []
        handle = sim.observe(frames.append)
        sim.step(3)
        saved, height = sim.save(), sim.signal("ball.z")
        arrays = [frame.position for frame in frames]
        gone = weakref.ref(frames[0].__class__)
        del sim
        gc.collect()
        handle.end()
        del frames
        gc.collect()
        self.assertTrue(all(np.isfinite(array).all() for array in arrays))
        del saved, height
        gc.collect()
        self.assertIsNotNone(gone())


class Faults(Case):
    def test_divergence_is_no_silence(self):
        text = YARD.replace('step="1 ms"', 'step="1 ms"')
        sim = cg.Simulation(cg.compile_string(text))
        velocity = np.zeros((len(sim.frame.bodies), 3))
        velocity[:] = 1e200
        sim.set_state(velocity=velocity)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            sim.run_until(0.1)
        if sim.status == "running":
            self.skipTest("this engine does not diverge here")
        self.assertTrue(any(issubclass(one.category, cg.RunWarning) for one in caught))


class Progress(Case):
    def lines(self, stream, end=0.3):
        sim = cg.Simulation(cg.compile_string(YARD))
        with contextlib.redirect_stderr(stream):
            sim.run_until(0.1)
            sim.run_until(end, progress=True)
        return sim, stream.getvalue().split("\r")

    def test_a_terminal_has_a_line(self):
        stream = io.StringIO()
        stream.isatty = lambda: True
        sim, lines = self.lines(stream)
        self.assertEqual(lines[0], "")
        self.assertRegex(lines[-1], r"^\[#+\] 100 %  0\.30 s of 0\.3 s.*\n$")
        plain = cg.Simulation(cg.compile_string(YARD))
        plain.run_until(0.3)
        self.assertEqual(sim.state_hash, plain.state_hash)

    def test_a_run_that_ends_early_stops_there(self):
        stream = io.StringIO()
        stream.isatty = lambda: True
        sim = cg.Simulation(cg.compile_string(YARD))
        sim.end_run("enough")
        with contextlib.redirect_stderr(stream):
            sim.run_for(1.0, progress=True)
        self.assertNotEqual(sim.status, "running")
        self.assertNotIn("100 %", stream.getvalue())

    def test_a_notebook_has_a_line(self):
        class OutStream(io.StringIO):
            pass

        OutStream.__module__ = "ipykernel.iostream"
        self.assertIn("100 %", self.lines(OutStream())[1][-1])

    def test_a_file_has_none(self):
        self.assertEqual(self.lines(io.StringIO())[1], [""])

    def test_a_closed_terminal_does_not_end_the_run(self):
        stream = io.StringIO()
        stream.isatty = lambda: True
        stream.write = unittest.mock.Mock(side_effect=OSError)
        self.assertEqual(self.lines(stream)[0].time, cg.Simulation(cg.compile_string(YARD)).run_until(0.3).time)
        stream.write.assert_called_once()


class Reloading(Case):
    def test_library(self):
        sim = cg.Simulation(CARRIER)
        sim.run_until(0.1)
        done = sim.reload_controller("robot")
        self.assertEqual(done["plugin"], "diff_drive")
        self.assertTrue(done["memory_kept"] or done["note"])
        sim.run_until(0.2)
        self.assertAlmostEqual(sim.time, 0.2)

    def test_errors(self):
        sim = yard()
        with self.assertRaisesRegex(cg.Error, "nobody"):
            sim.reload_controller("nobody")
        with self.assertRaises(TypeError):
            sim.reload_controller(1)
        sim.step()


if __name__ == "__main__":
    main()
