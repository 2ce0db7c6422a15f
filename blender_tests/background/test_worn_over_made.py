# SPDX-License-Identifier: GPL-3.0-or-later
"""The collection of inner garments that the first click makes is in no scene. So Blender took nothing out of it that
was deleted or joined, and a duplicate of a character was worn over the trousers of the first one."""
from __future__ import annotations

import os
import tempfile
import unittest

import bpy
import numpy as np
from rumple.blender import scheduler
from rumple.blender.objects import bodies, made_collections, runtimes
from support import sleeve
from support.worn_sleeve import posed, solved_body


class Case(unittest.TestCase):

    def setUp(self) -> None:
        self.obj = sleeve.scene(wrinkles=False)
        for name in ("base_cloth", "layers"):  # the click says
            self.obj.rumple.mesh.property_unset(name)
        self.obj.rumple.mesh.density, self.obj.rumple.mesh.level = "LEVEL", 1
        self.body, self.inner = sleeve.under(self.obj, "Human", 0.7), sleeve.under(self.obj, "Trousers", 0.9)
        sleeve.make_active(self.obj)
        bpy.ops.object.rumple_add(method="MESH")
        self.assertEqual(bodies.of(self.obj), [self.body, self.inner])

    def members(self, obj: bpy.types.Object) -> list[str]:
        return [member.name for member in obj.rumple.body_collection.objects]

    def worn_vertices(self, frame: int) -> int:
        sleeve.at(frame)
        return len(solved_body(self.obj).positions)


class SameNames(unittest.TestCase):

    def test_a_linked_body_beside_a_local_one_of_its_name(self) -> None:
        """The first of a name was taken for both, and the body was dropped as one that was deleted."""
        sleeve.under(sleeve.scene(wrinkles=False))
        self.addCleanup(sleeve.empty_file)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "library.blend")
            bpy.ops.wm.save_as_mainfile(filepath=path)
            obj = sleeve.scene()
            local = sleeve.under(obj)
            with bpy.data.libraries.load(path, link=True) as (_, wanted):
                wanted.objects = [local.name]
            bpy.context.scene.collection.objects.link(wanted.objects[0])
            for body in (wanted.objects[0], local):
                obj.rumple.body = body
                sleeve.at(2)
                self.assertEqual(obj.rumple.body, body)


class Gone(Case):

    def check_gone(self) -> None:
        self.assertEqual(bodies.of(self.obj), [self.body])
        self.assertEqual(self.worn_vertices(4), len(self.body.data.vertices))
        runtimes.of(self.obj).stale = True
        scheduler.sync_all()
        self.assertEqual(self.members(self.obj), [])
        self.assertEqual(bpy.data.objects["Trousers"].users if "Trousers" in bpy.data.objects else 0, 0)

    def test_deleted(self) -> None:
        self.assertEqual(self.worn_vertices(3), 2 * len(self.body.data.vertices))
        sleeve.make_active(self.inner)
        bpy.ops.object.delete()
        self.check_gone()

    def test_joined_to_another(self) -> None:
        prop = bpy.data.objects.new("Prop", sleeve.tube("Prop"))
        bpy.context.scene.collection.objects.link(prop)
        sleeve.make_active(prop)
        self.inner.select_set(True)
        bpy.ops.object.join()
        self.check_gone()

    def test_of_an_older_file(self) -> None:
        self.obj.rumple.body_collection.pop(made_collections.KEY, None)
        sleeve.make_active(self.inner)
        bpy.ops.object.delete()
        self.check_gone()

    def test_the_collection_of_an_artist_stays_as_it_is(self) -> None:
        for shown in (False, True):
            group = bpy.data.collections.new("Kept")
            group.objects.link(self.inner)
            if shown:
                bpy.context.scene.collection.children.link(group)
            self.obj.rumple.body_collection = group
            if self.inner.name in bpy.context.scene.collection.objects:
                bpy.context.scene.collection.objects.unlink(self.inner)
            scheduler.sync_all()
            self.assertEqual(self.members(self.obj), ["Trousers"])
            self.assertEqual(bodies.of(self.obj), [self.body, self.inner])

    def test_one_that_was_taken_into_the_scene_is_the_artists(self) -> None:
        bpy.context.scene.collection.children.link(self.obj.rumple.body_collection)
        bpy.context.scene.collection.objects.unlink(self.inner)
        scheduler.sync_all()
        self.assertEqual(bodies.of(self.obj), [self.body, self.inner])


