# SPDX-License-Identifier: GPL-3.0-or-later
"""A random walk through everything an artist may do to wrinkled objects, with a law checked at every step."""
from __future__ import annotations

from typing import Any

import bmesh
import bpy
import numpy as np
from rumple.blender import scheduler
from rumple.blender.frame import path_curves
from rumple.blender.objects import bodies, mesh_reader, modifier, properties, runtimes
from rumple.core.frame import engine
from support import curve_edges, sleeve
from support.random_walk import MOST_OBJECTS, RandomWalk

PAINT = "Rumple Radius"
SETTINGS = dict(
    MESH=(("radius", 0.5), ("bending", 0.2), ("level", 0), ("level", 1), ("hem_rings", 0), ("attachment", "PN"),
          ("attachment", "LIMIT"), ("source", "REGULAR"), ("source", "SUBDIVISION"), ("display_steps", 1),
          ("collision", "NONE"), ("rest_shape", "ADAPTIVE"), ("rest_shape", "REST_POSE"), ("gpu_preview", False),
          ("gpu_preview", True)),
    FIELD=(("output", "GEOMETRY"), ("output", "SHADING"), ("detail", 2), ("source", "EDGE_LENGTH"),
           ("profile", "CURVE"), ("profile", "ACCORDION"), ("irregularity", 0.5), ("rounds", 3), ("seed", 2),
           ("start", "RANDOM"), ("rest_shape", "ADAPTIVE"), ("gpu_preview", False), ("gpu_preview", True)),
    PATHS=(("width", 0.03), ("threshold", 1.1), ("reference", "FIRST_FRAME"), ("direction", "BOTH"), ("seed", 2),
           ("profile", "SINE"), ("source", "EDGE_LENGTH"), ("stateless", True), ("gpu_preview", False),
           ("gpu_preview", True)))


def is_seen(obj: bpy.types.Object) -> bool:
    """Whether the view layer has it: it, not one of its name from another file."""
    return any(other == obj for other in bpy.context.view_layer.objects)


def is_too_costly(obj: bpy.types.Object) -> bool:
    """Whether it was refused in words: a fine mesh of triangles above a Subdivision would take gigabytes."""
    return "switch off Use Limit Surface" in obj.rumple.message and "Subdivision" in obj.modifiers


