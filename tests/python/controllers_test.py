"""Controllers, supervisors and sensors in Python."""

import gc
import subprocess
import sys
import unittest
import warnings

import numpy as np

import cogrsim as cg

from support import SANITIZED, YARD, Case, main

ROBOT = YARD.replace("</assembly>", """<controller plugin="py:PLACE.Turner" rate="100 Hz" on-fault="FAULT">
      <set speed="90 deg/s" SETTINGS/>
    </controller>
  </assembly>""", 1)

MODULE = '''
import cogrsim as cg

handles = []

class Turner(cg.Controller):
    """Turns the arm."""
    parameters = [cg.parameter("speed", 0.2, "rad/s", "of the arm", range=(0.0, 3.0)),
                  cg.parameter("name", "left", choices=["left", "right"]),
                  cg.parameter("count", 3), cg.parameter("on", True),
                  cg.parameter("points", [0.0, 1.0], "m")]
    outputs = [cg.output("angle", "rad", "of the arm")]

    def configure(self, robot):
        self.robot = robot
        self.motor = robot.motor("turn")
        self.ticks = robot.sensor("ticks")
        self.speed = robot.parameter("speed")
        self.all = [robot.parameter(name) for name in ("name", "count", "on", "points")]
        self.updates = 0
        handles[:] = [robot, self.motor, self.ticks, self]

    def update(self, tick):
        self.updates += 1
        if tick.time > 0.3:
            raise ZeroDivisionError("after 0.3 s")
        self.motor.set(self.speed)
        self.robot.publish("angle", self.motor.joint_position)

    def save(self):
        return str(self.updates)

    def restore(self, memory):
        self.updates = int(memory)

class NotOne:
    pass

class Boss(cg.Supervisor):
    contacts = True
    parameters = [cg.parameter("limit", 0.5, "m")]
    outputs = [cg.output("height", "m")]
    frames = []

    def configure(self, context):
        self.limit = context.parameter("limit")
        self.kept, self.start = context, context.frame.time

    def update(self, tick, context):
        z = context.frame["ball"].z
        self.frames.append(context.frame)
        assert self.kept.frame.time == context.frame.time, "a context that is kept has the frame of this call"
        context.publish("height", z)
        if z < self.limit:
            context.end_run("low enough")

class Asker(cg.Controller):
    parameters = [cg.parameter("late", False)]
    outputs = [cg.output("asked", "rad/s")]

    def configure(self, robot):
        self.robot, self.late = robot, robot.parameter("late")
        self.speed = robot.input("speed", 0.5, -1, 2, "rad/s")
        handles[:] = [self.speed]

    def update(self, tick):
        if self.late and tick.count == 2:
            self.robot.input("late", 0, -1, 1)
        self.robot.publish("asked", self.speed.value)

class Looker(cg.Controller):
    """Reads by the names of C++."""
    def configure(self, robot):
        self.robot, self.motor, self.ticks = robot, robot.motor("turn"), robot.sensor("ticks")
        self.eye = robot.sensor("eye")

    def update(self, tick):
        assert self.ticks.type == "encoder" and self.ticks.position == self.ticks.value(0)
        assert self.eye.body == "ground" and self.eye.distance == self.eye.value(0)
        caught[:] = [self.robot.seed, self.robot.backend, self.robot.set_parameters, self.motor.lower,
                     self.motor.upper, self.motor.max_speed]
        try:
            self.eye.position
        except AttributeError as error:
            caught.append(str(error))

class Height(cg.Sensor):
    parameters = [cg.parameter("offset", 0.0, "m")]
    channels = [cg.channel("height", "m"), cg.channel("below", "m")]

    def configure(self, sensor, parameters):
        self.offset = parameters["offset"]
        self.body = sensor["body"]

    def read(self, context):
        z = context.frame[self.body].z
        distances, bodies = context.cast(context.frame[self.body].position, [(0, 0, -1)], ignore=self.body)
        return [z + self.offset, distances[0]]

class Bad(Height):
    def read(self, context):
        return [1.0, 2.0, 3.0]

class Late(Turner):
    def update(self, tick):
        self.robot.motor("trun")

caught = []

class Caster(Height):
    def read(self, context):
        up = [[0, 0, 1]]
        for cast in (lambda: context.cast((0, 0, 0), up, ignore="bal"),
                     lambda: context.cast((0, 0, 0), [[0, 0, 0]]),
                     lambda: context.cast((0, 0, 0), up, max_distance=-1.0),
                     lambda: context.cast((float("nan"), 0, 0), up)):
            try:
                cast()
            except (KeyError, ValueError) as error:
                caught.append(str(error.args[0]))
        return [0.0, 0.0]
'''