class Moved(Case):
    """To another collection by a script, which unlinks from all that an object is in: the garment lost it."""

    def move(self, into: str = "Clothes") -> None:
        other = bpy.data.collections.new(into)
        bpy.context.scene.collection.children.link(other)
        for collection in self.inner.users_collection:
            collection.objects.unlink(self.inner)
        other.objects.link(self.inner)

    def test_it_stays(self) -> None:
        self.worn_vertices(3)
        for again in range(2):
            self.move()
            self.assertEqual(self.worn_vertices(4 + again), 2 * len(self.body.data.vertices))
            self.assertEqual(self.members(self.obj), ["Trousers"])
        self.assertEqual(len(self.inner.users_collection), 2)

    def test_with_updates_while_it_is_nowhere(self) -> None:
        self.worn_vertices(3)
        for collection in self.inner.users_collection:
            collection.objects.unlink(self.inner)
        for _ in range(2):
            bpy.context.view_layer.update()
            scheduler.sync_all()
        bpy.context.scene.collection.objects.link(self.inner)
        self.worn_vertices(4)
        self.assertEqual(self.members(self.obj), ["Trousers"])

    def test_taken_out_by_hand_it_is_out(self) -> None:
        self.worn_vertices(3)
        self.obj.rumple.body_collection.objects.unlink(self.inner)
        for frame in (4, 5):
            self.assertEqual(self.worn_vertices(frame), len(self.body.data.vertices))
        self.assertEqual(self.members(self.obj), [])
        self.move()  # later
        self.assertEqual(self.worn_vertices(6), len(self.body.data.vertices))

    def test_a_collection_that_an_artist_took_over_is_left_alone(self) -> None:
        """What was lost from it was looked for, and asked for, at every update."""
        self.worn_vertices(3)
        bpy.context.scene.collection.children.link(self.obj.rumple.body_collection)
        self.move()
        self.worn_vertices(4)
        runtimes.of(self.obj).stale = False
        bpy.context.view_layer.update()
        self.assertEqual(made_collections.lost_members(self.obj.rumple.body_collection), [])
        self.assertEqual(self.members(self.obj), [])

    def test_another_object_of_its_name_is_not_taken_for_it(self) -> None:
        self.worn_vertices(3)
        for collection in self.inner.users_collection:
            collection.objects.unlink(self.inner)
        self.inner.name = "Renamed"
        other, elsewhere = bpy.data.objects.new("Trousers", self.body.data), bpy.data.collections.new("Elsewhere")
        elsewhere.objects.link(other)
        bpy.context.scene.collection.children.link(elsewhere)
        self.worn_vertices(4)
        self.assertNotIn("Trousers", self.members(self.obj))

    def test_deleted_it_is_gone(self) -> None:
        self.worn_vertices(3)
        bpy.data.objects.remove(self.inner)
        self.assertEqual(self.worn_vertices(4), len(self.body.data.vertices))


class Duplicated(Case):

    def duplicate(self, linked: bool) -> bpy.types.Object:
        """Of the whole character, in another pose; the new garment."""
        for each in (self.obj, self.body, self.inner, bpy.data.objects["Arm"]):
            each.select_set(True)
        bpy.ops.object.duplicate(linked=linked)
        bpy.data.objects["Arm.001"].location.y = 2.0  # around another elbow
        sleeve.at(5)
        return bpy.data.objects["Sleeve.001"]

    def check_own(self, copy: bpy.types.Object) -> None:
        self.assertEqual(self.members(self.obj), ["Trousers"])
        self.assertEqual(self.members(copy), ["Trousers.001"])
        sleeve.at(6)
        self.assertEqual((self.obj.rumple.message, copy.rumple.message), ("", ""))
        for garment, inner in ((self.obj, self.inner), (copy, bpy.data.objects["Trousers.001"])):
            found = solved_body(garment).positions[len(self.body.data.vertices):]
            np.testing.assert_allclose(found, posed(inner), atol=1e-5)
        self.assertGreater(np.abs(posed(self.inner) - posed(inner)).max(), 0.01)
        scheduler.sync_all()
        self.assertEqual(len([c for c in bpy.data.collections if made_collections.is_ours(c)]), 2)

    def test_each_is_worn_over_its_own(self) -> None:
        for linked in (False, True):
            with self.subTest(linked=linked):
                self.setUp()
                self.check_own(self.duplicate(linked))

    def test_of_an_older_file(self) -> None:
        self.obj.rumple.body_collection.pop(made_collections.KEY, None)
        self.check_own(self.duplicate(linked=False))

    def test_a_full_copy_of_the_scene(self) -> None:
        bpy.ops.scene.new(type="FULL_COPY")
        copy = next(obj for obj in bpy.context.scene.objects if obj.name.startswith("Sleeve"))
        self.assertNotEqual(copy, self.obj)
        sleeve.at(5)
        scheduler.sync_all()
        self.assertEqual(self.members(self.obj), ["Trousers"])
        self.assertIn(copy.rumple.body_collection.objects[0].name, bpy.context.scene.objects)
        self.assertEqual(len(copy.rumple.body_collection.objects), 1)

    def test_a_garment_alone_keeps_what_moves_with_it(self) -> None:
        sleeve.make_active(self.obj)
        bpy.ops.object.duplicate()
        sleeve.at(5)
        copy = bpy.data.objects["Sleeve.001"]
        self.assertEqual(self.members(copy), ["Trousers"])
        self.assertNotEqual(copy.rumple.body_collection, self.obj.rumple.body_collection)

    def test_with_no_trousers_of_its_own_it_keeps_those_of_the_first(self) -> None:
        for each in (self.obj, bpy.data.objects["Arm"]):
            each.select_set(True)
        bpy.ops.object.duplicate()
        sleeve.at(5)
        self.assertEqual(self.members(bpy.data.objects["Sleeve.001"]), ["Trousers"])

    def test_it_is_saved(self) -> None:
        self.duplicate(linked=False)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "scene.blend")
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.open_mainfile(filepath=path)
        self.addCleanup(sleeve.empty_file)
        self.assertEqual(self.members(bpy.data.objects["Sleeve.001"]), ["Trousers.001"])

    def test_a_collection_that_an_artist_made_is_shared(self) -> None:
        group = bpy.data.collections.new("Bodies")
        group.objects.link(self.inner)
        self.obj.rumple.body_collection = group
        copy = self.duplicate(linked=False)
        self.assertEqual(copy.rumple.body_collection, group)


if __name__ == "__main__":
    unittest.main()
