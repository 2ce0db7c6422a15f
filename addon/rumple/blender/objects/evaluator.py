# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the engine's Wrinkles of an object from its coarse mesh, settings and scale."""
from __future__ import annotations

import functools
import hashlib
from dataclasses import dataclass
from typing import Any, Callable

import bpy
import numpy as np

from ...core.base.wording import UserError
from ...core.files.checkpoint import carry_frames
from ...core.frame import engine
from ...core.mesh.base_mesh import BaseMesh
from ...core.settings.system_settings import FieldSettings, MeshSettings
from .. import scheduler
from . import incoming_mesh, mesh_reader, messages, modifier, properties, rig_scale, subdivision_behind, units
from .building import PATIENCE, Building
from .runtimes import Runtime


FEWEST = 6  # fine vertices / vertices of the coarse mesh, or of an own mesh, that are always allowed: one subdivision
_REMOVE_FACES = frozenset(("BOOLEAN", "BUILD", "DECIMATE", "EXPLODE", "MASK", "REMESH", "WELD"))  # modifiers that may


@dataclass
class Sources:
    """The data from which a fine mesh is built."""

    base: BaseMesh
    own: BaseMesh | None
    attached: np.ndarray | None
    settings: Any  # the system's
    unit_scale: float  # metres per object unit
    shape: str  # fingerprint of all of these


def sources(obj: bpy.types.Object) -> Sources:
    """Read the sources from the object in its current state. Raises UserError."""
    scene = units.scene_of(obj)
    settings = properties.settings_of(obj, scene)
    _refuse_without_faces(obj)
    base = mesh_reader.base_mesh(obj, settings.rest_shape, obj.rumple.rest_key)
    base.narrowest = mesh_reader.narrowest(obj, settings)
    if isinstance(settings, FieldSettings) and settings.output == "SHADING":
        base.uv = mesh_reader.render_uv(incoming_mesh.of(obj))
    own = _own_mesh(obj, settings)
    attached = mesh_reader.attached(obj.rumple.own_mesh) if own is not None else None
    _scale_rest(rig_scale.of_rest(obj, settings.rest_shape), base, own)
    unit_scale = units.metres_per_unit(obj, scene)
    return Sources(base, own, attached, settings, unit_scale,
                   _shape_fingerprint(base, own, attached, settings, unit_scale))


def _scale_rest(scale: float, *meshes: BaseMesh | None) -> None:
    for mesh in meshes if scale != 1.0 else ():
        if mesh is not None:
            mesh.positions, mesh.figure = mesh.positions * np.float32(scale), mesh.figure * scale


def _refuse_without_faces(obj: bpy.types.Object) -> None:
    """Raise UserError if modifiers leave no faces. The library refuses other meshes without faces."""
    if len(incoming_mesh.of(obj).polygons) or not len(obj.data.polygons):
        return
    front = [m for m in modifier.in_front(obj) if modifier.changes_topology(m)]
    nodes = [m for m in front if m.type == "NODES"]
    if nodes:
        raise UserError(f"{obj.name}: the modifier \"{nodes[-1].name}\" above the wrinkles leaves no faces: add "
                        "Realize Instances at the end of its nodes")
    removing = [m for m in front if m.type in _REMOVE_FACES]
    if removing:
        raise UserError(f"{obj.name}: the modifier \"{removing[-1].name}\" above the wrinkles leaves no faces: move it "
                        "below the wrinkles")


