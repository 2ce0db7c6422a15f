# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows in the panel how a mesh was healed, and selects the healed elements."""
from __future__ import annotations

import bpy
import numpy as np

from ...core.mesh.healing import SENTENCES, Origin
from .. import ui_base
from ..objects import incoming_mesh, runtimes


def origin_of(obj: bpy.types.Object) -> Origin | None:
    """The origins of the elements of an object's healed mesh; None if nothing was healed."""
    runtime = runtimes.known(obj)
    return None if runtime is None or runtime.evaluator is None else runtime.evaluator.base.origin


class OBJECT_OT_rumple_select_healed(ui_base.OnWrinkled, bpy.types.Operator):
    """Select in Edit Mode what was healed for the wrinkles"""

    bl_idname = "object.rumple_select_healed"
    bl_label = "Select These"

    kind: bpy.props.EnumProperty(name="Kind", items=[(kind, kind.title(), "") for kind in SENTENCES])

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = context.object
        origin = origin_of(obj)
        same = origin is not None and incoming_mesh.is_own(obj) and (origin.vertex_count, origin.corner_count) == (
            len(obj.data.vertices), len(obj.data.loops))
        elements = origin.elements[self.kind] if same else np.empty(0, np.int32)
        if not len(elements):
            return ui_base.refuse(self, f"{obj.name}: nothing of this kind had to be healed")
        domain = SENTENCES[self.kind][0]
        context.tool_settings.mesh_select_mode = (False, domain == "EDGE", domain == "FACE")
        _select(obj.data, domain, elements)
        bpy.ops.object.mode_set(mode="EDIT")
        return {"FINISHED"}


def _select(mesh: bpy.types.Mesh, domain: str, elements: np.ndarray) -> None:
    """Select only these elements. elements: polygons, or the two vertices of edges."""
    chosen = {"vertices": np.zeros(len(mesh.vertices), bool), "edges": np.zeros(len(mesh.edges), bool),
              "polygons": np.zeros(len(mesh.polygons), bool)}
    if domain == "FACE":
        chosen["polygons"][elements] = True
        for polygon in elements.tolist():
            chosen["vertices"][list(mesh.polygons[polygon].vertices)] = True
    else:
        wanted = set(map(tuple, elements.tolist()))
        chosen["edges"][[edge.index for edge in mesh.edges if tuple(sorted(edge.vertices)) in wanted]] = True
        chosen["vertices"][elements.ravel()] = True
    for name, values in chosen.items():
        getattr(mesh, name).foreach_set("select", values)


def draw(layout: bpy.types.UILayout, obj: bpy.types.Object) -> None:
    """Draw a sentence and a button for each kind."""
    origin = origin_of(obj)
    if origin is None:
        return
    can_select = incoming_mesh.is_own(obj)
    for kind, note in zip(origin.kinds(), origin.notes(obj.name)):
        ui_base.draw_note(layout, note)
        if can_select:
            layout.operator(OBJECT_OT_rumple_select_healed.bl_idname, icon="RESTRICT_SELECT_OFF").kind = kind


register, unregister = bpy.utils.register_classes_factory((OBJECT_OT_rumple_select_healed,))
