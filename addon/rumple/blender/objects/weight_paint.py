# SPDX-License-Identifier: GPL-3.0-or-later
"""What Weight Paint needs of a wrinkled mesh while it is in that mode.

Gradients, samples and the selection of a mask look for the artist's own vertices in the mesh that a viewport shows. A
mesh that nodes made has none of them, so these tools did nothing. Viewports show the coarse mesh for them, as it comes
from the modifiers in front; brushes work where the folds are shown. Colours under a brush are those of the fine mesh.
"""
from __future__ import annotations

import hashlib
import json

import bpy

from ...core.shown_mesh import ShownMesh
from .. import compat
from . import incoming_mesh, mesh_reader, output_mesh, painted_maps
from .runtimes import Runtime

MODE = "WEIGHT_PAINT"
_TOOLS = ("builtin.gradient", "builtin.sample_weight", "builtin.sample_vertex_group")

_asked = False  # by a shortcut of such a tool


def ask_for_coarse(wanted: bool) -> None:
    """For a tool that is not the active one. The object is to be evaluated after it."""
    global _asked
    _asked = wanted


def needs_coarse(obj: bpy.types.Object) -> bool:
    """Whether viewports show the coarse mesh. In the main thread."""
    if bpy.app.background or obj.mode != MODE:
        return False
    return _asked or painted_maps.is_masked(obj) or _has_tool()


def _has_tool() -> bool:
    """In any window: they may be of one workspace."""
    for window in bpy.context.window_manager.windows:
        tool = window.workspace.tools.from_space_view3d_mode("PAINT_WEIGHT", create=False)
        if tool is not None and tool.idname in _TOOLS:
            return True
    return False


def carry_colours(obj: bpy.types.Object, output: bpy.types.Object, fine: ShownMesh, runtime: Runtime) -> bool:
    """Give an output object the weights of the group that is painted now, as far as they differ from those it had.
    True where they do. Cost: 1 ms for 12,000 vertices, and 1 ms per 1,000 of the coarse mesh.

    rebuild.py carries all groups; this is for what a brush has changed since.
    """
    group = obj.vertex_groups.active
    if obj.mode != MODE or group is None or group.name not in output.vertex_groups:
        return False
    mesh, name = output.data, group.name
    weights = mesh_reader.group_weights(obj, incoming_mesh.of(obj), [name])
    wanted = hashlib.sha1(weights[:, 0].tobytes()).hexdigest()
    carried = json.loads(mesh.get(output_mesh.CARRIED_KEY, "{}"))
    had = carried.get("groups", {}).get(name)
    if had is None or had == wanted:
        return False
    steps = output_mesh.weight_steps(fine, weights)[:, 0]
    of, known = runtime.painted_steps or (None, None)
    key = compat.session_key(mesh)
    output_mesh.write_steps(output.vertex_groups[name], steps, known if of == (key, name, had) else None)
    runtime.painted_steps = (key, name, wanted), steps
    carried["groups"][name] = wanted
    mesh[output_mesh.CARRIED_KEY] = json.dumps(carried)
    mesh.update()
    return True
