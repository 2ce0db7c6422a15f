# SPDX-License-Identifier: GPL-3.0-or-later
"""The maps that can be painted for an object's wrinkles: their names, what they hold, and writing them."""
from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import bpy
import numpy as np

from ...core import paint_maps
from ...core.engine import UserError
from ...core.hangs_free import FREE
from ...core.keep_smooth import SMOOTH
from ...core.paint_maps import WIDTH
from ...core.painted_rigid import RIGID
from ...core.settings import FieldSettings, MeshSettings
from .. import compat, scheduler
from . import cloth_defaults, mesh_reader, properties, runtimes, units

# In the order in which they are listed.
KEYS = ("drape", "folds", "detail", "mask", WIDTH, "radius", "prestretch", "bending", "inside", "room", FREE,
        "follow", SMOOTH, RIGID)
_LABELS = {FREE: "Hangs Free", "follow": "Pinned", SMOOTH: "Keep Smooth", RIGID: "Rigid"}
_FIELDS = {WIDTH: "wavelength_scale"}  # of the settings, where its name is another
LABELS: dict[str, str] = {
    key: _LABELS.get(key) or next(f.metadata["name"] for system in (MeshSettings, FieldSettings) for f in fields(system)
                                  if f.name == _FIELDS.get(key, key)) for key in KEYS}
# Of a vertex that the map does not change.
REST = {key: 0.0 if key in (FREE, "follow", SMOOTH, RIGID) else 1.0 for key in KEYS}
_READ_DELAY = 0.2  # seconds: a frame that is solved meanwhile reads them anyway
_unread: set[str] = set()  # names of objects whose maps are to be read for the panel


@dataclass(frozen=True)
class PaintedMap:
    """One of them."""

    key: str  # of the engine
    name: str  # of the vertex group
    exists: bool  # as a vertex group

    @property
    def label(self) -> str:
        return LABELS[self.key]

    @property
    def rest(self) -> float:
        return REST[self.key]


def of(obj: bpy.types.Object) -> list[PaintedMap]:
    """Those that act with the settings of now, and those that are painted."""
    settings = properties.settings_of(obj, units.scene_of(obj))
    return [found for found in map(lambda key: find(obj, key, settings), KEYS)
            if found is not None and (found.exists or _acts(found.key, settings))]


def find(obj: bpy.types.Object, key: str, settings: Any = None) -> PaintedMap | None:
    """The map of that key; None where the object's wrinkles have none."""
    settings = settings or properties.settings_of(obj, units.scene_of(obj))
    name = mesh_reader.paint_groups(settings).get(key)
    return PaintedMap(key, name, name in obj.vertex_groups) if name else None


def _acts(key: str, settings: Any) -> bool:
    """Whether a map of that key would change anything."""
    if key in ("room", FREE, "follow"):
        return settings.base_cloth != "OFF"
    if key in ("drape", "folds", "detail"):
        return settings.layered
    if key == WIDTH and isinstance(settings, MeshSettings):
        return settings.layered and settings.density == "WAVELENGTH"
    return key != "inside" or settings.collision != "NONE"


# ---------------------------------------------------------------- for the panel
def measured(obj: bpy.types.Object) -> dict[str, tuple[float, float]]:
    """Key -> (mean, share of the coarse vertices that are not as without the map), of what is painted.

    Reads no mesh: they are computed once from what was read for the solver last (0.1 ms a map for 50,000 vertices).
    Where nothing was read since a change, as while a clip is shown, the former numbers are given and a timer reads once
    (1 ms per 1,000 vertices).
    """
    runtime = runtimes.of(obj)
    if runtime.paint is None:
        _read_soon(obj)
    elif runtime.measured is None or runtime.measured[0] is not runtime.paint:
        runtime.measured = runtime.paint, {key: paint_maps.numbers(runtime.paint[key], REST[key])
                                           for key in KEYS if key in runtime.paint}
    return {} if runtime.measured is None else runtime.measured[1]


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
        if any([_read(obj) for obj in objects]):
            scheduler.redraw_panels_soon()
    return None


def _read(obj: bpy.types.Object) -> bool:
    """Read what is painted, as a frame does. Whether there is something to show."""
    runtime = runtimes.known(obj)
    if runtime is None or obj.type != "MESH" or mesh_reader.is_busy(obj):
        return False
    try:
        if runtime.paint is None:
            runtime.paint = mesh_reader.paint(obj, properties.settings_of(obj, units.scene_of(obj)))
    except UserError:
        return False  # the frame says so
    return True


def stop() -> None:
    """For unregister()."""
    if bpy.app.timers.is_registered(_read_due):
        bpy.app.timers.unregister(_read_due)


# ---------------------------------------------------------------- reading and writing
def weights(obj: bpy.types.Object, painted: PaintedMap) -> np.ndarray:
    """(n,) float32 of the object's own vertices: as painted, else as without the map. 1 ms per 1,000 vertices."""
    if painted.name in obj.vertex_groups:
        return mesh_reader.group_weights(obj, obj.data, [painted.name])[:, 0]
    return start(obj, painted)


def start(obj: bpy.types.Object, painted: PaintedMap) -> np.ndarray:
    """(n,) float32: what a new map starts from, which changes nothing."""
    pinned = cloth_defaults.follow_weights(obj) if painted.key == "follow" else None
    return np.full(len(obj.data.vertices), painted.rest, np.float32) if pinned is None else pinned


def is_masked(obj: bpy.types.Object) -> bool:
    """Whether a mask of Weight Paint is on."""
    return obj.data.use_paint_mask or obj.data.use_paint_mask_vertex


def selected(obj: bpy.types.Object) -> np.ndarray | None:
    """(n,) bool: the vertices that Weight Paint's mask leaves; None where no mask is on."""
    mesh = obj.data
    if mesh.use_paint_mask_vertex:
        chosen = np.empty(len(mesh.vertices), bool)
        mesh.vertices.foreach_get("select", chosen)
        return chosen
    if not mesh.use_paint_mask:
        return None
    faces, total = np.empty(len(mesh.polygons), bool), compat.indices(mesh.polygons, "loop_total")
    mesh.polygons.foreach_get("select", faces)
    chosen = np.zeros(len(mesh.vertices), bool)
    chosen[compat.corner_vertices(mesh)[np.repeat(faces, total)]] = True
    return chosen


def write(obj: bpy.types.Object, painted: PaintedMap, values: np.ndarray, masked: bool = True) -> None:
    """Give the vertices that the mask leaves these weights, (n,) float32 in 0..1; not masked: all of them. A group that
    is not there is made, and starts as it means nothing. Not in Edit Mode. 0.1 s for 50,000 vertices that all differ.
    """
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
    """As if it had never been painted. The active group stays the active one, unless it is this."""
    groups = obj.vertex_groups
    active = groups.active.name if groups.active is not None else ""
    groups.remove(groups[painted.name])
    if active in groups:
        groups.active_index = groups[active].index
    touch(obj)


def touch(obj: bpy.types.Object) -> None:
    """The paint is another: read and solve again."""
    runtime = runtimes.of(obj)
    runtime.paint, runtime.stale = None, True
    obj.data.update()
    obj.update_tag()
    scheduler.request()
