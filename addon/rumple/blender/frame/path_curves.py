# SPDX-License-Identifier: GPL-3.0-or-later
"""The paths as curves: a child object of the garment, whose mesh has rows of numbers (core/systems/curve_rows.py).
Its node group makes curves from them (path_curves_tree.py).

The mesh has a capacity of points. Handlers write only positions and never change its topology. Structural work
increases the capacity. The modifier's input refers to the garment of the curves.
"""
from __future__ import annotations

from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, BinaryIO, Iterator

import bpy
import numpy as np

from ...core.files import clip_file, clip_folder
from ...core.files.clip_manifest import ClipFault, Manifest
from ...core.systems.curve_rows import MOST_ROOM, ROWS, CurvePoints, capacity_for, rows_of
from .. import compat, scheduler
from ..nodes import path_curves_tree
from ..nodes.modifier_inputs import get_object, set_input, set_relations
from ..objects import messages, modifier, properties, runtimes, units
from ..objects.kept_lists import ModifiedObjects
from ..objects.runtimes import Runtime

SUFFIX = ".curves"


# ---------------------------------------------------------------- whose they are
_CURVES = ModifiedObjects(path_curves_tree.is_ours)


def find(obj: bpy.types.Object) -> bpy.types.NodesModifier | None:
    """The modifier that makes curves from an object's mesh."""
    return _CURVES.find(obj)


def all_curves() -> Iterator[tuple[bpy.types.Object, bpy.types.NodesModifier]]:
    """Every object that shows paths, ordered by name. The list is cached."""
    return iter(_CURVES)


def garment_of(nodes_mod: bpy.types.NodesModifier) -> bpy.types.Object | None:
    return get_object(nodes_mod, path_curves_tree.GARMENT)


def of(garment: bpy.types.Object) -> list[bpy.types.Object]:
    """The curves of a garment."""
    return [obj for obj, nodes_mod in all_curves() if garment_of(nodes_mod) == garment]


# ---------------------------------------------------------------- adding and removing
def add(garment: bpy.types.Object) -> bpy.types.Object:
    """Add a child that shows the paths of a garment, in the same collections."""
    name = garment.name + SUFFIX
    child = bpy.data.objects.new(name, bpy.data.meshes.new(name))
    _set_capacity(child.data, _wanted_capacity(garment))
    child.parent = garment
    for collection in garment.users_collection:
        collection.objects.link(child)
    nodes_mod = child.modifiers.new("Path Curves", "NODES")
    nodes_mod.node_group = path_curves_tree.ensure()
    _CURVES.forget()
    set_relations(nodes_mod, {path_curves_tree.GARMENT: garment})
    _write_again(garment)
    return child


def remove(child: bpy.types.Object) -> None:
    """Remove a child, its mesh, and the node group if this was the last one."""
    group = find(child).node_group
    set_input(find(child), path_curves_tree.GARMENT, None)
    modifier.delete_hidden(child)
    _CURVES.forget()
    if group.users == 0 and compat.is_editable(group):
        bpy.data.node_groups.remove(group)


def _write_again(garment: bpy.types.Object) -> None:
    """Let the next update write the curves of this frame."""
    runtimes.of(garment).invalidate_output()
    garment.update_tag()


# ---------------------------------------------------------------- capacity
def capacity(mesh: bpy.types.Mesh) -> int:
    """The number of points for which a mesh has rows."""
    return len(mesh.vertices) // ROWS


def _set_capacity(mesh: bpy.types.Mesh, points: int) -> None:
    """Make rows for this number of points, and edges between consecutive points."""
    mesh.clear_geometry()
    mesh.vertices.add(ROWS * points)
    mesh.edges.add(points - 1)
    pairs = np.stack([np.arange(points - 1), np.arange(1, points)], 1)
    mesh.edges.foreach_set("vertices", np.ascontiguousarray(pairs, np.int32).ravel())
    mesh.update()


def _wanted_capacity(garment: bpy.types.Object) -> int:
    runtime = runtimes.known(garment)
    if runtime is None or runtime.evaluator is None:
        return capacity_for(0)
    settings = properties.settings_of(garment, units.scene_of(garment))
    return capacity_for(max(runtime.evaluator.curve_points(settings), 1.5 * runtime.curve_points))


