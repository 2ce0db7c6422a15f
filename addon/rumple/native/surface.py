# SPDX-License-Identifier: GPL-3.0-or-later
"""The coarse base mesh, the shown mesh that replaces it, and frames: native/include/rumple/surface.h."""
from __future__ import annotations

import ctypes
from typing import Any, Callable, Sequence, TypeVar

import numpy as np

from . import c
from .arrays import BYTE, DOUBLE, FLOAT, INT, Shapes, address, checked, fill, given, lent_all, new
from .handle import Array, Handle, Number
from .library import lib
from .struct import Choice, Within, chosen, put


class Surface(Handle):
    """A checked base mesh at rest. Made by build_surface."""

    __slots__ = ()
    POINTER, FREE = c.SurfacePointer, "rumple_surface_free"
    VIEW, LOOK = c.SurfaceView, "rumple_surface_get_view"

    vertex_count = Number("n: vertices as the artist has them")
    welded_vertex_count = Number("w: vertices after seams were joined")
    triangle_count = Number("t")

    @property
    def warnings(self) -> list[str]:
        """The texts of the warnings."""
        return [lib.rumple_surface_warning(self, number).decode() for number in range(self.view.warning_count)]


class HealedMesh(Handle):
    """A healed copy of a mesh, which build_surface accepts. Made by heal_mesh. n vertices: those of the mesh, then
    copies; p polygons, c corners, t triangles."""

    __slots__ = ()
    POINTER, FREE = c.HealedPointer, "rumple_healed_free"
    VIEW, LOOK = c.HealedView, "rumple_healed_get_view"

    polygon_start = Array("(p + 1,) int32", INT, "polygon_count", more=1)
    corner_vertex = Array("(c,) int32", INT, "corner_count")
    triangle_corner = Array("(t, 3) int32", INT, "triangle_count", 3)
    vertex_source = Array("(n,) int32: vertex of the mesh", INT, "vertex_count")
    corner_source = Array("(c,) int32: corner of the mesh", INT, "corner_count")
    polygon_source = Array("(p,) int32: polygon of the mesh", INT, "polygon_count")
    turned = Array("(k,) int32: polygons of the mesh that are wound the other way", INT, "turned_count")
    cut = Array("(k, 2) int32: edges of the mesh at which polygons were cut off", INT, "cut_count", 2)
    doubled = Array("(k, 2) int32: a polygon that was left out, and the one it lies on", INT, "doubled_count", 2)
    repeated = Array("(k,) int32: polygons that use a vertex twice", INT, "repeated_count")


def heal_mesh(positions_rest: np.ndarray, polygon_start: np.ndarray, corner_vertex: np.ndarray,
              triangle_corner: np.ndarray, weld_seams: bool = True) -> HealedMesh:
    """Makes any mesh acceptable for build_surface, with the same arguments (Gueziec, Taubin, Lazarus and Horn 2001).
    Raises ValueError for values that are not finite, an index out of range, a polygon with fewer than three corners."""
    return HealedMesh.made(lib.rumple_healed_build,
                           _surface_plan(positions_rest, polygon_start, corner_vertex, triangle_corner, weld_seams))


def build_surface(positions_rest: np.ndarray, polygon_start: np.ndarray, corner_vertex: np.ndarray,
                  triangle_corner: np.ndarray, weld_seams: bool = True, crease_edge: np.ndarray | None = None,
                  crease_sharpness: np.ndarray | None = None) -> Surface:
    """Check a polygon mesh and join its seams.

    positions_rest: (n, 3) float32, object space. polygon_start: (p + 1,) int32, the first corner of every polygon and
    the number of corners. corner_vertex: (c,) int32. triangle_corner: (t, 3) int32, the corners of a triangulation of
    every polygon. weld_seams: join border vertices at one place. crease_edge: (k, 2) int32, vertices of edges that
    subdivision rounds less. crease_sharpness: (k,) float32, for how many subdivisions, 0 or more; 10 or more: always.
    Raises ValueError naming the first bad element.
    """
    plan = _surface_plan(positions_rest, polygon_start, corner_vertex, triangle_corner, weld_seams)
    if crease_edge is not None and crease_sharpness is not None:
        fill(plan, "crease_edge", crease_edge, INT, 2)
        fill(plan, "crease_sharpness", crease_sharpness, FLOAT)
    return Surface.made(lib.rumple_surface_build, plan)


def _surface_plan(positions_rest: np.ndarray, polygon_start: np.ndarray, corner_vertex: np.ndarray,
                  triangle_corner: np.ndarray, weld_seams: bool) -> Any:
    """The plan of a surface. The arrays must live as long as the plan."""
    plan = lib.rumple_surface_plan_default()
    fill(plan, "positions_rest", positions_rest, FLOAT, 3)
    fill(plan, "polygon_start", polygon_start, INT)
    fill(plan, "corner_vertex", corner_vertex, INT)
    fill(plan, "triangle_corner", triangle_corner, INT, 3)
    plan.weld_seams = weld_seams
    return plan


