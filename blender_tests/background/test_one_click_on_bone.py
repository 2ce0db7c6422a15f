# SPDX-License-Identifier: GPL-3.0-or-later
"""Sheets that a bone moves as a whole are cloth: capes and flags of game characters. Other things on bones are not."""
from __future__ import annotations

import math
import unittest

import bmesh
import bpy
import numpy as np
from rumple.blender import compat
from rumple.blender.objects import bodies, on_bone, painted_maps, runtimes
from support import figure, sleeve


def made(name: str, bone: str, work: bmesh.types.BMesh) -> bpy.types.Object:
    """An object of that mesh, whose vertices are where the figure at rest has them, with a bone as parent."""
    mesh, rig = bpy.data.meshes.new(name), bpy.data.objects["Figure"]
    work.to_mesh(mesh)
    work.free()
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    obj.parent, obj.parent_type, obj.parent_bone = rig, "BONE", bone
    at_rest = rig.data.bones[bone].matrix_local.copy()
    at_rest.translation = rig.data.bones[bone].tail_local
    obj.matrix_parent_inverse = at_rest.inverted()
    return obj


def sheet(name: str, bone: str, corner: tuple[float, float, float], across: tuple[float, float, float],
          down: tuple[float, float, float]) -> bpy.types.Object:
    """A grid of 8 by 8 faces."""
    work, side = bmesh.new(), 9
    places = [np.array(corner) + np.array(across) * i / 8.0 + np.array(down) * j / 8.0
              for j in range(side) for i in range(side)]
    points = [work.verts.new(place) for place in places]
    for j in range(side - 1):
        for i in range(side - 1):
            work.faces.new([points[j * side + i], points[j * side + i + 1], points[(j + 1) * side + i + 1],
                            points[(j + 1) * side + i]])
    return made(name, bone, work)


def cape() -> bpy.types.Object:
    """Behind the figure, from its neck to its knees."""
    return sheet("Cape", "chest", (-0.25, 0.16, 1.5), (0.5, 0.0, 0.0), (0.0, 0.12, -0.9))


def cylinder(name: str, bone: str, place: tuple[float, float, float], radius: float, height: float,
             caps: bool) -> bpy.types.Object:
    work = bmesh.new()
    made_of = bmesh.ops.create_cone(work, cap_ends=caps, segments=16, radius1=radius, radius2=radius, depth=height)
    bmesh.ops.translate(work, verts=made_of["verts"], vec=place)
    return made(name, bone, work)


