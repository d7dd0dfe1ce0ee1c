"""VectorEnv and Env: the conventions of Gymnasium, and the results of single simulations."""

import gc
import math
import os
import sys
import unittest

import numpy as np

import cogrsim as cg

from support import CART, ENGINES, SANITIZED, YARD, Case, main

OPTIONS = {"actions": ["cart.push"], "observations": ["cart.rail.position", "cart.pivot.position"],
           "done": "abs(cart.pivot.position) gt 20 deg", "reward": "1 - abs(cart.pivot.position) / 1 rad"}

#: A ball of another mass in every episode, which a force pushes for 10 ms.
DRAWN = """<scene name="drawn" version="1">
  <physics backend="cogrsim" step="1 ms" duration="0.01 s" gravity="0 0 0"/>
  <sphere name="ball" radius="10 cm" mass="1 kg"/>
  <force on="ball" force="1 0 0"/>
  <randomize what="ball.mass" by="uniform(0.5, 2)"/>
</scene>
"""


def carts(n=4, **options):
    return cg.VectorEnv(cg.compile(CART), n, **{**OPTIONS, **options})


class Vector(Case):
    def test_shapes_and_spaces(self):
        env = carts()
        self.assertEqual(env.num_envs, 4)
        self.assertEqual(env.single_action_space.shape, (1,))
        np.testing.assert_array_equal(env.single_action_space.high, [20.0])
        self.assertEqual(env.action_space.shape, (4, 1))
        self.assertEqual(env.observation_space.shape, (4, 2))
        obs, info = env.reset(seed=3)
        self.assertEqual((obs.shape, obs.dtype, info), ((4, 2), np.float64, {}))
        self.assertTrue(env.observation_space.contains(obs))
        obs, reward, terminated, truncated, info = env.step(env.action_space.sample())
        self.assertEqual((obs.shape, reward.shape, terminated.dtype, truncated.dtype),
                         ((4, 2), (4,), np.dtype(bool), np.dtype(bool)))
        np.testing.assert_allclose(reward, 1 - np.abs(obs[:, 1]))
        self.assertAlmostEqual(env.dt, 0.002)

    def test_worlds_are_single_simulations(self):
        env = carts(len(ENGINES), frame_skip=5, backends=ENGINES, done="")
        env.reset(seed=10)
        self.assertEqual(env.backends, ENGINES)
        for _ in range(10):
            env.step(np.full((len(ENGINES), 1), 3.0))
        for i, engine in enumerate(ENGINES):
            sim = cg.Simulation(env.scene, backend=engine, seed=10 + i)
            sim.set_motor("cart.push", 3.0)
            self.assertEqual(sim.step(50).state_hash, env.frame(i).state_hash, engine)

    def test_a_scene_for_each_world(self):
        scenes = [cg.compile(CART, set={"tilt": f"{tilt} deg"}) for tilt in (1, 2, 3, 4)]
        env = cg.VectorEnv(scenes, 4, **OPTIONS, backends=["bullet", "cogrsim"])
        np.testing.assert_allclose(env.reset()[0][:, 1], np.radians([1, 2, 3, 4]), atol=1e-9)
        self.assertEqual(env.backends, ["bullet", "cogrsim"] * 2)
        with self.assertRaisesRegex(ValueError, "expected 1 or 3 scenes, given 4"):
            cg.VectorEnv(scenes, 3)
        with self.assertRaisesRegex(cg.Error, "world 1"):
            cg.VectorEnv([scenes[0], cg.compile_string(YARD)], 2, **OPTIONS)

    def test_same_step_autoreset(self):
        env = carts(duration=0.1)
        obs, _ = env.reset(seed=0)
        for step in range(1, 51):
            obs, reward, terminated, truncated, info = env.step(np.zeros((4, 1)))
            if step < 50:
                self.assertEqual((terminated.any(), truncated.any(), info), (False, False, {}))
        self.assertTrue(truncated.all())
        self.assertFalse(terminated.any())
        self.assertTrue(info["_final_obs"].all())
        self.assertEqual(list(info["final_info"]["end"]), ["time"] * 4)
        for i in range(4):
            self.assertEqual(info["final_obs"][i].shape, (2,))
            self.assertAlmostEqual(reward[i], 1 - abs(info["final_obs"][i][1]))  # of the old episode
            self.assertEqual(env.frame(i).time, 0.0)
        np.testing.assert_array_equal(obs[:, 0], 0.0)

    def test_terminated(self):
        env = carts(frame_skip=10)
        env.reset(seed=0)
        seen = np.zeros(4, bool)
        for _ in range(200):
            _, _, terminated, truncated, info = env.step(np.full((4, 1), 20.0))
            seen |= terminated
            for i in np.flatnonzero(terminated):
                self.assertGreater(abs(info["final_obs"][i][1]), math.radians(20))
                self.assertEqual(info["final_info"]["end"][i], "done")
                self.assertIn("cart.pivot.position", info["final_info"]["message"][i])
            if seen.all():
                break
        self.assertTrue(seen.all())

    def test_seeds(self):
        env = carts(threads=1)
        first, _ = env.reset(seed=7)
        for _ in range(20):
            a = env.step(np.ones((4, 1)))[0]
        again, _ = env.reset(seed=[7, 8, 9, 10])
        np.testing.assert_array_equal(first, again)
        for _ in range(20):
            b = env.step(np.ones((4, 1)))[0]
        np.testing.assert_array_equal(a, b)
        self.assertEqual(env.np_random_seed, (7, 8, 9, 10))
        env.reset()
        self.assertNotEqual(env.np_random_seed, (7, 8, 9, 10))
        env.reset(seed=1, options={"reset_mask": np.array([True, False, False, False])})
        self.assertEqual(env.np_random_seed[0], 1)
        for seed in (-1, 1.5, "1", [1, 2], [1, 2, 3, -4]):
            with self.assertRaises((TypeError, ValueError)):
                env.reset(seed=seed)

    def test_values_drawn_for_each_episode(self):
        scene = cg.compile_string(DRAWN)
        env = cg.VectorEnv(scene, 3, observations=["ball.vx"])
        ends = []
        for _ in range(2):
            env.reset(seed=4)
            seeds, speeds = [], []
            for _ in range(30):
                before = env.np_random_seed
                _, _, _, truncated, info = env.step(np.zeros((3, 0)))
                for i in np.flatnonzero(truncated):
                    seeds.append(before[i])
                    speeds.append(info["final_obs"][i][0])
            ends.append((seeds, speeds))
        self.assertEqual(ends[0], ends[1])
        seeds, speeds = ends[0]
        self.assertEqual(len(set(speeds)), 9)
        for seed, speed in zip(seeds, speeds):
            sim = cg.Simulation(scene, seed=seed)
            # The impulse of 10 ms, rounded in each step.
            self.assertAlmostEqual(speed, 0.01 / sim.drawn["ball.mass"], delta=1e-12)

    def test_buffer_of_the_caller(self):
        env = carts()
        buffer = np.zeros((4, 2))
        env.observe_into(buffer)
        obs, _ = env.reset(seed=0)
        self.assertIs(obs, buffer)
        obs = env.step(np.ones((4, 1)))[0]
        self.assertIs(obs, buffer)
        other = carts()
        other.reset(seed=0)
        np.testing.assert_array_equal(buffer, other.step(np.ones((4, 1)))[0])
        env.observe_into(None)
        before = buffer.copy()
        env.step(np.ones((4, 1)))
        np.testing.assert_array_equal(buffer, before)
        env.observe_into(np.zeros((4, 2)))  # whose only owner is the environment
        gc.collect()
        env.step(np.ones((4, 1)))
        locked = np.zeros((4, 2))
        locked.flags.writeable = False
        for wrong, text in ((np.zeros((4, 3)), r"\(4, 2\), given the shape \(4, 3\)"),
                            (np.zeros((4, 2), np.float32), "float64.*given the dtype float32"),
                            (np.zeros((2, 4)).T, "gaps"), (locked, "read-only"), ([[0.0]], "float64")):
            with self.assertRaisesRegex((TypeError, ValueError), text):
                env.observe_into(wrong)

    def test_a_buffer_that_changed_is_not_written(self):
        env = carts()
        buffer = np.zeros((4, 2))
        env.observe_into(buffer)
        env.reset(seed=0)
        env.step(np.ones((4, 1)))
        kept = buffer.copy()
        buffer.setflags(write=False)
        for use in (lambda: env.step(np.ones((4, 1))), lambda: env.reset(seed=1)):
            with self.assertRaisesRegex(ValueError, "changed: it is now one that is read-only"):
                use()
        np.testing.assert_array_equal(buffer, kept)
        buffer.setflags(write=True)
        env.step(np.ones((4, 1)))
        with self.assertRaises(ValueError):
            buffer.resize((40, 2), refcheck=False)  # which would be elsewhere in memory
        buffer.shape = (2, 4)
        with self.assertRaisesRegex(ValueError, r"changed: it is now the shape \(2, 4\)"):
            env.step(np.ones((4, 1)))
        env.observe_into(None)
        env.step(np.ones((4, 1)))

    def test_more_worlds_than_memory(self):
        with self.assertRaisesRegex(ValueError, "at most 100000 worlds, given 100000000"):
            carts(n=100_000_000)

    def test_wrong_input(self):
        env = carts()
        env.reset()
        for actions, text in ((np.zeros((4, 2)), r"expected the shape \(4, 1\), given \(4, 2\)"),
                              (np.zeros(4), r"given \(4,\)"), (np.zeros((4, 1), complex), "complex"),
                              ([["a"]] * 4, "real numbers"), (np.full((4, 1), np.nan), "world 0")):
            with self.assertRaisesRegex((TypeError, ValueError), text):
                env.step(actions)
        for options, text in (({"actions": ["cart.psh"]}, "cart.push"), ({"observations": ["cart.pivt.position"]}, "pivot"),
                              ({"done": "cart.pivot.position gt"}, "."), ({"reward": "cart.pivt.position"}, "pivot"),
                              ({"backends": ["bulet"]}, "bulet")):
            with self.assertRaisesRegex((cg.Error, KeyError), text):
                carts(**options)
        for options in ({"actions": "cart.push"}, {"n": 2.5}, {"frame_skip": "1"}):
            with self.assertRaises(TypeError):
                carts(**options)
        with self.assertRaises(ValueError):
            carts(n=0)

    def test_deleted_while_in_use(self):
        env = carts()
        frame, obs = env.frame(0), env.reset()[0]
        del env
        gc.collect()
        self.assertEqual(frame.position.shape[1], 3)
        self.assertEqual(obs.shape, (4, 2))

    def test_a_controller_in_python_in_every_world(self):
        self.write("pushing_cart.py", "import cogrsim as cg\nclass Push(cg.Controller):\n"
                   "    def configure(self, robot):\n        self.motor = robot.motor('push')\n"
                   "    def update(self, tick):\n        self.motor.set(2.0)\n")
        text = CART.read_text(encoding="utf-8").replace(
            "</assembly>", '<controller plugin="py:pushing_cart.Push" rate="100 Hz"/></assembly>')
        scene = cg.compile_string(text, plugin_path=[self.folder])
        env = cg.VectorEnv(scene, 8, observations=OPTIONS["observations"], threads=2)
        obs, _ = env.reset(seed=0)
        for _ in range(50):
            obs = env.step(np.zeros((8, 0)))[0]
        self.assertTrue((obs[:, 0] > 0).all())

    def test_render(self):
        env = carts(2)
        env.reset()
        first, second = env.render()
        self.assertEqual((first.shape, first.dtype), ((480, 640, 3), np.uint8))


