# SPDX-License-Identifier: GPL-3.0-or-later
"""The frame rendered is the frame solved, in every engine."""
import unittest

import bpy
import numpy as np
import shots
import sleeve


class Render(unittest.TestCase):

    def test_workbench(self):
        shots.check(self, "BLENDER_WORKBENCH")

    def test_cycles(self):
        shots.check(self, "CYCLES")

    def test_eevee(self):
        shots.check(self, "EEVEE")

    def test_a_jump_renders_what_it_shows(self):
        obj = shots.stage("CYCLES")
        picture = shots.still(14)
        self.assertLess(shots.difference(picture, shots.frozen(obj, 14)), 1e-4)

    def test_motion_blur(self):
        obj = shots.stage("CYCLES")
        sleeve.play()
        scene = bpy.context.scene
        scene.cycles.samples = 64
        sharp = shots.still(12)
        scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
        blurred = shots.still(12)
        obj.cycles.use_motion_blur = False
        unblurred = shots.still(12)
        scene.render.use_motion_blur = False
        times = ((11, 0.5), (11, 0.75), (12, 0.0), (12, 0.25), (12, 0.5))
        moments = [shots.frozen(obj, frame, part) for frame, part in times]
        coverage = [picture[..., 3] for picture in (sharp, blurred, unblurred, np.mean(moments, axis=0))]
        blur = shots.difference(coverage[0], coverage[1])
        self.assertGreater(blur, 5.0 * shots.difference(coverage[0], coverage[2]))
        self.assertLess(shots.difference(coverage[1], coverage[3]), 0.6 * blur)

    def test_subdivision_after_shape_keys_before(self):
        obj = shots.stage("CYCLES")
        obj.shape_key_add(name="Basis")
        key = obj.shape_key_add(name="Wide")
        for point in key.data:
            point.co.y *= 1.5
        for frame in (1, 6):
            key.value = (frame - 1) / 5.0
            key.keyframe_insert("value", frame=frame)
        obj.modifiers.new("Subdivision", "SUBSURF").render_levels = 1
        pictures = shots.clip(1, 4)
        sleeve.at(4)
        copy_mesh = bpy.data.meshes.new_from_object(sleeve.evaluated(obj))
        copy = bpy.data.objects.new("Frozen", copy_mesh)
        bpy.context.scene.collection.objects.link(copy)
        obj.hide_render = True
        self.assertLess(shots.difference(pictures[4], shots.still(4)), 2e-3)
