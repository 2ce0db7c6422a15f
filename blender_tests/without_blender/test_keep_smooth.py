# SPDX-License-Identifier: GPL-3.0-or-later
"""Keep Smooth, in every system alike: none of its folds where it is painted, all of them elsewhere."""
from __future__ import annotations

import unittest
from dataclasses import replace
from typing import Any

import numpy as np
from rumple.core.base.triangles import on_shown
from rumple.core.paint.keep_smooth import SMOOTH, share_of_folds
from rumple.core.settings.system_settings import FieldSettings, MeshSettings, PathsSettings
from rumple.core.systems.wrinkle_field import WEIGHT, WrinkleField
from rumple.core.systems.wrinkle_mesh import WrinkleMesh
from rumple.core.systems.wrinkle_paths import WrinklePaths
from support.frames import solve_frame
from support.meshes import compressed, tube

WIDTH = 0.03  # of folds, metres
SYSTEMS: dict[str, tuple[Any, Any]] = {
    "one layer": (WrinkleMesh, MeshSettings(density="LEVEL", level=2)),
    "layers": (WrinkleMesh, MeshSettings(wavelength=WIDTH, layers="CLOTH")),
    "layers on cloth": (WrinkleMesh, MeshSettings(wavelength=WIDTH, layers="CLOTH", base_cloth="HANG", hem_rings=0)),
    "waves": (WrinkleField, FieldSettings(output="GEOMETRY", wavelength=WIDTH)),
    "waves on drapes": (WrinkleField, FieldSettings(output="GEOMETRY", wavelength=WIDTH, base_cloth="HANG",
                                                    drape=1.0)),
    "paths": (WrinklePaths, PathsSettings(width=WIDTH, threshold=1.02)),
}
PAINTED, BARE = 0.15, 0.2  # of the tube's length: painted 1 below, 0 above