def count_openings(surface: Surface) -> int:
    """The number of openings of the connected part that has most of them. An opening is an open border that is not the
    outline of a sheet. A shirt has four, a skirt two, a head one. Separate heads, arms and feet also give one."""
    openings = ctypes.c_int32()
    lib.rumple_surface_count_openings(surface, ctypes.addressof(openings))
    return openings.value


def is_uneven(surface: Surface, width: float) -> bool:
    """Whether more than a tenth of the area lies in polygons narrower than `width`, object units. The width of a
    polygon is its area / its longest side; of a triangle twice that: its height. Cost: O(corners)."""
    uneven = ctypes.c_bool()
    lib.rumple_surface_is_uneven(surface, width, ctypes.addressof(uneven))
    return uneven.value


def outer_side(surface: Surface, polygon_count: int) -> tuple[np.ndarray, float]:
    """The outer side of a garment with modelled thickness: (p,) bool, the polygons of the outer side and of parts
    without an inner side; and the thickness, object units. All polygons and 0 if no thickness is modelled."""
    outer, thickness = new(BYTE, polygon_count), ctypes.c_float()
    lib.rumple_surface_outer_side(surface, address(outer), outer.size, ctypes.addressof(thickness))
    return outer.astype(bool), thickness.value


def suggest_follow(surface: Surface, up: Sequence[float]) -> np.ndarray:
    """(n,) float32: how firmly every vertex follows the animation, 0 to 1. It is derived from the open borders at rest:
    collars, waistbands and cuffs. up: three floats, unit, object space."""
    direction = _direction(up)
    follow = new(FLOAT, surface.vertex_count)
    lib.rumple_surface_suggest_follow(surface, address(direction), address(follow), len(follow))
    return follow


def sewn_on(surface: Surface, up: Sequence[float], polygon_count: int) -> np.ndarray:
    """(p,) bool: the polygons of parts that are sewn on other parts of the garment (pockets, lapels, the shirt front in
    a jacket). Alone they would fall. up: as of suggest_follow."""
    direction, sewn = _direction(up), new(BYTE, polygon_count)
    lib.rumple_surface_sewn_on(surface, address(direction), address(sewn), sewn.size)
    return sewn.astype(bool)


def _direction(up: Sequence[float]) -> np.ndarray:
    direction = np.array(up, np.float32)
    if direction.shape != (3,):
        raise ValueError(f"up: expected three floats, got {direction.shape}")
    return direction


