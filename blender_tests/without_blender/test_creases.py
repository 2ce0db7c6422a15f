# SPDX-License-Identifier: GPL-3.0-or-later
"""Creases of the coarse mesh in every fine mesh: edges that stay, at rest and in motion."""
from __future__ import annotations

import unittest
from dataclasses import replace
from typing import Any

import numpy as np
from rumple.core.mesh.base_mesh import BaseMesh
from rumple.core.settings.system_settings import FieldSettings, MeshSettings, PathsSettings
from rumple.core.systems.wrinkle_field import WrinkleField
from rumple.core.systems.wrinkle_mesh import WrinkleMesh
from rumple.core.systems.wrinkle_paths import WrinklePaths
from support.frames import solve_frame
from support.meshes import quad_mesh, rotated, tube

SYSTEMS: dict[str, tuple[Any, Any]] = {
    "subdivided": (WrinkleMesh, MeshSettings(density="LEVEL", level=2)),
    "regular": (WrinkleMesh, MeshSettings(source="REGULAR", segments=3)),
    "longest edge": (WrinkleMesh, MeshSettings(source="EDGE_LENGTH", edge_length=0.05)),
    "layers": (WrinkleMesh, MeshSettings(density="LEVEL", level=2, layers="CLOTH")),
    "waves": (WrinkleField, FieldSettings(output="GEOMETRY", wavelength=0.1)),
    "paths": (WrinklePaths, PathsSettings(width=0.05)),
    "paths on bisected triangles": (WrinklePaths, PathsSettings(width=0.05, source="EDGE_LENGTH")),
}
SIDE = 0.2
ROUNDING = 1e-5  # a wave is as high as the root of what its cloth is squeezed by: a rounding of that is seen


def box(sharpness: float) -> BaseMesh:
    """A cube with its middle at the origin; all of its edges are creased."""
    corners = np.array([(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], np.float32)
    quads = np.array([(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)])
    mesh = quad_mesh("Box", 0.5 * SIDE * corners, quads)
    mesh.crease_edge = np.ascontiguousarray(mesh.sides(), np.int32)
    mesh.crease_sharpness = np.full(len(mesh.crease_edge), sharpness, np.float32)
    return mesh


def from_box(points: np.ndarray) -> float:
    """How far the farthest point is from the surface of the cube."""
    return float(np.abs(np.abs(points).max(1) - 0.5 * SIDE).max())


class Creases(unittest.TestCase):
    def frame(self, base: BaseMesh, system: Any, settings: Any, positions: np.ndarray) -> tuple[Any, Any]:
        mesh = system.build(base, settings)
        return mesh, solve_frame(mesh, 1.0, np.ascontiguousarray(positions, np.float32), settings, {}, start=1)

    def test_a_box_of_sharp_edges_stays_the_box(self) -> None:
        for name, (system, settings) in SYSTEMS.items():
            with self.subTest(name):
                base = box(10.0)
                mesh, result = self.frame(base, system, settings, base.positions)
                self.assertLess(from_box(mesh.positions_rest), 1e-7)
                self.assertLess(from_box(result.positions), ROUNDING)
                round_mesh, _ = self.frame(box(0.0), system, settings, base.positions)
                self.assertGreater(from_box(round_mesh.positions_rest), 0.1 * SIDE)

    def test_rest_and_rigid_motions_change_nothing(self) -> None:
        for name, (system, settings) in SYSTEMS.items():
            for sharpness in (2.5, 10.0):
                with self.subTest(name, sharpness=sharpness):
                    base = box(sharpness)
                    mesh, still = self.frame(base, system, settings, base.positions)
                    np.testing.assert_allclose(still.positions, mesh.positions_rest, atol=ROUNDING)
                    _, turned = self.frame(base, system, settings, rotated(base.positions, 70.0))
                    np.testing.assert_allclose(turned.positions, rotated(mesh.positions_rest, 70.0), atol=2 * ROUNDING)

    def test_a_mesh_without_creases_has_the_same_bits_as_one_of_sharpness_zero(self) -> None:
        for name, (system, settings) in SYSTEMS.items():
            with self.subTest(name):
                bare, none = box(0.0), box(0.0)
                bare.crease_edge = bare.crease_sharpness = None
                pose = bare.positions * np.float32([1.0, 0.8, 1.0])
                (_, one), (_, other) = (self.frame(mesh, system, settings, pose) for mesh in (bare, none))
                np.testing.assert_array_equal(one.positions, other.positions)

    def test_healing_keeps_them(self) -> None:
        base = box(10.0)
        quads = base.corner_vertex.reshape(-1, 4).copy()
        quads[2] = quads[2][::-1]  # one face is wound the other way
        doubled = quad_mesh("Box", base.positions, np.concatenate([quads, quads[:1]]))
        doubled.crease_edge, doubled.crease_sharpness = base.crease_edge, base.crease_sharpness
        healed = doubled.healed(True)
        self.assertIsNotNone(healed.origin)
        mesh, result = self.frame(doubled, *SYSTEMS["subdivided"], doubled.positions)
        self.assertLess(from_box(result.positions), 1e-6)

    def test_healing_knows_which_edges(self) -> None:
        base = box(10.0)
        base.crease_edge = np.array([[4, 5], [7, 5], [0, 7]], np.int32)  # the last one is no edge
        base.crease_sharpness = np.array([1.0, 2.0, 3.0], np.float32)
        quads = base.corner_vertex.reshape(-1, 4).copy()
        quads[2] = quads[2][::-1]
        turned = quad_mesh("Box", base.positions, quads)
        turned.crease_edge, turned.crease_sharpness = base.crease_edge, base.crease_sharpness
        healed = turned.healed(True)
        assert healed.crease_edge is not None and healed.crease_sharpness is not None
        found = {(*sorted(edge), sharpness) for edge, sharpness in zip(healed.crease_edge.tolist(),
                                                                       healed.crease_sharpness.tolist())}
        self.assertEqual(found, {(4, 5, 1.0), (5, 7, 2.0)})

    def test_a_dense_mesh_that_is_solved_on_a_coarse_one_keeps_them(self) -> None:
        base = tube(64, 64, 0.2, 0.6)
        ring = np.arange(32 * 64, 33 * 64, dtype=np.int32)
        base.positions[ring, :2] *= np.float32(1.05)  # a rim
        settings = MeshSettings(wavelength=0.02, layers="CLOTH", base_cloth="HANG", display_steps=1)
        rims = {}
        for sharpness in (0.0, 10.0):
            base.crease_edge = np.ascontiguousarray(np.stack([ring, np.roll(ring, -1)], 1))
            base.crease_sharpness = np.full(64, sharpness, np.float32)
            mesh = WrinkleMesh.build(base, settings)
            self.assertIsNotNone(mesh.coarse)
            rims[sharpness] = np.linalg.norm(mesh.positions_rest[:, :2], axis=1).max()
        self.assertGreater(rims[10.0], rims[0.0] + 0.001)

    def test_their_unsolved_subdivisions_keep_them(self) -> None:
        base = box(10.0)
        for steps in (0, 1, 2):
            settings = replace(SYSTEMS["subdivided"][1], level=1, display_steps=steps)
            _, result = self.frame(base, WrinkleMesh, settings, base.positions)
            self.assertLess(from_box(result.positions), 1e-6)


if __name__ == "__main__":
    unittest.main()