class OnBone(unittest.TestCase):
    """A figure, and what hangs on its bones."""

    def setUp(self) -> None:
        figure.dressed()
        bpy.data.objects.remove(bpy.data.objects["Dress"])
        self.rig = bpy.data.objects["Figure"]
        chest = self.rig.pose.bones["chest"]
        chest.rotation_mode = "XYZ"
        for frame, degrees in ((1, 0.0), (sleeve.LAST, 60.0)):
            chest.rotation_euler.x = math.radians(degrees)
            chest.keyframe_insert("rotation_euler", frame=frame)

    def held(self, obj: bpy.types.Object) -> np.ndarray:
        """Its vertices that follow the animation firmly."""
        sleeve.at(1)
        follow = painted_maps.weights(obj, painted_maps.find(obj, "follow"))
        return compat.positions(obj.data)[follow > 0.9]

    def click(self, obj: bpy.types.Object, where: str, method: str = "MESH") -> None:
        self.assertIn(f"{obj.name}: it is a sheet that the bone {obj.parent_bone} moves, so it is cloth that is held "
                      f"{where}", sleeve.click(obj, method))
        self.assertEqual(getattr(obj.rumple, method.lower()).base_cloth, "HANG")

    def test_a_cape_hangs_from_its_upper_end(self) -> None:
        obj = cape()
        for frame in (1, sleeve.LAST):  # a pose at the click makes no difference
            sleeve.at(frame)
            self.click(obj, "by its upper end")
            self.assertEqual(obj.rumple.body.name, "Body")
            held = self.held(obj)
            self.assertGreater(len(held), 8)
            self.assertGreater(held[:, 2].min(), 1.4)
            self.assertEqual(obj.rumple.message, "")
            bpy.ops.object.rumple_remove()

    def test_it_moves_and_is_pinned(self) -> None:
        obj = cape()
        self.click(obj, "by its upper end")
        rest = compat.positions(obj.data).copy()
        sleeve.play()
        fine = sleeve.shown(obj)
        self.assertGreater(len(fine), len(rest))
        top = fine[fine[:, 2] > 1.495]
        self.assertLess(np.abs(top[:, 1] - 0.16).max(), 0.01)
        self.assertGreater(np.abs(fine[fine[:, 2] < 0.7][:, 1] - 0.28).max(), 0.03)
        self.assertEqual(runtimes.message(obj), "")

    def test_every_system(self) -> None:
        obj = cape()
        for method in ("FIELD", "PATHS"):
            self.click(obj, "by its upper end", method)
            bpy.ops.object.rumple_remove()

    def test_a_flag_is_held_by_its_pole(self) -> None:
        cylinder("Pole", "hand.L", (0.7, 0.0, 1.4), 0.015, 2.0, True)
        obj = sheet("Flag", "hand.L", (0.715, 0.0, 2.3), (0.9, 0.0, 0.0), (0.0, 0.0, -0.6))
        self.click(obj, "where it touches Pole")
        held = self.held(obj)
        self.assertEqual(len(held), 9)
        self.assertLess(held[:, 0].max(), 0.72)

    def test_what_lies_flat_is_held_beside_the_bone(self) -> None:
        obj = sheet("Flap", "hips", (-0.3, 0.05, 1.0), (0.6, 0.0, 0.0), (0.0, 0.9, 0.0))
        self.click(obj, "beside the head of this bone")
        held = self.held(obj)
        self.assertGreater(len(held), 0)
        self.assertLess(held[:, 1].max(), 0.2)

    def test_legs_of_their_own_are_bodies(self) -> None:
        legs = figure.tube(self.rig, "Legs", 0.1, 0.0, 0.8)
        obj = cape()
        self.click(obj, "by its upper end")
        self.assertIn(legs, bodies.of(obj))

    def test_other_things_on_bones_stay(self) -> None:
        things = (cylinder("Shield", "hand.L", (0.8, 0.0, 1.4), 0.4, 0.03, True),
                  cylinder("Lamp", "hand.R", (-0.8, 0.0, 1.3), 0.3, 0.5, False),
                  cylinder("Sword", "hand.R", (-0.8, 0.0, 1.6), 0.02, 1.2, True),
                  sheet("Badge", "chest", (-0.05, -0.16, 1.4), (0.1, 0.0, 0.0), (0.0, 0.0, -0.1)))
        for obj in things:
            with self.subTest(obj.name):
                self.assertNotIn("so it is cloth", sleeve.click(obj))
                self.assertEqual(obj.rumple.mesh.base_cloth, "OFF")
                bpy.ops.object.rumple_remove()

    def test_what_the_artist_painted_stays(self) -> None:
        obj = cape()
        obj.vertex_groups.new(name="Rumple Follow").add([0], 1.0, "REPLACE")
        self.assertNotIn("so it is cloth that is held", sleeve.click(obj))
        self.assertEqual(len(self.held(obj)), 1)

    def test_where_it_is_at_rest(self) -> None:
        obj = cape()
        for relative in (False, True):
            self.rig.data.bones["chest"].use_relative_parent = relative
            self.rig.data.pose_position = "REST"
            bpy.context.view_layer.update()
            expected = np.array(obj.matrix_world)
            self.rig.data.pose_position = "POSE"
            sleeve.at(sleeve.LAST)
            np.testing.assert_allclose(np.array(on_bone.world_at_rest(obj)), expected, atol=1e-6)
            self.assertGreater(np.abs(np.array(obj.matrix_world) - expected).max(), 0.1)


if __name__ == "__main__":
    unittest.main()
