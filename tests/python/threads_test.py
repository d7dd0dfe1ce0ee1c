"""Threads: one user of a simulation at a time, many simulations at once, Ctrl-C."""

import subprocess
import sys
import threading
import time
import unittest

import cogrsim as cg

from support import CART, YARD, Case, main

INTERRUPTED = """
import os, signal, sys, threading
import cogrsim as cg
sim = cg.Simulation(cg.compile(sys.argv[1], plugin_path=[os.path.dirname(sys.argv[1])]))
threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
recorder = sim.record("run.mcap") if "record" in sys.argv else None
try:
    if "step" in sys.argv:
        sim.step(10**9)
    else:
        sim.run_until(1e6, progress="progress" in sys.argv)
except KeyboardInterrupt:
    time, state, steps = sim.time, sim.state_hash, sim.step_count
    assert 0 < time < 1e5, time
    assert sim.status == "running"
    if "controller" in sys.argv:  # the update that was interrupted is the only one that is missing
        assert steps - sim.frame["arm.slow"].count <= 1, (steps, sim.frame["arm.slow"].count)
    # The state is that of an uninterrupted run of so many steps, and is followed by the same states.
    other = cg.Simulation(sim.scene)
    assert other.step(steps).state_hash == state
    assert sim.run_for(0.01).state_hash == other.run_for(0.01).state_hash
    assert abs(sim.time - time - 0.01) < 1e-6
    assert sim.messages == [], sim.messages
    if recorder:
        recorder.finish()
        recording = cg.Recording("run.mcap")
        assert len(recording) == sim.step_count + 1 and recording.info["complete"]
        assert recording[steps].state_hash == state
    print("interrupted and continued")
"""

SLOW = """
import time
import cogrsim as cg

class Slow(cg.Controller):
    outputs = [cg.output("count")]
    made = 0

    def configure(self, robot):
        self.robot = robot

    def update(self, tick):
        for _ in range(20):
            time.sleep(0.001)
        self.made += 1
        self.robot.publish("count", self.made)
"""


class Threads(Case):
    def test_a_simulation_in_two_threads_is_refused(self):
        sim = cg.Simulation(cg.compile_string(YARD))
        inside, go = threading.Event(), threading.Event()

        def wait(_):
            inside.set()
            go.wait(60)

        sim.observe(wait)
        worker = threading.Thread(target=sim.step)
        worker.start()
        self.assertTrue(inside.wait(60))
        for use in (lambda: sim.step(), lambda: sim.frame, lambda: sim.time, lambda: sim.save(),
                    lambda: sim.state_hash, lambda: sim.run_until(1.0), lambda: sim.observe(print)):
            with self.assertRaisesRegex(RuntimeError, "in use by another thread"):
                use()
        sim.set_motor("arm.turn", 1.0)  # commands are queued from any thread
        go.set()
        worker.join()
        self.assertEqual(sim.step_count, 1)
        sim.step()
        self.assertEqual(sim.step_count, 2)

    def test_several_simulations_at_once(self):
        scene = cg.compile_string(YARD)
        hashes = []

        def run():
            sim = cg.Simulation(scene)
            for _ in range(20):
                sim.run_for(0.02)
                sim.frame.position.sum()
            hashes.append(sim.state_hash)

        workers = [threading.Thread(target=run) for _ in range(4)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        self.assertEqual(len(hashes), 4)
        self.assertEqual(len(set(hashes)), 1)

    def test_stepping_lets_other_threads_run(self):
        sim = cg.Simulation(cg.compile_string(YARD), speed=1.0)
        count = 0

        def run():
            sim.run_until(0.3)

        worker = threading.Thread(target=run)
        worker.start()
        while worker.is_alive():
            count += 1
            time.sleep(0.001)
        self.assertGreater(count, 10)

    def test_an_environment_in_two_threads_is_refused(self):
        env = cg.VectorEnv(CART, 2, actions=["cart.push"], observations=["cart.pivot.position"])
        refused, stop = [], threading.Event()

        def look():
            while not stop.is_set():
                try:
                    env.frame(0)
                except RuntimeError as error:
                    refused.append(str(error))

        worker = threading.Thread(target=look)
        worker.start()
        steps = 0
        try:
            for _ in range(2000):
                try:
                    env.step([[0.0], [0.0]])
                    steps += 1
                except RuntimeError as error:
                    refused.append(str(error))
                if refused and steps:
                    break
        finally:
            stop.set()
            worker.join()
        self.assertTrue(refused)
        self.assertIn("environment is in use by another thread", refused[0])

    def interrupt(self, text, *how):
        path = self.write("yard.scene.xml", text)
        done = subprocess.run([sys.executable, "-c", INTERRUPTED, str(path), *how], capture_output=True, text=True,
                              timeout=120, check=False, cwd=self.folder)
        self.assertEqual((done.returncode, done.stdout.strip()), (0, "interrupted and continued"), done.stderr)

    def test_interrupt_ends_the_call_and_the_run_continues(self):
        for how in ("plain", "step", "progress", "record"):
            with self.subTest(how):
                self.interrupt(YARD, how)

    def test_interrupt_inside_a_controller_is_no_fault_of_it(self):
        self.write("slow_controller.py", SLOW)
        self.interrupt(YARD.replace("</assembly>", '<controller name="slow" plugin="py:slow_controller.Slow"'
                                    ' rate="1 kHz"/></assembly>', 1), "controller")


class Ending(Case):
    def test_the_program_ends_while_another_thread_steps(self):
        code = ("import sys, threading, time\nimport cogrsim as cg\nsim = cg.Simulation(sys.argv[1])\n"
                "sim.observe(lambda frame: None)\n"
                "threading.Thread(target=sim.run_until, args=(1e9,), daemon=True).start()\ntime.sleep(0.1)\n")
        self.end(code)

    def test_the_program_ends_while_other_threads_compile_and_step(self):
        self.end("import sys, threading, time\nimport numpy\nimport cogrsim as cg\n"
                 "def steps():\n    while True: cg.Simulation(sys.argv[1]).run_for(0.01)\n"
                 "def compiles():\n    while True: cg.compile(sys.argv[1])\n"
                 "def worlds():\n"
                 "    env = cg.VectorEnv(sys.argv[1], 3, observations=['cart.pivot.position'])\n"
                 "    env.reset()\n    while True: env.step(numpy.zeros((3, 0)))\n"
                 "for work in (steps, compiles, worlds) * 2: threading.Thread(target=work, daemon=True).start()\n"
                 "time.sleep(0.2)\n")

    def end(self, code):
        done = subprocess.run([sys.executable, "-W", "ignore", "-c", code, str(CART)], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (0, ""))


if __name__ == "__main__":
    main()