class Walk(RandomWalk):

    OFTEN: tuple[str, ...] = ("do_add", "do_free", "do_curves")

    def start(self) -> None:
        obj = sleeve.scene()
        with sleeve.context():
            bpy.ops.object.rumple_paint(group="radius")
            obj.vertex_groups[PAINT].add(range(20), 0.25, "REPLACE")
            self.leave_mode()
            bpy.ops.wm.save_as_mainfile(filepath=self.path)

    def choose(self, names: list[str]) -> str:
        return super().choose(names) if any(modifier.wrinkled_objects()) else "do_add"

    def is_ours(self, obj: bpy.types.Object) -> bool:
        return modifier.find(obj) is not None

    # --- the law
    def check(self) -> None:
        sleeve.at(self.random.randint(1, sleeve.LAST))
        self.check_lists()
        scheduler.sync_all()
        sleeve.at(self.random.randint(1, sleeve.LAST))
        outputs = set()
        for obj, nodes_mod in list(modifier.wrinkled_objects()):
            trail = f"{obj.name} after {self.done[-8:]}"
            output_obj = modifier.output_object(nodes_mod)
            assert output_obj is not None and output_obj.name not in outputs, f"{trail}: output object {output_obj}"
            outputs.add(output_obj.name)
            if PAINT in obj.vertex_groups:
                weights = mesh_reader.group_weights(obj, obj.data, [PAINT])
                assert np.isclose(weights, 0.25).sum() >= 20, f"{trail}: paint is lost"
            refused = bodies.refusal(obj)
            if not is_seen(obj):
                continue  # deleted, but still named by another one: nothing evaluates it
            if is_too_costly(obj):
                continue  # the last picture stays
            assert obj.rumple.message == refused or modifier.is_baked(nodes_mod), f"{trail}: {obj.rumple.message}"
            assert "expected" not in obj.rumple.message, f"{trail}: {obj.rumple.message}"  # of an array
            if refused:
                continue  # the last picture stays
            self.check_body(obj, trail)
            last = obj.modifiers[len(obj.modifiers) - 1] == nodes_mod  # a Subdivision behind it moves the points
            drawn = isinstance(sleeve.picture(obj), engine.PreviewFrame)  # by the viewport: no fine mesh to compare
            if last and not modifier.is_baked(nodes_mod) and not drawn:
                off = np.abs(sleeve.shown(obj) - sleeve.picture(obj).positions).max()
                assert off < 1e-5, f"{trail}: shows something else, {off}"
            self.check_curves(obj, trail)

    def check_body(self, obj: bpy.types.Object, trail: str) -> None:
        """What it was solved for is what is shown of its body."""
        if is_seen(obj) and not modifier.is_baked(modifier.find(obj)):
            found, seen = runtimes.of(obj).inputs.body, bodies.of(obj)
            assert (found is None) == (not seen), f"{trail}: {found} is not of {seen}"
            for body in seen:
                if modifier.find(body) is None and is_seen(body):
                    np.testing.assert_allclose(found.positions, sleeve.shown(body), atol=1e-5, err_msg=trail)

    def check_curves(self, obj: bpy.types.Object, trail: str) -> None:
        """Those that are shown are those that were solved; their meshes are their own."""
        for child in path_curves.of(obj):
            assert child.data.users == 1, f"{trail}: {child.name} shares its mesh"
            seen = is_seen(obj) and is_seen(child)
            if seen and modifier.find(obj).show_viewport and modifier.mesh_cache(child) is None:
                _, positions, _ = curve_edges.seen(child)
                expected = curve_edges.solved(obj).positions
                assert positions.shape == expected.shape, f"{trail}: {len(positions)} points of {len(expected)}"
                off = np.abs(positions - expected).max(initial=0.0)
                assert off < 1e-5, f"{trail}: curves show something else, {off}"

    # --- the steps
    def do_curves(self) -> Any:
        if self.pick():
            buttons = (bpy.ops.object.rumple_curves_add, bpy.ops.object.rumple_curves_remove)
            for button in buttons if self.random.random() < 0.7 else buttons[::-1]:
                if button.poll():
                    return button()

    def do_copy_with_curves(self) -> None:
        obj = self.pick()
        if obj and len(bpy.context.scene.objects) < MOST_OBJECTS:
            for child in path_curves.of(obj):
                child.select_set(True)
            bpy.ops.object.duplicate(linked=self.random.random() < 0.5)

    def do_body(self) -> None:
        """Set or unset one: it may be wrinkled itself, or worn over this one."""
        obj = self.pick()
        if obj:
            others = [o for o in bpy.context.scene.objects if o != obj and bodies.can_be_body(o)]
            obj.rumple.body = self.random.choice([None, *others])

    def do_frame(self) -> None:
        sleeve.at(self.random.randint(1, sleeve.LAST), self.random.choice((0.0, 0.0, 0.5)))

    def do_pose(self) -> None:
        bend = bpy.data.objects["Arm"].pose.bones["lower"]
        bend.rotation_euler.z = self.random.uniform(0.0, 1.5)
        bpy.context.view_layer.update()

    def do_setting(self) -> None:
        obj = self.pick()
        if obj:
            name, value = self.random.choice(SETTINGS[obj.rumple.method])
            setattr(properties.group_of(obj), name, value)

    def do_preset(self) -> None:
        obj = self.pick()
        if obj and bpy.ops.object.rumple_preset.poll():
            bpy.ops.object.rumple_preset(preset=self.random.choice(("LEATHER", "SILK", "COTTON")))

    def do_rename(self) -> None:
        obj = self.pick()
        if obj:
            obj.name = self.random.choice(("Shirt", "Coat", "Sleeve"))

    def do_remove(self) -> None:
        if self.pick():
            bpy.ops.object.rumple_remove()

    def do_add(self) -> None:
        obj = self.pick(ours=False)
        if obj and len(obj.data.vertices) < 1500 and path_curves.find(obj) is None:
            obj.rumple.mesh.density, obj.rumple.mesh.level, obj.rumple.mesh.display_steps = "LEVEL", 1, 0
            for group in (obj.rumple.mesh, obj.rumple.field, obj.rumple.paths):
                group.gpu_preview = True
            self.add(obj)

    def add(self, obj: bpy.types.Object) -> None:
        """One thing may be refused, with words, and leaves nothing: see subdivision_behind.py."""
        try:
            bpy.ops.object.rumple_add(method=self.random.choice(("MESH", "FIELD", "PATHS")))
        except RuntimeError as error:
            assert "GB for a fine mesh of triangles: switch off" in str(error), f"after {self.done[-8:]}: {error}"
            assert not self.is_ours(obj), f"after {self.done[-8:]}: refused, and there all the same"

    def do_materials(self) -> None:
        if self.pick() and bpy.ops.object.rumple_shade.poll():
            self.random.choice((bpy.ops.object.rumple_shade, bpy.ops.object.rumple_unshade))()

    def do_apply(self) -> None:
        if len([o for o in bpy.context.scene.objects if o.type == "MESH"]) > 2:
            obj = self.pick()
            if obj and len(obj.data.vertices) < 300 and not modifier.is_baked(modifier.find(obj)):
                bpy.ops.object.rumple_apply()

    def do_paint(self) -> None:
        obj = self.pick()
        if obj:
            groups = dict(MESH=("bending", "inside"), FIELD=("mask", "wavelength"), PATHS=("mask",))[obj.rumple.method]
            bpy.ops.object.rumple_paint(group=self.random.choice(groups))

    def do_topology(self) -> None:
        obj = self.pick()
        if obj and len(obj.data.polygons) > 100:
            edit = bmesh.new()
            edit.from_mesh(obj.data)
            edit.faces.ensure_lookup_table()
            bmesh.ops.delete(edit, geom=edit.faces[-3:], context="FACES")
            edit.to_mesh(obj.data)
            edit.free()
            obj.data.update()

    def do_edit_mode(self) -> None:
        if self.pick():
            bpy.ops.object.mode_set(mode="EDIT")
            sleeve.at(self.random.randint(1, sleeve.LAST))
            bpy.ops.object.mode_set(mode="OBJECT")

    def do_subdivision(self) -> None:
        obj = self.pick()
        if obj:
            former = obj.modifiers.get("Subdivision")
            if former:
                obj.modifiers.remove(former)
            else:
                obj.modifiers.new("Subdivision", "SUBSURF")

    def do_switch_off_and_on(self) -> None:
        obj = self.pick()
        if obj:
            modifier.find(obj).show_viewport = False
            sleeve.at(3)
            modifier.find(obj).show_viewport = True

    def do_capture(self) -> None:
        obj = self.pick()
        if obj and not modifier.is_baked(modifier.find(obj)):
            bpy.ops.object.rumple_capture_rest(frame=self.random.randint(1, 5))
            properties.group_of(obj).rest_shape = "REST_POSE"

    def do_bake(self) -> None:
        obj = self.pick()
        if obj and not bodies.refusal(obj) and not is_too_costly(obj):
            obj.rumple.bake_start, obj.rumple.bake_end = 3, 6
            bpy.ops.object.rumple_bake()

    def do_free(self) -> None:
        if self.pick() and bpy.ops.object.rumple_bake_free.poll():
            bpy.ops.object.rumple_bake_free()

    def do_render(self) -> None:
        if self.random.random() < 0.3:
            scene = bpy.context.scene
            if scene.camera is None:
                scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
                scene.collection.objects.link(scene.camera)
            scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 1, False
            scene.render.resolution_x = scene.render.resolution_y = 16
            bpy.ops.render.render()
