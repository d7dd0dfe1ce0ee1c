"""What the tests of the Python module share."""

import os
import pathlib
import shutil
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
CART = EXAMPLES / "070_batch" / "cart.scene.xml"
ROBOT = EXAMPLES / "010_two_wheels" / "two_wheels.scene.xml"
ENGINES = [name for name in os.environ.get("COGRSIM_ENGINES", "").split(",") if name]

#: Under the address sanitizer freed memory is held for a while, and programs start slowly.
SANITIZED = bool(os.environ.get("COGRSIM_SANITIZE"))

#: A ball that falls onto a floor, with a kinematic lift, a template and a sensor.
YARD = """<scene name="yard" version="1">
  <param name="height" type="length" default="1 m" min="10 cm" max="5 m"/>
  <physics backend="cogrsim" step="1 ms" duration="1 s"/>
  <plane name="ground"/>
  <sphere name="ball" radius="10 cm" mass="1 kg" xyz="0 0 ${height}"/>
  <box name="crate" size="20 20 20 cm" mass="2 kg" xyz="1 0 0.1"/>
  <assembly name="arm" xyz="0 2 1">
    <box name="link" size="5 5 40 cm" mass="1 kg"/>
    <hinge name="elbow" child="link" axis="0 1 0" frame="arm"/>
    <motor name="turn" joint="elbow" mode="velocity" max-torque="5 N*m" max-speed="3 rad/s"/>
    <encoder name="ticks" joint="elbow"/>
  </assembly>
  <template name="pebble"><sphere name="stone" radius="2 cm" mass="10 g"/></template>
</scene>
"""


class Case(unittest.TestCase):
    """A test with a folder of its own."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="cogrsim_test_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text, encoding="utf-8")
        return path


def main():
    unittest.main(argv=[sys.argv[0], *sys.argv[1:]], verbosity=2)