class Single(Case):
    def test_episode(self):
        env = cg.Env(CART, **OPTIONS, backend="cogrsim", frame_skip=5)
        obs, info = env.reset(seed=2)
        self.assertEqual((obs.shape, info), ((2,), {}))
        terminated = truncated = False
        while not (terminated or truncated):
            obs, reward, terminated, truncated, info = env.step(np.array([20.0]))
        self.assertIsInstance(reward, float)
        self.assertEqual((terminated, truncated, info["end"]), (True, False, "done"))
        with self.assertRaisesRegex(RuntimeError, "reset"):
            env.step(np.array([0.0]))
        again, _ = env.reset(seed=2)
        self.assertLess(abs(again[1]), math.radians(6))
        with self.assertRaisesRegex(ValueError, "shape"):
            env.step(np.zeros(2))

    def test_values_drawn_for_each_episode(self):
        scene = cg.compile_string(DRAWN)
        env = cg.Env(scene, observations=["ball.vx"])

        def episodes():
            speeds = []
            for seed in (5, None, None, 6):
                env.reset(seed=seed)
                terminated = truncated = False
                while not (terminated or truncated):
                    observation, _, terminated, truncated, _ = env.step(np.zeros(0))
                speeds.append(observation[0])
            return speeds

        speeds = episodes()
        self.assertEqual(len(set(speeds)), 4)
        self.assertEqual(speeds, episodes())
        for seed, speed in ((5, speeds[0]), (6, speeds[3])):
            sim = cg.Simulation(scene, seed=seed)
            self.assertEqual(speed, sim.run_until(0.01)["ball"].vx)
            # The impulse of 10 ms, rounded in each step.
            self.assertAlmostEqual(speed, 0.01 / sim.drawn["ball.mass"], delta=1e-12)

    def test_checkers_of_gymnasium(self):
        try:
            from gymnasium.utils.env_checker import check_env
        except ImportError:
            self.skipTest("gymnasium is not installed")
        check_env(cg.Env(CART, **OPTIONS))


