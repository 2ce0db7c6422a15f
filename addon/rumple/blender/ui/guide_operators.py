# SPDX-License-Identifier: GPL-3.0-or-later
"""The buttons of guides: bpy.ops.object.rumple_guide_add(), rumple_guide_remove(name="...")."""
from __future__ import annotations

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ...core.base.wording import UserError
from .. import ui_base
from ..objects import guide_curves, incoming_mesh, mesh_reader, properties, rig_scale, units
from ..translation import said

POINTS = 7  # number of points of a new guide
LENGTH = 8.0  # in spacings


class OBJECT_OT_rumple_guide_add(ui_base.OnWrinkled, bpy.types.Operator):
    """Let folds run along the other selected curves; with none selected, along a new one near the 3D cursor"""

    bl_idname = "object.rumple_guide_add"
    bl_label = "Add Guide"

    def execute(self, context: bpy.types.Context) -> set[str]:
        garment = context.object
        try:
            curves = [obj for obj in context.selected_objects if obj.type == "CURVE"] or [_new_curve(context, garment)]
        except UserError as error:
            return ui_base.refuse(self, error)
        metres = units.scene_of(garment).unit_settings.scale_length
        for curve in curves:
            if curve.parent != garment:
                matrix = curve.matrix_world.copy()
                curve.parent, curve.matrix_parent_inverse = garment, garment.matrix_world.inverted_safe()
                curve.matrix_world = matrix
            about = curve.rumple_guide
            about.spacing, about.depth = guide_curves.SPACING / metres, guide_curves.DEPTH / metres
            about.reach = guide_curves.REACH / metres
            about.is_guide = True
        guide_curves.read_again(garment)
        self.report({"INFO"}, said(f"{garment.name}: folds run along {', '.join(curve.name for curve in curves)}"))
        return {"FINISHED"}


def _new_curve(context: bpy.types.Context, garment: bpy.types.Object) -> bpy.types.Object:
    """A new child curve on the garment at rest. Raises UserError if there is no rest shape, or nothing to lie on."""
    settings = properties.settings_of(garment, context.scene)
    rest = mesh_reader.rest_positions(garment, settings.rest_shape, garment.rumple.rest_key).astype(np.float64)
    faces = [polygon.vertices[:] for polygon in incoming_mesh.of(garment).polygons]
    tree = BVHTree.FromPolygons(rest.tolist(), faces)
    to_garment = garment.matrix_world.inverted_safe()
    centre, normal, _face, _distance = tree.find_nearest(to_garment @ context.scene.cursor.location)
    if centre is None:
        raise UserError(f"{garment.name}: its mesh has no faces: add some, or choose another object")
    up = to_garment.to_3x3() @ Vector((0.0, 0.0, 1.0))
    up -= up.dot(normal) * normal
    up = up.normalized() if up.length > 1e-6 else normal.orthogonal().normalized()
    scale = rig_scale.metres_at_rest(garment, units.scene_of(garment)) or 1.0
    curve = bpy.data.curves.new(f"{garment.name}.guide", "CURVE")
    curve.dimensions = "3D"
    spline = curve.splines.new("BEZIER")
    spline.bezier_points.add(POINTS - 1)
    for point, share in zip(spline.bezier_points, np.linspace(-0.5, 0.5, POINTS)):
        point.co = tree.find_nearest(centre + float(share) * LENGTH * guide_curves.SPACING / scale * up)[0]
        point.handle_left_type = point.handle_right_type = "AUTO"
    child = bpy.data.objects.new(curve.name, curve)
    child.parent = garment
    for collection in garment.users_collection:
        collection.objects.link(child)
    return child


class OBJECT_OT_rumple_guide_remove(ui_base.OnWrinkled, bpy.types.Operator):
    """Let no folds run along this curve any more. The curve stays"""

    bl_idname = "object.rumple_guide_remove"
    bl_label = "Remove Guide"

    name: bpy.props.StringProperty(name="Guide", options={"SKIP_SAVE"}, description="Of the curve. Empty: all guides")

    def execute(self, context: bpy.types.Context) -> set[str]:
        for guide in guide_curves.of(context.object):
            if self.name in ("", guide.name):
                guide.rumple_guide.is_guide = False
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((OBJECT_OT_rumple_guide_add, OBJECT_OT_rumple_guide_remove))
