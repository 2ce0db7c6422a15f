# SPDX-License-Identifier: GPL-3.0-or-later
"""Whatever poses a garment in Blender: one click, a played clip, frames that are reached again with the same bits.
Not Alembic: no Blender that the project is tested in reads it."""
from __future__ import annotations

import contextlib
import io
import struct
import tempfile
import unittest
from pathlib import Path
from typing import Callable

import bpy
import numpy as np
from rumple.blender.frame import clip_status
from rumple.blender.objects import runtimes, stack_notes
from support import sleeve
from support.arriving import Arriving

LAST = 12


def keyed(thing: bpy.types.bpy_struct, path: str, first: object, last: object) -> None:
    for frame, value in ((1, first), (LAST, last)):
        setattr(thing, path, value)
        thing.keyframe_insert(path, frame=frame)


def lattice(obj: bpy.types.Object) -> None:
    cage = bpy.data.objects.new("Cage", bpy.data.lattices.new("Cage"))
    bpy.context.scene.collection.objects.link(cage)
    cage.location, cage.scale = (0.3, 0.0, 0.0), (0.8, 0.4, 0.4)
    obj.modifiers.new("Lattice", "LATTICE").object = cage
    keyed(cage, "scale", (0.8, 0.4, 0.4), (0.6, 0.4, 0.4))


def mesh_cache(obj: bpy.types.Object) -> None:
    """A PC2 of what the armature did."""
    frames = []
    for frame in range(1, LAST + 1):
        sleeve.at(frame)
        frames.append(sleeve.shown(obj))
    points = np.array(frames, np.float32)
    path = Path(tempfile.mkdtemp()) / "sleeve.pc2"
    path.write_bytes(struct.pack("<12siiffi", b"POINTCACHE2\0", 1, points.shape[1], 1.0, 1.0, LAST) + points.tobytes())
    obj.modifiers.remove(obj.modifiers["Armature"])
    cache = obj.modifiers.new("Cache", "MESH_CACHE")
    cache.cache_format, cache.filepath, cache.frame_start = "PC2", str(path), 1.0


def surface_deform(obj: bpy.types.Object) -> None:
    body = sleeve.under(obj, radius=0.9)
    obj.modifiers.remove(obj.modifiers["Armature"])
    sleeve.at(1)
    bound = obj.modifiers.new("Bound", "SURFACE_DEFORM")
    bound.target = body
    assert bpy.ops.object.surfacedeform_bind(modifier="Bound") == {"FINISHED"} and bound.is_bound


def multiresolution(obj: bpy.types.Object) -> None:
    """In front of the armature, as sculptors have it."""
    obj.modifiers.new("Multires", "MULTIRES")
    bpy.ops.object.modifier_move_up(modifier="Multires")
    bpy.ops.object.multires_subdivide(modifier="Multires", mode="CATMULL_CLARK")
    assert obj.modifiers[0].total_levels == 1


def driven_keys(obj: bpy.types.Object) -> None:
    """A shape key that shortens the sleeve, driven by the bone that bends."""
    obj.shape_key_add(name="Basis")
    short = obj.shape_key_add(name="Short")
    for point in short.data:
        point.co.x *= 0.8
    driver = short.driver_add("value").driver
    driver.type = "SUM"
    variable = driver.variables.new()
    variable.type = "TRANSFORMS"
    target = variable.targets[0]
    target.id, target.bone_target = bpy.data.objects["Arm"], "lower"
    target.transform_type, target.transform_space = "ROT_Z", "LOCAL_SPACE"


def parent_and_constraint(obj: bpy.types.Object) -> None:
    mover = bpy.data.objects.new("Mover", None)
    bpy.context.scene.collection.objects.link(mover)
    obj.parent = mover
    keyed(mover, "rotation_euler", (0.0, 0.0, 0.0), (0.3, 0.2, 1.0))
    obj.constraints.new("COPY_LOCATION").target = bpy.data.objects["Arm"]
    keyed(bpy.data.objects["Arm"], "location", (0.0, 0.0, 0.0), (1.0, 0.0, 2.0))


def scale_that_is_negative_and_animated(obj: bpy.types.Object) -> None:
    keyed(obj, "scale", (-1.0, 1.0, 1.0), (-1.4, 0.7, 1.2))


