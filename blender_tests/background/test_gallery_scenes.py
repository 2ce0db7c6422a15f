# SPDX-License-Identifier: GPL-3.0-or-later
"""The scenes of the gallery: the figure stands on the ground, and each of the examples opens, plays and folds."""
from __future__ import annotations

import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import bpy
import numpy as np
from rumple.blender import compat
from rumple.blender.nodes import wrinkle_tree
from rumple.blender.objects import modifier
from rumple.blender.ui import examples
from support import sleeve
from support.one_blender import in_one_blender, long_one

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
PLAYED = 6  # frames
BUCKLE = 2  # its material
LEAST_FOLD = 0.002  # metres: that something of the cloth is moved, at least


def scripts() -> None:
    if str(SCRIPTS) not in sys.path:
        sys.path.insert(0, str(SCRIPTS))


class Motions(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        scripts()

    def ankles(self, motion: list, frames: range) -> np.ndarray:
        """(frames, 2, 3) metres, of a skeleton alone."""
        import demo_rig
        bpy.ops.wm.read_homefile(use_empty=True)
        skeleton = demo_rig.build_armature(bpy.context.scene.collection)
        demo_rig.animate(skeleton, motion)
        found = []
        for frame in frames:
            bpy.context.scene.frame_set(frame)
            found.append([tuple(skeleton.pose.bones[f"foot.{side}"].head) for side in "LR"])
        return np.array(found)

    def test_who_sits_down_keeps_the_feet_in_place(self) -> None:
        import scene_motions
        feet = self.ankles(scene_motions.sit(), range(1, 85, 3))
        self.assertLess(np.ptp(feet, axis=0).max(), 0.01)

    def test_who_runs_is_on_the_ground_or_above_and_moves_the_legs_in_turns(self) -> None:
        import demo_body
        import scene_motions
        feet = self.ankles(scene_motions.run(), range(40, 84))
        lower = feet[..., 2].min(axis=1)
        self.assertLess(np.abs(lower - demo_body.ANKLE[2]).max(), 0.06)  # a hop is 4.5 cm
        self.assertGreater(lower.min(), demo_body.ANKLE[2] - 0.01)
        ahead = feet[:, 0, 1] - feet[:, 1, 1]
        self.assertGreater(np.ptp(ahead), 0.6)
        self.assertLess(abs(np.corrcoef(feet[:, 0, 2], feet[:, 1, 2])[0, 1]), 0.999)

    def test_legs_that_are_alike_are_a_crouch(self) -> None:
        import demo_rig
        leg = demo_rig.LegPose(40.0, demo_rig.knee_bend(40.0))
        posed, crouching = demo_rig.Pose(1, left_leg=leg, right_leg=leg), demo_rig.Pose(1, crouch=40.0)
        self.assertEqual(demo_rig.hips_shift(posed), demo_rig.hips_shift(crouching))
        self.assertEqual(demo_rig.pose_turns(posed), demo_rig.pose_turns(crouching))


class Examples(unittest.TestCase):
    """Each file, as scripts/examples makes it."""

    def open_made(self, name: str) -> None:
        scripts()
        import examples_run
        with tempfile.TemporaryDirectory() as folder:
            examples_run.make(name, Path(folder) / f"{name}.blend")  # refuses what is too large
            with mock.patch.object(examples, "FOLDER", Path(folder)):
                self.assertEqual(bpy.ops.wm.rumple_open_example(name=name.replace("_", " ")), {"FINISHED"})
        self.assertEqual(bpy.data.filepath, "")
        self.assertIn("Licence: GPL-3.0-or-later", bpy.data.texts["Read Me"].as_string())

    def plays_and_folds(self, name: str, *garments: str) -> None:
        self.open_made(name)
        start = bpy.context.scene.frame_start
        sleeve.play(start, start + PLAYED)
        wrinkled = [obj for obj in bpy.context.scene.objects if obj.type == "MESH" and modifier.find(obj) is not None]
        self.assertEqual({obj.name for obj in wrinkled}, set(garments))
        for obj in wrinkled:
            self.assertEqual(obj.rumple.message, "", obj.name)
            mesh = sleeve.evaluated(obj).data
            # The cape's wide folds need no more vertices in a viewport than it was modelled with.
            finer = 1 if obj.name == "Cape" else 3
            self.assertGreaterEqual(len(mesh.vertices), finer * len(obj.data.vertices), obj.name)
            smooth = compat.read_attribute(mesh.attributes[wrinkle_tree.BASE_POSITION])
            moved = np.linalg.norm(compat.positions(mesh) - smooth, axis=1)
            self.assertGreater(np.percentile(moved, 99), LEAST_FOLD, obj.name)

    @in_one_blender
    def test_cape(self) -> None:
        self.plays_and_folds("Cape", "Trousers", "Shirt", "Cape")

    def test_jeans(self) -> None:
        self.plays_and_folds("Jeans", "Jeans")

    def test_jeans_have_a_buckle_that_is_shown_as_it_is_skinned(self) -> None:
        self.open_made("Jeans")
        sleeve.play(1, 12)
        obj = bpy.data.objects["Jeans"]
        shown = self.buckle(sleeve.evaluated(obj).data)
        modifier.find(obj).show_viewport = False
        posed = self.buckle(sleeve.evaluated(obj).data)
        self.assertEqual(len(shown), len(posed), "the buckle is subdivided")
        for way in (1, 2):  # sides and diagonals of its faces: each bar keeps its shape
            lengths = [np.linalg.norm(faces - np.roll(faces, way, axis=1), axis=2) for faces in (shown, posed)]
            np.testing.assert_allclose(*lengths, atol=1e-5)
        middles = [faces.mean(axis=(0, 1)) for faces in (shown, posed)]
        spread = [np.linalg.norm(faces - middle, axis=2) for faces, middle in zip((shown, posed), middles)]
        np.testing.assert_allclose(*spread, atol=2e-4)  # and they stay beside each other

    def buckle(self, mesh: bpy.types.Mesh) -> np.ndarray:
        """(faces, 4, 3) its corners, metres."""
        faces = [list(polygon.vertices) for polygon in mesh.polygons if polygon.material_index == BUCKLE]
        return compat.positions(mesh)[np.array(faces)]

    @long_one
    def test_sitting_down(self) -> None:
        self.plays_and_folds("Sitting_Down", "Trousers", "Shirt")

    @long_one
    def test_sweater(self) -> None:
        self.plays_and_folds("Sweater", "Shirt")

    @long_one
    def test_twist(self) -> None:
        self.plays_and_folds("Twist", "Trousers", "Shirt")

    @in_one_blender
    def test_painted_shirt(self) -> None:
        self.plays_and_folds("Painted_Shirt", "Shirt")
        painted = compat.read_attribute(bpy.data.objects["Shirt"].data.attributes["rumple_rest_wrinkle"])
        self.assertGreater((np.linalg.norm(painted, axis=1) > 0.3).sum(), 10)


if __name__ == "__main__":
    unittest.main()
