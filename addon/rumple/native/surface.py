# SPDX-License-Identifier: GPL-3.0-or-later
"""The coarse base mesh, the mesh that is shown in its place, and frames of it: native/include/rumple/surface.h."""
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
        """What was tolerated, in words."""
        return [lib.rumple_surface_warning(self, number).decode() for number in range(self.view.warning_count)]


class HealedMesh(Handle):
    """A mesh that is no oriented manifold, as one that build_surface takes. Made by heal_mesh. n vertices: those of the
    mesh, then copies; p polygons, c corners, t triangles."""

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
    """What build_surface takes, of any mesh. Arguments as there. Raises ValueError for what is not finite, an index out
    of range, a polygon with fewer than three corners. Gueziec, Taubin, Lazarus and Horn 2001."""
    return HealedMesh.made(lib.rumple_healed_build,
                           _surface_plan(positions_rest, polygon_start, corner_vertex, triangle_corner, weld_seams))


def build_surface(positions_rest: np.ndarray, polygon_start: np.ndarray, corner_vertex: np.ndarray,
                  triangle_corner: np.ndarray, weld_seams: bool = True, crease_edge: np.ndarray | None = None,
                  crease_sharpness: np.ndarray | None = None) -> Surface:
    """Check a polygon mesh and join its seams.

    positions_rest: (n, 3) float32, object space. polygon_start: (p + 1,) int32, the first corner of every polygon and
    the number of corners. corner_vertex: (c,) int32. triangle_corner: (t, 3) int32, the corners of a triangulation of
    every polygon. weld_seams: join border vertices at one place. crease_edge: (k, 2) int32, vertices of edges that
    subdivision rounds less. crease_sharpness: (k,) float32, for how many subdivisions, 0 or more; from 10 on for ever.
    Raises ValueError naming the first bad element.
    """
    plan = _surface_plan(positions_rest, polygon_start, corner_vertex, triangle_corner, weld_seams)
    if crease_edge is not None and crease_sharpness is not None:
        fill(plan, "crease_edge", crease_edge, INT, 2)
        fill(plan, "crease_sharpness", crease_sharpness, FLOAT)
    return Surface.made(lib.rumple_surface_build, plan)


def _surface_plan(positions_rest: np.ndarray, polygon_start: np.ndarray, corner_vertex: np.ndarray,
                  triangle_corner: np.ndarray, weld_seams: bool) -> Any:
    """The arrays must outlive it."""
    plan = lib.rumple_surface_plan_default()
    fill(plan, "positions_rest", positions_rest, FLOAT, 3)
    fill(plan, "polygon_start", polygon_start, INT)
    fill(plan, "corner_vertex", corner_vertex, INT)
    fill(plan, "triangle_corner", triangle_corner, INT, 3)
    plan.weld_seams = weld_seams
    return plan


def count_openings(surface: Surface) -> int:
    """Of its connected parts the one with most: open borders that are not the outline of a sheet. A shirt has four, a
    skirt two, a head one, and so have a head, two arms and two feet."""
    openings = ctypes.c_int32()
    lib.rumple_surface_count_openings(surface, ctypes.addressof(openings))
    return openings.value


def outer_side(surface: Surface, polygon_count: int) -> tuple[np.ndarray, float]:
    """Of a garment whose thickness was modelled: (p,) bool, the polygons of its outer side and of parts without an
    inner one; and the thickness, object units. All polygons and 0 where none is modelled."""
    outer, thickness = new(BYTE, polygon_count), ctypes.c_float()
    lib.rumple_surface_outer_side(surface, address(outer), outer.size, ctypes.addressof(thickness))
    return outer.astype(bool), thickness.value


def suggest_follow(surface: Surface, up: Sequence[float]) -> np.ndarray:
    """(n,) float32: how firmly every vertex follows the animation, 0 to 1: collars, waistbands and cuffs, found from
    the open borders at rest. up: three floats, unit, object space."""
    direction = np.array(up, np.float32)
    if direction.shape != (3,):
        raise ValueError(f"up: expected three floats, got {direction.shape}")
    follow = new(FLOAT, surface.vertex_count)
    lib.rumple_surface_suggest_follow(surface, address(direction), address(follow), len(follow))
    return follow


