# SPDX-License-Identifier: GPL-3.0-or-later
"""The walk with what goes between scenes and files: other scenes, append, link, override, a library that is read again
or made local, a purge, Alt-D in Edit Mode, rig and body deleted while a clip plays."""
from __future__ import annotations

from typing import Any

import bpy
from rumple.blender.objects import modifier, properties
from support import garment_walk, sleeve

MOST_SCENES = 3


class Walk(garment_walk.Walk):

    OFTEN: tuple[str, ...] = (*garment_walk.Walk.OFTEN, *("do_append", "do_link", "do_override", "do_scene",
                                                          "do_alt_d_edit", "do_delete_in_play") * 2)

    def room(self) -> bool:
        """Few objects keep the walk quick."""
        return len([o for o in bpy.data.objects if modifier.find(o)]) < garment_walk.MOST_OBJECTS

    def pick(self, ours: bool = True) -> Any:
        """Of those that may be edited: an override's mesh is its library's."""
        found = [o for o in bpy.context.scene.objects if o.type == "MESH" and self.is_ours(o) == ours
                 and o.library is None and o.data.library is None]
        if not found:
            return None
        sleeve.make_active(self.random.choice(found))
        return bpy.context.view_layer.objects.active

    # --- the steps
    def library(self) -> str:
        """A file with a wrinkled sleeve, as another artist saved it: this one as it is now, under a name of its own."""
        path = self.path.replace(".blend", f"_{len(self.done)}.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
        return path

    def bring(self, link: bool) -> Any:
        """One of the wrinkled objects of a library, in this scene."""
        mine = [o.name for o in bpy.data.objects if self.is_ours(o) and o.library is None]
        if not mine or not self.room():
            return None
        with bpy.data.libraries.load(self.library(), link=link) as (_, wanted):
            wanted.objects = [self.random.choice(mine)]
        return self.shown(wanted.objects[0])

    def shown(self, obj: Any) -> Any:
        """In this scene."""
        if obj is not None and not garment_walk.is_seen(obj):
            bpy.context.scene.collection.objects.link(obj)
        return obj

    def do_append(self) -> None:
        self.bring(link=False)

    def do_link(self) -> None:
        self.bring(link=True)

    def do_override(self) -> None:
        obj = self.bring(link=True)
        if obj is not None and obj.library is not None:
            made = self.shown(obj.override_create(remap_local_usages=True))
            if made is not None and self.random.random() < 0.5:
                made.rumple.mesh.radius = 0.5

    def do_override_setting(self) -> None:
        overrides = [o for o in bpy.context.scene.objects if o.override_library and self.is_ours(o)]
        if overrides:
            obj = self.random.choice(overrides)
            name, value = self.random.choice(garment_walk.SETTINGS[obj.rumple.method])
            setattr(properties.group_of(obj), name, value)

    def do_reload(self) -> None:
        """A library that somebody else has saved meanwhile."""
        if len(bpy.data.libraries):
            self.random.choice(list(bpy.data.libraries)).reload()

    def do_make_local(self) -> None:
        linked = [o for o in bpy.context.scene.objects if o.library is not None and self.is_ours(o)]
        if linked and self.room():
            obj = self.random.choice(linked)
            for found in (obj, obj.data):
                found.make_local()

    def do_purge(self) -> None:
        bpy.data.orphans_purge(do_recursive=True)

    def do_scene(self) -> None:
        """Make one, leave it, or go to another. None is removed that another window shows: that ends Blender."""
        window, *others = bpy.context.window_manager.windows
        scenes = list(bpy.data.scenes)
        removable = [scene for scene in scenes if not any(other.scene == scene for other in others)]
        if len(scenes) < MOST_SCENES and self.random.random() < 0.4:
            bpy.ops.scene.new(type=self.random.choice(("EMPTY", "LINK_COPY", "FULL_COPY")))
            scene = bpy.context.scene
            scene.frame_start, scene.frame_end = 1, sleeve.LAST
            scene.render.fps = self.random.choice((24, 60))
            scene.unit_settings.scale_length = self.random.choice((1.0, 0.01))
        elif len(scenes) > 1 and removable and self.random.random() < 0.2:
            bpy.data.scenes.remove(self.random.choice(removable))
        else:
            window.scene = self.random.choice(scenes)

    def do_alt_d_edit(self) -> None:
        """Two objects with one mesh, one of them edited while frames change."""
        obj = self.pick()
        if obj and self.room():
            bpy.ops.object.duplicate(linked=True)
            bpy.ops.object.mode_set(mode="EDIT")
            bpy.ops.mesh.select_all(action="SELECT")
            bpy.ops.transform.translate(value=(0.0, 0.0, self.random.uniform(-0.01, 0.01)))
            sleeve.at(self.random.randint(1, sleeve.LAST))
            bpy.ops.object.mode_set(mode="OBJECT")

    def do_delete_in_play(self) -> None:
        """What it is worn over goes between two frames of play."""
        obj = self.pick()
        if obj:
            body = sleeve.under(obj, "Going")
            obj.rumple.body = body
            sleeve.at(4)
            sleeve.at(5)
            bpy.data.objects.remove(body)
            sleeve.at(6)
            sleeve.at(7)
