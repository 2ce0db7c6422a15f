# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes of several parts, and single frames of them that are solved without Blender."""
from __future__ import annotations

from typing import Any

import numpy as np
from rumple.core.frame.engine import FrameResult, Wrinkles
from rumple.core.mesh.base_mesh import BaseMesh
from rumple.core.systems.wrinkle_mesh import WrinkleMesh
from support.frames import solve_frame
from support.meshes import quad_mesh

BOX = np.array([(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)])


def box(centre: tuple[float, float, float], size: tuple[float, float, float]) -> BaseMesh:
    """Closed, its normals outward."""
    x, y, z = (0.5 * s for s in size)
    ring = np.array([(-x, -y), (x, -y), (x, y), (-x, y)])
    return quad_mesh("Box", np.concatenate([np.c_[ring, np.full(4, -z)], np.c_[ring, np.full(4, z)]]) + centre, BOX)


def together(*meshes: BaseMesh) -> BaseMesh:
    """One mesh of several, in this order."""
    first = np.cumsum([0, *(len(mesh.positions) for mesh in meshes)])
    return quad_mesh("Worn", np.concatenate([mesh.positions for mesh in meshes]),
                     np.concatenate([mesh.corner_vertex.reshape(-1, 4) + start for mesh, start in zip(meshes, first)]))


def solved(base: BaseMesh, settings: Any, positions: np.ndarray, system: type[Wrinkles] = WrinkleMesh,
           in_viewport: bool = False, **more: Any) -> tuple[Wrinkles, FrameResult]:
    """One frame of it, on its own."""
    mesh = system.build(base, settings, **more)
    result = solve_frame(mesh, 1.0, np.ascontiguousarray(positions, np.float32), settings, {}, start=1,
                         world_from_object=np.eye(3), in_viewport=in_viewport)
    assert isinstance(result, FrameResult)
    return mesh, result


def embedded(mesh: Wrinkles, coarse: np.ndarray, local_offset: np.ndarray) -> np.ndarray:
    """As the node tree has it: nodes/wrinkle_tree.py."""
    p0, p1, p2 = (coarse[mesh.triangle_vertex[:, k]].astype(np.float64) for k in range(3))
    t, n = p1 - p0, np.cross(p1 - p0, p2 - p0)
    t, n = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (t, n))
    u, v = mesh.barycentric[:, :1], mesh.barycentric[:, 1:]
    x, y, z = (local_offset[:, k:k + 1] for k in range(3))
    return p0 + u * (p1 - p0) + v * (p2 - p0) + t * x + np.cross(n, t) * y + n * z


def leant(positions: np.ndarray) -> np.ndarray:
    """Laid on its side: cloth sinks through what it hung on."""
    x, y, z = positions.T
    return np.ascontiguousarray(np.stack([x, -z, y], axis=1))


def distances(points: np.ndarray) -> np.ndarray:
    """Between all of them."""
    return np.linalg.norm(points[:, None].astype(np.float64) - points[None], axis=2)
