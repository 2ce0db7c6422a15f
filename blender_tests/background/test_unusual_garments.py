# SPDX-License-Identifier: GPL-3.0-or-later
"""Garments and stacks as they come out of exporters, games and old files: one click, a played clip, by laws."""
from __future__ import annotations

import unittest
from typing import Callable

import bmesh
import bpy
import numpy as np
from rumple.blender.objects import runtimes
from support import sleeve

LAST = 8
Change = Callable[[bpy.types.Object], object]


def on_a_scaled_rig(scale: float, away: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Change:
    """The armature is scaled and moved, the garment its child."""
    def change(obj: bpy.types.Object) -> None:
        rig = bpy.data.objects["Arm"]
        rig.scale, rig.location, obj.parent = (scale,) * 3, away, rig
    return change


def in_centimetres(obj: bpy.types.Object) -> None:
    """As FBX arrives: coordinates in centimetres under a scale of 0.01."""
    for vertex in obj.data.vertices:
        vertex.co *= 100.0
    obj.scale = (0.01,) * 3


def edited(change: Callable[[bmesh.types.BMesh], object]) -> Change:
    def edit(obj: bpy.types.Object) -> None:
        work = bmesh.new()
        work.from_mesh(obj.data)
        change(work)
        work.to_mesh(obj.data)
        work.free()
    return edit


def split_everywhere(work: bmesh.types.BMesh) -> None:
    """Every face has vertices of its own, as flat-shaded exports have."""
    bmesh.ops.split_edges(work, edges=work.edges[:])


def double_sided(work: bmesh.types.BMesh) -> None:
    """Every face once more, turned, on vertices of its own: for engines that draw front faces alone."""
    made = bmesh.ops.duplicate(work, geom=work.verts[:] + work.edges[:] + work.faces[:])["geom"]
    bmesh.ops.reverse_faces(work, faces=[face for face in made if isinstance(face, bmesh.types.BMFace)])


def one_ring(work: bmesh.types.BMesh) -> None:
    """Only faces along the border are left."""
    bmesh.ops.delete(work, geom=[face for face in work.faces if face.calc_center_median().x > 0.05], context="FACES")


def one_triangle(work: bmesh.types.BMesh) -> None:
    work.faces.ensure_lookup_table()
    bmesh.ops.delete(work, geom=work.faces[1:], context="FACES")
    bmesh.ops.triangulate(work, faces=work.faces[:])
    work.faces.ensure_lookup_table()
    bmesh.ops.delete(work, geom=work.faces[1:], context="FACES")


def with_modifier(kind: str, **settings: object) -> Change:
    """Behind the Armature."""
    def change(obj: bpy.types.Object) -> None:
        made = obj.modifiers.new(kind.title(), kind)
        for name, value in settings.items():
            setattr(made, name, value)
    return change


def with_modifiers(*kinds: str) -> Change:
    def change(obj: bpy.types.Object) -> None:
        for kind in kinds:
            with_modifier(kind)(obj)
    return change


def posed_twice(obj: bpy.types.Object) -> None:
    """Two Armatures of which the second blends with what the first was given."""
    second = obj.modifiers.new("Again", "ARMATURE")
    second.object, second.use_multi_modifier = bpy.data.objects["Arm"], True
    obj.modifiers["Armature"].use_deform_preserve_volume = True


def of_bendy_bones(obj: bpy.types.Object) -> None:
    for bone in bpy.data.armatures["Arm"].bones:
        bone.bbone_segments = 6


def with_absolute_shape_keys(obj: bpy.types.Object) -> None:
    """Keys that follow each other in time."""
    obj.shape_key_add(name="Basis")
    for point in obj.shape_key_add(name="Short").data:
        point.co.x *= 0.8
    keys = obj.data.shape_keys
    keys.use_relative = False
    for frame, time in ((1, 0.0), (LAST, 10.0)):
        keys.eval_time = time
        keys.keyframe_insert("eval_time", frame=frame)


def hooked(obj: bpy.types.Object) -> None:
    target = bpy.data.objects.new("Hook", None)
    bpy.context.scene.collection.objects.link(target)
    hook = obj.modifiers.new("Hook", "HOOK")
    hook.object = target
    hook.vertex_indices_set(list(range(32)))
    for frame, height in ((1, 0.0), (LAST, 0.1)):
        target.location.z = height
        target.keyframe_insert("location", frame=frame)


def of_a_bone_of_no_size(obj: bpy.types.Object) -> None:
    """A bone is scaled to nothing for two frames, as things are hidden."""
    bone = bpy.data.objects["Arm"].pose.bones["lower"]
    for frame, scale in ((1, 1.0), (3, 1.0), (4, 0.0), (5, 0.0), (6, 1.0)):
        bone.scale = (scale,) * 3
        bone.keyframe_insert("scale", frame=frame)


def simplified(obj: bpy.types.Object) -> None:
    """A Subdivision in front that the scene's Simplify takes back."""
    bpy.context.scene.render.use_simplify = True
    bpy.context.scene.render.simplify_subdivision = 0
    subdivision = obj.modifiers.new("Subdivision", "SUBSURF")
    while obj.modifiers[0] != subdivision:
        bpy.ops.object.modifier_move_up(modifier=subdivision.name)


def with_a_name_of_all_signs(obj: bpy.types.Object) -> None:
    obj.name = "n\u00e9/..\\\"q' %s {x} \U0001f455"


def without_uv_and_material(obj: bpy.types.Object) -> None:
    while obj.data.uv_layers:
        obj.data.uv_layers.remove(obj.data.uv_layers[0])
    obj.data.materials.clear()


def with_materials_that_are_not_there(obj: bpy.types.Object) -> None:
    obj.data.materials.clear()
    obj.data.materials.append(None)
    obj.data.polygons.foreach_set("material_index", np.full(len(obj.data.polygons), 3, np.int32))


def with_every_face_hidden(obj: bpy.types.Object) -> None:
    obj.data.polygons.foreach_set("hide", np.ones(len(obj.data.polygons), bool))


def with_custom_normals(obj: bpy.types.Object) -> None:
    if hasattr(obj.data, "use_auto_smooth"):
        obj.data.use_auto_smooth = True
    obj.data.normals_split_custom_set_from_vertices([(0.0, 0.0, 1.0)] * len(obj.data.vertices))


def with_vertices_of_no_weight(obj: bpy.types.Object) -> None:
    for group in obj.vertex_groups:
        group.add([3, 4, 5], 0.0, "REPLACE")


def without_weights(obj: bpy.types.Object) -> None:
    obj.vertex_groups.clear()


GARMENTS: dict[str, Change] = {
    "in_centimetres": in_centimetres,
    "on_a_miniature": on_a_scaled_rig(0.001),
    "on_a_giant": on_a_scaled_rig(100.0),
    "far_from_the_origin": on_a_scaled_rig(1.0, away=(20000.0, -30000.0, 5.0)),
    "split_everywhere": edited(split_everywhere),
    "double_sided": edited(double_sided),
    "one_ring": edited(one_ring),
    "one_triangle": edited(one_triangle),
    "posed_twice": posed_twice,
    "of_bendy_bones": of_bendy_bones,
    "with_absolute_shape_keys": with_absolute_shape_keys,
    "hooked": hooked,
    "of_a_bone_of_no_size": of_a_bone_of_no_size,
    "simplified": simplified,
    "split_by_a_modifier": with_modifier("EDGE_SPLIT", split_angle=0.1),
    "with_a_wave": with_modifier("WAVE", height=0.01),
    "bevelled": with_modifier("BEVEL", width=0.002),
    "repeated": with_modifier("ARRAY", count=3),
    "corrected": with_modifier("CORRECTIVE_SMOOTH", rest_source="ORCO"),
    "triangulated_and_bevelled": with_modifiers("WEIGHTED_NORMAL", "EDGE_SPLIT", "TRIANGULATE", "BEVEL"),
    "with_a_name_of_all_signs": with_a_name_of_all_signs,
    "without_uv_and_material": without_uv_and_material,
    "with_materials_that_are_not_there": with_materials_that_are_not_there,
    "with_every_face_hidden": with_every_face_hidden,
    "with_custom_normals": with_custom_normals,
    "with_vertices_of_no_weight": with_vertices_of_no_weight,
    "without_weights": without_weights,
}
SYSTEMS = ("MESH", "FIELD", "PATHS")


class UnusualGarments(unittest.TestCase):
    """Each with one of the systems, in turn."""

    def clicked_and_played(self, change: Change, system: str) -> None:
        obj = sleeve.scene(wrinkles=False)
        sleeve.bend_until(LAST)
        sleeve.make_active(obj)
        change(obj)
        bare = {frame: self.size_at(obj, frame) for frame in (1, LAST)}
        for settings in (obj.rumple.mesh, obj.rumple.field, obj.rumple.paths):
            settings.base_cloth = "HANG"
        sleeve.at(1)
        self.assertEqual(bpy.ops.object.rumple_add(method=system), {"FINISHED"})
        played = {}
        for frame in range(1, LAST + 1):
            sleeve.at(frame)
            self.assertEqual(obj.rumple.message, "")
            played[frame] = sleeve.shown(obj)
            self.assertTrue(np.isfinite(played[frame]).all())
        self.assertIsNotNone(runtimes.of(obj).result)
        for frame, size in bare.items():  # cloth, not an explosion and not a rag
            self.assertAlmostEqual(np.ptp(played[frame], axis=0).max() / size, 1.0, delta=0.15)
        for frame in (3, LAST):
            sleeve.at(frame)
            np.testing.assert_array_equal(sleeve.shown(obj), played[frame])

    @staticmethod
    def size_at(obj: bpy.types.Object, frame: int) -> float:
        """Longest side of the bounding box, object units."""
        sleeve.at(frame)
        return float(np.ptp(sleeve.shown(obj), axis=0).max())


for _number, (_name, _change) in enumerate(GARMENTS.items()):
    def _test(self: UnusualGarments, change: Change = _change, system: str = SYSTEMS[_number % 3]) -> None:
        self.clicked_and_played(change, system)
    setattr(UnusualGarments, f"test_{_name}", _test)
