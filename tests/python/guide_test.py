"""The examples of docs/python.md run as they stand, one after the other."""

import contextlib
import io
import os
import re
import shutil
import sys
import unittest

from support import CART, ROOT, Case, main


class Guide(Case):
    def test_every_example(self):
        text = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
        blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
        self.assertGreaterEqual(len(blocks), 8)
        shutil.copy(CART, self.folder / "cart.scene.xml")
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
        self.assertEqual(len(names["recording"]), 251)
        self.assertEqual(len(names["result"].table("bodies")), 2)


if __name__ == "__main__":
    main()