def ensure(obj: bpy.types.Object, runtime: Runtime, meanwhile: Callable[[], object] | None = None) -> None:
    """Make runtime.evaluator for the current object. Only reads Blender, so any handler may call it. Raises UserError.

    meanwhile: reads other data from Blender while a thread builds.
    """
    now, build = sources(obj), runtime.build
    runtime.seen.scale = _scale_of(obj, units.scene_of(obj))
    wanted = _wanted(obj, now)
    begun, build.running = build.running, None
    if begun is not None and begun.wanted != wanted:
        begun.drop()
    if runtime.evaluator is not None and build.shape == wanted:
        return
    if build.refused == _refusable(obj, wanted):
        raise UserError(runtime.refusal)
    try:
        if begun is not None and begun.wanted == wanted:
            evaluator = begun.result()
        else:
            evaluator = _built(obj, now, wanted, meanwhile)
        evaluator = _checked(obj, evaluator)
        if runtime.evaluator is not None and solved_alike(build.shape) == solved_alike(wanted):
            carry_frames(runtime.evaluator, evaluator)
        runtime.evaluator = evaluator
    except Exception as error:  # any exception, because otherwise every update would try it again
        build.refused = _refusable(obj, wanted)
        messages.set_build_error(runtime, messages.of_error(obj, error))
        raise
    runtime.paint.forget()
    build.shape, build.refused, build.just_added = wanted, None, False
    build.properties = _properties(obj, now.settings)
    runtime.forget_inputs()  # the former evaluator solved them, so drawing must wait
    runtime.notes = list(runtime.evaluator.warnings)
    if incoming_mesh.of(obj).has_custom_normals:
        runtime.notes.append(f"{obj.name}: custom normals are not carried to the fine mesh")
    runtime.evaluator.frame_cache.limit_bytes = obj.rumple.memory_limit << 20


def _built(obj: bpy.types.Object, now: Sources, wanted: tuple[str, int, int],
           meanwhile: Callable[[], object] | None) -> engine.Wrinkles:
    if meanwhile is None:
        return _builder(obj, now)()
    building = Building(obj.name, wanted, _builder(obj, now))
    meanwhile()
    return building.result()


def note_scale(obj: bpy.types.Object, runtime: Runtime) -> None:
    """Notice a change of scale of an object, of its parents, or of the bones that move it: it edits no mesh."""
    scene, seen = units.scene_of(obj), runtime.seen
    former, seen.plain_scales = seen.plain_scales, (units.plain_scales(obj, scene), rig_scale.plain(obj))
    if former == seen.plain_scales or not (units.scale_is_known(obj) or runtime.refusal):
        return
    found = _scale_of(obj, scene)
    # A refused mesh may have been refused at a scale of zero, by which drivers hide objects.
    if found != seen.scale and (seen.scale or runtime.refusal):
        runtime.stale = True
        scheduler.request(scheduler.DELAY)
    seen.scale = found


def _scale_of(obj: bpy.types.Object, scene: bpy.types.Scene) -> str:
    return f"{_rounded(units.metres_per_unit(obj, scene))} {rig_scale.of(obj, scene)}"


def _rounded(unit_scale: float) -> str:
    """The scale with significant digits only: smaller differences are rounding."""
    return f"{unit_scale:.4g}"


def begin(obj: bpy.types.Object, runtime: Runtime) -> Building | None:
    """Begin to build in a thread what ensure() needs. Returns None if there is nothing to wait for: it is ready, or
    was built within PATIENCE. Raises UserError."""
    now, build = sources(obj), runtime.build
    wanted = _wanted(obj, now)
    if wanted == build.shape or _refusable(obj, wanted) == build.refused:
        return None
    if build.running is None or build.running.wanted != wanted:
        if build.running is not None:
            build.running.drop()
        build.running = Building(obj.name, wanted, _builder(obj, now))
    return build.running if build.running.is_running(PATIENCE) else None


def cancel(obj: bpy.types.Object, runtime: Runtime) -> str:
    """Stop the build and restore the settings from before it. Returns a message; empty if nothing was being built."""
    dropped, runtime.build.running = runtime.build.running, None
    if dropped is None:
        return ""
    dropped.drop()
    changed = False
    for path, value in runtime.build.properties.items():
        group, name = _place(obj, path)
        if getattr(group, name) != value:
            setattr(group, name, value)
            changed = True
    if changed:
        return f"{obj.name}: the former folds stay, and the settings are as they were"
    runtime.build.refused = _refusable(obj, dropped.wanted)
    said = f"{obj.name}: Esc stopped the building of its fine mesh: change a setting to start again"
    messages.set_build_error(runtime, said)
    return said


