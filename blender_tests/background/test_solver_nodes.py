# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkles over Blender 5.2's own Cloth Dynamics, an asset with the XPBD Solver: played, jumped to, rendered, baked."""
from __future__ import annotations

import unittest
from pathlib import Path

import bpy
import numpy as np
from rumple.blender.objects import modifier
from support import sleeve
from test_viewport_mesh import rendered

ASSETS = Path(bpy.utils.system_resource("DATAFILES")) / "assets" / "nodes" / "geometry_nodes_dynamics_assets.blend"
CLOTH = "Cloth Dynamics (Experimental)"
FRAMES = range(1, 13)


def simulated_sleeve() -> bpy.types.Object:
    """Its upper arm is pinned to the animation, the lower one falls."""
    obj = sleeve.scene(wrinkles=False)
    with bpy.data.libraries.load(str(ASSETS)) as (_, wanted):
        wanted.node_groups = [CLOTH]
    cloth = obj.modifiers.new("Cloth Dynamics", "NODES")
    cloth.node_group = wanted.node_groups[0]
    pin = next(item for item in cloth.node_group.interface.items_tree
               if item.name == "Pin Group" and item.in_out == "INPUT")
    pinned = getattr(cloth.properties.inputs, pin.identifier)
    pinned.type, pinned.attribute_name = "ATTRIBUTE", "upper"
    return obj


@unittest.skipUnless(ASSETS.is_file(), "this Blender has no Cloth Dynamics")
class OverClothDynamics(unittest.TestCase):

    def setUp(self) -> None:
        self.obj = simulated_sleeve()
        self.bare = self.play()
        self.obj = simulated_sleeve()
        self.obj.rumple.mesh.property_unset("base_cloth")  # which the click is to find
        with sleeve.context():
            bpy.ops.object.rumple_add(method="MESH")
        self.obj.rumple.viewport_steps = self.obj.rumple.mesh.display_steps  # renders show the same mesh
        self.played = self.play()

    def play(self) -> dict[int, np.ndarray]:
        found = {}
        for frame in FRAMES:
            sleeve.at(frame)
            found[frame] = sleeve.shown(self.obj).copy()
        return found

    def test_it_is_taken_for_cloth_and_has_folds(self) -> None:
        settings = self.obj.rumple.mesh
        self.assertEqual((settings.base_cloth, settings.layers, self.obj.rumple.message), ("OFF", "CLOTH", ""))
        coarse, last = len(self.obj.data.vertices), FRAMES[-1]
        self.assertGreater(np.abs(self.bare[last] - self.bare[1]).max(), 0.05)  # it fell
        moved = np.linalg.norm(self.played[last][:coarse] - self.bare[last], axis=1)
        self.assertGreater(moved.max(), 0.001)
        self.assertLess(moved.max(), 0.1)

    def test_jumps_and_renders_show_what_was_played(self) -> None:
        for frame in (7, 11, 3):
            sleeve.at(frame)
            np.testing.assert_array_equal(sleeve.shown(self.obj), self.played[frame])
            np.testing.assert_array_equal(rendered(frame), self.played[frame])

    def test_a_bake_has_what_was_played(self) -> None:
        bpy.context.scene.frame_end = FRAMES[-1]
        with sleeve.context():
            bpy.ops.object.rumple_bake()
        self.assertTrue(modifier.is_baked(modifier.find(self.obj)))
        for frame in (11, 2, 7):
            sleeve.at(frame)
            np.testing.assert_allclose(sleeve.shown(self.obj), self.played[frame], atol=1e-6)
