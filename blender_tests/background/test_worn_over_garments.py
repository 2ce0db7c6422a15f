# SPDX-License-Identifier: GPL-3.0-or-later
"""A garment over another one that is baked in a part of its frames, switched off, or changed after its own bake; two
over one body."""
from __future__ import annotations

import math
import unittest
from unittest import mock

import bpy
import numpy as np
from rumple.blender.frame import clip_status
from rumple.blender.objects import bodies, modifier, runtimes
from support import cloth_scenes, sleeve
from support.cloth_scenes import Cloth, forget
from support.worn_sleeve import Worn, posed, solved_body

LAST, BAKED = 8, 4  # frames


class Over(Cloth):

    def setUp(self) -> None:
        self.outer, self.inner = cloth_scenes.two()
        sleeve.bend_until(LAST)

    def under(self, frame: int) -> np.ndarray:
        """What the outer garment lies on in a frame."""
        sleeve.at(frame)
        return runtimes.of(self.outer).inputs.body.positions.copy()


class BakedInPart(Over):

    def setUp(self) -> None:
        super().setUp()
        self.saved()
        settings = self.inner.rumple
        settings.bake_scene_range, settings.bake_start, settings.bake_end = False, 1, BAKED
        sleeve.make_active(self.inner)
        self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})
        forget(self.outer)

    def test_the_order_of_frames_does_not_count(self) -> None:
        played = {frame: self.under(frame) for frame in range(1, LAST + 1)}
        for frame in (2, 7, 6, 7, 1, 8, 4, 5, 3):
            np.testing.assert_array_equal(self.under(frame), played[frame], f"frame {frame}")

    def test_it_lies_on_what_is_shown(self) -> None:
        for frame in (1, 4, 5, 8, 2, 7):
            under = self.under(frame)
            if frame > BAKED:
                state = runtimes.of(self.inner).evaluator.wrinkles_of(float(frame))
                np.testing.assert_array_equal(under, state.solved, f"frame {frame}")
            else:
                np.testing.assert_allclose(under, sleeve.shown(self.inner), atol=1e-6, err_msg=f"frame {frame}")


class OuterBaked(Over):

    def setUp(self) -> None:
        super().setUp()
        self.saved()
        sleeve.make_active(self.outer)
        self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})

    def said(self) -> str:
        bpy.context.view_layer.update()
        return runtimes.message(self.outer)

    def test_a_change_of_the_garment_under_it_is_said(self) -> None:
        settings = self.inner.rumple.mesh
        for name, value in (("folds", 2.0), ("gravity", 0.5)):
            former = getattr(settings, name)
            setattr(settings, name, value)
            self.assertIn("changed since the bake", self.said(), name)
            setattr(settings, name, former)
            self.assertEqual(self.said(), "", name)
        sleeve.make_active(self.inner)
        bpy.ops.object.rumple_paint(group="folds")
        bpy.ops.object.mode_set(mode="OBJECT")
        self.assertIn("changed since the bake", self.said())

    def test_a_clip_of_an_older_rumple_is_right(self) -> None:
        scene = bpy.context.scene
        with mock.patch.object(clip_status, "_wrinkles_under", lambda *_: b""):
            older = clip_status.inputs_fingerprint(self.outer, scene)
        self.assertNotEqual(older, clip_status.inputs_fingerprint(self.outer, scene))
        self.assertTrue(clip_status.is_baked_from(older, self.outer, scene))


class SwitchedOff(Over):

    def test_it_lies_on_the_bare_one_in_the_present_pose(self) -> None:
        sleeve.play(1, BAKED)
        modifier.find(self.inner).show_viewport = False
        bend = bpy.data.objects["Arm"].pose.bones["lower"]
        for angle in (None, 40.0, 80.0):
            if angle is not None:
                bend.rotation_euler.z = math.radians(angle)
            bpy.context.view_layer.update()
            np.testing.assert_allclose(runtimes.of(self.outer).inputs.body.positions, sleeve.shown(self.inner),
                                       atol=1e-6, err_msg=f"{angle} degrees")


class ReadOnce(Worn):
    """A frame reads a body once, for all garments that are worn over it."""

    def test_by_two_garments(self) -> None:
        inner = sleeve.under(self.obj, "Inner", 0.9)
        sleeve.make_active(inner)
        bpy.ops.object.rumple_add(method="MESH")
        for garment in (self.obj, inner):
            garment.rumple.body, garment.rumple.body_collection = self.body, None
        sleeve.at(3)
        for frame in (4, 9, 4):
            with mock.patch.object(bodies, "_plain", wraps=bodies._plain) as read:
                sleeve.at(frame)
            self.assertEqual([call.args[0] for call in read.call_args_list], [self.body])
            for garment in (self.obj, inner):
                np.testing.assert_allclose(solved_body(garment).positions, posed(self.body), atol=2e-6)

    def test_anew_by_whoever_asks_later(self) -> None:
        self.obj.rumple.body = self.body
        sleeve.at(3)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        evaluated = self.obj.evaluated_get(depsgraph)
        with mock.patch.object(bodies, "_plain", wraps=bodies._plain) as read:
            for _ in range(2):
                bodies.read(self.obj, evaluated, depsgraph)
        self.assertEqual(read.call_count, 2)


if __name__ == "__main__":
    unittest.main()