class InPython(Case):
    count = 0

    def setUp(self):
        super().setUp()
        InPython.count += 1
        self.module = f"turning_{InPython.count}"
        self.write(f"{self.module}.py", MODULE)

    def compile(self, text=ROBOT, fault="stop-controller", settings="", **options):
        text = text.replace("PLACE", self.module).replace("FAULT", fault).replace("SETTINGS", settings)
        return cg.compile_string(text, plugin_path=[self.folder], **options)

    def loaded(self):
        return sys.modules[self.module]

    def test_controller_runs_with_its_parameters(self):
        sim = cg.Simulation(self.compile(settings='name="right" count="5" on="false" points="1 2 3"'))
        frame = sim.run_until(0.25)
        self.assertAlmostEqual(frame["arm.elbow"].velocity, np.pi / 2, places=2)
        controller = self.loaded().handles[3]
        self.assertEqual(controller.all, ["right", 5, False, [1.0, 2.0, 3.0]])
        self.assertEqual(controller.updates, 25)
        name = sim.scene.controllers[0]
        self.assertAlmostEqual(frame[name].angle, frame["arm.elbow"].position, places=1)

    def asker(self, settings="", isolation="none"):
        text = ROBOT.replace("Turner", "Asker").replace('speed="90 deg/s" ', "")
        return cg.Simulation(self.compile(text, settings=settings), isolation=isolation)

    def test_inputs(self):
        for isolation in ("none", "process"):
            sim = self.asker('late="false"', isolation)
            name = sim.scene.controllers[0]
            self.assertEqual(sim.run_until(0.1)[name].asked, 0.5)
            (one,) = sim.controller_inputs[name]
            self.assertEqual((one.name, one.unit, one.lower, one.upper, one.value, one.start),
                             ("speed", "rad/s", -1.0, 2.0, 0.5, 0.5))
            sim.set_input("arm", "speed", 1.5)
            self.assertEqual(sim.run_until(0.2)[name].asked, 1.5)
            self.assertEqual([(each.value, each.start) for each in sim.controller_inputs[name]], [(1.5, 0.5)])
            with self.assertWarnsRegex(cg.RunWarning, "2.5 is not from -1 to 2"):
                sim.set_input("arm", "speed", 2.5)
                sim.step()
            with self.assertWarnsRegex(cg.RunWarning, "has no input 'sped'"):
                sim.set_input("arm", "sped", 1)
                sim.step()
            self.assertEqual(sim.controller_inputs[name][0].value, 1.5)
        with self.assertRaisesRegex(RuntimeError, "input 'speed'.*inside the calls"):
            self.loaded().handles[0].value

    def test_an_input_that_is_declared_later_is_a_fault(self):
        sim = self.asker('late="true"')
        with self.assertWarnsRegex(cg.RunWarning, "'late' is declared after configure"):
            sim.run_until(0.1)
        self.assertEqual(sim.controller_inputs, {})

    def test_parameters_are_checked_by_the_compiler(self):
        for settings, expected in (('sped="1 m"', "speed"), ('name="up"', "left"), ('count="1.5"', "count")):
            with self.assertRaises(cg.CompileError) as caught:
                self.compile(settings=settings)
            self.assertIn(expected, str(caught.exception))
            self.assertGreater(caught.exception.diagnostics[0].line, 0)
        with self.assertRaises(cg.CompileError) as caught:
            self.compile(ROBOT.replace('"90 deg/s"', '"9 rad/s"'))
        self.assertIn("3", str(caught.exception))
        with self.assertRaises(cg.CompileError):
            self.compile(ROBOT.replace('"90 deg/s"', '"9 m"'))

    def test_names_that_are_wrong(self):
        for name, expected in (("Turnr", "did you mean 'Turner'"), ("NotOne", "not derived from"),
                               ("Boss", "not derived from"), ("missing", "no controller")):
            with self.assertRaises(cg.CompileError) as caught:
                self.compile(ROBOT.replace("PLACE.Turner", f"PLACE.{name}"))
            self.assertIn(expected, str(caught.exception))
        with self.assertRaisesRegex(cg.CompileError, "there is no Python module"):
            self.compile(ROBOT.replace("PLACE", "no_such_module"))
        with self.assertRaisesRegex(cg.CompileError, "MODULE.CLASS"):
            self.compile(ROBOT.replace("py:PLACE.Turner", "py:Turner"))
        self.write("broken_module.py", "import no_such_thing_either\n")
        with self.assertRaisesRegex(cg.CompileError, "no_such_thing_either"):
            self.compile(ROBOT.replace("PLACE", "broken_module"))

    def test_exception_stops_the_controller(self):
        sim = cg.Simulation(self.compile())
        events = []
        sim.observe(lambda frame: events.extend(frame.events))
        with self.assertWarnsRegex(cg.RunWarning, "after 0.3 s"):
            frame = sim.run_until(0.5)
        self.assertEqual((sim.status, round(frame.time, 6)), ("running", 0.5))
        message = [one for one in sim.messages if one.severity == "error"][0]
        self.assertIn("'arm'", message.source)
        self.assertAlmostEqual(message.time, 0.31, delta=0.011)
        self.assertIn("ZeroDivisionError", message.message)
        self.assertIn(f"{self.module}.py", message.message)
        self.assertIn("in update", message.message)
        self.assertEqual([event.kind for event in events], ["fault"])

    def test_exception_ends_the_run(self):
        sim = cg.Simulation(self.compile(fault="end-run"))
        with self.assertWarns(cg.RunWarning):
            sim.run_until(0.5)
        self.assertEqual(sim.status, "fault")
        self.assertLess(sim.time, 0.35)

    def test_a_module_that_raises_on_import(self):
        for raised in ("KeyError", "KeyError(5)", "TypeError('it needs more')"):
            name = f"raising_{abs(hash(raised))}"
            self.write(f"{name}.py", f"raise {raised}")
            with self.assertRaisesRegex(cg.CompileError, f"(?s)CG0902.*cannot be imported.*{raised[:8]}"):
                cg.compile_string(YARD.replace("</assembly>", f'<controller plugin="py:{name}.C"/></assembly>'),
                                  plugin_path=[self.folder])

    def test_a_class_is_not_reloaded(self):
        sim = cg.Simulation(self.compile())
        sim.step()
        with self.assertRaisesRegex(cg.Error, "is not a library"):
            sim.reload_controller("arm")
        sim.run_until(0.1)
        self.assertEqual(self.loaded().handles[3].updates, 10)

    def test_missing_motor_is_an_error_of_the_scene(self):
        with self.assertRaisesRegex(cg.Error, "turn"):
            cg.Simulation(self.compile(ROBOT.replace('"turn"', '"turns"')))

    def test_handles_outside_their_calls_raise(self):
        sim = cg.Simulation(self.compile())
        sim.run_until(0.1)
        robot, motor, ticks, controller = self.loaded().handles
        for again in (True, False):
            for use in (lambda: motor.set(1.0), lambda: motor.target, lambda: ticks.values,
                        lambda: robot.motors, lambda: robot.motor("turn"), lambda: robot.parameter("speed")):
                with self.assertRaisesRegex(RuntimeError, "only be used inside the calls"):
                    use()
            if again:
                del sim
                gc.collect()

    def test_a_process_of_its_own_gives_the_same(self):
        scene = self.compile()
        here, there = cg.Simulation(scene), cg.Simulation(scene, isolation="process")
        a, b = here.run_until(0.25), there.run_until(0.25)
        self.assertEqual(a.state_hash, b.state_hash)
        np.testing.assert_array_equal(a.position, b.position)
        self.assertEqual(a[scene.controllers[0]].angle, b[scene.controllers[0]].angle)
        self.assertEqual(self.loaded().handles[3].updates, 25)  # of the other one nothing is seen here
        data = there.save_bytes()
        again = cg.resume(data, scene, isolation="process")
        # A snapshot keeps poses, not the engine's coordinates: equal to rounding.
        np.testing.assert_allclose(again.run_until(0.3).position, here.run_until(0.3).position, atol=1e-12)

    def test_an_exception_in_a_process_of_its_own_is_the_same_fault(self):
        messages = []
        for isolation in ("none", "process"):
            sim = cg.Simulation(self.compile(), isolation=isolation)
            with self.assertWarnsRegex(cg.RunWarning, "after 0.3 s"):
                sim.run_until(0.5)
            messages.append([(one.time, one.source, one.message) for one in sim.messages if one.severity == "error"])
        self.assertIn(f"{self.module}.py", messages[1][0][2])
        self.assertEqual(messages[0], messages[1])

    def test_a_controller_that_ends_or_hangs_is_a_fault(self):
        # The address sanitizer handles SIGSEGV itself.
        crash = ("os.kill(os.getpid(), 6)", "SIGABRT") if SANITIZED else ("os.kill(os.getpid(), 11)", "SIGSEGV")
        for does, expected in (("os._exit(3)", "exit code 3"), crash,
                               ("while True: pass", "0.5 s"), ("sys.exit(4)", "SystemExit")):
            name = "ending_" + str(abs(hash(does)))
            self.write(f"{name}.py", MODULE.replace("self.updates += 1", does).replace("import cogrsim", "import os, sys\nimport cogrsim"))
            text = ROBOT.replace("PLACE", name).replace('rate="100 Hz"', 'rate="100 Hz" isolation="process" deadline="0.5 s"')
            sim = cg.Simulation(self.compile(text))
            with self.subTest(does), self.assertWarnsRegex(cg.RunWarning, expected):
                frame = sim.run_until(0.1)
            self.assertEqual((sim.status, round(frame.time, 6)), ("running", 0.1))

    def test_a_class_of_the_program_itself_has_no_process(self):
        main_module = sys.modules["__main__"]
        main_module.Turner = type("Turner", (cg.Controller,), {"parameters": [cg.parameter("speed", 0.2, "rad/s")]})
        self.addCleanup(delattr, main_module, "Turner")
        scene = self.compile(ROBOT.replace("PLACE", "__main__"))
        with self.assertRaisesRegex(cg.Error, "put the class into a module"):
            cg.Simulation(scene, isolation="process")

    def test_snapshot_keeps_the_inner_state(self):
        scene = self.compile()
        sim = cg.Simulation(scene)
        sim.run_until(0.2)
        data = sim.save_bytes()
        other = cg.resume(data, scene)
        controller = self.loaded().handles[3]
        self.assertEqual(controller.updates, 20)
        other.run_until(0.25)
        self.assertEqual(controller.updates, 25)

    def test_results_are_those_of_commands(self):
        sim = cg.Simulation(self.compile())
        frame = sim.run_until(0.2)
        plain = cg.Simulation(cg.compile_string(YARD))
        plain.set_motor("arm.turn", np.pi / 2)
        self.assertAlmostEqual(plain.run_until(0.2)["arm.elbow"].position, frame["arm.elbow"].position)

    def test_supervisor(self):
        text = YARD.replace("</scene>", '<supervisor plugin="py:PLACE.Boss"><set limit="60 cm"/></supervisor></scene>')
        sim = cg.Simulation(self.compile(text))
        frame = sim.run_until(1.0)
        self.assertEqual(sim.status, "stopped")
        self.assertAlmostEqual(frame["ball"].z, 0.6, delta=0.01)
        frames = self.loaded().Boss.frames
        del sim, frame
        gc.collect()
        self.assertGreater(frames[0]["ball"].z, frames[-1]["ball"].z)
        self.assertGreater(len(frames[-1].contacts), 0)

    def test_names_of_sensors_and_the_run(self):
        text = ROBOT.replace("Turner", "Looker").replace('<set speed="90 deg/s" SETTINGS/>', "")
        text = text.replace('<encoder name="ticks"', '<infrared name="eye" on="link" rpy="0 90 0 deg" range="0 .. 9 m"/>'
                            '<encoder name="ticks"').replace('frame="arm"/>', 'frame="arm" lower="-2 rad" upper="1 rad"/>')
        sim = cg.Simulation(self.compile(text, set={"height": "2 m"}), seed=77, backend="ode")
        sim.run_until(0.05)
        self.assertEqual([message for message in sim.messages if message.severity == "error"], [])
        caught = self.loaded().caught
        self.assertEqual(caught[:6], [77, "ode", {"height": "2 m"}, -2.0, 1.0, 3.0])
        self.assertIn("of type 'infrared', which has no 'position'; it has body, distance, volts", caught[6])

    def test_every_fault_is_shown(self):
        # With Python's own filters a loop would show the fault of its first engine only.
        self.write("robot.scene.xml", ROBOT.replace("PLACE", self.module).replace("FAULT", "stop-controller")
                   .replace("SETTINGS", ""))
        path = self.write("run.py", f"""
import cogrsim as cg
for engine in ("cogrsim", "ode", "bullet"):
    scene = cg.compile({str(self.folder / "robot.scene.xml")!r}, plugin_path=[{str(self.folder)!r}])
    cg.Simulation(scene, backend=engine).run_until(0.4)
""")
        done = subprocess.run([sys.executable, str(path)], capture_output=True, text=True, check=True)
        self.assertEqual(done.stderr.count("RunWarning"), 3, done.stderr)
        strict = subprocess.run([sys.executable, "-W", "error::RuntimeWarning", str(path)], capture_output=True,
                                text=True, check=False)
        self.assertNotEqual(strict.returncode, 0)

    def test_sensor(self):
        text = YARD.replace('<encoder name="ticks"', '<sensor plugin="py:PLACE.Height" name="eye" on="link">'
                            '<set offset="10 cm"/></sensor><encoder name="ticks"')
        frame = cg.Simulation(self.compile(text)).run_until(0.01)
        eye = frame.sensors["arm.eye"]
        self.assertEqual((eye.channels, eye.units), (["height", "below"], ["m", "m"]))
        self.assertAlmostEqual(eye["height"], 1.1, places=3)
        self.assertAlmostEqual(eye["below"], 1.0, places=3)
        sim = cg.Simulation(self.compile(text.replace("Height", "Bad")))
        with self.assertWarnsRegex(cg.RunWarning, r"expected the shape \(2,\), given \(3,\)"):
            frame = sim.run_until(0.01)
        self.assertFalse(frame.sensors["arm.eye"].valid)

    def test_many_classes(self):
        self.compile()
        module = self.loaded()
        scenes = []
        text = ROBOT.replace("Turner", "Kind")
        with self.assertRaisesRegex(cg.CompileError, "classes are in use"):
            for i in range(200):
                setattr(module, "Kind", type("Kind", (module.Turner,), {}))
                scenes.append(self.compile(text))
        self.assertGreater(len(scenes), 100)
        scenes.clear()
        gc.collect()
        self.compile(text)

    def test_declarations(self):
        for declare, error, expected in (
                (lambda: cg.parameter("x", object()), TypeError, "expected a default"),
                (lambda: cg.parameter("two words", 1.0), ValueError, "a name has letters"),
                (lambda: cg.parameter(3, 1.0), TypeError, "name of type str, given int"),
                (lambda: cg.parameter("x", 1.0, "furlong"), ValueError, "'furlong' is not a unit"),
                (lambda: cg.parameter("x", 5.0, range=(0, 1)), ValueError, "the default 5.0 is outside of 0"),
                (lambda: cg.parameter("x", 5.0, range=(1, 0)), ValueError, "expected a range"),
                (lambda: cg.parameter("x", "a", range=(0, 1)), TypeError, "a str has no range"),
                (lambda: cg.parameter("x", "c", choices=["a", "b"]), ValueError, "none of"),
                (lambda: cg.parameter("x", "a", choices="ab"), TypeError, "a list of texts"),
                (lambda: cg.output("", "m"), ValueError, "a name has letters"),
                (lambda: cg.output("x", "apples"), ValueError, "not a unit"),
                (lambda: cg.channel("x", group=-1), ValueError, "group from 0"),
                (lambda: cg.channel("x", unit=None), TypeError, "unit of type str")):
            with self.subTest(expected), self.assertRaisesRegex(error, expected):
                declare()
        self.assertEqual(cg.parameter("x", 2.0, "m/s", range=(0, 3)).maximum, 3.0)
        self.assertEqual(cg.parameter("x", 9.0, required=True, range=(0, 3)).default, 9.0)

    def test_a_name_that_is_wrong_later(self):
        scene = self.compile(ROBOT.replace("PLACE.Turner", "PLACE.Late"))
        with self.assertWarnsRegex(cg.RunWarning, "there is no motor 'trun'; did you mean 'turn'"):
            cg.Simulation(scene).run_until(0.1)

    def test_rays_that_are_none(self):
        text = YARD.replace("</scene>", '<sensor plugin="py:PLACE.Caster" name="caster" on="ball"/></scene>')
        cg.Simulation(self.compile(text)).step()
        expected = ["there is no body 'bal'; did you mean 'ball'?", "directions: expected finite vectors",
                    "max_distance: expected a distance", "origin: expected finite numbers"]
        for found, begins in zip(self.loaded().caught, expected, strict=False):
            self.assertTrue(found.startswith(begins), found)
        self.assertGreaterEqual(len(self.loaded().caught), len(expected))


if __name__ == "__main__":
    main()
