# SPDX-License-Identifier: GPL-3.0-or-later
"""A random walk through what an artist may do with Wrinkle Maps: at every step the masks are those of a fresh start."""
from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from rumple.blender import compat, scheduler
from rumple.blender.maps import modifier as maps_modifier, rig as maps_rig
from rumple.blender.nodes import maps_mask_tree
from rumple.blender.objects import modifier, properties
from rumple.core.systems.poses import PoseComparison, strengths
from support import face, keyed_face, sleeve
from support.random_walk import RandomWalk

ROUNDING = 2e-4  # of a mask, where the gain is 1: nodes count in single precision


class Walk(RandomWalk):

    REOPEN = 0.03
    OFTEN = ("do_pose",) * 3

    def start(self) -> None:
        face.two_poses(*face.scene())

    def is_ours(self, obj: bpy.types.Object) -> bool:
        return maps_modifier.find(obj) is not None

    # --- the law
    def check(self) -> None:
        scheduler.sync_all()
        self.do_pose()
        self.check_lists()
        mapped = maps_modifier.mapped_objects()
        shown = [(obj, nodes_mod) for obj, nodes_mod in mapped if obj.name in bpy.context.view_layer.objects]
        owned = [nodes_mod.node_group for _, nodes_mod in shown]
        owned += [maps_modifier.skin(nodes_mod) for obj, nodes_mod in shown if obj.rumple_maps.poses]
        assert len(set(owned)) == len(owned) and None not in owned, f"after {self.done[-8:]}: {owned}"
        for obj, nodes_mod in shown:
            trail = f"{obj.name} after {self.done[-8:]}"
            assert obj.rumple_maps.message == "", f"{trail}: {obj.rumple_maps.message}"
            if nodes_mod.show_viewport and obj.rumple_maps.poses:
                self.compare(obj, trail)

    def compare(self, obj: bpy.types.Object, trail: str) -> None:
        rig, _ = maps_rig.rig_of(obj)
        bones, keys = maps_rig.present(obj, rig)
        fresh = PoseComparison.build(rig, maps_rig.weights_of(obj, rig)).frame(bones, keys=keys)
        names = {maps_mask_tree.MASK.format(pose.name) for pose in rig.poses}
        attributes = sleeve.evaluated(obj).data.attributes
        assert names == {a.name for a in attributes if a.name.startswith("rumple_pose_")}, f"{trail}: other names"
        for pose, mask, strength in zip(rig.poses, fresh.pose, strengths(rig.poses)):
            found = compat.read_attribute(attributes[maps_mask_tree.MASK.format(pose.name)])[:, 0]
            mask = face.carried(obj, mask)
            assert found.shape == mask.shape and np.abs(found - mask).max() < ROUNDING * rig.gain, \
                f"{trail}: {pose.name} shows {found.max()}, not {mask.max()}"
            assert strength > 0.0 or not found.any(), f"{trail}: {pose.name} is muted"
        images = [node.image for node in (obj.rumple_maps.group.nodes if obj.rumple_maps.group else ())
                  if node.type == "TEX_IMAGE"]
        assert obj.rumple_maps.group is None or images == [i for i in maps_rig.usable_images(obj) if i], trail

    # --- helpers
    def pick_pose(self) -> Any:
        obj = self.pick()
        if obj is None or not obj.rumple_maps.poses:
            return None
        obj.rumple_maps.active = self.random.randrange(len(obj.rumple_maps.poses))
        return obj.rumple_maps.poses[obj.rumple_maps.active]

    # --- the steps
    def do_pose(self) -> None:
        face.pose(bpy.data.objects["Rig"], **{name: self.random.uniform(-0.01, 0.01)
                                              for name in ("brow_L", "brow_R", "jaw") if self.random.random() < 0.7})

    def do_keys(self) -> None:
        """Shape keys: made, chosen, set, muted, renamed, taken away."""
        obj = self.pick()
        if obj is None:
            return
        if obj.data.shape_keys is None:
            keyed_face.add_keys(obj, ("brow.L", "brow.R", "jaw"))
        blocks = list(obj.data.shape_keys.key_blocks)[1:]
        bpy.ops.rumple.maps_keys()
        for block in blocks:
            block.value, block.mute = self.random.uniform(-1.0, 1.0), self.random.random() < 0.2
        if self.random.random() < 0.2:
            blocks[0].name = self.random.choice(("brow.L", "a \"quoted\" key"))
        elif self.random.random() < 0.2 and len(blocks) > 1:
            obj.shape_key_remove(blocks[-1])
        bpy.context.view_layer.update()

    def do_pose_add(self) -> None:
        obj = self.pick()
        if obj and len(obj.rumple_maps.poses) < 7:
            self.do_pose()
            try:
                bpy.ops.rumple.pose_add(name=self.random.choice(("Surprise", "Anger", "Pose")))
            except RuntimeError as error:
                assert "it is the neutral pose" in str(error), error

    def do_pose_update(self) -> None:
        if self.pick_pose():
            face.pose(bpy.data.objects["Rig"], brow_L=self.random.uniform(0.004, 0.009), jaw=0.003)
            bpy.ops.rumple.pose_update()

    def do_pose_remove(self) -> None:
        if self.pick_pose():
            bpy.ops.rumple.pose_remove()

    def do_pose_move(self) -> None:
        if self.pick_pose():
            bpy.ops.rumple.pose_move(direction=self.random.choice(("UP", "DOWN")))

    def do_pose_rename(self) -> None:
        pose = self.pick_pose()
        if pose:
            pose.name = self.random.choice(("Surprise", "Anger", "Grief", ""))

    def do_pose_switches(self) -> None:
        pose = self.pick_pose()
        if pose:
            name, value = self.random.choice((("muted", True), ("muted", False), ("solo", True), ("solo", False),
                                              ("strength", 0.5), ("strength", 1.0)))
            setattr(pose, name, value)

    def do_image(self) -> None:
        pose = self.pick_pose()
        if pose:
            pose.image = bpy.data.images.new("Wrinkles", 4, 4, is_data=True) if self.random.random() < 0.7 else None

    def do_neutral(self) -> None:
        obj = self.pick()
        if obj and self.random.random() < 0.5:
            bpy.ops.rumple.neutral_rest()
        elif obj:
            face.pose(bpy.data.objects["Rig"], brow_L=0.001, brow_R=0.001)
            bpy.ops.rumple.neutral_capture()

    def do_bone_settings(self) -> None:
        obj = self.pick()
        if obj and obj.rumple_maps.bones:
            bone = self.random.choice(list(obj.rumple_maps.bones))
            bone.tracked, bone.group = self.random.choice(("HEAD", "TAIL", "BOTH")), self.random.choice(("", "brows"))
            obj.rumple_maps.gain = self.random.choice((1.0, 3.0))

    def do_materials(self) -> None:
        if self.pick():
            try:
                self.random.choice((bpy.ops.rumple.maps_show, bpy.ops.rumple.maps_hide))()
            except RuntimeError as error:   # duplicates share a material
                assert "shows the maps of another object" in str(error), error

    def do_remove(self) -> None:
        if self.pick():
            bpy.ops.rumple.maps_remove()

    def do_add(self) -> None:
        if self.pick(ours=False):
            bpy.ops.rumple.maps_add()

    def do_wrinkle_mesh(self) -> None:
        obj = self.pick()
        if obj and modifier.find(obj) is None:
            obj.rumple.mesh.density, obj.rumple.mesh.level, obj.rumple.mesh.display_steps = "LEVEL", 1, 0
            bpy.ops.object.rumple_add(method="MESH")
        elif obj:
            bpy.ops.object.rumple_remove()

    def do_bake(self) -> None:
        if self.random.random() < 0.3 and self.pick_pose():
            bpy.context.object.rumple_maps.bake_size = 16
            properties.group_of(bpy.context.object).level = 1
            bpy.ops.rumple.maps_bake()

    def do_paint(self) -> None:
        obj = self.pick()
        if obj:
            index = self.random.randrange(len(obj.data.vertices))
            obj.vertex_groups["jaw"].add([index], self.random.random(), "REPLACE")
            obj.data.update()

    def do_edit_mode(self) -> None:
        if self.pick():
            bpy.ops.object.mode_set(mode="EDIT")
            bpy.ops.object.mode_set(mode="OBJECT")

    def do_switch_off_and_on(self) -> None:
        obj = self.pick()
        if obj:
            maps_modifier.find(obj).show_viewport = False
            self.do_pose()
            maps_modifier.find(obj).show_viewport = True
