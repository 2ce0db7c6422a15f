# SPDX-License-Identifier: GPL-3.0-or-later
"""Laws of fabrics: what their weight and bending length do to the base cloth and to the layers on it."""
from __future__ import annotations

import unittest
from dataclasses import replace

import numpy as np
from rumple.core.cloth.base_cloth import BaseCloth, ClothInput, stiffness_over_cotton
from rumple.core.cloth.layers import FINEST_HEM, layer_settings
from rumple.core.settings.cloth_settings import ClothSettings
from rumple.core.settings.fabrics import COTTON, FABRICS, GRAVITY
from rumple.core.settings.presets import MESH_PRESETS, PATHS_PRESETS
from rumple.core.settings.system_settings import MeshSettings
from rumple.core.systems.fold_density import halvings, layers_for, level_for, suggested_wavelength, wavelength_of
from rumple.core.systems.wrinkle_mesh import WrinkleMesh
from support.frames import solve_frame
from support.meshes import compressed, tube

CLOTH = MeshSettings(base_cloth="HANG", layers="CLOTH", room=0.02, thickness=0.002, hem_rings=0)


class Fabrics(unittest.TestCase):
    def test_the_bending_length_is_that_of_peirce(self) -> None:
        for name, fabric in FABRICS.items():
            self.assertAlmostEqual(fabric.bending_length ** 3 * fabric.mass * GRAVITY, fabric.rigidity, 12, name)

    def test_cotton_is_what_nobody_chose(self) -> None:
        settings = ClothSettings()
        for name, value in COTTON.values.items():
            self.assertEqual(getattr(settings, name), value, name)
        self.assertEqual(stiffness_over_cotton(settings.bending_length), 1.0)

    def test_a_preset_has_the_weight_of_its_fabric(self) -> None:
        for presets in (MESH_PRESETS, PATHS_PRESETS):
            for name in FABRICS.keys() & presets.keys():
                self.assertLessEqual(FABRICS[name].values.items(), presets[name].values.items(), name)

    def test_files_know_presets_by_these_numbers(self) -> None:
        numbers = lambda presets: {key: preset.number for key, preset in presets.items()}
        self.assertEqual(numbers(MESH_PRESETS), dict(COTTON=0, DENIM=1, LEATHER=2, SILK=3, SKIN=4, PAPER=5, JERSEY=6,
                                                     WOOL=7, STRETCH=8, SUIT=9))
        self.assertEqual(numbers(PATHS_PRESETS), dict(COTTON=0, SILK=1, WOOL=2, LEATHER=3))

    def test_the_limpest_cloth_can_still_be_solved(self) -> None:
        for length in (1e-9, 0.005, 1.0):
            for layer in layer_settings(replace(CLOTH, slack=1.5, bending_length=length), 3):
                self.assertTrue(1.0 <= layer.prestretch <= 1.0 + 4.0 * 0.5 / 0.7 + 1e-6, length)

    def test_the_longer_it_bends_the_less_it_is_pushed_together(self) -> None:
        base = tube(16, 16)
        cloth = BaseCloth(base.surface(True), base.diagonal(), 1.0)
        squeezed = compressed(base.positions, 0.8)
        heights = [0.8 * float(np.ptp(base.positions[:, 2]))]
        for length in (0.001, 0.016, 0.022, 0.04, 0.2):
            settings = ClothSettings(base_cloth="HANG", gravity=0.0, slack=1.0, room=0.05, bending_length=length)
            paint = {"follow": np.zeros(len(squeezed), np.float32)}
            solved = cloth.solve(settings, paint, ClothInput(squeezed)).positions
            heights.append(float(np.ptp(solved[:, 2])))
        self.assertEqual(heights, sorted(heights))
        self.assertLess(heights[1], 1.002 * heights[0])
        self.assertGreater(heights[-1], 1.04 * heights[0])


