# SPDX-License-Identifier: GPL-3.0-or-later
"""The frame rendered is the frame solved, with the engines that need a screen."""
import shots
from case import WindowCase


class Render(WindowCase):

    def test_workbench(self):
        shots.check(self, "BLENDER_WORKBENCH")

    def test_cycles(self):
        shots.check(self, "CYCLES")

    def test_eevee(self):
        shots.check(self, "EEVEE")
