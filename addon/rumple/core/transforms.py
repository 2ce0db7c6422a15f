# SPDX-License-Identifier: GPL-3.0-or-later
"""Turning vectors by a matrix of three rows, term by term. NumPy leaves `@` and `linalg` to libraries that add in
another order, or round less often, on another processor: machines of a farm would not agree to the bit. Never imports
bpy."""
from __future__ import annotations

import math

import numpy as np

JACOBI_ROUNDS = 6


def turned(matrix: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """(n, 3) of (n, 3): each is M x. matrix: (3, 3)."""
    return vectors[:, :1] * matrix[:, 0] + vectors[:, 1:2] * matrix[:, 1] + vectors[:, 2:] * matrix[:, 2]


def turned_one(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """(3,): M x."""
    return turned(matrix, vector[None, :])[0]


def product(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """(3, 3)"""
    return turned(left, right.T).T


def placed(matrix: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(n, 3) points in the space that a matrix of four rows, or three, leads to."""
    return turned(matrix[:3, :3], points) + matrix[:3, 3]


def determinant(matrix: np.ndarray) -> float:
    """Of (3, 3)."""
    first = matrix[0].astype(np.float64).tolist()
    return sum(entry * cofactor for entry, cofactor in zip(first, _cofactors(matrix)[0]))


def inverse(matrix: np.ndarray) -> np.ndarray:
    """(3, 3) float64, of one whose determinant is not 0."""
    return (np.array(_cofactors(matrix)) / determinant(matrix)).T


def principal_axes(matrices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues, rising, and unit eigenvectors in columns, of symmetric matrices: (k, 3), (k, 3, 3) of (k, 3, 3).

    By the rotations of Jacobi 1846, which each bring one number off the diagonal to zero; after six rounds nothing that
    a float64 shows is left there. The signs of the vectors are any.
    """
    values, axes = matrices.astype(np.float64), np.tile(np.eye(3), (len(matrices), 1, 1))
    for p, q in ((0, 1), (0, 2), (1, 2)) * JACOBI_ROUNDS:
        off = values[:, p, q].copy()
        with np.errstate(over="ignore"):
            ratio = (values[:, q, q] - values[:, p, p]) / np.where(off == 0.0, 1.0, 2.0 * off)
            tangent = np.where(ratio < 0.0, -1.0, 1.0) / (np.abs(ratio) + np.sqrt(1.0 + ratio * ratio))
        tangent[off == 0.0] = 0.0
        cosine = 1.0 / np.sqrt(1.0 + tangent * tangent)
        sine = tangent * cosine
        for rows in (values.transpose(0, 2, 1), values, axes):  # columns are turned: A J, Jt (A J), V J
            left, right = rows[:, :, p].copy(), rows[:, :, q].copy()
            rows[:, :, p] = cosine[:, None] * left - sine[:, None] * right
            rows[:, :, q] = sine[:, None] * left + cosine[:, None] * right
    found = values[:, (0, 1, 2), (0, 1, 2)]
    order = np.argsort(found, axis=1, kind="stable")
    return np.take_along_axis(found, order, 1), np.take_along_axis(axes, order[:, None, :], 2)


def length(vector: np.ndarray) -> float:
    """Of (3,)."""
    x, y, z = map(float, vector)
    return math.sqrt(x * x + y * y + z * z)


def _cofactors(matrix: np.ndarray) -> list[list[float]]:
    """3 rows of 3: row k is the cross product of the other two rows, in their order."""
    a = matrix.astype(np.float64).tolist()  # floats of Python: a third of the time of NumPy's
    return [[a[i][k] * a[j][m] - a[i][m] * a[j][k] for k, m in ((1, 2), (2, 0), (0, 1))]
            for i, j in ((1, 2), (2, 0), (0, 1))]