class KeepSmooth(unittest.TestCase):
    def setUp(self) -> None:
        self.base = tube(24, 24, 0.05, 0.6)
        self.smooth = np.clip((BARE - self.base.positions[:, 2]) / (BARE - PAINTED), 0.0, 1.0).astype(np.float32)

    def play(self, system: Any, settings: Any, paint: dict[str, np.ndarray], **more: Any) -> tuple[Any, Any]:
        """What is solved, and the last of some frames."""
        mesh = system.build(self.base, settings, **more)
        for frame in range(1, 7):
            result = solve_frame(mesh, float(frame), compressed(self.base.positions, 1.04 - 0.04 * frame), settings,
                                 paint, start=1, in_viewport="viewport_steps" in more)
        return mesh, result

    def test_no_fold_where_it_is_painted_and_the_same_folds_three_wavelengths_away(self) -> None:
        for name, (system, settings) in SYSTEMS.items():
            with self.subTest(name):
                (mesh, bare), (_, kept) = (self.play(system, settings, paint)
                                           for paint in ({}, {SMOOTH: self.smooth}))
                along = mesh.shown.positions_rest[:, 2]
                inside, far = along < PAINTED - 0.03, along > BARE + 3.0 * WIDTH
                self.assertGreater(np.linalg.norm(bare.offset[inside], axis=1).max(), 0.0015)
                self.assertLess(np.linalg.norm(kept.offset[inside], axis=1).max(), 1e-6)
                self.assertGreater(np.linalg.norm(bare.offset[far], axis=1).max(), 0.002)
                moved = np.linalg.norm(kept.positions - bare.positions, axis=1)[far]
                self.assertLess(np.percentile(moved, 99), 1e-4)

    def test_half_of_it_leaves_half_of_every_fold(self) -> None:
        for name in ("one layer", "layers", "waves", "paths"):
            with self.subTest(name):
                system, settings = SYSTEMS[name]
                if name == "waves":  # both set heights by how high the waves were
                    settings = replace(settings, keep_length=False, dissolve=False)
                half = np.full(len(self.base.positions), 0.5, np.float32)
                (_, bare), (_, kept) = (self.play(system, settings, paint) for paint in ({}, {SMOOTH: half}))
                name = "rumple_amplitude" if system is WrinkleField else "rumple_offset"
                whole = bare.attributes[name]
                self.assertGreater(np.abs(whole).max(), 0.001)
                self.assertLess(np.abs(kept.attributes[name] - 0.5 * whole).max(), 1e-6)

    def test_painted_with_nothing_it_changes_nothing(self) -> None:
        nothing = np.zeros(len(self.base.positions), np.float32)
        for name, (system, settings) in SYSTEMS.items():
            (_, bare), (_, kept) = (self.play(system, settings, paint) for paint in ({}, {SMOOTH: nothing}))
            np.testing.assert_array_equal(kept.positions, bare.positions, err_msg=name)

    def test_what_is_written_embeds_where_the_picture_is(self) -> None:
        """local_offset, which the node group shows, says the same as positions."""
        mesh, kept = self.play(*SYSTEMS["layers"], {SMOOTH: self.smooth})
        posed = compressed(self.base.positions, 0.8)
        corners = posed[mesh.triangle_vertex]
        weights = np.column_stack([1.0 - mesh.barycentric.sum(axis=1), mesh.barycentric])
        tangent = corners[:, 1] - corners[:, 0]
        normal = np.cross(tangent, corners[:, 2] - corners[:, 0])
        tangent, normal = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (tangent, normal))
        axes = np.stack([tangent, np.cross(normal, tangent), normal], axis=1)
        shown = np.einsum("mc,mci->mi", weights, corners) + np.einsum("mji,mj->mi", axes, kept.local_offset)
        np.testing.assert_allclose(shown, kept.positions, atol=1e-6)

    def test_viewports_show_the_same(self) -> None:
        mesh, kept = self.play(*SYSTEMS["layers"], {SMOOTH: self.smooth}, viewport_steps=0)
        self.assertEqual(len(kept.positions), mesh.in_viewport.vertex_count)
        inside = mesh.in_viewport.shown.positions_rest[:, 2] < PAINTED - 0.03
        self.assertLess(np.linalg.norm(kept.offset[inside], axis=1).max(), 1e-6)

    def test_shaded_waves_too(self) -> None:
        system, settings = WrinkleField, FieldSettings(wavelength=WIDTH)
        (mesh, bare), (_, kept) = (self.play(system, settings, paint) for paint in ({}, {SMOOTH: self.smooth}))
        inside = mesh.positions_rest[mesh.corner_vertex][:, 2] < PAINTED - 0.03
        self.assertGreater(np.abs(bare.attributes["rumple_amplitude"]).max(), 0.0)
        self.assertEqual(np.abs(kept.attributes["rumple_amplitude"][mesh.positions_rest[:, 2] < PAINTED - 0.03]).max(),
                         0.0)
        self.assertTrue(inside.any())
        self.assertEqual(np.abs(kept.attributes[WEIGHT][inside]).max(), 0.0)

    def test_an_attribute_with_anything_in_it_counts_from_0_to_1(self) -> None:
        values = np.array([-1.0, 0.25, 7.0, np.nan, np.inf], np.float32)
        np.testing.assert_array_equal(share_of_folds(values), np.array([1.0, 0.75, 0.0, 1.0, 0.0], np.float32))

    def test_it_fades_as_it_is_painted(self) -> None:
        mesh, _ = self.play(*SYSTEMS["one layer"], {})
        carried = on_shown(self.smooth, mesh.shown)
        along = mesh.shown.positions_rest[:, 2]
        expected = np.clip((BARE - along) / (BARE - PAINTED), 0.0, 1.0)
        self.assertLess(np.abs(carried - expected).max(), 0.15)  # linear between its vertices, 26 mm apart


if __name__ == "__main__":
    unittest.main()
