# SPDX-License-Identifier: GPL-3.0-or-later
"""Turning vectors term by term: what linear algebra says, and the same bits on every processor."""
from __future__ import annotations

import re
import unittest
from pathlib import Path

import numpy as np
from rumple.core.base import transforms

ADDON = Path(transforms.__file__).parents[2]
# What a frame is solved from goes through these.
SOLVED_FROM = ("core/base/triangles.py", "core/mesh/body.py", "core/mesh/rigid_parts.py", "core/paint/fold_guides.py",
               "core/cloth/base_cloth.py", "core/cloth/draped_cloth.py", "core/cloth/surroundings.py",
               "core/cloth/worn_at_rest.py", "blender/objects/bodies.py", "blender/objects/mesh_reader.py",
               "blender/objects/posed_coarse.py", "blender/objects/wind.py", "blender/objects/guide_curves.py",
               "blender/objects/bodies_at_rest.py")
LEFT_TO_LIBRARIES = r"[\w)\]] @ |linalg|np\.dot|einsum|matmul|np\.(cos|sin|tan|arc|hypot|exp|log)"


class Transforms(unittest.TestCase):

    def setUp(self) -> None:
        random = np.random.default_rng(4)
        self.matrix, self.other = random.normal(size=(2, 3, 3))
        self.points = random.normal(size=(50, 3))

    def test_it_is_linear_algebra(self) -> None:
        near = dict(rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(transforms.turned(self.matrix, self.points), self.points @ self.matrix.T, **near)
        np.testing.assert_allclose(transforms.product(self.matrix, self.other), self.matrix @ self.other, **near)
        np.testing.assert_allclose(transforms.inverse(self.matrix), np.linalg.inv(self.matrix), **near)
        self.assertAlmostEqual(transforms.determinant(self.matrix), np.linalg.det(self.matrix), 12)
        self.assertAlmostEqual(transforms.length(self.points[0]), np.linalg.norm(self.points[0]), 12)

    def test_principal_axes(self) -> None:
        """Of any symmetric matrices, of equal eigenvalues, zeros, and numbers at the ends of the range."""
        random = np.random.default_rng(4).normal(size=(200, 3, 3))
        matrices = random + random.transpose(0, 2, 1)
        matrices[:4] = np.zeros((3, 3)), np.diag([2.0, 1.0, 1.0]), np.ones((3, 3)), 1e-200 * matrices[3]
        matrices[4] *= 1e150
        values, axes = transforms.principal_axes(matrices)
        largest = np.maximum(np.abs(matrices).max(axis=(1, 2)), 1e-300)
        np.testing.assert_allclose(values / largest[:, None], np.linalg.eigvalsh(matrices) / largest[:, None],
                                   atol=1e-14)
        np.testing.assert_allclose((matrices @ axes - axes * values[:, None]) / largest[:, None, None], 0.0,
                                   atol=1e-14)
        np.testing.assert_allclose(axes.transpose(0, 2, 1) @ axes, np.tile(np.eye(3), (200, 1, 1)), atol=1e-14)

    def test_worked_by_hand(self) -> None:
        """A quarter turn about Z, twice as large, and mirrored: (1, 0, 0) goes to (0, 2, 0)."""
        matrix = np.array([[0.0, -2.0, 0.0, 5.0], [2.0, 0.0, 0.0, 6.0], [0.0, 0.0, -2.0, 7.0]])
        np.testing.assert_array_equal(transforms.placed(matrix, np.eye(3)[:1]), [[5.0, 8.0, 7.0]])
        self.assertEqual(transforms.determinant(matrix[:, :3]), -8.0)
        np.testing.assert_array_equal(transforms.inverse(matrix[:, :3]), [[0, 0.5, 0], [-0.5, 0, 0], [0, 0, -0.5]])

    def test_the_affine_map_between_points_is_found_where_most_were_moved_by_one(self) -> None:
        turn = np.array([[0.0, -2.0, 0.0, 5.0], [2.0, 0.0, 0.0, 6.0], [0.0, 0.0, -3.0, 7.0]])
        moved = transforms.placed(turn, self.points)
        np.testing.assert_allclose(transforms.affine_between(self.points, moved), turn, atol=1e-9)
        moved[:12] += 0.5  # edited since
        np.testing.assert_allclose(transforms.affine_between(self.points, moved), turn, atol=1e-9)
        for other in (self.points, self.points[::-1], np.full_like(moved, np.nan), self.points[:, ::-1] ** 2):
            self.assertIsNone(transforms.affine_between(self.points, other))
        self.assertIsNone(transforms.affine_between(self.points[:0], self.points[:0]))

    def test_a_plane_is_turned_and_scaled_as_a_solid(self) -> None:
        plane = self.points * (1.0, 1.0, 0.0)
        turn = 2.0 * np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
        found = transforms.affine_between(plane, plane @ turn.T + (1.0, 2.0, 3.0))
        np.testing.assert_allclose(found, np.concatenate([turn, [[1.0], [2.0], [3.0]]], 1), atol=1e-9)
        np.testing.assert_allclose(transforms.redirected(found, np.array([[0.0, 0.0, 0.3], [0.0, 0.0, 0.0]])),
                                   [[0.3, 0.0, 0.0], [0.0, 0.0, 0.0]], atol=1e-12)
        line = self.points * (1.0, 0.0, 0.0)
        np.testing.assert_allclose(transforms.affine_between(line, line + 1.0), np.eye(3, 4) + [[0, 0, 0, 1]] * 3,
                                   atol=1e-9)

    def test_the_scale_of_what_turns_and_scales_alone(self) -> None:
        turn, _ = np.linalg.qr(self.matrix)
        turn *= np.sign(np.linalg.det(turn))
        for scale in (100.0, 1.0, 0.01):
            self.assertAlmostEqual(transforms.scale_of(np.c_[scale * turn, self.points[0]]), scale, 9)
        for other in (-turn, turn * (1.0, 1.0, 1.01), turn + 0.1 * self.matrix, 0.0 * turn):
            self.assertIsNone(transforms.scale_of(np.c_[other, self.points[0]]))

    def test_single_precision_stays_single(self) -> None:
        matrix, points = self.matrix.astype(np.float32), self.points.astype(np.float32)
        found = transforms.turned(matrix, points)
        self.assertEqual(found.dtype, np.float32)
        exact = [[(p[0] * m[0] + p[1] * m[1]) + p[2] * m[2] for m in matrix] for p in points]  # each rounded
        np.testing.assert_array_equal(found, np.array(exact, np.float32))

    def test_nothing_that_frames_are_solved_from_is_left_to_a_library_for_matrices(self) -> None:
        """Machines of a farm agree to the bit: products of matrices and vectors of mathutils are Blender's own."""
        for name in SOLVED_FROM:
            for line in (ADDON / name).read_text(encoding="utf-8").splitlines():
                code = line.split("#")[0]
                if "matrix_world" in code or "matrix_basis" in code or "norm(" in code and "axis=1" in code:
                    continue
                self.assertIsNone(re.search(LEFT_TO_LIBRARIES, code), f"{name}: {line}")


if __name__ == "__main__":
    unittest.main()
