# SPDX-License-Identifier: GPL-3.0-or-later
"""Support for Weight Paint on a wrinkled mesh.

Gradients, samples and the selection of a mask search for the artist's own vertices in the mesh that a viewport shows. A
mesh made by nodes has no such vertices, so these tools would do nothing. For them viewports show the coarse mesh, as it
comes from the modifiers in front. Brushes work on the shown folds. The colours under a brush are those of the fine
mesh.
"""
from __future__ import annotations

import hashlib
import json

import bpy
import numpy as np

from ...core.mesh.shown_mesh import ShownMesh
from .. import compat
from . import incoming_mesh, mesh_reader, output_mesh, painted_maps
from .runtimes import Runtime

MODE = "WEIGHT_PAINT"
_TOOLS = ("builtin.gradient", "builtin.sample_weight", "builtin.sample_vertex_group")

_asked = False  # by a shortcut of such a tool


def ask_for_coarse(wanted: bool) -> None:
    """For a tool that is not the active one. Evaluate the object afterwards."""
    global _asked
    _asked = wanted


def needs_coarse(obj: bpy.types.Object) -> bool:
    """Whether viewports show the coarse mesh. Call it in the main thread."""
    if bpy.app.background or obj.mode != MODE:
        return False
    return _asked or painted_maps.is_masked(obj) or _has_tool()


def _has_tool() -> bool:
    """Whether such a tool is active in any window. Each workspace may have its own tool."""
    for window in bpy.context.window_manager.windows:
        tool = window.workspace.tools.from_space_view3d_mode("PAINT_WEIGHT", create=False)
        if tool is not None and tool.idname in _TOOLS:
            return True
    return False


def carry_colours(obj: bpy.types.Object, output: bpy.types.Object, fine: ShownMesh, runtime: Runtime) -> bool:
    """Update the weights of the painted group on an output object. Returns whether they changed. Cost: 1 ms for 12,000
    vertices, and 1 ms per 1,000 of the coarse mesh.

    rebuild.py carries all groups; this carries only the changes made by a brush.
    """
    group = obj.vertex_groups.active
    if obj.mode != MODE or group is None or group.name not in output.vertex_groups:
        return False
    mesh, name = output.data, group.name
    weights = np.ascontiguousarray(mesh_reader.group_weights(obj, incoming_mesh.of(obj), [name])[:, 0])
    wanted = hashlib.sha1(weights.tobytes()).hexdigest()
    carried = json.loads(mesh.get(output_mesh.CARRIED_KEY, "{}"))
    had = carried.get("groups", {}).get(name)
    if had is None or had == wanted:
        return False
    steps = output_mesh.weight_steps(fine, weights)
    of, known = runtime.paint.steps or (None, None)
    key = compat.session_key(mesh)
    output_mesh.write_steps(output.vertex_groups[name], steps, known if of == (key, name, had) else None)
    runtime.paint.steps = (key, name, wanted), steps
    carried["groups"][name] = wanted
    mesh[output_mesh.CARRIED_KEY] = json.dumps(carried)
    mesh.update()
    return True
