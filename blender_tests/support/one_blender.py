# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests that take long: of what no version of Blender decides, in one; of what is like another test, on demand."""
from __future__ import annotations

import os
import unittest

import bpy

in_one_blender = unittest.skipUnless(bpy.app.version < (4, 0, 0) or "RUMPLE_LONG" in os.environ,
                                     "in Blender 3.4, or with RUMPLE_LONG")
long_one = unittest.skipUnless("RUMPLE_LONG" in os.environ, "with RUMPLE_LONG")
