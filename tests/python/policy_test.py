"""Policies: what is observed and decided, for one world and for many, beside the controller of the SDK."""

import math
import threading
import unittest

import numpy as np

import cogrsim as cg

from support import Case, constant, main, model, node, port

ROBOT = """<scene name="arm" version="1">
  <physics step="2 ms"/>
  <plane name="floor"/>
  <assembly name="bot">
    <box name="trunk" size="40 40 20 cm" mass="5 kg" xyz="0 0 0.1"/>
    <box name="upper" size="4 4 20 cm" mass="0.5 kg" xyz="0 0 0.31"/>
    <hinge name="elbow" parent="trunk" child="upper" frame="trunk" xyz="0 0 0.1" axis="0 1 0" lower="-90 deg" upper="90 deg" damping="0.2 N*m*s/rad"/>
    <motor name="first" joint="elbow" mode="torque" max-torque="20 N*m"/>
CONTROLLER  </assembly>
</scene>
"""

CARD = """policy: 1
robot: arm.scene.xml
base: trunk
network: net.onnx
step: 2 ms
rate: 50 Hz
joints: [elbow]
default-pose: 0.1 rad
observations:
  - base-linear-velocity: {frame: base, scale: 2}
  - projected-gravity: {history: 2}
  - joint-positions
  - joint-velocities: {scale: 0.05, newest-first: true, history: 3}
  - last-action: {clipped: false}
  - command
  - phase: {frequency: 1.25 Hz}
actions: {kind: position, scale: 0.5, offset: default, clip: 2, kp: 40, kd: 2}
command: 0.5 0 0.1
"""


def perceptron(rng, sizes):
    """The bytes of a network of tanh layers, and its function in float64."""
    parts, weights = [port(11, "obs", (1, sizes[0])), port(12, "actions", (1, sizes[-1]))], []
    before = "obs"
    for i, (n, m) in enumerate(zip(sizes, sizes[1:])):
        w = rng.uniform(-1, 1, (m, n)).astype("f4") / math.sqrt(n)
        b = rng.uniform(-0.1, 0.1, m).astype("f4")
        weights.append((w.astype(float), b.astype(float)))
        last = i == len(sizes) - 2
        parts += [constant(f"w{i}", w), constant(f"b{i}", b),
                  node("Gemm", [before, f"w{i}", f"b{i}"], ["actions" if last else f"h{i}"], transB=1)]
        if not last:
            parts.append(node("Tanh", [f"h{i}"], [f"a{i}"]))
            before = f"a{i}"

    def function(x):
        for i, (w, b) in enumerate(weights):
            x = x @ w.T + b
            x = np.tanh(x) if i < len(weights) - 1 else x
        return x
    return model(*parts), function


#: h' = tanh(h + mean of obs) as state, which is the action, too.
RECURRENT = model(port(11, "obs", (1, 2)), port(11, "h_in", (1, 1)), port(12, "actions", (1, 1)), port(12, "h_out", (1, 1)),
                  constant("w", np.full((2, 1), 0.5)), node("MatMul", ["obs", "w"], ["m"]),
                  node("Add", ["m", "h_in"], ["s"]), node("Tanh", ["s"], ["h_out"]), node("Tanh", ["s"], ["actions"]))


