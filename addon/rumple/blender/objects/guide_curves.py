# SPDX-License-Identifier: GPL-3.0-or-later
"""Guides of a garment: its child curves and its seams, in the form that core/paint/fold_guides.py needs.

`object.rumple_guide` of each curve has the settings of its folds. A curve is read in the garment's object space at
rest, independent of the pose and the location of the garment.
"""
from __future__ import annotations

from typing import Callable, Iterator

import bpy
import numpy as np
from mathutils.geometry import interpolate_bezier

from ...core.base import transforms
from ...core.base.wording import UserError
from ...core.paint.fold_guides import DIRECTION, KINDS, PUCKER, Guide
from .. import compat
from . import incoming_mesh, modifier, runtimes, units

_OVERRIDE = {"LIBRARY_OVERRIDABLE"}
SPACING, DEPTH, REACH = 0.03, 0.006, 0.15  # metres, defaults of a new guide
SEAM_RINGS = 2  # width of a seam's puckers in spacings, both sides together


def _changed(group: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    obj = group.id_data
    read_again(obj.parent if obj.type != "MESH" else obj)


_LENGTH = dict(min=0.0, step=0.02, precision=4, subtype="DISTANCE", unit="LENGTH", options=set(), override=_OVERRIDE,
               update=_changed)


class RUMPLE_Guide(bpy.types.PropertyGroup):
    """What folds along a curve are, on the curve; and what puckers along seams are, on the garment."""

    is_guide: bpy.props.BoolProperty(name="Guide", default=False, options=set(), override=_OVERRIDE, update=_changed,
                                     description="Folds of the garment that this curve is a child of run along it")
    kind: bpy.props.EnumProperty(name="Folds", items=KINDS, options=set(), override=_OVERRIDE, update=_changed,
                                 description="What the curve makes of the cloth")
    count: bpy.props.IntProperty(name="Count", default=3, min=1, max=200, soft_max=30, options=set(),
                                 override=_OVERRIDE, update=_changed,
                                 description="Folds side by side; of puckers, how many spacings they reach over")
    spacing: bpy.props.FloatProperty(name="Spacing", default=SPACING, soft_max=0.1, **_LENGTH,
                                     description="From fold to fold")
    depth: bpy.props.FloatProperty(name="Fold Depth", default=DEPTH, soft_max=0.03, **_LENGTH,
                                   description="From valley to crest. The radius of each point of the curve scales it")
    reach: bpy.props.FloatProperty(name="Reach", default=REACH, soft_max=1.0, **_LENGTH,
                                   description="How far to each side folds turn along the curve: wholly up to the half "
                                               "of it, less and less behind. The radius of each point of the curve "
                                               "says how much")
    others: bpy.props.FloatProperty(name="Other Folds", default=0.0, min=0.0, max=1.0, subtype="FACTOR", options=set(),
                                    override=_OVERRIDE, update=_changed,
                                    description="Share of the folds of motion that stays between those of the guide")
    seam_depth: bpy.props.FloatProperty(name="Seam Pucker", default=0.0, soft_max=0.02, **_LENGTH,
                                        description="How high the cloth puckers along edges that are marked as seams")
    seam_spacing: bpy.props.FloatProperty(name="Pucker Spacing", default=0.02, soft_max=0.06, **_LENGTH,
                                          description="From pucker to pucker along a seam")


def of(garment: bpy.types.Object) -> list[bpy.types.Object]:
    """The garment's guides, ordered by name."""
    return [child for child in garment.children if child.type == "CURVE" and child.rumple_guide.is_guide]


def make_folds(garment: bpy.types.Object) -> bool:
    """Whether its guides make geometric folds, which the shading of a coarse mesh cannot show."""
    return garment.rumple_guide.seam_depth > 0.0 or any(guide.rumple_guide.kind != "DIRECTION" for guide in of(garment))


def read_again(garment: bpy.types.Object | None) -> None:
    """Mark the guides, so that the next update reads them."""
    runtime = None if garment is None else runtimes.known(garment)
    if runtime is not None:
        runtime.paint.values = None
        garment.update_tag()


def note_updates(garment: bpy.types.Object, touched: set[int]) -> None:
    """Called after an update, which may have changed, added or removed guides. touched: session keys of the changed
    data."""
    runtime, found = runtimes.of(garment), of(garment)
    names = [guide.name for guide in found]
    if names != runtime.seen.guides or any(compat.session_key(key) in touched for guide in found
                                           for key in (guide, guide.data)):
        runtime.seen.guides, runtime.paint.values = names, None
        modifier.tag_soon([garment])


def read(garment: bpy.types.Object, rest_of: Callable[[], np.ndarray]) -> np.ndarray | None:
    """The rows of all guides; None if there are none. rest_of: returns (n, 3) positions of the incoming mesh. Raises
    UserError."""
    scene = units.scene_of(garment)
    # Lengths are stored in the scene's units.
    scale = scene.unit_settings.scale_length / (units.metres_per_unit(garment, scene) or 1.0)
    rows: list[np.ndarray] = []
    for guide in of(garment):
        about, matrix = guide.rumple_guide, np.array(guide.matrix_parent_inverse @ guide.matrix_basis)
        kind = [identifier for identifier, *_ in KINDS].index(about.kind)
        for points in _lines(guide.data):
            points[:, :3] = transforms.placed(matrix, points[:, :3])
            if not np.isfinite(points).all():
                raise UserError(f"{garment.name}: the guide \"{guide.name}\" has a point without a valid place: delete "
                                "that point")
            spacing = about.reach if kind == DIRECTION else about.spacing
            line = Guide(points[:, :3], points[:, 3], kind, about.count, scale * spacing, scale * about.depth,
                         about.others)
            rows.append(line.rows(len(rows)))
    about = garment.rumple_guide
    if about.seam_depth > 0.0 and about.seam_spacing > 0.0:
        rest = rest_of()
        for chain in _seams(incoming_mesh.of(garment)):
            line = Guide(rest[chain], np.ones(len(chain)), PUCKER, SEAM_RINGS, scale * about.seam_spacing,
                         scale * about.seam_depth, 1.0)
            rows.append(line.rows(len(rows)))
    return np.concatenate(rows) if rows else None


def _lines(curve: bpy.types.Curve) -> Iterator[np.ndarray]:
    """(k, 4) position and radius of the points, for every spline."""
    for spline in curve.splines:
        if spline.type == "BEZIER":
            points = _bezier_points(spline)
        else:
            points = [(*point.co[:3], point.radius) for point in spline.points]
            points += points[:1] if spline.use_cyclic_u else []
        if len(points) > 1:
            yield np.array(points, np.float64)


def _bezier_points(spline: bpy.types.Spline) -> list[tuple[float, ...]]:
    knots, steps = list(spline.bezier_points), max(spline.resolution_u, 2)
    found: list[tuple[float, ...]] = []
    for one, two in zip(knots, knots[1:] + (knots[:1] if spline.use_cyclic_u else [])):
        places = interpolate_bezier(one.co, one.handle_right, two.handle_left, two.co, steps + 1)
        radii = np.linspace(one.radius, two.radius, steps + 1)
        begin = 1 if found else 0
        found += [(*place, radius) for place, radius in zip(places[begin:], radii[begin:])]
    return found


def _seams(mesh: bpy.types.Mesh) -> Iterator[list[int]]:
    """The vertices of every line of edges that are marked as seams."""
    marked = compat.edge_marks(mesh).get("use_seam")
    if marked is None:
        return
    beside: dict[int, list[int]] = {}
    for one, two in compat.edge_vertices(mesh)[marked].tolist():
        beside.setdefault(one, []).append(two)
        beside.setdefault(two, []).append(one)
    ends = dict.fromkeys(vertex for vertex in sorted(beside) if len(beside[vertex]) != 2)  # ordered, with fast lookup
    for begin in (*ends, *sorted(beside)):  # first the lines between ends; the rest are rings
        while beside[begin]:
            chain = [begin]
            while beside[chain[-1]] and (len(chain) == 1 or chain[-1] not in ends):
                after = beside[chain[-1]].pop()
                beside[after].remove(chain[-1])
                chain.append(after)
            yield chain


def register() -> None:
    bpy.utils.register_class(RUMPLE_Guide)
    bpy.types.Object.rumple_guide = bpy.props.PointerProperty(type=RUMPLE_Guide, override=_OVERRIDE)


def unregister() -> None:
    del bpy.types.Object.rumple_guide
    bpy.utils.unregister_class(RUMPLE_Guide)