# ---------------------------------------------------------------- every frame
def write(garment: bpy.types.Object, runtime: Runtime) -> None:
    """Write the curves of the last solved frame. Called by handlers."""
    children = [child for child in of(garment) if _is_writable(child)]
    if not children:
        messages.note_no_room(runtime, "")
        return
    inputs = runtime.inputs
    curves = runtime.evaluator.curves(inputs.frame, inputs.positions, inputs.settings)
    points, no_room = len(curves.width), ""
    for child in children:
        if capacity(child.data) < points:
            runtime.curve_points = points
            if scheduler.allowed_now():
                _set_capacity(child.data, _wanted_capacity(garment))
            else:
                scheduler.request()
        rows, left_out = rows_of(curves, capacity(child.data))
        if left_out:
            no_room = (f"{garment.name}: {child.name} has no room for {left_out} of {len(curves.id)} paths in this "
                       "frame: play the clip through before you render it")
        if not np.array_equal(compat.positions(child.data), rows):
            compat.set_positions(child.data, rows)
            compat.values_changed(child.data)
    messages.note_no_room(runtime, no_room)


def _is_writable(child: bpy.types.Object) -> bool:
    """Whether the mesh can be written: in Edit Mode it is not the shown one, a baked one is played, and writing to
    linked ones has no effect."""
    return (child.mode == "OBJECT" and modifier.mesh_cache(child) is None and compat.is_editable(child)
            and compat.is_editable(child.data))


# ---------------------------------------------------------------- structural work
def sync(wrinkled: list[bpy.types.Object]) -> None:
    """Called after other structural work: give every child its own mesh that is large enough, and remove unused
    children."""
    seen: set[int] = set()
    for child, nodes_mod in list(all_curves()):
        if not compat.is_editable(child):
            continue
        garment = garment_of(nodes_mod)
        if _is_left_over(child, garment, wrinkled):
            remove(child)
            continue
        key = compat.session_key(child.data)
        if key in seen or not compat.is_editable(child.data):
            child.data = child.data.copy()
        seen.add(compat.session_key(child.data))
        if garment is not None and modifier.mesh_cache(child) is None and child.mode == "OBJECT":
            wanted = _wanted_capacity(garment)
            if capacity(child.data) < wanted:
                _set_capacity(child.data, wanted)
                _write_again(garment)


def _is_left_over(child: bpy.types.Object, garment: bpy.types.Object | None,
                  wrinkled: list[bpy.types.Object]) -> bool:
    """Whether its garment was deleted, or no longer has such wrinkles. If the artist has only cleared the input, the
    child stays."""
    if garment is None:
        return child.parent is None
    return (garment not in wrinkled or not properties.system_of(garment).wrinkles.HAS_CURVES
            or _was_deleted(child, garment))


def _was_deleted(child: bpy.types.Object, garment: bpy.types.Object) -> bool:
    """Whether the artist has deleted the garment. Blender then takes it out of all collections, but keeps it, because
    the child refers to it."""
    return compat.is_editable(garment) and not garment.users_collection and bool(child.users_collection)


def note_deleted(scene: bpy.types.Scene) -> None:
    """Called after an update: request the removal of children whose garments were deleted."""
    for child, nodes_mod in all_curves():
        garment = garment_of(nodes_mod)
        if garment is None or compat.holds(scene.objects, garment) or not compat.is_editable(child):
            continue
        if _was_deleted(child, garment):
            scheduler.request()


