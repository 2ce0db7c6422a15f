# SPDX-License-Identifier: GPL-3.0-or-later
"""Products of small matrices and vectors, term by term, with the same bits on every processor. NumPy's `@` and `linalg`
use libraries whose order of additions and rounding depends on the processor. The machines of a farm would then get
different bits. Never imports bpy."""
from __future__ import annotations

import math

import numpy as np

JACOBI_ROUNDS = 6
FITS = 8  # number of fits in affine_between()
FITTING = 1e-4  # distance / size: how exactly an affine map must fit the points
SIMILAR = 1e-3  # relative difference between the axes that scale_of() accepts
FLAT, TINY = 1e-10, 1e-30  # relative to the largest moment; of an area


def turned(matrix: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """M x for each row x of (n, 3). matrix: (3, 3)."""
    return vectors[:, :1] * matrix[:, 0] + vectors[:, 1:2] * matrix[:, 1] + vectors[:, 2:] * matrix[:, 2]


def turned_one(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """(3,): M x."""
    return turned(matrix, vector[None, :])[0]


def product(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Left times right, (3, 3)."""
    return turned(left, right.T).T


def placed(matrix: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(n, 3) points, transformed by an affine matrix of three or four rows."""
    return turned(matrix[:3, :3], points) + matrix[:3, 3]


def determinant(matrix: np.ndarray) -> float:
    """The determinant of (3, 3)."""
    first = matrix[0].astype(np.float64).tolist()
    return sum(entry * cofactor for entry, cofactor in zip(first, _cofactors(matrix)[0]))


def inverse(matrix: np.ndarray) -> np.ndarray:
    """The inverse, (3, 3) float64. The determinant must not be 0."""
    return (np.array(_cofactors(matrix)) / determinant(matrix)).T


def principal_axes(matrices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ascending eigenvalues, (k, 3), and unit eigenvectors in columns, (k, 3, 3), of symmetric matrices (k, 3, 3).

    By the rotations of Jacobi 1846. Each makes one number off the diagonal zero. After six rounds all of them are zero
    in float64 precision. The signs of the vectors are arbitrary.
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
    """The length of (3,)."""
    x, y, z = map(float, vector)
    return math.sqrt(x * x + y * y + z * z)


def _cofactors(matrix: np.ndarray) -> list[list[float]]:
    """3 rows of 3: row k is the cross product of the other two rows, in their order."""
    a = matrix.astype(np.float64).tolist()  # Python's floats take a third of the time of NumPy's
    return [[a[i][k] * a[j][m] - a[i][m] * a[j][k] for k, m in ((1, 2), (2, 0), (0, 1))]
            for i, j in ((1, 2), (2, 0), (0, 1))]


def affine_between(before: np.ndarray, after: np.ndarray) -> np.ndarray | None:
    """The affine map (3, 4) that moved most of the (n, 3) points to (n, 3) others. None if no affine map fits, or if
    the points did not move. Points in a plane are treated as a solid as thick as it is wide, which is rotated and
    scaled.

    It is a least-squares fit, repeated with the half of the points that fits best, because the others may have been
    edited.
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
    """The scale of an affine map (3, 4) that rotates and scales uniformly. None if it scales the axes differently,
    mirrors or shears."""
    squares = turned(affine[:, :3].T, affine[:, :3].T)
    scale = math.sqrt(max(float(squares[0, 0] + squares[1, 1] + squares[2, 2]) / 3.0, 0.0))
    mirrors = determinant(affine[:, :3]) <= 0.0
    return None if mirrors or np.abs(squares - scale**2 * np.eye(3)).max() > SIMILAR * scale**2 else scale


def redirected(affine: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (n, 3) in the direction that an affine map (3, 4) gives them, with their lengths unchanged."""
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
    """(3, 3): the sums of the products of each coordinate of `left` with each of `right`."""
    return np.array([[(left[:, i] * right[:, k]).sum() for k in range(3)] for i in range(3)])


def _crossed(a: np.ndarray, b: np.ndarray) -> tuple[float, float, float]:
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


def stretch_range(matrix: np.ndarray) -> tuple[float, float]:
    """The smallest and the largest singular value of a (3, 3) matrix: its strongest compression and stretch."""
    squares = principal_axes(product(matrix.T, matrix)[None])[0][0]
    return math.sqrt(max(squares[0], 0.0)), math.sqrt(max(squares[2], 0.0))