def rigid_motions(starts: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """(p, 4, 3) float32: for each of p parts the rigid motion that fits the movement of its points best: the rows of
    the rotation R, then the translation t. A point x moves to R x + t. starts: (p + 1,) int32, the first point of each
    part, then the number of points n. before, after: (n, 3) float32. Cost: O(n)."""
    first, count = given(starts, "starts", INT)
    motions = new(FLOAT, max(count - 1, 0), 12)
    lib.rumple_rigid_motions(first, count, *given(before, "before", FLOAT, 3), *given(after, "after", FLOAT, 3),
                             address(motions), len(motions))
    return motions.reshape(-1, 4, 3)


class ShownMesh(Handle):
    """The mesh that is shown instead of the base: d vertices, q polygons, k corners. Part of a model."""

    __slots__ = ("_model",)
    _model: Handle
    VIEW, LOOK = c.ShownMeshView, "rumple_shown_mesh_get_view"

    vertex_count = Number("d")
    polygon_start = Array("(q + 1,) int32: the first corner of every polygon, then k", INT, "polygon_count", more=1)
    corner_vertex = Array("(k,) int32", INT, "corner_count")
    polygon_source = Array("(q,) int32: polygon of the base, or of the own mesh", INT, "polygon_count")
    edges = Array("(e, 2) int32: shown edges that lie on a source edge", INT, "edge_count", 2)
    edge_sources = Array("(e, 2) int32: the vertices of that source edge", INT, "edge_count", 2)
    positions_rest = Array("(d, 3) float32, object space", FLOAT, "vertex_count", 3)
    triangle_vertex = Array("(d, 3) int32: the base vertices that every shown vertex is embedded in", INT,
                            "vertex_count", 3)
    barycentric = Array("(d, 2) float32: weights of the second and third of them", FLOAT, "vertex_count", 2)
    solved_start = Array("(d + 1,) int32: the first entry of every vertex, then m", INT, "vertex_count", more=1)
    solved_vertex = Array("(m,) int32: the solved vertices that its position is made from", INT, "solved_count")
    solved_weight = Array("(m,) float32: their weights", FLOAT, "solved_count")

    def __init__(self, model: Handle, pointer: Any) -> None:
        """Borrowed from a model, which it keeps alive."""
        self._model, self._as_parameter_, self._seen = model, pointer, None

    def carry_points(self, values: np.ndarray, source_vertices: int) -> np.ndarray:
        """(n, j) float32 of the source's vertices -> (d, j), linear."""
        return self._carried(lib.rumple_shown_mesh_carry_points, values, "point values", source_vertices,
                             self.vertex_count)

    def carry_corners(self, values: np.ndarray, source_corners: int) -> np.ndarray:
        """(c, j) float32 of the source's corners -> (k, j) of the shown mesh; seams stay sharp."""
        return self._carried(lib.rumple_shown_mesh_carry_corners, values, "corner values", source_corners,
                             self.view.corner_count)

    def _carried(self, carry: Any, values: np.ndarray, name: str, rows: int, count: int) -> np.ndarray:
        if not isinstance(values, np.ndarray) or values.ndim != 2 or len(values) != rows:
            came = f"{values.dtype} {values.shape}" if isinstance(values, np.ndarray) else type(values).__name__
            raise ValueError(f"{name}: expected shape ({rows}, k), got {came}")
        columns = values.shape[1]
        place, _ = given(values, name, FLOAT, columns)
        out = new(FLOAT, count, columns)
        carry(self, place, rows, columns, address(out), count)
        return out


class Model(Handle):
    """Base class of the models of all systems. SHOWN: the function that returns the borrowed shown mesh."""

    __slots__ = ()
    SHOWN = ""

    @property
    def shown(self) -> ShownMesh:
        """The mesh that is shown."""
        return ShownMesh(self, getattr(lib, self.SHOWN)(self))


class SteppedModel(Model):
    """A model whose shown mesh may be subdivided fewer times in viewports."""

    __slots__ = ()

    @property
    def shown(self) -> ShownMesh:
        """The mesh that is shown in renders."""
        return ShownMesh(self, getattr(lib, self.SHOWN)(self, False))

    @property
    def shown_in_viewport(self) -> ShownMesh:
        """The mesh that is shown in viewports. It is the mesh of renders if it does not have fewer steps."""
        return ShownMesh(self, getattr(lib, self.SHOWN)(self, True))


class ShownFrame(Handle):
    """The shown mesh of one frame, of any system; d vertices."""

    __slots__ = ()
    POINTER, FREE = c.FramePointer, "rumple_frame_free"
    VIEW, LOOK = c.FrameView, "rumple_frame_get_view"

    positions = Array("(d, 3) float32, object space", FLOAT, "vertex_count", 3)
    local_offset = Array("(d, 3) float32, from the linear embedding, in the frame of the deformed base triangle", FLOAT,
                         "vertex_count", 3)
    offset = Array("(d, 3) float32, from the unwrinkled surface, object space", FLOAT, "vertex_count", 3)
    stretch_min = Array("(d,) float32, smaller principal stretch of the base, 1 at rest", FLOAT, "vertex_count")
    stretch_max = Array("(d,) float32, the larger one", FLOAT, "vertex_count")
    stretch_direction = Array("(d, 3) float32, of strongest compression, unit, object space", FLOAT, "vertex_count", 3)


def embed_frame(frame: ShownFrame, positions: np.ndarray) -> None:
    """Embeds a frame in other positions, (n, 3) float32, of its model's base. local_offset is computed again, also in
    arrays that were read before. Raises ValueError."""
    lib.rumple_frame_embed(frame, *given(positions, "positions", FLOAT, 3))


# ---------------------------------------------------------------- arguments of all systems
def fine_plan(plan: Any, source: str, level: int, segments: int, longest_edge: float, most_vertices: int,
              attachment: str, sources: Sequence[str] = ("SUBDIVISION", "REGULAR", "EDGE_LENGTH")) -> None:
    """Fills a plan of a fine mesh."""
    plan.source = chosen(source, "source", {name: c.FINE_SOURCE[name] for name in sources})
    plan.level, plan.segments, plan.longest_edge = level, segments, longest_edge
    plan.most_vertices = most_vertices
    plan.attachment = chosen(attachment, "attachment", c.ATTACHMENT)


def pose(positions: np.ndarray, time: float = 0.0, labels: np.ndarray | None = None,
         next_positions: np.ndarray | None = None, next_time: float = 0.0,
         world_from_object: np.ndarray | None = None) -> Any:
    """The struct of the base in one frame. positions: (n, 3) float32. The arrays must live as long as the struct."""
    out = lib.rumple_pose_default()
    place, count = given(positions, "positions", FLOAT, 3)
    put(out, "positions", place)
    put(out, "positions_count", count)
    put(out, "time", time)
    put(out, "next_time", next_time)
    if labels is not None:
        fill(out, "labels", labels, BYTE)
    if next_positions is not None:
        fill(out, "next_positions", next_positions, FLOAT, 3)
    if world_from_object is not None:
        rows = checked(world_from_object, "world_from_object", FLOAT, 3)
        if rows.shape != (3, 3):
            raise ValueError(f"world_from_object: expected shape (3, 3), got {rows.shape}")
        out.world_from_object[:] = rows.ravel().tolist()
    return out


class FramePose(Handle):
    """The pose of a model in one frame. Make it once per frame, and pass it to all functions for this frame. BUILD: the
    function that makes it."""

    __slots__ = ()
    BUILD = ""

    @classmethod
    def of(cls, model: Any, positions: "np.ndarray | FramePose", *others: Any, **named: Any) -> Any:
        """positions, others, named: arguments of pose(); or a pose, which is returned unchanged."""
        if isinstance(positions, FramePose):
            return positions
        return cls.made(getattr(lib, cls.BUILD), model, pose(positions, *others, **named))


class FrameState(Handle):
    """Base class of the states of all systems. of() of the class makes the same state from the arrays, bit for bit."""

    __slots__ = ()
    nbytes = Number("memory of the state", "bytes")

    @property
    def arrays(self) -> dict[str, Any]:
        """The state as plain arrays."""
        raise NotImplementedError


class ReferenceSettings:
    """The settings of adaptive rest shapes, as part of a system's settings."""

    __slots__ = ()
    window = Within("rest", "seconds; labels compare with the pose so long ago; 0: the previous frame")
    relaxation = Within("rest", "share per 1/30 s by which compressed reference triangles give in, 0..1")
    growth = Within("rest", "most length of a reference triangle over the rest pose's, >= 1")
    growth_time = Within("rest", "seconds in which a reference triangle takes over a longer shape, >= 0")
    reference = Choice(c.REFERENCE, "what compression is measured against", outer="rest")


REFERENCE_ARRAYS: Shapes = {
    "labels": (BYTE, 0), "reference": (FLOAT, 3), "past_times": (DOUBLE, 0), "past_positions": (FLOAT, 3)}


def stored_array(arrays: dict[str, Any], name: str) -> Any:
    """One of the arrays. Raises ValueError if it is missing."""
    if name not in arrays:
        raise ValueError(f"state: expected an array {name}, got none")
    return arrays[name]


N = TypeVar("N", int, float)


def stored_number(arrays: dict[str, Any], name: str, kind: Callable[[Any], N]) -> N:
    """One of the numbers. Raises ValueError if it is missing or not a number of this kind."""
    try:
        return kind(arrays[name])
    except (KeyError, TypeError, ValueError, OverflowError):
        raise ValueError(f"state: expected a number {name}, got {arrays.get(name, 'none')!r}") from None


def fill_stored(view: Any, arrays: dict[str, Any], shapes: Shapes) -> None:
    """Puts plain arrays into a view, by name. They must live as long as the view. Raises ValueError if one is missing
    or wrong."""
    for name, (dtype, columns) in shapes.items():
        fill(view, name, stored_array(arrays, name), dtype, columns)


def fill_reference(view: Any, arrays: dict[str, Any]) -> None:
    """Fills the state of the reference triangles from plain arrays. They must live as long as the view."""
    view.time = stored_number(arrays, "time", float)
    fill_stored(view, arrays, REFERENCE_ARRAYS)


def reference_arrays(owner: Handle, view: Any) -> dict[str, Any] | None:
    """The state of the reference triangles in a handle as plain arrays; None if it has none."""
    return {"time": view.time, **lent_all(owner, view, REFERENCE_ARRAYS)} if view.reference_count else None


def label_clip(model: Any, settings: Any, times: np.ndarray, positions: np.ndarray, raw: bool = False) -> np.ndarray:
    """Labels of a whole clip by one graph cut, (f, t) uint8: 0 compress, 1 rest, 2 stretch (Gillette 2015, section
    4.1.2). times: (f,) float64, seconds, ascending. positions: (f n, 3) float32, frame after frame. raw: every triangle
    gets the label that is cheapest for itself, without a cut. Cost: about 1 ms and half a megabyte per frame and 1,000
    triangles."""
    when, frames = given(times, "times", DOUBLE)
    where, points = given(positions, "positions", FLOAT, 3)
    labels = new(BYTE, frames, model.base.triangle_count)
    getattr(lib, model.LABEL)(model, settings, when, frames, where, points, raw, address(labels), labels.size)
    return labels


__all__ = ["HealedMesh", "ShownFrame", "ShownMesh", "Surface", "build_surface", "count_openings", "embed_frame",
           "heal_mesh", "is_uneven", "label_clip", "outer_side", "rigid_motions", "sewn_on",
           "suggest_follow"]
