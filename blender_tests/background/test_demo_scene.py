# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo, as a visitor has it: a figure whose feet stand while it crouches, dressed by one click for each garment."""
from __future__ import annotations

import sys
import unittest
from pathlib import Path
from unittest import mock

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree
from rumple.blender import compat
from rumple.blender.objects import bodies
from support import sleeve

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
CROUCH = 48
THROUGH = 0.002  # metres
MOST_THROUGH = 0.01  # share of the shown points; the bare trousers have 0.013 of theirs in the crouch


class Demo(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        if str(SCRIPTS) not in sys.path:
            sys.path.insert(0, str(SCRIPTS))
        import demo_scene
        build = demo_scene.demo_body.build_body
        with sleeve.context(), mock.patch.object(demo_scene.demo_body, "build_body", lambda _spacing: build(0.012)):
            demo_scene.build_demo_scene()
            demo_scene.add_wrinkles("MESH")

    def test_what_each_is_worn_over(self) -> None:
        self.assertEqual({body.name for body in bodies.of(bpy.data.objects["Trousers"])}, {"Mannequin"})
        self.assertEqual({body.name for body in bodies.of(bpy.data.objects["Shirt"])}, {"Mannequin", "Trousers"})

    def test_the_feet_stand(self) -> None:
        bones, places = bpy.data.objects["Skeleton"].pose.bones, []
        for frame in (1, 20, 48, 60):
            sleeve.at(frame)
            places.append([tuple(bones[f"foot.{side}"].head) for side in "LR"])
        self.assertLess(np.ptp(np.array(places), axis=0).max(), 0.012)
        self.assertLess(bones["hips"].head.z, bones["hips"].bone.head_local.z - 0.01)

    def test_no_skin_comes_through_the_trousers(self) -> None:
        sleeve.play(30, CROUCH)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        skin = BVHTree.FromObject(bpy.data.objects["Mannequin"], depsgraph)
        shown = compat.positions(bpy.data.objects["Trousers"].evaluated_get(depsgraph).data)
        deep = [(place - nearest).dot(normal) < -THROUGH
                for place, (nearest, normal, _, _) in ((p, skin.find_nearest(p)) for p in map(Vector, shown.tolist()))]
        self.assertLess(np.mean(deep), MOST_THROUGH)


if __name__ == "__main__":
    unittest.main()