# ---------------------------------------------------------------- baked
class Recorder:
    """Records the curves of a garment sample by sample during a bake, and lets its children play them. They are first
    written to a temporary file beside the clip, because the capacity for the longest sample is known only at the
    end."""

    def __init__(self, garment: bpy.types.Object, clip: Path) -> None:
        """clip: the garment's clip."""
        self.garment, self.clip = garment, clip_path(clip)
        self.points: list[int] = []  # of every sample
        self.waiting: BinaryIO | None = None
        self.wanted = bool(of(garment))
        self.writer: clip_file.SampleWriter | None = None

    def add(self) -> None:
        """Add the last solved sample. Raises ClipFault."""
        if not self.wanted:
            return
        runtime = runtimes.of(self.garment)
        inputs = runtime.inputs
        curves = CurvePoints.none() if inputs is None else runtime.evaluator.curves(inputs.frame, inputs.positions,
                                                                                    inputs.settings)
        points = min(len(curves.width), MOST_ROOM)
        try:
            if self.waiting is None:
                self.waiting = open(clip_folder.temporary(self.clip), "w+b")
            self.waiting.write(rows_of(curves, points)[0].tobytes())
        except OSError as error:
            raise ClipFault(clip_folder.in_words(error, self.clip.parent)) from error
        self.points.append(points)

    def seal(self, manifest: Manifest) -> int:
        """Write the clip that in_place() moves beside the garment's clip, and return its checksum. Raises ClipFault."""
        if not self.wanted or self.waiting is None:
            return 0
        room = capacity_for(max(self.points))
        about = replace(manifest, vertices=ROWS * room, points=ROWS * room, checksums=[])
        self.writer = clip_file.SampleWriter(self.clip, about)
        try:
            self.waiting.seek(0)
            for points in self.points:
                self.writer.add_points(self._read(points, room))
        except OSError as error:
            raise ClipFault(clip_folder.in_words(error, self.clip.parent)) from error
        self.writer.seal()
        self._forget_waiting()
        return clip_file.checksum(about)

    def _read(self, points: int, room: int) -> np.ndarray:
        """The rows of the next sample, padded to this capacity."""
        assert self.waiting is not None
        rows = np.zeros((ROWS, room, 3), np.float32)
        data = self.waiting.read(ROWS * points * 3 * rows.itemsize)
        rows[:, :points] = np.ndarray((ROWS, points, 3), np.float32, data)
        return rows.reshape(-1, 3)

    def _forget_waiting(self) -> None:
        """Close and remove the temporary file. Never raises, although buffered data may not fit on the disk."""
        if self.waiting is None:
            return
        try:
            self.waiting.close()
        except OSError:
            pass
        clip_folder.discard(Path(self.waiting.name))
        self.waiting = None

    def discard(self) -> None:
        """Keep the former clip."""
        self._forget_waiting()
        if self.writer is not None:
            self.writer.discard()

    @contextmanager
    def in_place(self) -> Iterator[None]:
        """A context in which the garment's clip is moved into place. If this fails, the former curves are restored,
        because curves of another bake are not shown. Raises ClipFault."""
        if self.writer is None:
            yield
            return
        try:
            with clip_folder.aside(self.clip):
                self.writer.commit()
                try:
                    yield
                except BaseException:
                    self.writer.take_back()
                    raise
        except OSError as error:
            raise ClipFault(clip_folder.in_words(error, self.clip.parent)) from error

    def play(self, stored_path: Any) -> None:
        """Let the children play the clip. stored_path: returns the form of a path in the blend file."""
        if self.writer is not None:
            play(self.garment, self.writer.manifest, stored_path(self.writer.clip))


def play(garment: bpy.types.Object, about: Manifest, path: str) -> None:
    """Let the curves of a garment play their clip. path: in the form of the blend file."""
    for child in of(garment):
        if compat.is_editable(child):
            free(child)  # of the former clip, which it has played until now
            _set_capacity(child.data, about.points // ROWS)
            cache = modifier.add_mesh_cache(child, about, path)
            cache.interpolation = "NONE"  # between two samples the curves may differ, so they only follow the pose
            cache.show_viewport = False  # while it is the last one, the points differ in number: an error is printed
            compat.move_modifier(child, len(child.modifiers) - 1, 0)
            modifier.mesh_cache(child).show_viewport = True


def clip_path(clip: Path) -> Path:
    """The path of the curves of a garment's clip. Names of clips have no dots."""
    return clip.with_suffix(f"{SUFFIX}{clip.suffix}")


def free(child: bpy.types.Object) -> None:
    """Show live curves again."""
    cache = modifier.mesh_cache(child)
    if cache is not None and compat.is_editable(child):
        child.modifiers.remove(cache)
