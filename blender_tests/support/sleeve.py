# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene that most tests use: a skinned sleeve on an arm that bends from frame 1 to 20, in an empty file."""
from __future__ import annotations

import contextlib
import io
import math
from typing import Any, Iterator

import bpy
import numpy as np
from rumple.blender import compat
from rumple.blender.objects import modifier, runtimes

AROUND, ALONG, LENGTH, RADIUS = 16, 12, 0.6, 0.06
LAST = 20


def tube(name: str = "Sleeve") -> bpy.types.Mesh:
    """A tube of quads along x, with a UV map (one seam), two materials and smooth shading."""
    vertices = [(LENGTH * j / (ALONG - 1), RADIUS * math.cos(a), RADIUS * math.sin(a))
                for j in range(ALONG) for a in np.linspace(0.0, 2.0 * math.pi, AROUND, endpoint=False)]
    quads = [(j * AROUND + i, j * AROUND + (i + 1) % AROUND, (j + 1) * AROUND + (i + 1) % AROUND, (j + 1) * AROUND + i)
             for j in range(ALONG - 1) for i in range(AROUND)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], quads)
    corners = [(i + (corner in (1, 2)), j + (corner in (2, 3))) for j in range(ALONG - 1) for i in range(AROUND)
               for corner in range(4)]
    uv = np.array(corners, np.float32) / (AROUND, ALONG - 1)
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", np.ascontiguousarray(uv, np.float32).ravel())
    mesh.polygons.foreach_set("use_smooth", np.ones(len(quads), bool))
    for material in ("Outside", "Cuff"):
        mesh.materials.append(bpy.data.materials.new(material))
    mesh.polygons.foreach_set("material_index", (np.arange(len(quads)) >= len(quads) - AROUND).astype(np.int32))
    mesh.update()
    return mesh


def arm() -> bpy.types.Object:
    """An armature of two bones; the lower one bends about z by 100 degrees."""
    rig = bpy.data.objects.new("Arm", bpy.data.armatures.new("Arm"))
    bpy.context.scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    upper, lower = (rig.data.edit_bones.new(name) for name in ("upper", "lower"))
    upper.head, upper.tail = (0.0, 0.0, 0.0), (LENGTH / 2, 0.0, 0.0)
    lower.head, lower.tail, lower.parent = upper.tail, (LENGTH, 0.0, 0.0), upper
    bpy.ops.object.mode_set(mode="OBJECT")
    bend = rig.pose.bones["lower"]
    bend.rotation_mode = "XYZ"
    for frame, degrees in ((1, 0.0), (LAST, 100.0)):
        bend.rotation_euler = (0.0, 0.0, math.radians(degrees))
        bend.keyframe_insert("rotation_euler", frame=frame)
    return rig


def bend_until(last: int) -> None:
    """The arm bends faster: until this frame."""
    for curve in compat.keyed_curves(bpy.data.objects["Arm"].animation_data):
        curve.keyframe_points[-1].co.x = last
        curve.update()


def skinned(mesh: bpy.types.Mesh, rig: bpy.types.Object, name: str = "Sleeve") -> bpy.types.Object:
    """An object with that mesh that follows the arm. Its wrinkles lie on the animated mesh, in one layer: tests of the
    cloth say so."""
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    upper, lower = (obj.vertex_groups.new(name=name) for name in ("upper", "lower"))
    for vertex in mesh.vertices:
        share = min(max((vertex.co.x / LENGTH - 0.35) / 0.3, 0.0), 1.0)
        upper.add([vertex.index], 1.0 - share, "REPLACE")
        lower.add([vertex.index], share, "REPLACE")
    obj.modifiers.new("Armature", "ARMATURE").object = rig
    for settings in (obj.rumple.mesh, obj.rumple.field, obj.rumple.paths):
        settings.base_cloth = "OFF"
    return obj


def make_active(obj: bpy.types.Object) -> None:
    bpy.context.view_layer.update()     # selecting an object that was just linked is silently ignored
    for other in bpy.context.view_layer.objects:
        other.select_set(other == obj)
    bpy.context.view_layer.objects.active = obj


