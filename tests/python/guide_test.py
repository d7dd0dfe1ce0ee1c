"""The examples of docs/python.md run as they stand, one after the other."""

import contextlib
import io
import os
import re
import shutil
import sys
import unittest

import numpy as np

from support import CART, ROOT, Case, constant, main, model, node, port


# Seen from a pole that falls about y, downwards has the sine of its pitch as x.
BALANCE = """policy: 1
robot: cart.scene.xml
base: pole
network: balance.onnx
rate: 100 Hz
joints: [rail]
default-pose: 0 m
observations:
  - projected-gravity
  - base-angular-velocity: {frame: world}
actions: {kind: torque, scale: 1}
"""


def balance():
    """The force on the cart: 80 N per rad and 10 N per rad/s."""
    return model(port(11, "obs", (1, 6)), port(12, "force", (1, 1)),
                 constant("w", np.array([[80.0], [0], [0], [0], [10], [0]])), node("MatMul", ["obs", "w"], ["force"]))


class Guide(Case):
    def test_every_example(self):
        text = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
        blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
        self.assertGreaterEqual(len(blocks), 8)
        shutil.copy(CART, self.folder / "cart.scene.xml")
        (self.folder / "balance.policy.yaml").write_text(BALANCE)
        (self.folder / "balance.onnx").write_bytes(balance())
        before = os.getcwd()
        os.chdir(self.folder)
        self.addCleanup(os.chdir, before)
        names = {}
        for block in blocks:
            with self.subTest(block=block.splitlines()[0]), contextlib.redirect_stdout(io.StringIO()):
                exec(compile(block, "docs/python.md", "exec"), names)
        self.assertLess(abs(names["frame"]["cart.pivot"].position), 0.5)
        self.assertEqual(len(names["seen"]), 51)  # with the present one
        self.assertEqual(names["other"].backend, "bullet")
        self.assertGreater(names["rewards"].min(), 0.5)
        self.assertLess(np.abs(names["measured"][:, 4]).max(), 0.2)  # the pole stands in every world
        self.assertEqual(len(names["recording"]), 251)
        self.assertEqual(len(names["result"].table("bodies")), 2)


if __name__ == "__main__":
    main()