def instances(obj: bpy.types.Object) -> None:
    """An empty shows the collection that the garment is in; its own is not in the scene."""
    collection = bpy.data.collections.new("Outfit")
    collection.objects.link(obj)
    empty = bpy.data.objects.new("Instance", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", collection
    empty.location.z = 3.0
    bpy.context.scene.collection.objects.link(empty)
    bpy.context.view_layer.update()


class Deformers(Arriving, unittest.TestCase):
    """With the Wrinkle Mesh; the other systems are below."""

    method = "MESH"

    def garment(self, posed: Callable[[bpy.types.Object], None]) -> bpy.types.Object:
        obj = sleeve.scene(wrinkles=False)
        sleeve.bend_until(LAST)
        posed(obj)
        sleeve.make_active(obj)
        settings = getattr(obj.rumple, self.method.lower())
        settings.density, settings.level, settings.display_steps = "LEVEL", 1, 0
        if self.method == "FIELD":
            settings.output = "GEOMETRY"  # what is shown is what is solved
        obj.rumple.viewport_steps = 0
        sleeve.at(1)
        self.assertEqual(bpy.ops.object.rumple_add(method=self.method), {"FINISHED"})
        return obj

    def played(self, posed: Callable[[bpy.types.Object], None]) -> bpy.types.Object:
        obj = self.garment(posed)
        self.check(obj)
        sleeve.play(1, LAST)
        before = sleeve.shown(obj)
        for frame in (3, LAST):
            sleeve.at(frame)
        np.testing.assert_array_equal(sleeve.shown(obj), before)
        self.assertEqual(runtimes.of(obj).notes, [])
        return obj

    def test_lattice(self) -> None:
        self.played(lattice)

    def test_mesh_cache(self) -> None:
        self.played(mesh_cache)

    def test_surface_deform(self) -> None:
        self.played(surface_deform)

    def test_multiresolution(self) -> None:
        self.played(multiresolution)

    def test_shape_keys_with_drivers(self) -> None:
        obj = self.played(driven_keys)
        self.assertGreater(obj.data.shape_keys.key_blocks["Short"].value, 0.5)

    def test_parent_and_constraint(self) -> None:
        obj = self.played(parent_and_constraint)
        self.assertAlmostEqual(sleeve.evaluated(obj).matrix_world.translation.z, 2.0, places=5)

    def test_scale_that_is_negative_and_animated(self) -> None:
        self.played(scale_that_is_negative_and_animated)

    def test_instances_show_the_wrinkles(self) -> None:
        obj = self.played(instances)
        count = runtimes.of(obj).evaluator.vertex_count
        depsgraph = bpy.context.evaluated_depsgraph_get()
        seen = [len(instance.object.data.vertices) for instance in depsgraph.object_instances
                if instance.is_instance and instance.object.original == obj]
        self.assertEqual(seen, [count])


class WithField(Deformers):
    method = "FIELD"


class WithPaths(Deformers):
    method = "PATHS"


class HeldByOthers(unittest.TestCase):
    """Other objects that hold on to the points of a garment, which are other ones with wrinkles. Only a child of
    vertices was said, and only by the first click."""

    def setUp(self) -> None:
        self.obj = sleeve.scene(wrinkles=False)
        self.obj.rumple.mesh.density, self.obj.rumple.mesh.level, self.obj.rumple.mesh.display_steps = "LEVEL", 1, 0

    def other(self, name: str) -> bpy.types.Object:
        other = bpy.data.objects.new(name, bpy.data.meshes.new(name))
        other.data.from_pydata([(0.3, 0.0, 0.07), (0.31, 0.0, 0.07), (0.31, 0.01, 0.07)], [], [(0, 1, 2)])
        bpy.context.scene.collection.objects.link(other)
        bpy.context.view_layer.update()
        return other

    def badge(self) -> bpy.types.Object:
        """It is bound to the points that are shown now."""
        badge = self.other("Badge")
        badge.modifiers.new("Glue", "SURFACE_DEFORM").target = self.obj
        self.toggle(badge)
        return badge

    def toggle(self, badge: bpy.types.Object) -> None:
        """The button Bind or Unbind."""
        sleeve.make_active(badge)
        bpy.ops.object.surfacedeform_bind(modifier="Glue")
        bpy.context.view_layer.update()

    NOTE = 'Sleeve: the object "Badge" is bound to it by "Glue", and its vertices are other ones now: unbind that ' \
           "modifier, and bind it again"

    def test_what_was_bound_before_the_click_is_said_until_it_is_bound_again(self) -> None:
        badge = self.badge()
        self.assertIn(self.NOTE, sleeve.click(self.obj))
        sleeve.play(1, 3)
        self.assertEqual(stack_notes.of(self.obj), [self.NOTE])
        for bound in (False, True):
            self.toggle(badge)
            self.assertEqual((badge.modifiers["Glue"].is_bound, stack_notes.of(self.obj)), (bound, []))
        self.obj.rumple.mesh.level = 2
        sleeve.play(4, 6)
        self.assertEqual(stack_notes.of(self.obj), [self.NOTE])
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            clip_status.check_before_render()
        self.assertIn(self.NOTE, printed.getvalue())
        sleeve.make_active(self.obj)
        with contextlib.redirect_stdout(printed := io.StringIO()):
            bpy.ops.object.rumple_remove()
        self.assertIn(self.NOTE, printed.getvalue())

    def test_waves_of_the_materials_keep_what_is_bound(self) -> None:
        """The mesh keeps its vertices."""
        self.badge()
        self.assertNotIn("is bound to it", sleeve.click(self.obj, "FIELD"))
        self.assertEqual(stack_notes.of(self.obj), [])

    def test_children_of_vertices_are_said_whenever_they_are_made(self) -> None:
        sleeve.click(self.obj)
        for name, kind in (("Badge", "OBJECT"), ("Button", "VERTEX")):
            child = self.other(name)
            child.parent, child.parent_type = self.obj, kind
        note = 'Sleeve: the object "Button" is parented to vertices of it, which are other ones now: give it a Copy ' \
               "Location constraint with a vertex group in place of the parent"
        self.assertEqual(stack_notes.of(self.obj), [note])
        sleeve.play(1, 2)
        self.assertEqual(sleeve.evaluated(bpy.data.objects["Button"]).matrix_world.translation.length, 0.0)

    def test_children_on_its_faces_and_vertices_are_said(self) -> None:
        self.other("Leaf").parent = self.obj
        self.obj.instance_type = "FACES"
        note = 'Sleeve: the object "Leaf" is instanced on its vertices or faces, of which the fine mesh has more: ' \
               "let another object without wrinkles be its parent"
        self.assertIn(note, sleeve.click(self.obj))
        self.assertEqual(stack_notes.of(self.obj), [note])
        self.obj.instance_type = "VERTS"
        self.assertEqual(stack_notes.of(self.obj), [note])
        self.obj.instance_type = "NONE"
        self.assertEqual(stack_notes.of(self.obj), [])


if __name__ == "__main__":
    unittest.main()
