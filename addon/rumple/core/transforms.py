# SPDX-License-Identifier: GPL-3.0-or-later
"""Turning vectors by a matrix of three rows, term by term. NumPy leaves `@` and `linalg` to libraries that add in
another order, or round less often, on another processor: machines of a farm would not agree to the bit. Never imports
bpy."""
from __future__ import annotations

import math

import numpy as np

JACOBI_ROUNDS = 6
FITS = 8  # of affine_between()
FITTING = 1e-4  # of the size: how near points come that an affine map moved
SIMILAR = 1e-3  # of scale_of(): between the axes
FLAT, TINY = 1e-10, 1e-30  # of the largest moment; of an area


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


def affine_between(before: np.ndarray, after: np.ndarray) -> np.ndarray | None:
    """(3, 4): what moved most of (n, 3) points to (n, 3) others. None where no affine map did, or they are where they
    were. Points in a plane are taken for a solid as thick as they are wide, which is turned and scaled with it.

    Least squares, again over the half that it fits best: the others may have been edited beside.
    """
    if not len(before) or not (np.isfinite(before).all() and np.isfinite(after).all()):
        return None
    before, after = before.astype(np.float64), after.astype(np.float64)
    chosen = np.ones(len(before), bool)
    for _ in range(FITS):
        affine = _least_squares(before[chosen], after[chosen])
        distance = np.sqrt(((placed(affine, before) - after) ** 2).sum(axis=1))
        chosen = distance <= np.median(distance)
    size = np.sqrt((np.ptp(after, axis=0) ** 2).sum())
    still = np.abs(placed(affine, before) - before).max() <= FITTING * size
    return None if still or np.median(distance) > FITTING * size else affine


def scale_of(affine: np.ndarray) -> float | None:
    """How many times as long everything is after an affine map (3, 4) that turns and scales. None where it scales by
    axes, mirrors or shears."""
    squares = turned(affine[:, :3].T, affine[:, :3].T)
    scale = math.sqrt(max(float(squares[0, 0] + squares[1, 1] + squares[2, 2]) / 3.0, 0.0))
    mirrors = determinant(affine[:, :3]) <= 0.0
    return None if mirrors or np.abs(squares - scale**2 * np.eye(3)).max() > SIMILAR * scale**2 else scale


def redirected(affine: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """(n, 3) of (n, 3): as long as they were, turned as an affine map (3, 4) turns them."""
    directions = turned(affine[:, :3], vectors)
    lengths = np.sqrt((directions**2).sum(axis=1, keepdims=True))
    return directions * np.sqrt((vectors**2).sum(axis=1, keepdims=True)) / np.where(lengths > 0.0, lengths, 1.0)


def _least_squares(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    middle, other = before.mean(axis=0), after.mean(axis=0)
    x, y = before - middle, after - other
    values, axes = (found[0] for found in principal_axes(_moments(x, x)[None]))
    flat = values <= FLAT * values[-1]
    share = np.where(flat, 0.0, 1.0 / np.where(flat, 1.0, values))
    linear = np.eye(3) if flat[1] else product(product(_moments(y, x), axes * share), axes.T)
    if flat[0] and not flat[1]:
        normal = np.array(_crossed(turned_one(linear, axes[:, 1]), turned_one(linear, axes[:, 2])))
        along = np.array(_crossed(axes[:, 1], axes[:, 2]))
        linear = linear + np.sqrt(1.0 / max(length(normal), TINY)) * normal[:, None] * along
    return np.concatenate([linear, (other - turned_one(linear, middle))[:, None]], axis=1)


def _moments(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """(3, 3): the sum of each coordinate of the one times each of the other."""
    return np.array([[(left[:, i] * right[:, k]).sum() for k in range(3)] for i in range(3)])


def _crossed(a: np.ndarray, b: np.ndarray) -> tuple[float, float, float]:
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


def stretch_range(matrix: np.ndarray) -> tuple[float, float]:
    """How many times as long a (3, 3) matrix makes what it shortens most, and what it lengthens most."""
    squares = principal_axes(product(matrix.T, matrix)[None])[0][0]
    return math.sqrt(max(squares[0], 0.0)), math.sqrt(max(squares[2], 0.0))
