# SPDX-License-Identifier: GPL-3.0-or-later
"""The maps that can be painted for an object's wrinkles: names, weights, and writing them."""
from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import bpy
import numpy as np
from mathutils.kdtree import KDTree

from ...core.base.wording import UserError
from ...core.paint import paint_maps
from ...core.paint.hangs_free import FREE
from ...core.paint.keep_smooth import SMOOTH
from ...core.paint.paint_maps import WIDTH
from ...core.paint.painted_rigid import RIGID
from ...core.settings.system_settings import FieldSettings, MeshSettings
from .. import compat, scheduler
from . import incoming_mesh, lost_maps, mesh_reader, modifier, properties, runtimes, units

STEPS = 20  # number of different weights in a new group
# In the order of the list in the panel.
KEYS = ("drape", "folds", "detail", "mask", WIDTH, "radius", "prestretch", "bending", "inside", "room", FREE,
        "follow", SMOOTH, RIGID)
_LABELS = {FREE: "Hangs Free", "follow": "Pinned", SMOOTH: "Keep Smooth", RIGID: "Rigid"}
_FIELDS = {WIDTH: "wavelength_scale"}  # names in the settings that differ from the key
LABELS: dict[str, str] = {
    key: _LABELS.get(key) or next(f.metadata["name"] for system in (MeshSettings, FieldSettings) for f in fields(system)
                                  if f.name == _FIELDS.get(key, key)) for key in KEYS}
# The weight of a vertex that the map does not affect.
REST = {key: 0.0 if key in (FREE, "follow", SMOOTH, RIGID) else 1.0 for key in KEYS}
_READ_DELAY = 0.2  # seconds: a frame solved before that reads the maps anyway
_unread: set[str] = set()  # names of objects whose maps must be read for the panel


@dataclass(frozen=True)
class PaintedMap:
    """One map."""

    key: str  # key of the engine
    name: str  # name of the vertex group
    exists: bool  # whether the vertex group exists

    @property
    def label(self) -> str:
        return LABELS[self.key]

    @property
    def rest(self) -> float:
        return REST[self.key]


def of(obj: bpy.types.Object) -> list[PaintedMap]:
    """The maps that have an effect with the current settings, and the painted ones."""
    settings = properties.settings_of(obj, units.scene_of(obj))
    return [found for found in map(lambda key: find(obj, key, settings), KEYS)
            if found is not None and (found.exists or _acts(found.key, settings))]


def find(obj: bpy.types.Object, key: str, settings: Any = None) -> PaintedMap | None:
    """The map with this key; None if the object's system has no such map."""
    settings = settings or properties.settings_of(obj, units.scene_of(obj))
    name = mesh_reader.paint_groups(settings).get(key)
    return PaintedMap(key, name, name in obj.vertex_groups) if name else None


def _acts(key: str, settings: Any) -> bool:
    """Whether a map with this key would have an effect."""
    if key in ("room", FREE, "follow"):
        return settings.base_cloth != "OFF"
    if key in ("drape", "folds", "detail"):
        return settings.layered
    if key == WIDTH and isinstance(settings, MeshSettings):
        return settings.layered and settings.density == "WAVELENGTH"
    return key != "inside" or settings.collision != "NONE"


# ---------------------------------------------------------------- for the panel
def measured(obj: bpy.types.Object) -> dict[str, tuple[float, float]]:
    """Key -> (mean, share of the coarse vertices that the map affects), of the painted maps.

    This reads no mesh. The numbers are computed once from the last data for the solver (0.1 ms per map for 50,000
    vertices). If nothing was read since a change, as while a clip is shown, the former numbers are returned, and a
    timer reads the maps once (1 ms per 1,000 vertices).
    """
    paint = runtimes.of(obj).paint
    if paint.values is None:
        _read_soon(obj)
    elif paint.measured is None or paint.measured[0] is not paint.values:
        paint.measured = paint.values, {key: paint_maps.numbers(paint.values[key], REST[key])
                                        for key in KEYS if key in paint.values}
    return {} if paint.measured is None else paint.measured[1]


def _read_soon(obj: bpy.types.Object) -> None:
    if bpy.app.background:
        return
    _unread.add(obj.name)
    if not bpy.app.timers.is_registered(_read_due):
        bpy.app.timers.register(_read_due, first_interval=_READ_DELAY)


def _read_due() -> float | None:
    if scheduler.rendering():
        return 0.5
    objects = [bpy.data.objects[name] for name in _unread if name in bpy.data.objects]
    _unread.clear()
    with scheduler.LOCK:
        if any([_read_for_panel(obj) for obj in objects]):
            scheduler.redraw_panels_soon()
    return None


def _read_for_panel(obj: bpy.types.Object) -> bool:
    """Read the painted maps. Returns whether there is something to show."""
    runtime = runtimes.known(obj)
    if runtime is None or obj.type != "MESH" or mesh_reader.is_busy(obj):
        return False
    try:
        read(obj)
    except UserError:
        return False  # the frame reports this error
    return True


def stop() -> None:
    """Called by unregister()."""
    if bpy.app.timers.is_registered(_read_due):
        bpy.app.timers.unregister(_read_due)


