# SPDX-License-Identifier: GPL-3.0-or-later
"""Laws of what is painted Rigid: it has the shape of the coarse mesh in the pose, and moves as one on a base cloth."""
from __future__ import annotations

import unittest
from dataclasses import replace
from typing import Any

import numpy as np
from rumple.core.mesh.base_mesh import BaseMesh
from rumple.core.paint.painted_rigid import RIGID, patches_of, wholly_painted
from rumple.core.settings.system_settings import FieldSettings, MeshSettings, PathsSettings
from rumple.core.systems.wrinkle_field import WEIGHT, WrinkleField
from rumple.core.systems.wrinkle_mesh import WrinkleMesh
from rumple.core.systems.wrinkle_paths import WrinklePaths
from support.frames import solve_frame
from support.meshes import compressed, quad_mesh, rotated, sheet, tube

WIDTH = 0.03  # of folds, metres
BARE = {
    "one layer": (WrinkleMesh, MeshSettings(density="LEVEL", level=2)),
    "layers": (WrinkleMesh, MeshSettings(wavelength=WIDTH, layers="CLOTH")),
    "waves": (WrinkleField, FieldSettings(output="GEOMETRY", wavelength=WIDTH)),
    "paths": (WrinklePaths, PathsSettings(width=WIDTH, threshold=1.02)),
}
ON_CLOTH = {
    "one layer on cloth": (WrinkleMesh, MeshSettings(density="LEVEL", level=2, base_cloth="HANG")),
    "layers on cloth": (WrinkleMesh, MeshSettings(wavelength=WIDTH, layers="CLOTH", base_cloth="HANG")),
    "waves on cloth": (WrinkleField, FieldSettings(output="GEOMETRY", wavelength=WIDTH, base_cloth="HANG")),
    "shaded waves on cloth": (WrinkleField, FieldSettings(wavelength=WIDTH, base_cloth="HANG")),
    "paths on cloth": (WrinklePaths, PathsSettings(width=WIDTH, base_cloth="HANG")),
}


def bands(base: BaseMesh) -> np.ndarray:
    """Painted 1 on two patches of a tube, soft at their sides."""
    x, _, z = base.positions.T
    height = np.clip(2.5 - np.abs(z - 0.3) / 0.025, 0.0, 1.0)
    return (height * np.clip(np.abs(x) / 0.02 - 0.75, 0.0, 1.0)).astype(np.float32)


def flat(mesh: Any, positions: np.ndarray) -> np.ndarray:
    """(d, 3): the shown vertices on the flat triangles of the coarse mesh."""
    weights = np.column_stack([1.0 - mesh.barycentric.sum(1), mesh.barycentric])
    return (weights[:, :, None] * positions[mesh.triangle_vertex]).sum(1)


def whole(mesh: Any, rigid: np.ndarray) -> np.ndarray:
    """(d,) bool: shown vertices in faces that are painted 1."""
    return (rigid[mesh.triangle_vertex] == 1.0).all(1)


def distances(points: np.ndarray) -> np.ndarray:
    return np.linalg.norm(points[:, None].astype(np.float64) - points[None], axis=2)