def _wanted(obj: bpy.types.Object, now: Sources) -> tuple[str, int, int]:
    return now.shape, obj.rumple.most_vertices, obj.rumple.viewport_steps


def solved_alike(shape: tuple[str, int, int] | None) -> tuple[str, int] | None:
    """The part of a shape on which the solution of frames depends. The other part is for viewports only."""
    return None if shape is None else shape[:2]


def _refusable(obj: bpy.types.Object, wanted: tuple[str, int, int]) -> tuple[str, int, int, int]:
    """The values that decide whether the fine mesh can be built."""
    return *wanted, subdivision_behind.quality(obj)


def _properties(obj: bpy.types.Object, settings: Any) -> dict[str, Any]:
    """Blender's values of all settings that the fine mesh depends on, by their path from obj.rumple."""
    group = properties.system_of(obj).group
    paths = ["most_vertices", "viewport_steps", *(f"{group}.{name}" for name in settings.structural())]
    return {path: getattr(*_place(obj, path)) for path in paths}


def _place(obj: bpy.types.Object, path: str) -> tuple[Any, str]:
    group, _, name = path.rpartition(".")
    return (getattr(obj.rumple, group) if group else obj.rumple), name


def _builder(obj: bpy.types.Object, now: Sources) -> Callable[[], engine.Wrinkles]:
    """A function that builds the Wrinkles. It uses only arrays, so it may run in any thread."""
    more: dict[str, Any] = dict(own=now.own, attached=now.attached) if now.own is not None else {}
    if isinstance(now.settings, MeshSettings):
        more["viewport_steps"] = obj.rumple.viewport_steps
    least = FEWEST * max(len(mesh.positions) for mesh in (now.base, now.own) if mesh is not None)
    return functools.partial(modifier.system(modifier.find(obj)).wrinkles.build, now.base, now.settings,
                             unit_scale=now.unit_scale, most_vertices=max(obj.rumple.most_vertices, least), **more)


def _checked(obj: bpy.types.Object, evaluator: engine.Wrinkles) -> engine.Wrinkles:
    coarse = evaluator.coarse_count
    if evaluator.vertex_count < coarse:  # the result could not carry the coarse positions
        raise UserError(f"{obj.name}: the fine mesh has {evaluator.vertex_count} vertices, fewer than the coarse one "
                        f"({coarse}): choose a denser one")
    subdivision_behind.refuse_costly(obj, evaluator)
    return evaluator


def _own_mesh(obj: bpy.types.Object, settings: Any) -> BaseMesh | None:
    if not _wants_own_mesh(settings):
        return None
    own = obj.rumple.own_mesh
    if own is None or own.type != "MESH":
        raise UserError(f"{obj.name}: choose your own fine mesh first")
    return mesh_reader.own_mesh(obj, own)


def source_of(obj: bpy.types.Object) -> bpy.types.Object:
    """The object whose materials, UV maps and attributes the fine mesh inherits."""
    own = obj.rumple.own_mesh
    return own if own is not None and _wants_own_mesh(properties.group_of(obj)) else obj


def _wants_own_mesh(settings: Any) -> bool:
    """settings: the system's settings, or their properties."""
    return getattr(settings, "source", "") == "OBJECT"


def _shape_fingerprint(base: BaseMesh, own: BaseMesh | None, attached: np.ndarray | None, settings: Any,
                       unit_scale: float) -> str:
    digest = hashlib.sha1(mesh_reader.shape_fingerprint(base).encode())
    if own is not None:
        digest.update(mesh_reader.shape_fingerprint(own).encode())
        digest.update(b"" if attached is None else attached.tobytes())
    digest.update(repr((settings.structural(), _rounded(unit_scale))).encode())
    return digest.hexdigest()
