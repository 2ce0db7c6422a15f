# SPDX-License-Identifier: GPL-3.0-or-later
"""Garments of real scenes, broken in eleven ways: clicked, played, rendered. Pictures go to RUMPLE_OUT."""
from __future__ import annotations

import unittest

import bpy
from mathutils.bvhtree import BVHTree
from support import damage
from support.damaged_case import Damaged
from support.one_blender import in_one_blender
from support.real_garment import DATA

WHOLE: dict[tuple[str, str], BVHTree] = {}  # by file and name: garments are broken in several ways


class RealDamaged(Damaged):
    file: str
    name: str
    frames = range(46, 61)

    @classmethod
    def opened(cls) -> bpy.types.Object:
        bpy.ops.wm.open_mainfile(filepath=str(DATA / f"{cls.file}.blend"))
        return bpy.data.objects[cls.name]

    @classmethod
    def whole_garment(cls) -> BVHTree:
        if (cls.file, cls.name) not in WHOLE:
            WHOLE[cls.file, cls.name] = super().whole_garment()
        return WHOLE[cls.file, cls.name]


class TurnedShirt(RealDamaged, unittest.TestCase):
    file, name, way = "S1_walk_shirt", "shirt", damage.turned


@in_one_blender
class TrousersWithFlaps(RealDamaged, unittest.TestCase):
    file, name, way = "S1_walk_shirt", "trousers", damage.flaps


@in_one_blender
class DoubledSweater(RealDamaged, unittest.TestCase):
    file, name, way = "S2_squat_trousers", "sweater", damage.doubled


@in_one_blender
class DegenerateTrousers(RealDamaged, unittest.TestCase):
    file, name, way = "S2_squat_trousers", "trousers", damage.degenerate


@in_one_blender
class ShirtWithHoles(RealDamaged, unittest.TestCase):
    file, name, way = "S1_walk_shirt", "shirt", damage.holes


@in_one_blender
class SkirtWithWires(RealDamaged, unittest.TestCase):
    file, name, way = "S3_skirt_sim", "skirt", damage.wires


@in_one_blender
class TeeInTwoLayers(RealDamaged, unittest.TestCase):
    file, name, way = "S3_skirt_sim", "tee", damage.second_layer


@in_one_blender
class TrousersOfNgons(RealDamaged, unittest.TestCase):
    file, name, way = "S1_walk_shirt", "trousers", damage.ngons


@in_one_blender
class UnmergedShirt(RealDamaged, unittest.TestCase):
    file, name, way = "S1_walk_shirt", "shirt", damage.unmerged


@in_one_blender
class HalfAShirt(RealDamaged, unittest.TestCase):
    file, name, way = "S1_walk_shirt", "shirt", damage.half
    longest = 4.6  # where the neck is cut: 4.67 times on the base cloth alone, 4.51 with its layers


class BrokenSweater(RealDamaged, unittest.TestCase):
    file, name, way = "S2_squat_trousers", "sweater", damage.everything


if __name__ == "__main__":
    unittest.main()
