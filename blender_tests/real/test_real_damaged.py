# SPDX-License-Identifier: GPL-3.0-or-later
"""Garments of real scenes, broken in eleven ways: clicked, played, rendered. Pictures go to RUMPLE_OUT."""
from __future__ import annotations

import unittest

import bpy
from support import damage
from support.damaged_case import Damaged
from support.real_garment import DATA


class RealDamaged(Damaged):
    file: str
    name: str
    frames = range(46, 61)

    @classmethod
    def opened(cls) -> bpy.types.Object:
        bpy.ops.wm.open_mainfile(filepath=str(DATA / f"{cls.file}.blend"))
        return bpy.data.objects[cls.name]


class TurnedShirt(RealDamaged, unittest.TestCase):
    file, name, way = "S1_walk_shirt", "shirt", damage.turned


class TrousersWithFlaps(RealDamaged, unittest.TestCase):
    file, name, way = "S1_walk_shirt", "trousers", damage.flaps


class DoubledSweater(RealDamaged, unittest.TestCase):
    file, name, way = "S2_squat_trousers", "sweater", damage.doubled


class DegenerateTrousers(RealDamaged, unittest.TestCase):
    file, name, way = "S2_squat_trousers", "trousers", damage.degenerate


class ShirtWithHoles(RealDamaged, unittest.TestCase):
    file, name, way = "S1_walk_shirt", "shirt", damage.holes


class SkirtWithWires(RealDamaged, unittest.TestCase):
    file, name, way = "S3_skirt_sim", "skirt", damage.wires


class TeeInTwoLayers(RealDamaged, unittest.TestCase):
    file, name, way = "S3_skirt_sim", "tee", damage.second_layer


class TrousersOfNgons(RealDamaged, unittest.TestCase):
    file, name, way = "S1_walk_shirt", "trousers", damage.ngons


class UnmergedShirt(RealDamaged, unittest.TestCase):
    file, name, way = "S1_walk_shirt", "shirt", damage.unmerged


class HalfAShirt(RealDamaged, unittest.TestCase):
    file, name, way = "S1_walk_shirt", "shirt", damage.half


class BrokenSweater(RealDamaged, unittest.TestCase):
    file, name, way = "S2_squat_trousers", "sweater", damage.everything


if __name__ == "__main__":
    unittest.main()
