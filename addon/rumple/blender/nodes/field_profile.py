# SPDX-License-Identifier: GPL-3.0-or-later
"""The profile that an artist draws: half a wave, from crest (left) to valley (right).

Blender has such curves only in nodes. So the curve is in a hidden node group, object.rumple.profile_curve. Blender does
not report edits of it. So the panel compares it with the curve in use whenever it is drawn.
"""
from __future__ import annotations

import hashlib

import bpy
import numpy as np

from ...core.base.wording import UserError
from ...core.systems import wrinkle_field
from ...native import kernels
from .. import compat

NAME = "Rumple Profile"
NODE = "Profile"
FIRST_POINTS = 7  # points of a new curve, which is a sine


def ensure(obj: bpy.types.Object) -> None:
    """Give an object its own curve. A duplicate gets a copy."""
    shared = obj.rumple.profile_curve
    if shared is not None and not any(o.rumple.profile_curve == shared for o in bpy.data.objects if o != obj):
        return
    if shared is not None:
        obj.rumple.profile_curve = shared.copy()
        return
    group = bpy.data.node_groups.new(NAME, "ShaderNodeTree")
    mapping = group.nodes.new("ShaderNodeFloatCurve")
    mapping.name = NODE
    points = mapping.mapping.curves[0].points
    for _ in range(FIRST_POINTS - len(points)):
        points.new(0.5, 0.5)
    for point, x in zip(points, np.linspace(0.0, 1.0, FIRST_POINTS)):
        point.location = (float(x), float(0.5 + 0.5 * np.cos(np.pi * x)))
    mapping.mapping.update()
    obj.rumple.profile_curve = group


def node(obj: bpy.types.Object) -> bpy.types.Node | None:
    """The node with the curve."""
    group = obj.rumple.profile_curve
    return group.nodes.get(NODE) if group is not None else None


def heights(obj: bpy.types.Object) -> np.ndarray:
    """The drawn heights, -1 (valley) to 1 (crest), for the kernel. Raises UserError."""
    curve = node(obj)
    if curve is None:
        raise UserError(f"{obj.name}: its profile curve is gone: choose another profile and Curve again")
    mapping = curve.mapping
    mapping.initialize()
    places = np.linspace(0.0, 1.0, kernels.PROFILE_INTERVALS + 1)
    drawn = [mapping.evaluate(mapping.curves[0], float(place)) for place in places]
    return np.clip(2.0 * np.array(drawn, np.float32) - 1.0, -1.0, 1.0)


def key(obj: bpy.types.Object) -> str:
    """A key of an object's profile. Equal keys have equal tables."""
    kind = obj.rumple.field.profile
    if kind != "CURVE":
        return kind
    return f"CURVE {hashlib.sha1(heights(obj).tobytes()).hexdigest()[:12]}"


def table(obj: bpy.types.Object) -> object:
    """The native profile of an object."""
    kind = obj.rumple.field.profile
    return wrinkle_field.native_profile(kind, heights(obj) if kind == "CURVE" else None)


def drop_orphans() -> None:
    """Remove curves that no object uses."""
    used = {obj.rumple.profile_curve for obj in bpy.data.objects}
    for group in [g for g in bpy.data.node_groups if NODE in g.nodes and g.name.startswith(NAME)]:
        if group not in used and compat.is_editable(group):
            bpy.data.node_groups.remove(group)