# ---------------------------------------------------------------- reading and writing
def read(obj: bpy.types.Object) -> dict[str, np.ndarray]:
    """The painted maps for the solver, as mesh_reader.paint(). Only what may have changed is read. Raises UserError."""
    paint = runtimes.of(obj).paint
    if paint.values is None:
        settings = properties.settings_of(obj, units.scene_of(obj))
        names = mesh_reader.painted_groups(obj, settings)
        if paint.weights is None or paint.weights.keys() != set(names):
            paint.weights = mesh_reader.weights_by_name(obj, names)
        paint.values = mesh_reader.paint(obj, settings, paint.weights)
        lost_maps.follow(obj, paint, settings)
    return paint.values


def weights(obj: bpy.types.Object, painted: PaintedMap) -> np.ndarray:
    """(n,) float32, per vertex of the object's own mesh: the painted weights, or the neutral weight. Cost: 1 ms per
    1,000 vertices."""
    if painted.name in obj.vertex_groups:
        return mesh_reader.group_weights(obj, obj.data, [painted.name])[:, 0]
    return start(obj, painted)


def start(obj: bpy.types.Object, painted: PaintedMap) -> np.ndarray:
    """(n,) float32: the first weights of a new map, which change nothing."""
    pinned = follow_weights(obj) if painted.key == "follow" else None
    return np.full(len(obj.data.vertices), painted.rest, np.float32) if pinned is None else pinned


def follow_weights(obj: bpy.types.Object) -> np.ndarray | None:
    """(n,) float32, per vertex of the object's own mesh: where the base cloth is pinned automatically. None before the
    evaluator exists."""
    evaluator = runtimes.of(obj).evaluator
    if evaluator is None:
        return None
    settings = properties.settings_of(obj, units.scene_of(obj))
    return on_own_vertices(obj, in_steps(evaluator.suggested_follow(settings)))


def in_steps(weights: np.ndarray) -> np.ndarray:
    """Rounded, float32. With few different values a vertex group is written quickly."""
    return (np.round(weights * STEPS) / STEPS).astype(np.float32)


def on_own_vertices(obj: bpy.types.Object, weights: np.ndarray) -> np.ndarray:
    """From weights of the incoming mesh, (m,), to weights of the object's own vertices, (n,), which are painted."""
    if incoming_mesh.is_own(obj):
        return weights
    return weights[_nearest(compat.positions(incoming_mesh.of(obj)), compat.positions(obj.data))]


def _nearest(places: np.ndarray, to: np.ndarray) -> list[int]:
    """For every row of `to`, the index of the nearest row of `places`."""
    tree = KDTree(len(places))
    for number, place in enumerate(places.tolist()):
        tree.insert(place, number)
    tree.balance()
    return [tree.find(place)[1] for place in to.tolist()]


def is_masked(obj: bpy.types.Object) -> bool:
    """Whether one of Weight Paint's masks is on."""
    return obj.data.use_paint_mask or obj.data.use_paint_mask_vertex


def selected(obj: bpy.types.Object) -> np.ndarray | None:
    """(n,) bool: the vertices selected by Weight Paint's mask; None if no mask is on."""
    mesh = obj.data
    if mesh.use_paint_mask_vertex:
        chosen = np.empty(len(mesh.vertices), bool)
        mesh.vertices.foreach_get("select", chosen)
        return chosen
    if not mesh.use_paint_mask:
        return None
    faces = np.empty(len(mesh.polygons), bool)
    mesh.polygons.foreach_get("select", faces)
    return vertices_of(mesh, faces)


def vertices_of(mesh: bpy.types.Mesh, faces: np.ndarray) -> np.ndarray:
    """(n,) bool: the vertices of some faces. faces: (polygons,) bool."""
    chosen = np.zeros(len(mesh.vertices), bool)
    chosen[compat.corner_vertices(mesh)[np.repeat(faces, compat.indices(mesh.polygons, "loop_total"))]] = True
    return chosen


def write(obj: bpy.types.Object, painted: PaintedMap, values: np.ndarray, masked: bool = True) -> None:
    """Write these weights, (n,) float32 in 0..1, to the vertices selected by the mask; masked=False: to all. A missing
    group is created with its neutral weights. Do not call it in Edit Mode. Cost: 0.1 s for 50,000 different values."""
    group = obj.vertex_groups.get(painted.name)
    former = None
    chosen = selected(obj) if masked else None
    if group is None:
        before = start(obj, painted)
        group = obj.vertex_groups.new(name=painted.name)
    else:
        before = former = weights(obj, painted)
    wanted = values if chosen is None else np.where(chosen, values, before)
    rows = np.arange(len(wanted)) if former is None else np.flatnonzero(wanted != former)
    order = rows[np.argsort(wanted[rows], kind="stable")]
    cuts = np.flatnonzero(np.diff(wanted[order])) + 1
    for piece in np.split(order, cuts) if len(order) else ():
        group.add(piece.tolist(), float(wanted[piece[0]]), "REPLACE")
    touch(obj)


def remove(obj: bpy.types.Object, painted: PaintedMap) -> None:
    """Remove a map. The active group stays active, unless it is this one."""
    groups = obj.vertex_groups
    active = groups.active.name if groups.active is not None else ""
    for other, _ours in modifier.wrinkled_objects():
        if other.data == obj.data:
            lost_maps.forget(other, painted.name)
    groups.remove(groups[painted.name])
    if active in groups:
        groups.active_index = groups[active].index
    touch(obj)


def touch(obj: bpy.types.Object) -> None:
    """Mark the paint as changed: it is read and solved again."""
    runtime = runtimes.of(obj)
    runtime.paint.forget()
    runtime.stale = True
    obj.data.update()
    obj.update_tag()
    scheduler.request()