class PaintedRigid(unittest.TestCase):
    def setUp(self) -> None:
        self.base = tube(24, 24, 0.05, 0.6)
        self.rigid = bands(self.base)
        self.poses = [compressed(self.base.positions, 1.04 - 0.04 * frame) for frame in range(1, 7)]

    def play(self, system: Any, settings: Any, paint: dict[str, np.ndarray], turn: float = 0.0,
             **more: Any) -> tuple[Any, Any]:
        """What is solved, and the last of some frames."""
        mesh = system.build(self.base, settings, **more)
        world = np.linalg.inv(rotated(np.eye(3), turn) - rotated(np.zeros((3, 3)), turn)).T
        for number, pose in enumerate(self.poses):
            pose = rotated(pose, turn) if turn else pose
            result = solve_frame(mesh, 1.0 + number, pose, settings, paint, start=1,
                                 in_viewport="viewport_steps" in more,
                                 world_from_object=np.ascontiguousarray(world, np.float32))
        return mesh, result

    def test_it_has_the_shape_of_the_coarse_mesh_in_the_pose(self) -> None:
        for name, (system, settings) in BARE.items():
            with self.subTest(name):
                mesh, result = self.play(system, settings, {RIGID: self.rigid})
                inside = whole(mesh, self.rigid)
                self.assertGreater(int(inside.sum()), 100)
                away = np.linalg.norm(result.positions - flat(mesh, self.poses[-1]), axis=1)
                self.assertLess(away[inside].max(), 1e-7)
                self.assertLess(np.linalg.norm(result.offset[inside], axis=1).max(), 1e-7)
                self.assertGreater(away[~inside].max(), 0.002)

    def test_cloth_beside_it_has_the_same_folds(self) -> None:
        for name in ("one layer", "layers", "paths"):
            with self.subTest(name):
                (mesh, bare), (_, kept) = (self.play(*BARE[name], paint) for paint in ({}, {RIGID: self.rigid}))
                beside = (self.rigid[mesh.triangle_vertex] == 0.0).all(1)
                np.testing.assert_array_equal(kept.positions[beside], bare.positions[beside])

    def test_between_it_is_mixed_by_its_weight(self) -> None:
        half = np.full(len(self.base.positions), 0.25, np.float32)
        for name in ("one layer", "layers", "paths"):
            with self.subTest(name):
                (mesh, bare), (_, kept) = (self.play(*BARE[name], paint) for paint in ({}, {RIGID: half}))
                expected = 0.75 * bare.positions + 0.25 * flat(mesh, self.poses[-1])
                np.testing.assert_allclose(kept.positions, expected, atol=1e-7)
                np.testing.assert_allclose(kept.offset, 0.75 * bare.offset, atol=1e-7)

    def test_on_cloth_every_patch_moves_as_one(self) -> None:
        for name, (system, settings) in ON_CLOTH.items():
            with self.subTest(name):
                mesh, result = self.play(system, settings, {RIGID: self.rigid})
                modelled = flat(mesh, self.poses[-1])
                for side in (-1.0, 1.0):
                    inside = np.flatnonzero(whole(mesh, self.rigid) & (side * mesh.positions_rest[:, 0] > 0.0))
                    self.assertGreater(len(inside), 8)
                    inside = inside[::1 + len(inside) // 50]
                    np.testing.assert_allclose(distances(result.positions[inside]), distances(modelled[inside]),
                                               atol=1e-6)
                    self.assertGreater(np.linalg.norm((result.positions - modelled)[inside], axis=1).min(), 1e-4)
                cloth = mesh.solved_over(6.0, self.poses[-1])
                if len(cloth) < len(self.base.positions):
                    continue  # of the coarse mesh in its place
                at = whole(mesh, self.rigid) & (mesh.positions_rest[:, 0] > 0.0)
                apart = flat(mesh, cloth)[at].mean(0) - result.positions[at].mean(0)
                self.assertLess(np.linalg.norm(apart), 0.002)

    def test_painted_with_nothing_it_changes_nothing(self) -> None:
        nothing = np.zeros(len(self.base.positions), np.float32)
        for name, (system, settings) in {**BARE, **ON_CLOTH}.items():
            with self.subTest(name):
                (_, bare), (_, kept) = (self.play(system, settings, paint) for paint in ({}, {RIGID: nothing}))
                np.testing.assert_array_equal(kept.positions, bare.positions)
                np.testing.assert_array_equal(kept.local_offset, bare.local_offset)

    def test_what_is_written_embeds_where_the_picture_is(self) -> None:
        """local_offset, which the node group shows, says the same as positions."""
        for name in ("layers on cloth", "waves on cloth"):
            with self.subTest(name):
                mesh, kept = self.play(*ON_CLOTH[name], {RIGID: self.rigid})
                corners = self.poses[-1][mesh.triangle_vertex]
                tangent = corners[:, 1] - corners[:, 0]
                normal = np.cross(tangent, corners[:, 2] - corners[:, 0])
                tangent, normal = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (tangent, normal))
                axes = np.stack([tangent, np.cross(normal, tangent), normal], axis=1)
                at = flat(mesh, self.poses[-1]) + np.einsum("mji,mj->mi", axes, kept.local_offset)
                np.testing.assert_allclose(at, kept.positions, atol=1e-6)

    def test_rigid_motion_carries_it_along(self) -> None:
        """The last pose alone: a round tube that is pressed together step by step has more than one answer, and
        roundings choose."""
        self.poses = self.poses[-1:]
        for name, (system, settings) in {**BARE, **ON_CLOTH}.items():
            with self.subTest(name):
                (mesh, still), (_, turned) = (self.play(system, settings, {RIGID: self.rigid}, turn)
                                              for turn in (0.0, 40.0))
                inside = whole(mesh, self.rigid)
                np.testing.assert_allclose(turned.positions[inside], rotated(still.positions, 40.0)[inside],
                                           atol=4e-6)

    def test_at_rest_it_is_as_it_was_modelled(self) -> None:
        for name, (system, settings) in BARE.items():
            with self.subTest(name):
                self.poses = [self.base.positions]
                mesh, result = self.play(system, settings, {RIGID: self.rigid})
                inside = whole(mesh, self.rigid)
                np.testing.assert_allclose(result.positions[inside], flat(mesh, self.base.positions)[inside],
                                           atol=1e-7)

    def test_viewports_show_the_same(self) -> None:
        mesh, kept = self.play(*BARE["layers"], {RIGID: self.rigid}, viewport_steps=0)
        self.assertEqual(len(kept.positions), mesh.in_viewport.vertex_count)
        inside = whole(mesh.in_viewport, self.rigid)
        away = np.linalg.norm(kept.positions - flat(mesh.in_viewport, self.poses[-1]), axis=1)
        self.assertLess(away[inside].max(), 1e-7)

    def test_shaded_waves_have_none(self) -> None:
        mesh, kept = self.play(WrinkleField, FieldSettings(wavelength=WIDTH), {RIGID: self.rigid})
        inside = self.rigid[mesh.corner_vertex] == 1.0
        self.assertEqual(np.abs(kept.attributes[WEIGHT][inside]).max(), 0.0)
        self.assertGreater(np.abs(kept.attributes[WEIGHT]).max(), 0.0)

    def test_heights_of_paths_are_none(self) -> None:
        mesh, kept = self.play(*BARE["paths"], {RIGID: self.rigid})
        self.assertLess(np.abs(kept.attributes["rumple_height"][whole(mesh, self.rigid)]).max(), 1e-8)
        self.assertGreater(np.abs(kept.attributes["rumple_height"]).max(), 0.0)

    def test_a_dense_garment_that_is_solved_on_a_coarse_one(self) -> None:
        self.base = tube(96, 96, 0.1, 0.6)
        self.rigid = bands(self.base)
        self.poses = [compressed(self.base.positions, 1.0 - 0.03 * frame) for frame in range(3)]
        mesh, result = self.play(WrinkleMesh, replace(ON_CLOTH["layers on cloth"][1], wavelength=0.06),
                                 {RIGID: self.rigid})
        self.assertIsNotNone(mesh.coarse)
        modelled = flat(mesh, self.poses[-1])
        for side in (-1.0, 1.0):
            inside = np.flatnonzero(whole(mesh, self.rigid) & (side * mesh.positions_rest[:, 0] > 0.0))[::7]
            np.testing.assert_allclose(distances(result.positions[inside]), distances(modelled[inside]), atol=1e-6)

    def test_a_custom_mesh_keeps_what_it_has_over_the_coarse_one(self) -> None:
        own = tube(72, 72, 0.055, 0.6)
        own.positions[:, :2] *= (1.0 + 0.03 * np.sin(60.0 * own.positions[:, 2]))[:, None].astype(np.float32)
        settings = MeshSettings(source="OBJECT", display_steps=0)
        self.poses = [self.base.positions]
        mesh, result = self.play(WrinkleMesh, settings, {RIGID: self.rigid}, own=own)
        inside = whole(mesh, self.rigid)
        np.testing.assert_allclose(result.positions[inside], own.positions[inside], atol=1e-6)
        self.poses = [rotated(self.base.positions, 25.0)]
        _, turned = self.play(WrinkleMesh, settings, {RIGID: self.rigid}, own=own)
        np.testing.assert_allclose(turned.positions[inside], rotated(own.positions, 25.0)[inside], atol=2e-6)

    def test_an_attribute_may_hold_anything(self) -> None:
        odd = self.rigid.copy()
        odd[:3] = np.nan, -7.0, np.inf
        _, result = self.play(*BARE["one layer"], {RIGID: odd})
        self.assertTrue(np.isfinite(result.positions).all())


