# SPDX-License-Identifier: GPL-3.0-or-later
"""The menu of fabrics: what a choice sets, what the next one takes back, and files of before."""
from __future__ import annotations

import sys
import unittest
from pathlib import Path
from unittest import mock

import bpy
import numpy as np
from rumple.blender.objects import properties, runtimes
from rumple.core.settings.presets import MESH_PRESETS
from support import sleeve

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
if str(SCRIPTS) not in sys.path:
    sys.path.insert(0, str(SCRIPTS))


class Presets(unittest.TestCase):

    def test_all_presets(self) -> None:
        obj = sleeve.scene()
        for preset in (*(key for key in MESH_PRESETS if key != "COTTON"), "COTTON"):
            bpy.ops.object.rumple_preset(preset=preset)
            sleeve.at(15)
            self.assertEqual(obj.rumple.message, "", preset)
            self.assertEqual(obj.rumple.mesh.preset, preset)

    def test_stiff_cloth_has_wider_folds_than_what_was_chosen_and_the_way_back_is_exact(self) -> None:
        obj = sleeve.scene()
        settings = obj.rumple.mesh
        for chosen in (0.03, 0.0317234):
            settings.wavelength = chosen
            chosen = settings.wavelength
            for preset, width in (("DENIM", 1.35), ("DENIM", 1.35), ("LEATHER", 1.85), ("SILK", 0.75), ("COTTON", 1.0)):
                bpy.ops.object.rumple_preset(preset=preset)
                self.assertAlmostEqual(settings.wavelength, width * chosen, 8)
            self.assertEqual(settings.wavelength, chosen)

    def test_fabrics_of_paths_scale_how_far_the_threshold_is_above_1_and_the_way_back_is_exact(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        settings = obj.rumple.paths
        settings.property_unset("base_cloth")
        with sleeve.context():
            bpy.ops.object.rumple_add(method="PATHS")
        self.assertEqual(settings.base_cloth, "HANG")
        self.assertEqual(settings.threshold, np.float32(1.1))  # of the first click on what hangs
        for chosen, silk, leather in ((1.1, 1.072, 1.128), (1.25, 1.18, 1.32), (1.4321, 1.311112, 1.553088)):
            settings.threshold = chosen
            for preset, threshold in (("SILK", silk), ("SILK", silk), ("WOOL", chosen), ("LEATHER", leather),
                                      ("COTTON", chosen)):
                bpy.ops.object.rumple_preset(preset=preset)
                self.assertEqual(settings.threshold, np.float32(threshold), preset)

    def test_a_threshold_that_is_typed_in_silk_is_that_of_silk(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        with sleeve.context():
            bpy.ops.object.rumple_add(method="PATHS")
        bpy.ops.object.rumple_preset(preset="SILK")
        obj.rumple.paths.threshold = 1.36
        bpy.ops.object.rumple_preset(preset="COTTON")
        self.assertEqual(obj.rumple.paths.threshold, np.float32(1.5))

    def test_the_preset_of_the_paper_brings_back_what_it_replaced(self) -> None:
        obj = sleeve.scene()
        settings = obj.rumple.mesh
        settings.base_cloth, settings.layers, settings.display_steps = "HANG", "CLOTH", 2
        before = properties.settings_of(obj, bpy.context.scene)
        for preset in ("PAPER", "PAPER", "DENIM", "COTTON"):
            bpy.ops.object.rumple_preset(preset=preset)
            paper = preset == "PAPER"
            self.assertEqual((settings.layers, settings.display_steps), ("ONE", 0) if paper else ("CLOTH", 2), preset)
        self.assertEqual(properties.settings_of(obj, bpy.context.scene), before)

    def test_stretch_stays_on_the_body_and_the_next_preset_brings_back_the_room(self) -> None:
        obj = sleeve.scene()
        settings = obj.rumple.mesh
        bpy.context.scene.unit_settings.scale_length = 0.01  # lengths of presets are in metres
        settings.room, settings.slide_room = 2.5, 12.0
        bpy.ops.object.rumple_preset(preset="COTTON")
        before, farthest = properties.settings_of(obj, bpy.context.scene), [self.farthest(obj)]
        for preset in ("STRETCH", "STRETCH", "SILK", "COTTON"):
            bpy.ops.object.rumple_preset(preset=preset)
            is_tight = preset == "STRETCH"
            self.assertAlmostEqual(settings.room, 0.8 if is_tight else 2.5, 5, preset)
            self.assertAlmostEqual(settings.slide_room, 2.0 if is_tight else 12.0, 5, preset)
            farthest.append(self.farthest(obj))
        self.assertEqual(properties.settings_of(obj, bpy.context.scene), before)
        self.assertLess(farthest[1], 0.8 * farthest[0])

    def farthest(self, obj: bpy.types.Object) -> float:
        sleeve.at(15)
        return float(np.linalg.norm(runtimes.of(obj).result.offset, axis=1).max())

    def clicked_trousers(self, deleted_below: float) -> bpy.types.Object:
        """Those of the demo after the first click. deleted_below: metres, up to which the figure has no faces."""
        import demo_scene
        build = demo_scene.demo_body.build_body

        def build_upper(_spacing: float) -> tuple[np.ndarray, np.ndarray]:
            points, quads = build(0.02)
            return points, quads[points[quads][:, :, 2].mean(1) > deleted_below]

        with sleeve.context(), mock.patch.object(demo_scene.demo_body, "build_body", build_upper):
            demo_scene.build_demo_scene()
            obj = bpy.data.objects["Trousers"]
            sleeve.make_active(obj)
            bpy.ops.object.rumple_add(method="MESH")
        return obj

    def test_trousers_over_a_whole_body_are_as_wide_as_they_are_modelled(self) -> None:
        """A simulation of these has smooth legs too while the figure stands."""
        obj = self.clicked_trousers(0.0)
        self.assertEqual(obj.rumple.mesh.slack, np.float32(1.02))
        for preset, slack in (("COTTON", 1.02), ("DENIM", 1.05), ("COTTON", 1.02)):
            bpy.ops.object.rumple_preset(preset=preset)
            self.assertEqual(obj.rumple.mesh.slack, np.float32(slack), preset)

    def test_others_are_cut_wider_in_cotton_and_as_their_fabric_says_in_others(self) -> None:
        """While the figure stood, trousers were smooth tubes. Cotton is as the first click leaves them."""
        obj = self.clicked_trousers(0.95)
        self.assertEqual(obj.rumple.mesh.slack, np.float32(1.05))
        for preset, slack in (("SUIT", 1.02), ("DENIM", 1.05), ("STRETCH", 0.95), ("COTTON", 1.05), ("PAPER", 1.05)):
            bpy.ops.object.rumple_preset(preset=preset)
            self.assertEqual(obj.rumple.mesh.slack, np.float32(slack), preset)
        obj.rumple.mesh.slack = 1.03
        bpy.ops.object.rumple_remove()
        bpy.ops.object.rumple_add(method="MESH")
        self.assertEqual(obj.rumple.mesh.slack, np.float32(1.03))  # what the artist has set stays

    def test_presets_of_a_file_from_before_fabrics_had_weights_are_taken_back(self) -> None:
        for preset, width in (("DENIM", 2.0), ("LEATHER", 2.0), ("SILK", 1.0), ("PAPER", 1.0)):
            obj = sleeve.scene()
            settings = obj.rumple.mesh
            settings["preset"] = MESH_PRESETS[preset].number  # as files have it
            settings.wavelength = width * 0.04
            if preset == "PAPER":
                settings.attachment, settings.hem_rings, settings.collision = "PN", 0, "NONE"
            bpy.ops.object.rumple_preset(preset="COTTON")
            self.assertAlmostEqual(settings.wavelength, 0.04, 6, preset)
            self.assertEqual((settings.attachment, settings.hem_rings, settings.collision), ("LIMIT", 3, "PLANE"))

    def test_a_preset_scales_a_length_that_was_never_set_in_a_scene_in_centimetres(self) -> None:
        obj = sleeve.scene()
        bpy.context.scene.unit_settings.scale_length = 0.01
        obj.rumple.mesh.property_unset("wavelength")
        before = properties.settings_of(obj, bpy.context.scene).wavelength
        bpy.ops.object.rumple_preset(preset="DENIM")
        self.assertAlmostEqual(properties.settings_of(obj, bpy.context.scene).wavelength, 1.35 * before, 6)

    def test_a_length_beyond_its_range_is_taken_at_its_end(self) -> None:
        obj = sleeve.scene()
        for scale in (1.0, 0.001):
            bpy.context.scene.unit_settings.scale_length = scale
            for value, taken in ((0.0, 0.005), (1e6, 1.0)):
                obj.rumple.mesh.bending_length = value
                self.assertEqual(properties.settings_of(obj, bpy.context.scene).bending_length, taken)