class Wavelengths(unittest.TestCase):
    """Any wavelength may be asked for, though layers are halved from one to the next."""

    def setUp(self) -> None:
        self.base = tube(12, 12)

    def test_the_wavelength_asked_for_chooses_the_level(self) -> None:
        for level in range(4):
            self.assertEqual(level_for(self.base, wavelength_of(self.base, level, 1.0), 1.0), level)
        self.assertEqual(level_for(self.base, wavelength_of(self.base, 2, 0.01), 0.01), 2,
                         "in metres, whatever the scale is")

    def test_the_fitting_wavelength_suits_dolls_and_giants_and_spares_dense_meshes(self) -> None:
        for unit_scale in (0.05, 1.0, 20.0):
            self.assertEqual(level_for(self.base, suggested_wavelength(self.base, unit_scale), unit_scale), 2)
        dense = tube(160, 160)
        self.assertEqual(level_for(dense, suggested_wavelength(dense, 1.0), 1.0), 0)

    def test_there_is_more_of_the_finer_layers_the_shorter_the_wavelength(self) -> None:
        longest = wavelength_of(self.base, 0, 1.0)
        amounts = []
        for wavelength in np.geomspace(longest, longest / 31.0, 2000):
            level, share = layers_for(halvings(self.base.mean_edge(), float(wavelength)))
            self.assertTrue(0.0 < share <= 1.0)
            amounts.append(level - 1 + share)
        steps = np.diff(amounts)
        self.assertGreaterEqual(steps.min(), 0.0)
        self.assertLess(steps.max(), 0.004)  # no step: 4 / 3 a halving, of 2000 / 5
        self.assertEqual((round(amounts[0]), round(amounts[-1])), (0, 5))

    def test_at_the_wavelength_of_a_layer_it_is_the_last_and_whole(self) -> None:
        for level in range(6):
            count = halvings(self.base.mean_edge(), wavelength_of(self.base, level, 1.0))
            self.assertEqual(layers_for(count), (level, 1.0))

    def test_a_finer_layer_begins_with_nothing(self) -> None:
        squeezed = compressed(self.base.positions, 0.85)
        begins = wavelength_of(self.base, 1, 1.0) / 2.0**0.2501
        settings = replace(CLOTH, slack=1.05, wavelength=begins)
        self.assertAlmostEqual(halvings(self.base.mean_edge(), begins), 1.2501, 6)
        mesh = WrinkleMesh.build(self.base, settings)
        self.assertEqual(mesh.level, 2)
        shown = lambda values: solve_frame(mesh, 1.0, squeezed, replace(settings, **values), {}, start=1).positions
        np.testing.assert_allclose(shown({}), shown(dict(detail=0.0)), atol=1e-5)
        mesh.finest_share = 1.0
        self.assertGreater(np.abs(shown(dict(seed=1)) - shown(dict(detail=0.0))).max(), 1e-4)

    def test_what_a_layer_has_less_of_it_is_less_wider_by(self) -> None:
        whole, half = (layer_settings(replace(CLOTH, slack=1.05, detail=d, folds=d, drape=d), 3) for d in (1.0, 0.5))
        for a, b in zip(whole, half):
            self.assertAlmostEqual(b.radius, 0.5 * a.radius, 6)
            self.assertAlmostEqual(b.prestretch - 1.0, 0.5 * (a.prestretch - 1.0), 6)

    def test_stiff_cloth_is_wider_in_its_widest_folds_alone(self) -> None:
        cotton, stiff = (layer_settings(replace(CLOTH, slack=1.05, bending_length=c), 3) for c in (0.022, 0.044))
        self.assertEqual(stiff[0].prestretch, cotton[0].prestretch)
        for a, b in zip(cotton[1:], stiff[1:]):
            self.assertAlmostEqual(b.prestretch - 1.0, 0.5 * (a.prestretch - 1.0), 6)

    def test_a_layer_is_the_finest_as_long_as_the_next_is_not_there(self) -> None:
        settings = replace(CLOTH, slack=1.05)
        two, begun = layer_settings(settings, 2), layer_settings(settings, 3, finest=0.0)
        for a, b in zip(two, begun):
            self.assertAlmostEqual(a.prestretch, b.prestretch, 6)
            self.assertEqual((a.compression_limit, a.iterations), (b.compression_limit, b.iterations))
        self.assertEqual(begun[2].prestretch, settings.prestretch)

    def test_wider_layers_gather_less_and_none_more_than_is_set(self) -> None:
        limits = lambda **values: [layer.compression_limit for layer in layer_settings(replace(CLOTH, **values), 4)]
        drape, wide, folds, detail = limits()
        self.assertTrue(1.0 < drape == wide == folds < detail)
        self.assertAlmostEqual(detail, CLOTH.compression_limit, 6)
        for layer in layer_settings(replace(CLOTH, slack=1.1), 4)[:-1]:  # a skirt
            self.assertEqual(layer.compression_limit, layer.prestretch)
        for limit in limits(compression_limit=1.02):
            self.assertAlmostEqual(limit, 1.02, 6)
        for limit in limits(base_cloth="OFF"):
            self.assertEqual(limit, detail)

    def test_wide_layers_alone_gather_less_where_cloth_touches_a_body(self) -> None:
        *wide, detail = (layer.contact_gather for layer in layer_settings(CLOTH, 4))
        self.assertEqual((set(wide), detail), ({wide[0]}, 1.0))
        self.assertTrue(0.2 < wide[0] < 0.5)
        begun = [layer.contact_gather for layer in layer_settings(CLOTH, 3, finest=0.5)]
        self.assertTrue(begun[0] < begun[1] < begun[2] == 1.0)  # the second one is half of a finest layer
        off = replace(CLOTH, base_cloth="OFF")
        self.assertEqual({layer.contact_gather for layer in layer_settings(off, 3)}, {1.0})

    def test_the_stiffer_the_cloth_the_more_its_wide_layers_gather(self) -> None:
        """Leather was bare: its fine layers give less, and its wide ones gave no more than cotton's."""
        limits = lambda length: [layer.compression_limit for layer in layer_settings(
            replace(CLOTH, slack=1.0, bending_length=length), 3)]
        cotton, silk, denim, leather, board = (limits(length) for length in (0.022, 0.016, 0.029, 0.04, 0.2))
        for other, length in ((silk, 16.0), (denim, 29.0)):
            self.assertAlmostEqual(other[0] - 1.0, (length / 22.0) ** 2 * (cotton[0] - 1.0), 5)
        self.assertEqual({silk[2], *leather, *board}, {cotton[2]})  # never more than is set

    def test_wider_layers_have_more_passes(self) -> None:
        self.assertEqual([layer.iterations for layer in layer_settings(replace(CLOTH, iterations=10), 3)], [60, 30, 10])
        self.assertEqual([layer.iterations for layer in layer_settings(CLOTH, 4, finer=1)][-2:], 2 * [CLOTH.iterations])

    def test_the_narrowest_folds_of_cloth_end_before_its_hems(self) -> None:
        rings = lambda settings: [layer.hem_rings for layer in layer_settings(settings, 3)]
        self.assertEqual(rings(CLOTH), [0, 0, FINEST_HEM])
        self.assertEqual(rings(replace(CLOTH, hem_rings=5)), [1, 2, 3])
        self.assertEqual(rings(replace(CLOTH, base_cloth="OFF")), [0, 0, 0])


if __name__ == "__main__":
    unittest.main()
