# SPDX-License-Identifier: GPL-3.0-or-later
"""Limits for Blender's own Subdivision behind the wrinkles. Quads are cheap. For triangles it refines every corner
according to its Quality, which needs gigabytes for a fine mesh of tens of thousands. The user is warned before the
memory is needed."""
from __future__ import annotations

from typing import Any, Callable

import bpy
import numpy as np

from ...core.base.wording import UserError
from . import modifier

MEGABYTES = 0.028  # per triangle and step of Quality: measured in 3.4, 5,632 triangles, Quality 1 to 4
NOTED, MOST = 300.0, 3000.0  # megabytes
MANY = 1_000_000  # number of vertices in a render


def refuse_costly(obj: bpy.types.Object, fine: Any) -> None:
    """Raises UserError if Blender could crash from lack of memory. The result depends on quality() too. fine:
    the engine.Wrinkles to show."""
    name, needed = _need(obj, fine)
    if needed > MOST:
        raise UserError(_sentence(obj, name, needed))


def try_lighter(obj: bpy.types.Object, prepare: Callable[[], bool]) -> str:
    """Try to make the fine mesh without Use Limit Surface in the Subdivisions behind it. The limit surface needs the
    gigabytes, and has little effect on a fine mesh. prepare: makes the mesh, and returns whether this succeeded.
    Returns a message; empty if it failed, and then nothing is changed."""
    costly = _refining(obj)
    for m in costly:
        m.use_limit_surface = False
    if costly and prepare():
        names = ", ".join(f'"{m.name}"' for m in costly)
        return (f"{obj.name}: Use Limit Surface (Advanced) is off now in the modifier {names} below the wrinkles: for "
                "a fine mesh of triangles it needs gigabytes")
    for m in costly:
        m.use_limit_surface = True
    return ""


def quality(obj: bpy.types.Object) -> int:
    """The largest Quality of a Subdivision behind the wrinkles; 0: none refines."""
    return max((m.quality for m in _refining(obj)), default=0)


def notes(obj: bpy.types.Object, fine: Any) -> list[str]:
    """Warnings about large memory or vertex numbers. fine: the shown engine.Wrinkles, or None."""
    name, needed = _need(obj, fine)
    return [_sentence(obj, name, needed)] if needed > NOTED else _too_many(obj, fine)


def _too_many(obj: bpy.types.Object, fine: Any) -> list[str]:
    """Warns about levels that were chosen for the coarse mesh: on a fine mesh they make millions of vertices."""
    behind = [m for m in _behind(obj) if m.type == "SUBSURF" and m.show_render and m.render_levels]
    if not behind or fine is None or _only_shades(obj):
        return []
    count = fine.vertex_count * 4**sum(m.render_levels for m in behind)
    return [f"{obj.name}: the modifier \"{behind[-1].name}\" below the wrinkles makes {count:,} vertices in renders: "
            "the fine mesh is smooth already, so set its levels to 0"] if count > MANY else []


def _only_shades(obj: bpy.types.Object) -> bool:
    return obj.rumple.method == "FIELD" and obj.rumple.field.output == "SHADING"


def _need(obj: bpy.types.Object, fine: Any) -> tuple[str, float]:
    """The modifier that needs most memory, and megabytes. A mesh that is only shaded does not count: it has its own
    triangles, which the artist chose."""
    behind = _refining(obj)
    if fine is None or _only_shades(obj) or not behind:
        return "", 0.0
    triangles = int((np.diff(fine.polygon_start) == 3).sum())
    costliest = max(behind, key=lambda m: m.quality)
    return costliest.name, MEGABYTES * triangles * costliest.quality


def _refining(obj: bpy.types.Object) -> list[bpy.types.Modifier]:
    return [m for m in _behind(obj) if _refines(m)]


def _behind(obj: bpy.types.Object) -> list[bpy.types.Modifier]:
    nodes_mod, stack = modifier.find(obj), list(obj.modifiers)
    return stack[stack.index(nodes_mod) + 1:] if nodes_mod is not None else []


def _refines(m: bpy.types.Modifier) -> bool:
    return (m.type == "SUBSURF" and m.subdivision_type == "CATMULL_CLARK" and getattr(m, "use_limit_surface", True)
            and bool((m.show_viewport and m.levels) or (m.show_render and m.render_levels)))


def _sentence(obj: bpy.types.Object, name: str, needed: float) -> str:
    return (f"{obj.name}: the modifier \"{name}\" below the wrinkles needs about {needed / 1000.0:.1f} GB for a fine "
            "mesh of triangles: switch off Use Limit Surface in it (Advanced)")