class Patches(unittest.TestCase):
    """Of a row of nine quads: vertices 0 to 9 below, 10 to 19 above."""

    def patches(self, weights: list[float]) -> list[int]:
        return patches_of(np.array(2 * weights, np.float32), sheet(9, 1)).tolist()[:10]

    def test_what_is_connected_and_painted_is_one(self) -> None:
        self.assertEqual(self.patches([0, 1, 1, 0, 0, 0, 1, 1, 0, 0]), [-1, 0, 0, -1, -1, -1, 1, 1, -1, -1])

    def test_pale_vertices_belong_to_the_nearest(self) -> None:
        self.assertEqual(self.patches([1, .4, .1, .1, .1, .1, .1, .1, .4, 1]), [0, 0, 0, 0, 0, 1, 1, 1, 1, 1])

    def test_what_is_pale_all_over_is_one_as_well(self) -> None:
        self.assertEqual(self.patches([.2, .2, 0, 0, 1, 1, 0, .3, .1, 0]), [0, 0, -1, -1, 1, 1, -1, 2, 2, -1])

    def test_seams_join_them(self) -> None:
        row = sheet(9, 1)
        quads = row.corner_vertex.reshape(-1, 4)
        split = quad_mesh("Split", row.positions[quads.ravel()], np.arange(36).reshape(-1, 4))
        weights = (row.positions[quads.ravel(), 0] < 0.5).astype(np.float32)
        found = patches_of(weights, split)
        self.assertEqual(set(found.tolist()), {-1, 0})
        np.testing.assert_array_equal(found == 0, weights == 1.0)

    def test_without_paint_there_is_none(self) -> None:
        self.assertEqual(self.patches([0.0] * 10), [-1] * 10)


