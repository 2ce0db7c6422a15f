# SPDX-License-Identifier: GPL-3.0-or-later
"""What makes the wrinkles of an object: the engine's Wrinkles, built from its coarse mesh, settings and scale."""
from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from ...core import engine
from ...core.settings import FieldSettings, MeshSettings
from .. import compat
from . import incoming_mesh, mesh_reader, messages, modifier, properties, units
from .runtimes import Runtime


FEWEST = 6  # vertices of a fine mesh over those of the coarse one, or of an own one, that are always allowed: one step


@dataclass
class Sources:
    """What a fine mesh is made from."""

    base: engine.BaseMesh
    own: engine.BaseMesh | None
    attached: np.ndarray | None
    settings: Any  # of the system
    unit_scale: float  # metres per object unit
    shape: str  # fingerprint of all of these


def sources(obj: bpy.types.Object) -> Sources:
    """Read them from the object as it is now. Raises engine.UserError."""
    scene = units.scene_of(obj)
    settings = properties.settings_of(obj, scene)
    base = mesh_reader.base_mesh(obj, settings.rest_shape, obj.rumple.rest_key)
    if isinstance(settings, FieldSettings) and settings.output == "SHADING":
        base.uv = mesh_reader.render_uv(incoming_mesh.of(obj))
    own = _own_mesh(obj, settings)
    attached = mesh_reader.attached(obj.rumple.own_mesh) if own is not None else None
    unit_scale = units.metres_per_unit(obj, scene)
    return Sources(base, own, attached, settings, unit_scale,
                   _shape_fingerprint(base, own, attached, settings, unit_scale))


def ensure(obj: bpy.types.Object, runtime: Runtime) -> None:
    """Make entry.evaluator for the object as it is now. Reads only: allowed in any handler. Raises engine.UserError."""
    now = sources(obj)
    wanted = now.shape, obj.rumple.most_vertices, obj.rumple.viewport_steps
    if runtime.evaluator is not None and runtime.shape == wanted:
        return
    if runtime.refused == wanted:
        raise engine.UserError(runtime.refusal)
    try:
        runtime.evaluator = _build(obj, now)
    except engine.UserError as error:
        runtime.refused = wanted
        messages.set_build_error(runtime, str(error))
        raise
    runtime.shape, runtime.refused, runtime.paint = wanted, None, None
    runtime.inputs = None  # solved by the former one: who draws by them must wait
    runtime.notes = list(runtime.evaluator.warnings)
    if compat.has_custom_normals(incoming_mesh.of(obj)):
        runtime.notes.append(f"{obj.name}: custom normals are not carried to the fine mesh")
    runtime.evaluator.frame_cache.limit_bytes = obj.rumple.memory_limit << 20


def _build(obj: bpy.types.Object, now: Sources) -> engine.Wrinkles:
    more: dict[str, Any] = dict(own=now.own, attached=now.attached) if now.own is not None else {}
    if isinstance(now.settings, MeshSettings):
        more["viewport_steps"] = obj.rumple.viewport_steps
    least = FEWEST * max(len(mesh.positions) for mesh in (now.base, now.own) if mesh is not None)
    fine = modifier.system(modifier.find(obj)).wrinkles.build(
        now.base, now.settings, unit_scale=now.unit_scale, most_vertices=max(obj.rumple.most_vertices, least), **more)
    coarse = fine.coarse_count
    if fine.vertex_count < coarse:  # the result could not bring the coarse positions back to us
        raise engine.UserError(f"{obj.name}: the fine mesh has {fine.vertex_count} vertices, fewer than the coarse one "
                               f"({coarse}): choose a denser one")
    return fine


def _own_mesh(obj: bpy.types.Object, settings: Any) -> engine.BaseMesh | None:
    if not _wants_own_mesh(settings):
        return None
    own = obj.rumple.own_mesh
    if own is None or own.type != "MESH":
        raise engine.UserError(f"{obj.name}: choose your own fine mesh first")
    return mesh_reader.own_mesh(obj, own)


def source_of(obj: bpy.types.Object) -> bpy.types.Object:
    """The object whose materials, UV maps and attributes the fine mesh inherits."""
    own = obj.rumple.own_mesh
    return own if own is not None and _wants_own_mesh(properties.group_of(obj)) else obj


def _wants_own_mesh(settings: Any) -> bool:
    """settings: of the system, or their properties."""
    return getattr(settings, "source", "") == "OBJECT"


def _shape_fingerprint(base: engine.BaseMesh, own: engine.BaseMesh | None, attached: np.ndarray | None, settings: Any,
                       unit_scale: float) -> str:
    digest = hashlib.sha1(mesh_reader.shape_fingerprint(base).encode())
    if own is not None:
        digest.update(mesh_reader.shape_fingerprint(own).encode())
        digest.update(b"" if attached is None else attached.tobytes())
    digest.update(repr((settings.structural(), f"{unit_scale:.4g}")).encode())
    return digest.hexdigest()
