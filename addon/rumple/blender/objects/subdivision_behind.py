# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's own Subdivision behind the wrinkles needs. Quads are cheap; of triangles it refines every corner as
often as its Quality says, with gigabytes for a fine mesh of tens of thousands. That is said before it is spent."""
from __future__ import annotations

from typing import Any, Callable

import bpy
import numpy as np

from ...core.engine import UserError
from . import modifier

MEGABYTES = 0.028  # for a triangle and a step of Quality: measured in 3.4, 5,632 triangles, Quality 1 to 4
NOTED, MOST = 300.0, 3000.0  # megabytes
MANY = 1_000_000  # vertices that a render gets


def refuse_costly(obj: bpy.types.Object, fine: Any) -> None:
    """Raises engine.UserError where Blender could end for want of memory. It depends on quality() too. fine:
    engine.Wrinkles that are to be shown."""
    name, needed = _need(obj, fine)
    if needed > MOST:
        raise UserError(_sentence(obj, name, needed))


def try_lighter(obj: bpy.types.Object, prepare: Callable[[], bool]) -> str:
    """Tries to make the fine mesh without the limit surface of what is behind it: that costs the gigabytes, and shows
    little over a fine mesh. prepare: makes it, and says whether that went. Returns what to say of it; empty where it
    did not go, and nothing is changed."""
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
    """Most Quality of a Subdivision behind the wrinkles; 0: none refines."""
    return max((m.quality for m in _refining(obj)), default=0)


def notes(obj: bpy.types.Object, fine: Any) -> list[str]:
    """What to say where it is much. fine: engine.Wrinkles that are shown; None: none are."""
    name, needed = _need(obj, fine)
    return [_sentence(obj, name, needed)] if needed > NOTED else _too_many(obj, fine)


def _too_many(obj: bpy.types.Object, fine: Any) -> list[str]:
    """Folds are fine meshes already: what was chosen for the coarse one makes millions of vertices of them."""
    behind = [m for m in _behind(obj) if m.type == "SUBSURF" and m.show_render and m.render_levels]
    if not behind or fine is None or _only_shades(obj):
        return []
    count = fine.vertex_count * 4**sum(m.render_levels for m in behind)
    return [f"{obj.name}: the modifier \"{behind[-1].name}\" below the wrinkles makes {count:,} vertices in renders: "
            "the fine mesh is smooth already, so set its levels to 0"] if count > MANY else []


def _only_shades(obj: bpy.types.Object) -> bool:
    return obj.rumple.method == "FIELD" and obj.rumple.field.output == "SHADING"


def _need(obj: bpy.types.Object, fine: Any) -> tuple[str, float]:
    """The modifier that needs most, and megabytes. A mesh that is only shaded keeps its own triangles, which the artist
    chose: they are not counted."""
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