class LooseParts(unittest.TestCase):
    """A large loose part that is painted all over is no cloth at all."""

    def setUp(self) -> None:
        garment, belt = tube(24, 24), tube(24, 2, 0.055, 0.02)
        belt.positions[:, 2] += np.float32(0.14)
        self.belt = np.arange(len(garment.positions), len(garment.positions) + len(belt.positions))
        quads = np.concatenate([garment.corner_vertex.reshape(-1, 4),
                                belt.corner_vertex.reshape(-1, 4) + len(garment.positions)])
        self.base = quad_mesh("Worn", np.concatenate([garment.positions, belt.positions]), quads)
        self.weights = np.zeros(len(self.base.positions), np.float32)

    def built(self, small: bool = True) -> Any:
        self.base.painted_rigid = wholly_painted(self.base, self.weights)
        return WrinkleMesh.build(self.base, MeshSettings(density="LEVEL", level=1, rigid_parts=small))

    def test_it_is_shown_as_it_was_modelled(self) -> None:
        self.assertIsNone(self.built().base.rigid)
        self.weights[self.belt] = 1.0
        for small in (True, False):
            mesh = self.built(small)
            np.testing.assert_array_equal(np.sort(mesh.base.rigid.vertex), self.belt)
            np.testing.assert_array_equal(mesh.positions_rest[-len(self.belt):], self.base.positions[self.belt])
        pose = compressed(self.base.positions, 0.9)
        result = solve_frame(mesh, 1.0, pose, MeshSettings(density="LEVEL", level=1), {RIGID: self.weights}, start=1)
        self.assertEqual(len(result.positions), mesh.vertex_count)

    def test_painted_in_part_it_is_cloth(self) -> None:
        self.weights[self.belt[1:]] = 1.0
        self.assertIsNone(wholly_painted(self.base, self.weights))
        self.assertIsNone(self.built().base.rigid)

    def test_cloth_is_left_where_all_is_painted(self) -> None:
        self.weights[:] = 1.0
        mesh = self.built()
        self.assertIsNone(mesh.base.rigid)
        settings = MeshSettings(density="LEVEL", level=1)
        pose = compressed(self.base.positions, 0.9)
        result = solve_frame(mesh, 1.0, pose, settings, {RIGID: self.weights}, start=1)
        np.testing.assert_allclose(result.positions, flat(mesh, pose), atol=1e-7)


if __name__ == "__main__":
    unittest.main()
