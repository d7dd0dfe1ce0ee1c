"""examples/140_trot: learning beats chance, its network is read as numpy computes it, and the trained one walks."""

import io
import json
import os
import shutil
import subprocess
import sys
import unittest
from contextlib import redirect_stdout
from unittest import mock

import numpy as np

import cogrsim as cg
from support import EXAMPLES, Case, main

TROT = EXAMPLES / "140_trot"
sys.path.insert(0, str(TROT))
import network as net  # noqa: E402
import train  # noqa: E402

try:
    import onnx
except ImportError:
    onnx = None  # Debian: python3-onnx

#: The drive law of the card on torque motors: the torque in a step tells the target to the last digits.
KP, KD = 60.0, 2.0


def program(*arguments):
    return subprocess.run([os.environ["COGRSIM_PROGRAM"], *map(str, arguments)], capture_output=True, text=True,
                          check=False)


class Trot(Case):
    def setUp(self):
        super().setUp()
        for path in TROT.iterdir():
            if path.is_file():
                shutil.copy(path, self.folder)

    def test_the_mirror_keeps_the_network(self):
        free = np.random.default_rng(3).normal(size=(12, net.FEATURES))
        weight = net.weights(free)
        np.testing.assert_allclose(net.MIRROR_ACT @ weight @ net.MIRROR_READ, weight, atol=1e-12)
        read = np.random.default_rng(4).normal(size=(1, net.READ))
        mirrored = read @ net.MIRROR_READ[:net.READ, :net.READ].T
        np.testing.assert_allclose(net.act(weight[None], mirrored)[0], net.MIRROR_ACT @ net.act(weight[None], read)[0],
                                   atol=1e-12)

    def test_what_is_observed_is_in_the_axes_of_the_trunk(self):
        # Turned by yaw 0.7, then pitch 0.2, then roll -0.4: against rotation matrices.
        def turn(axis, angle):
            c, s = np.cos(angle), np.sin(angle)
            i, j = (axis + 1) % 3, (axis + 2) % 3
            out = np.eye(3)
            out[i, i] = out[j, j] = c
            out[i, j], out[j, i] = -s, s
            return out
        roll, pitch, yaw = -0.4, 0.2, 0.7
        R = turn(2, yaw) @ turn(1, pitch) @ turn(0, roll)
        velocity, spin = np.array([1.0, 2.0, 3.0]), np.array([-1.0, 0.5, 2.0])
        seen = np.concatenate([[0.3, roll, pitch, yaw], velocity, spin, np.zeros(24)])[None]
        w, g, v = train.turned_back(seen)
        np.testing.assert_allclose(w[0], R.T @ spin, atol=1e-12)
        np.testing.assert_allclose(g[0], R.T @ [0, 0, -1], atol=1e-12)
        np.testing.assert_allclose(v[0], turn(2, yaw).T @ velocity, atol=1e-12)

    def trained(self, iterations, out):
        text = io.StringIO()
        arguments = ["train.py", "--iterations", str(iterations), "--out", str(out)]
        with mock.patch.object(sys, "argv", arguments), redirect_stdout(text):
            return train.main(), text.getvalue()

    @unittest.skipIf(onnx is None, "there is no onnx")
    def test_a_few_iterations_gain_more_than_chance(self):
        out = self.folder / "trot.onnx"
        status, text = self.trained(8, out)
        self.assertEqual(status, 0, text)  # 32 robots that were not learned on, by pairs, 95 %
        self.assertEqual(text.count("iteration"), 8)
        checked = program("policy", "check", self.folder / "trot.policy.yaml")
        self.assertEqual((checked.returncode, checked.stderr), (0, ""))
        self.assertIn("reads 35 values", checked.stdout)

    @unittest.skipIf(onnx is None, "there is no onnx")
    def test_the_same_seed_gives_the_same_bits(self):
        with mock.patch.multiple(train, DIRECTIONS=4, BEST=2, LENGTH=20, ROBOTS=4):
            texts = [self.trained(2, self.folder / f"{k}.onnx")[1].splitlines()[:3] for k in "ab"]
        self.assertEqual(texts[0], texts[1])
        self.assertEqual((self.folder / "a.onnx").read_bytes(), (self.folder / "b.onnx").read_bytes())

    @unittest.skipIf(onnx is None, "there is no onnx")
    def test_the_program_decides_as_numpy(self):
        # Weights as trained ones, with noise in all of them, so that no feature goes unread.
        weight = net.weights(net.start() + np.random.default_rng(5).normal(scale=0.05, size=(12, net.FEATURES)))
        net.write(weight, str(self.folder / "trot.onnx"))
        card = (self.folder / "trot.policy.yaml").read_text()
        for old, new in (("offset: default}", f"offset: default, kp: {KP}, kd: {KD}}}"), ("step: 4 ms", "step: 0.5 ms")):
            self.assertIn(old, card)
            card = card.replace(old, new)
        self.write("trot.policy.yaml", card)
        scene = (self.folder / "trained.scene.xml").read_text()
        # Torques of gains are explicit, so the step is short.
        for old, new in (('servos="true"', 'servos="false" max_torque="10000 N*m"'), ('step="4 ms"', 'step="0.5 ms"')):
            self.assertIn(old, scene)
            scene = scene.replace(old, new)
        path = self.write("torque.scene.xml", scene)
        simulation = cg.Simulation(cg.compile(path))
        signals = [name.replace("robot.", "dog.robot.", 1) for name in train.SIGNALS]
        motors = [f"dog.{name}" for name in train.MOTORS]
        command = np.array([[0.4, 0.0, 0.0]])
        for decision in range(40):
            frame = simulation.frame
            seen = np.array([[frame.value(name) for name in signals]])
            wanted = net.act(weight[None], train.observations(seen, command, decision))[0]
            frame = simulation.step(1)
            torque = np.array([frame[name].effort for name in motors])
            angle, speed = seen[0, -24:-12], seen[0, -12:]
            action = ((torque + KD * speed) / KP + angle - net.POSE) / net.SCALE
            # float32 has 24 bits: sums of 56 products of up to 4 are within 56 * 4 * 6e-8 = 1.3e-5, commonly 1e-6.
            np.testing.assert_allclose(action, wanted, atol=1e-5)
            simulation.step(39)

    def test_the_trained_network_walks(self):
        for speed in (0.2, 0.4):
            run = program("policy", "run", TROT / "trot.policy.yaml", "--command", f"{speed} 0 0", "-d", "4s",
                          "--json", "-")
            self.assertEqual(run.returncode, 0, run.stderr)
            # As the README says: within 0.03 m/s where it learned.
            self.assertAlmostEqual(json.loads(run.stdout)["velocity"][0], speed, delta=0.03)
        self.assertLess((TROT / "trot.onnx").stat().st_size, 100_000)


if __name__ == "__main__":
    main()
