# SPDX-License-Identifier: GPL-3.0-or-later
"""A baked clip stays right where nothing that makes it changed. Names of bodies counted, which differ in a shot that
links the character; and so did Start, moved into a clip that begins behind it."""
from __future__ import annotations

import hashlib
import os
import tempfile
import unittest
from typing import Any
from unittest import mock

import bpy
from rumple.blender.frame import clip_status
from rumple.blender.objects import evaluator, mesh_reader, modifier, properties, runtimes, units
from support import sleeve
from support.worn_sleeve import Worn

CHANGED = "bodies changed since the bake"


class Baked(Worn):

    def setUp(self) -> None:
        super().setUp()
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(sleeve.empty_file)
        self.path = os.path.join(folder.name, "character.blend")
        self.obj.rumple.body = self.body

    def bake(self, first: int = 1, last: int = 3) -> None:
        """In a collection that can be linked."""
        group = bpy.data.collections.new("Character")
        bpy.context.scene.collection.children.link(group)
        for member in (self.obj, self.body, bpy.data.objects["Arm"]):
            bpy.context.scene.collection.objects.unlink(member)
            group.objects.link(member)
        sleeve.make_active(self.obj)
        bpy.ops.wm.save_as_mainfile(filepath=self.path)
        self.obj.rumple.bake_start, self.obj.rumple.bake_end = first, last
        bpy.ops.object.rumple_bake()
        bpy.ops.wm.save_as_mainfile(filepath=self.path)
        self.check_right(self.obj)

    def said(self, obj: bpy.types.Object) -> str:
        return clip_status.check(obj, sleeve.output_object(obj))

    def check_right(self, obj: bpy.types.Object) -> None:
        self.assertEqual(self.said(obj), "")

    def link(self) -> bpy.types.Collection:
        sleeve.empty_file()
        with bpy.data.libraries.load(self.path, link=True) as (_, wanted):
            wanted.collections = ["Character"]
        return wanted.collections[0]

    def check_all(self) -> None:
        sleeve.at(1)
        sleeve.at(2)
        garments = [obj for obj, _ in modifier.wrinkled_objects()]
        self.assertGreater(len(garments), 0)
        for obj in garments:
            self.check_right(obj)
            self.assertEqual(runtimes.of(obj).bake_note, "")

    def test_a_body_that_is_renamed(self) -> None:
        self.bake()
        self.body.name = "Hero"
        self.check_right(self.obj)

    def test_a_linked_character(self) -> None:
        self.bake()
        group, instance = self.link(), bpy.data.objects.new("Instance", None)
        instance.instance_type, instance.instance_collection = "COLLECTION", group
        bpy.context.scene.collection.objects.link(instance)
        self.check_all()

    def test_an_override(self) -> None:
        self.bake()
        group = self.link()
        scene = bpy.context.scene
        scene.collection.children.link(group)
        group.override_hierarchy_create(scene, bpy.context.view_layer, do_fully_editable=True)
        self.check_all()

    def test_a_duplicate(self) -> None:
        self.bake()
        for each in bpy.data.collections["Character"].objects:
            each.select_set(True)
        bpy.ops.object.duplicate()
        self.check_all()
        self.assertEqual(bpy.data.objects["Sleeve.001"].rumple.body.name, "Human.001")

    def test_what_changes_a_body_makes_it_wrong(self) -> None:
        self.bake()
        self.body.data.vertices[5].co.z += 0.01
        self.assertIn(CHANGED, self.said(self.obj))
        self.body.data.vertices[5].co.z -= 0.01
        self.obj.rumple.body = sleeve.under(self.obj, "Other", 0.5)
        self.assertIn(CHANGED, self.said(self.obj))

    def test_a_setting_with_keys(self) -> None:
        """A clip was of the frame that was looked at: in all others it was called wrong."""
        settings = self.obj.rumple.mesh
        for frame, value in ((1, 0.5), (10, 1.0)):
            settings.detail = value
            self.obj.keyframe_insert("rumple.mesh.detail", frame=frame)
        sleeve.at(1)
        self.bake()
        for frame in (1, 3, 6):
            sleeve.at(frame)
            self.check_right(self.obj)
        settings.folds = 0.5
        self.assertIn(CHANGED, self.said(self.obj))

    def test_another_frame_rate(self) -> None:
        """Of what moves with time: the folds were those of the former rate, and nothing was said."""
        scene, obj, mesh = bpy.context.scene, self.obj, self.obj.rumple.mesh
        cases: tuple[tuple[str, bool, dict[str, Any]], ...] = (
            ("it hangs", False, dict(base_cloth="HANG")), ("it swings", True, dict(base_cloth="SWING")),
            ("each frame on its own", False, dict(stateless=True)),
            ("its rest shape adapts", True, dict(stateless=False, base_cloth="OFF", rest_shape="ADAPTIVE")),
            ("paths", True, {}))
        for name, is_timed, values in cases:
            with self.subTest(name):
                for key, value in values.items():
                    setattr(mesh, key, value)
                obj.rumple.method = "PATHS" if name == "paths" else "MESH"
                scene.render.fps = 24
                inputs = clip_status.inputs_fingerprint(obj, scene)
                with mock.patch.object(clip_status, "_frame_rate", lambda *_: b""):
                    older = clip_status.inputs_fingerprint(obj, scene)
                self.assertEqual(older != inputs, is_timed)
                for rate in (24, 60):
                    scene.render.fps = rate
                    self.assertEqual(clip_status.is_baked_from(inputs, obj, scene), rate == 24 or not is_timed)
                    self.assertTrue(clip_status.is_baked_from(older, obj, scene))

    def test_another_frame_rate_is_said(self) -> None:
        self.obj.rumple.mesh.base_cloth = "SWING"
        self.bake()
        bpy.context.scene.render.fps = 60
        self.assertIn(CHANGED, self.said(self.obj))
        bpy.context.scene.render.fps = 24
        self.check_right(self.obj)

    def test_start_is_moved_into_a_clip(self) -> None:
        self.bake(4, 8)
        for start, is_right in ((6, True), (4, True), (12, True), (0, False)):
            bpy.context.scene.frame_start = start
            self.assertEqual(CHANGED not in self.said(self.obj), is_right, start)

    def test_one_that_an_older_rumple_baked(self) -> None:
        self.bake()
        settings = properties.settings_of(self.obj, bpy.context.scene)
        digest = hashlib.sha1(evaluator.sources(self.obj).shape.encode())
        digest.update(repr((settings, units.first_frame(self.obj, bpy.context.scene))).encode())
        for key, weights in sorted(mesh_reader.paint(self.obj, settings).items()):
            digest.update(key.encode() + weights.tobytes())
        digest.update(self.body.name_full.encode())
        older = digest.hexdigest()
        self.assertTrue(clip_status.is_baked_from(older, self.obj, bpy.context.scene))
        self.body.name = "Hero"
        self.assertFalse(clip_status.is_baked_from(older, self.obj, bpy.context.scene))
        for damaged in ("", "@", older + "@x", older + "@1"):
            self.assertFalse(clip_status.is_baked_from(damaged, self.obj, bpy.context.scene))


if __name__ == "__main__":
    unittest.main()
