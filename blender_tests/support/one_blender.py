# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of what no version of Blender decides, and that take long."""
from __future__ import annotations

import os
import unittest

import bpy

in_one_blender = unittest.skipUnless(bpy.app.version < (4, 0, 0) or "RUMPLE_LONG" in os.environ,
                                     "in Blender 3.4, or with RUMPLE_LONG")
