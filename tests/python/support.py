"""What the tests of the Python module share."""

import os
import pathlib
import shutil
import sys
import tempfile
import unittest

import numpy as np

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


# ---- networks in ONNX, by the numbers of onnx.proto3

def varint(value):
    out = b""
    while True:
        out += bytes([(value & 127) | (128 if value > 127 else 0)])
        value >>= 7
        if not value:
            return out


def field(tag, value):
    """A field of a protobuf message: whole numbers, bytes and texts."""
    if isinstance(value, int):
        return varint(tag << 3) + varint(value & (1 << 64) - 1)
    value = value.encode() if isinstance(value, str) else value
    return varint(tag << 3 | 2) + varint(len(value)) + value


def constant(name, array):
    return field(5, b"".join(field(1, n) for n in array.shape) + field(2, 1) + field(8, name) +
                 field(9, np.ascontiguousarray(array, "<f4").tobytes()))


def port(tag, name, dims):
    shape = b"".join(field(1, field(1, n)) for n in dims)
    return field(tag, field(1, name) + field(2, field(1, field(1, 1) + field(2, shape))))


def node(kind, inputs, outputs, **attributes):
    body = b"".join(field(1, n) for n in inputs) + b"".join(field(2, n) for n in outputs) + field(4, kind)
    for name, value in attributes.items():
        body += field(5, field(1, name) + field(3, value))
    return field(1, body)


def model(*parts):
    return field(1, 8) + field(7, b"".join(parts)) + field(8, field(2, 17))


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