class Policies(Case):
    def setUp(self):
        super().setUp()
        (self.folder / "arm.scene.xml").write_text(ROBOT.replace("CONTROLLER", ""))
        (self.folder / "arm.policy.yaml").write_text(CARD)
        network, self.function = perceptron(np.random.default_rng(5), (19, 16, 1))
        (self.folder / "net.onnx").write_bytes(network)
        self.card = self.folder / "arm.policy.yaml"

    def test_sizes_and_names(self):
        policy = cg.Policy(self.card)
        self.assertEqual(policy.check(), [])
        self.assertEqual((policy.observation_size, policy.action_size, policy.measured_size), (19, 1, 14))
        self.assertEqual(policy.joints, ["elbow"])
        self.assertEqual(policy.terms[:3], [("base-linear-velocity", 0, 3), ("projected-gravity", 3, 9),
                                            ("joint-positions", 9, 10)])
        self.assertEqual(policy.terms[-1], ("phase", 17, 19))
        self.assertEqual(policy.inputs, {"obs": [1, 19]})
        self.assertAlmostEqual(policy.period, 0.02)
        self.assertEqual(policy.motors(), ["bot.first"])
        self.assertEqual(policy.signals()[:4], ["bot.trunk.x", "bot.trunk.y", "bot.trunk.z", "bot.trunk.roll"])
        self.assertEqual(policy.signals()[-2:], ["bot.elbow.position", "bot.elbow.velocity"])

    def test_what_is_wrong(self):
        self.card.write_text(CARD.replace("joints: [elbow]", "joints: [elbo]"))
        (found,) = [d for d in cg.Policy(self.card).check() if d.severity == "error"]
        self.assertEqual((found.code, found.line), ("CG1505", 7))
        self.card.write_text(CARD.replace("rate: 50 Hz", "ratte: 50 Hz"))
        with self.assertRaisesRegex(cg.CompileError, "CG1502"):
            cg.Policy(self.card)
        self.card.write_text(CARD.replace("  - last-action: {clipped: false}\n", ""))
        with self.assertRaisesRegex(cg.CompileError, "CG1506"):
            cg.Policy(self.card)
        with self.assertRaises(cg.CompileError):
            cg.Policy(self.folder / "none.policy.yaml")
        with self.assertRaisesRegex(cg.Error, "CG1510|no such file"):
            cg.Policy(self.folder / "none.onnx")
        self.card.write_text(CARD)
        policy = cg.Policy(self.card)
        with self.assertRaisesRegex(ValueError, r"\(19,\)"):
            policy.act(np.zeros(18))
        with self.assertRaisesRegex(ValueError, r"\(4, 14\)"):
            policy.observe(np.zeros((3, 14)), policy.start(4))
        with self.assertRaisesRegex(ValueError, "another policy"):
            policy.act(np.zeros(19), cg.Policy(self.card).start())
        with self.assertRaises(ValueError):
            policy.start(0)
        late = cg.Policy(self.card, change={"observations.joint-positions.delay": "5 ms"})
        with self.assertRaisesRegex(cg.Error, "delay"):
            late.start()
        alone = cg.Policy(self.folder / "net.onnx")
        self.assertEqual(alone.act(np.zeros(19)).shape, (1,))
        with self.assertRaisesRegex(cg.Error, "card"):
            alone.joints

    def test_numbers(self):
        """float32 of 19 and 16 terms of at most 1 is within (19 + 16) 2^-24 times a sum of at most 5: 1e-5."""
        policy = cg.Policy(self.card)
        obs = np.random.default_rng(1).uniform(-1, 1, (50, 19)).astype("f4")
        actions = policy.act(obs)
        self.assertEqual((actions.shape, actions.dtype), ((50, 1), np.float32))
        np.testing.assert_allclose(actions, self.function(obs.astype(float)), atol=1e-5)

    def test_rows_do_not_depend_on_each_other(self):
        policy = cg.Policy(self.card)
        obs = np.random.default_rng(2).uniform(-1, 1, (64, 19))
        together = policy.act(obs)
        for i in range(64):
            np.testing.assert_array_equal(together[i], policy.act(obs[i]))

    def test_threads(self):
        policy = cg.Policy(self.card)
        obs = np.random.default_rng(2).uniform(-1, 1, (64, 19))
        expected, wrong = policy.act(obs), []

        def work():
            for _ in range(20):
                if not np.array_equal(policy.act(obs), expected):
                    wrong.append(1)
        threads = [threading.Thread(target=work) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(wrong, [])

    def test_observations_are_those_of_the_card(self):
        policy = cg.Policy(self.card)
        memory = policy.start()
        roll, pitch, yaw = 0.3, -0.2, 1.1
        measured = np.array([0, 0, 1, roll, pitch, yaw, 0.4, -0.1, 0.2, 0, 0, 0, 0.35, 2.0])
        cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
        rz = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
        ry = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
        rx = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
        turn = (rz @ ry @ rx).T
        down = turn @ [0, 0, -1]
        obs = policy.observe(measured, memory, command=[1, 2, 3])
        expected = [*(2 * turn @ [0.4, -0.1, 0.2]), *down, *down, 0.25, 0.1, 0.1, 0.1, 0, 1, 2, 3, 0, 1]
        np.testing.assert_allclose(obs, expected, atol=1e-6)
        action = policy.act(obs, memory)
        np.testing.assert_array_equal(memory.last_action, action)
        measured[-1] = 4.0
        obs = policy.observe(measured, memory)
        np.testing.assert_allclose(obs[10:13], [0.2, 0.1, 0.1], atol=1e-6)
        np.testing.assert_allclose(obs[13], action[0], atol=1e-6)
        np.testing.assert_allclose(obs[14:17], policy.command, atol=1e-6)
        np.testing.assert_allclose(obs[17:], [math.sin(2 * math.pi * 0.025), math.cos(2 * math.pi * 0.025)], atol=1e-6)
        memory.reset()
        self.assertEqual(memory.last_action, [0])
        np.testing.assert_allclose(policy.targets([3.0]), [0.1 + 0.5 * 2])  # within its clip
        np.testing.assert_allclose(policy.efforts([1.0], measured), [40 * (1 - 0.35) - 2 * 4])

    def test_recurrent_state(self):
        (self.folder / "rec.onnx").write_bytes(RECURRENT)
        self.card.write_text(CARD.split("observations:")[0].replace("net.onnx", "rec.onnx\nstate: {h_in: h_out}") +
                             "observations: [joint-positions, joint-velocities]\n"
                             "actions: {kind: position, scale: 1, offset: none, kp: 1, kd: 1}\n")
        policy = cg.Policy(self.card)
        memory = policy.start(3)
        self.assertEqual(list(memory.state), ["h_in"])
        with self.assertRaisesRegex(ValueError, "memory"):
            policy.act(np.zeros((3, 2)))
        obs = np.array([[0.1, 0.3], [1, 1], [0, 0]])
        h = np.zeros(3)
        for _ in range(3):
            h = np.tanh(h + obs.mean(axis=1))
            np.testing.assert_allclose(policy.act(obs, memory)[:, 0], h, atol=1e-6)
        np.testing.assert_allclose(memory.state["h_in"][:, 0], h, atol=1e-6)
        memory.reset(np.array([True, False, False]))
        np.testing.assert_allclose(memory.state["h_in"][:, 0], [0, h[1], h[2]], atol=1e-6)
        memory.state = {"h_in": np.array([[0.5], [0], [0]])}
        np.testing.assert_allclose(policy.act(obs, memory)[0, 0], math.tanh(0.7), atol=1e-6)
        with self.assertRaises(KeyError):
            memory.state = {"h": np.zeros((3, 1))}
        with self.assertRaises(IndexError):
            memory.reset([3])

    def test_it_drives_as_the_controller_does(self):
        """The loop in Python and the plugin make the same motion, to the rounding of roll, pitch and yaw."""
        policy = cg.Policy(self.card)
        scene = self.folder / "run.scene.xml"
        scene.write_text(ROBOT.replace("CONTROLLER", '    <pose name="base" on="trunk"/>\n    <controller plugin="policy">'
                                       '<set card="arm.policy.yaml"/></controller>\n'))
        other = cg.Simulation(cg.compile(scene), backend="cogrsim")
        sim = cg.Simulation(policy.scene, backend="cogrsim")
        memory = policy.start()
        for i in range(100):
            measured = policy.measure(sim.frame)
            if i % 10 == 0:
                targets = policy.targets(policy.act(policy.observe(measured, memory), memory))
            sim.set_motor("bot.first", policy.efforts(targets, measured)[0])
            sim.step(1)
            other.step(1)
        self.assertGreater(abs(sim.frame["bot.elbow"].position), 0.01)
        self.assertAlmostEqual(sim.frame["bot.elbow"].position, other.frame["bot.elbow"].position, places=6)

    def test_many_worlds(self):
        policy = cg.Policy(self.card)
        env = cg.VectorEnv(policy.scene, 4, actions=policy.motors(), observations=policy.signals(), duration=0.05,
                           backends=["cogrsim"])
        memory = policy.start(4)
        measured, _ = env.reset(seed=1)
        one = policy.start()
        first = policy.measure(env.frame(0))
        np.testing.assert_allclose(measured[0], first, atol=1e-12)
        obs = policy.observe(measured, memory, command=np.arange(12).reshape(4, 3))
        np.testing.assert_array_equal(obs[2][14:17], [6, 7, 8])
        np.testing.assert_array_equal(obs[1][:14], policy.observe(first, one)[:14])
        targets = policy.targets(policy.act(obs, memory))
        for _ in range(30):
            measured, _, terminated, truncated, _ = env.step(policy.efforts(targets, measured))
            memory.reset(terminated | truncated)
        self.assertEqual(measured.shape, (4, 14))


if __name__ == "__main__":
    main()