def empty_file() -> bpy.types.Scene:
    """A file with one empty scene, frames 1 to 20. The add-on stays on: read_homefile would load preferences."""
    bpy.ops.wm.read_homefile(use_empty=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, LAST
    return scene


open_overrides = 0


@contextlib.contextmanager
def context(**members: object) -> Iterator[None]:
    """Timers have no window in their context, and opening a file makes other windows. No yield inside: run_suite.py."""
    global open_overrides
    if bpy.app.background:
        yield
        return
    with bpy.context.temp_override(**{"window": bpy.context.window_manager.windows[0], **members}):
        open_overrides += 1
        try:
            yield
        finally:
            open_overrides -= 1


def scene(wrinkles: bool = True, level: int = 1) -> bpy.types.Object:
    """Everything. level: solved subdivisions, low so that tests are quick."""
    empty_file()
    with context():
        obj = skinned(tube(), arm())
        make_active(obj)
        if wrinkles:
            obj.rumple.mesh.density, obj.rumple.mesh.level, obj.rumple.mesh.display_steps = "LEVEL", level, 0
            bpy.ops.object.rumple_add(method="MESH")
        bpy.context.view_layer.update()
    return obj


def another(name: str, radius: float = 1.0) -> bpy.types.Object:
    """A second wrinkled tube on the arm, of that many of the sleeve's radii."""
    mesh = tube(name)
    for vertex in mesh.vertices:
        vertex.co.yz *= radius
    obj = skinned(mesh, bpy.data.objects["Arm"], name)
    obj.rumple.mesh.density, obj.rumple.mesh.level, obj.rumple.mesh.display_steps = "LEVEL", 1, 0
    make_active(obj)
    with context():
        bpy.ops.object.rumple_add(method="MESH")
    return obj


def cuff(sleeve_object: bpy.types.Object, follow: str, name: str) -> bpy.types.Object:
    """A wider tube that follows the sleeve by Shrinkwrap or Surface Deform, wrinkled itself."""
    mesh = tube(name)
    for vertex in mesh.vertices:
        vertex.co.yz *= 1.3
    obj = skinned(mesh, bpy.data.objects["Arm"], name)
    leaning = obj.modifiers.new("Follow", follow)
    leaning.target = sleeve_object
    make_active(obj)
    if follow == "SHRINKWRAP":
        leaning.offset = 0.02
    else:
        obj.modifiers.remove(obj.modifiers["Armature"])
        with context():
            bpy.ops.object.surfacedeform_bind(modifier="Follow")
        assert leaning.is_bound
    obj.rumple.mesh.density, obj.rumple.mesh.level, obj.rumple.mesh.display_steps = "LEVEL", 1, 0
    with context():
        bpy.ops.object.rumple_add(method="MESH")
    return obj


def under(obj: bpy.types.Object, name: str = "Human", radius: float = 0.8) -> bpy.types.Object:
    """A tube that follows the arm of the sleeve, of that many of its radii: what it is worn over. obj stays active."""
    mesh = tube(name)
    for vertex in mesh.vertices:
        vertex.co.yz *= radius
    body = skinned(mesh, bpy.data.objects["Arm"], name)
    make_active(obj)
    return body


def to_be_cloth() -> bpy.types.Object:
    """The sleeve over an arm, without wrinkles: a first click says what they lie on."""
    obj = scene(wrinkles=False)
    for settings in (obj.rumple.mesh, obj.rumple.field, obj.rumple.paths):
        settings.property_unset("base_cloth")
    under(obj, "Human")
    return obj


def click(obj: bpy.types.Object, method: str = "MESH") -> str:
    """Adds wrinkles by the first click. Returns what it says."""
    make_active(obj)
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        assert bpy.ops.object.rumple_add(method=method) == {"FINISHED"}
    return said.getvalue()


# ---------------------------------------------------------------- what is seen
def evaluated(obj: bpy.types.Object) -> bpy.types.Object:
    return obj.evaluated_get(bpy.context.evaluated_depsgraph_get())


def shown(obj: bpy.types.Object) -> np.ndarray:
    """Positions of what the viewport shows of an object, (n, 3) float32."""
    return compat.positions(evaluated(obj).data).copy()


def attribute(obj: bpy.types.Object, name: str) -> np.ndarray:
    """Values of an attribute of the evaluated mesh."""
    return compat.read_attribute(evaluated(obj).data.attributes[name])


def picture(obj: bpy.types.Object) -> Any:
    """What was solved last."""
    return runtimes.of(obj).result


def output_object(obj: bpy.types.Object) -> bpy.types.Object:
    return modifier.output_object(modifier.find(obj))


def at(frame: int, subframe: float = 0.0) -> None:
    bpy.context.scene.frame_set(frame, subframe=subframe)


def play(first: int = 1, last: int = LAST) -> None:
    for frame in range(first, last + 1):
        at(frame)


def names(collection: Any) -> list[str]:
    return sorted(item.name for item in collection)


def is_fine(obj: bpy.types.Object) -> bool:
    """Whether viewports show more than the coarse mesh."""
    shown = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return len(shown.data.vertices) > len(obj.data.vertices)
