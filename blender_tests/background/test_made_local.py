# SPDX-License-Identifier: GPL-3.0-or-later
"""A character of a library that becomes the shot's own: Make Local > All."""
from __future__ import annotations

import os
import tempfile
import unittest

import bpy
import numpy as np
from rumple.blender.objects import modifier, output_mesh
from support import sleeve


def overridden_from(path: str) -> bpy.types.Object:
    """The sleeve of a library in a new file, as a library override with its rig."""
    sleeve.empty_file()
    with bpy.data.libraries.load(path, link=True) as (_, wanted):
        wanted.collections = ["Character"]
    shown = bpy.data.objects.new("Character", None)
    shown.instance_type, shown.instance_collection = "COLLECTION", wanted.collections[0]
    bpy.context.scene.collection.objects.link(shown)
    made = wanted.collections[0].override_hierarchy_create(bpy.context.scene, bpy.context.view_layer, reference=shown)
    bpy.data.objects.remove(shown)
    bpy.context.view_layer.update()
    return next(obj for obj in made.all_objects if modifier.find(obj) is not None)


class MadeLocal(unittest.TestCase):

    def test_nothing_but_the_character_is_in_the_scene(self) -> None:
        """Blender puts objects without users into the scene when it makes them local. One was the library's own output
        object: the garment stood there once more, at rest, in viewports and renders."""
        with tempfile.TemporaryDirectory() as folder:
            sleeve.scene()
            character = bpy.data.collections.new("Character")
            bpy.context.scene.collection.children.link(character)
            for obj in list(bpy.context.scene.collection.objects):
                character.objects.link(obj)
                bpy.context.scene.collection.objects.unlink(obj)
            bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "library.blend"))
            obj = overridden_from(os.path.join(folder, "library.blend"))
            sleeve.play()
            seen = sleeve.shown(obj)
            bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "shot.blend"))
            bpy.ops.wm.open_mainfile(filepath=os.path.join(folder, "shot.blend"))
            obj = next(o for o in bpy.context.scene.objects if modifier.find(o) is not None)
            sleeve.make_active(obj)
            bpy.ops.object.make_local(type="ALL")
            bpy.context.view_layer.update()
            sleeve.play()
            self.assertEqual(sleeve.names(bpy.context.scene.objects), ["Arm", "Sleeve"])
            obj = bpy.context.scene.objects["Sleeve"]
            np.testing.assert_array_equal(sleeve.shown(obj), seen)
            self.assertEqual(obj.rumple.message, "")
            left = [o.name for o in bpy.data.objects if output_mesh.KEY in o and o.users_collection]
            self.assertEqual(left, [])