class BadInput(Case):
    def test_names_and_options(self):
        with self.assertRaisesRegex(ValueError, "actions: 'cart.push' is given twice"):
            carts(actions=["cart.push", "cart.push"])
        with self.assertRaisesRegex(ValueError, "observations: 'cart.x' is given twice"):
            cg.Env(CART, observations=["cart.x", "cart.x"])
        with self.assertRaisesRegex(ValueError, "no option 'resetmask'; there are reset_mask"):
            carts().reset(options={"resetmask": [True]})
        with self.assertRaisesRegex(ValueError, "no option 'x'; there are none"):
            cg.Env(CART).reset(options={"x": 1})

    def test_faults_of_worlds_are_shown(self):
        text = CART.read_text(encoding="utf-8").replace("</scene>", '''
          <supervisor name="judge" plugin="py:failing_judge.Judge"/></scene>''')
        self.write("failing_judge.py", """
import cogrsim as cg

class Judge(cg.Supervisor):
    def update(self, tick, context):
        if tick.time > 0.05:
            raise ZeroDivisionError("after 50 ms")
""")
        scene = cg.compile_string(text, plugin_path=[self.folder])
        env = cg.VectorEnv(scene, 2, frame_skip=100)
        with self.assertWarnsRegex(cg.RunWarning, "(?s)world 1: at 0.0.* s, .*after 50 ms"):
            env.step(np.zeros((2, 0)))
        single = cg.Env(scene, frame_skip=100)
        with self.assertWarnsRegex(cg.RunWarning, "after 50 ms"):
            single.step(np.zeros(0))
        self.assertIn("after 50 ms", single.messages[-1].message)

    @unittest.skipIf(SANITIZED, "a forked process would report what its parent holds")
    def test_a_forked_process_refuses_what_has_threads(self):
        env = carts(threads=2)
        env.reset()
        sim = cg.Simulation(env.scene)
        recorder = sim.record(self.folder / "run.mcap")
        sys.stdout.flush()
        child = os.fork()
        if child == 0:
            for call in (lambda: env.step(np.zeros((4, 1))), recorder.finish):
                try:
                    call()
                    os._exit(1)
                except RuntimeError as error:
                    if "before this process was forked" not in str(error):
                        os._exit(2)
            del env, recorder
            gc.collect()
            cg.VectorEnv(sim.scene, 2, threads=2, observations=["cart.rail.position"]).step(np.zeros((2, 0)))
            os._exit(0)
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), 0)
        env.step(np.zeros((4, 1)))
        recorder.finish()


class Spaces(Case):
    def test_box(self):
        from cogrsim.spaces import Box, batch_space
        box = Box(np.array([-1.0, -np.inf]), np.array([1.0, np.inf]), dtype=np.float64)
        box.seed(1)
        for _ in range(100):
            self.assertTrue(box.contains(box.sample()))
        self.assertFalse(box.contains(np.array([2.0, 0.0])))
        self.assertFalse(box.contains(np.array([0.0])))
        self.assertEqual(batch_space(box, 3).shape, (3, 2))
        self.assertEqual(box, Box(np.array([-1.0, -np.inf]), np.array([1.0, np.inf]), dtype=np.float64))


if __name__ == "__main__":
    main()