def rigid_motions(starts: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """(p, 4, 3) float32: the rigid motion of each of p parts that is nearest to what moved its points: the rotation R,
    row by row, and the translation t; a point goes to R x + t. starts: (p + 1,) int32, the first point of each part,
    and last their number n. before, after: (n, 3) float32. Cost: O(n)."""
    first, count = given(starts, "starts", INT)
    motions = new(FLOAT, max(count - 1, 0), 12)
    lib.rumple_rigid_motions(first, count, *given(before, "before", FLOAT, 3), *given(after, "after", FLOAT, 3),
                             address(motions), len(motions))
    return motions.reshape(-1, 4, 3)


class CoarseMesh(Handle):
    """A coarse mesh that stands for a dense one. Made by build_coarse. m vertices."""

    __slots__ = ("surface", "dense")
    POINTER, FREE = c.CoarsePointer, "rumple_coarse_free"
    VIEW, LOOK = c.CoarseView, "rumple_coarse_get_view"

    surface: Surface  # its triangles
    dense: Surface
    dense_vertex = Array("(m,) int32: of every vertex a vertex of the dense mesh", INT, "vertex_count")
    mean_edge = Number("mean length of its edges, object units")

    def positions(self, dense: Surface, positions: np.ndarray) -> np.ndarray:
        """(n, 3) float32 of the dense mesh's vertices -> (m, 3), such that the smooth surfaces lie on one another."""
        if dense is not self.dense:
            raise ValueError("dense: the coarse mesh was made for another mesh")
        place, count = given(positions, "positions", FLOAT, 3)
        out = new(FLOAT, self.view.vertex_count, 3)
        lib.rumple_coarse_positions(self, place, count, address(out), len(out))
        return out


def build_coarse(dense: Surface, spacing: float, part: Surface | None = None) -> CoarseMesh:
    """spacing: about the mean length of its edges, object units. part: some of the polygons of the dense mesh over all
    of its vertices, which it stands for; None: all of it. Raises ValueError where the mesh is too small for it. Peyre
    and Cohen 2006."""
    coarse = CoarseMesh.made(lib.rumple_coarse_build_of, dense, part or dense, spacing)
    coarse.dense, coarse.surface = dense, Surface.made(lib.rumple_coarse_surface, coarse)
    return coarse


class ShownMesh(Handle):
    """The mesh that is shown in place of the base: d vertices, q polygons, k corners. Part of a model."""

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

    def __init__(self, model: Handle, pointer: Any) -> None:
        """Borrowed from a model, which it keeps."""
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
    """What a model of any system is. SHOWN: the function that lends its shown mesh."""

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
        """The mesh that is shown in viewports; where it has no fewer steps, that of renders."""
        return ShownMesh(self, getattr(lib, self.SHOWN)(self, True))


F = TypeVar("F", bound="ShownFrame")


class ShownFrame(Handle):
    """What every system shows of a frame; d vertices of the shown mesh."""

    __slots__ = ("_model",)
    _model: Handle
    POINTER, FREE = c.FramePointer, "rumple_frame_free"
    VIEW, LOOK = c.FrameView, "rumple_frame_get_view"

    positions = Array("(d, 3) float32, object space", FLOAT, "vertex_count", 3)
    local_offset = Array("(d, 3) float32, from the linear embedding, in the frame of the deformed base triangle", FLOAT,
                         "vertex_count", 3)
    offset = Array("(d, 3) float32, from the unwrinkled surface, object space", FLOAT, "vertex_count", 3)
    stretch_min = Array("(d,) float32, smaller principal stretch of the base, 1 at rest", FLOAT, "vertex_count")
    stretch_max = Array("(d,) float32, the larger one", FLOAT, "vertex_count")
    stretch_direction = Array("(d, 3) float32, of strongest compression, unit, object space", FLOAT, "vertex_count", 3)

    @classmethod
    def of(cls: type[F], model: Handle, function: Any, *arguments: Any) -> F:
        """A frame of a model."""
        frame = cls.made(function, *arguments)
        frame._model = model
        return frame


def embed_frame(base: Surface, shown: ShownMesh, positions: np.ndarray, frame: ShownFrame) -> None:
    """Embeds a frame in other positions, (n, 3) float32, of the base: its local_offset anew, also in arrays that were
    taken before. base, shown: those of the frame's model."""
    if shown._model is not frame._model:
        raise ValueError("frame: it was made for another model")
    place, count = given(positions, "positions", FLOAT, 3)
    if count != base.vertex_count:
        raise ValueError(f"positions: expected {base.vertex_count} vertices, got {count}")
    lib.rumple_frame_embed(frame, place, count)


# ---------------------------------------------------------------- what all systems take
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
    """The base in one frame. positions: (n, 3) float32. The arrays must outlive it."""
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
    """What the positions of one frame make of a model: made once a frame, handed to all that is asked of the frame.
    BUILD: the function that makes it."""

    __slots__ = ()
    BUILD = ""

    @classmethod
    def of(cls, model: Any, positions: "np.ndarray | FramePose", *others: Any) -> Any:
        """positions, others: as pose() takes them; or a pose, which is returned as it is."""
        if isinstance(positions, FramePose):
            return positions
        return cls.made(getattr(lib, cls.BUILD), model, pose(positions, *others))


class FrameState(Handle):
    """What a system keeps from one frame to the next. Its class makes the same state, to the bit, of the arrays."""

    __slots__ = ()
    nbytes = Number("memory of the state", "bytes")

    @property
    def arrays(self) -> dict[str, Any]:
        """A dict of plain arrays."""
        raise NotImplementedError


class ReferenceSettings:
    """The settings of the reference triangles among those of a system."""

    __slots__ = ()
    window = Within("rest", "seconds; labels compare with the pose so long ago; 0: the previous frame")
    relaxation = Within("rest", "share per 1/30 s by which compressed reference triangles give in, 0..1")
    growth = Within("rest", "most length of a reference triangle over the rest pose's, >= 1")
    growth_time = Within("rest", "seconds in which a reference triangle takes over a longer shape, >= 0")
    reference = Choice(c.REFERENCE, "what compression is measured against", outer="rest")


REFERENCE_ARRAYS: Shapes = {
    "labels": (BYTE, 0), "reference": (FLOAT, 3), "past_times": (DOUBLE, 0), "past_positions": (FLOAT, 3)}


def stored_array(arrays: dict[str, Any], name: str) -> Any:
    """Raises ValueError where there is none."""
    if name not in arrays:
        raise ValueError(f"state: expected an array {name}, got none")
    return arrays[name]


N = TypeVar("N", int, float)


def stored_number(arrays: dict[str, Any], name: str, kind: Callable[[Any], N]) -> N:
    """Raises ValueError where there is none, or what is no number of that kind."""
    try:
        return kind(arrays[name])
    except (KeyError, TypeError, ValueError, OverflowError):
        raise ValueError(f"state: expected a number {name}, got {arrays.get(name, 'none')!r}") from None


def fill_stored(view: Any, arrays: dict[str, Any], shapes: Shapes) -> None:
    """Puts plain arrays into a view, by name. They must outlive it. Raises ValueError where one is missing or wrong."""
    for name, (dtype, columns) in shapes.items():
        fill(view, name, stored_array(arrays, name), dtype, columns)


def fill_reference(view: Any, arrays: dict[str, Any]) -> None:
    """The state of the reference triangles, from plain arrays. They must outlive it."""
    view.time = stored_number(arrays, "time", float)
    fill_stored(view, arrays, REFERENCE_ARRAYS)


def reference_arrays(owner: Handle, view: Any) -> dict[str, Any] | None:
    """The state of the reference triangles in a handle as plain arrays; None where there is none."""
    return {"time": view.time, **lent_all(owner, view, REFERENCE_ARRAYS)} if view.reference_count else None


def label_clip(model: Any, settings: Any, times: np.ndarray, positions: np.ndarray, raw: bool = False) -> np.ndarray:
    """Labels of a whole clip in one cut, (f, t) uint8: 0 compress, 1 rest, 2 stretch. times: (f,) float64, seconds,
    ascending. positions: (f n, 3) float32, frame after frame. raw: every triangle's cheapest label for itself. Cost:
    about 1 ms and half a megabyte per frame and 1,000 triangles. Gillette 2015, section 4.1.2."""
    when, frames = given(times, "times", DOUBLE)
    where, points = given(positions, "positions", FLOAT, 3)
    labels = new(BYTE, frames, model.base.triangle_count)
    getattr(lib, model.LABEL)(model, settings, when, frames, where, points, raw, address(labels), labels.size)
    return labels


__all__ = ["CoarseMesh", "HealedMesh", "ShownFrame", "ShownMesh", "Surface", "build_coarse", "build_surface",
           "count_openings", "embed_frame", "heal_mesh", "label_clip", "outer_side", "rigid_motions", "suggest_follow"]
