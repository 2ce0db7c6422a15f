# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of the Wrinkle Maps: s4_face.jpg beside this file, from a scene of ../shared/data.

    RUMPLE_NATIVE=build/release/python blender -b --factory-startup ../shared/data/S4_face_expressions.blend \
        --python-exit-code 1 --python docs/pictures/make_face.py
"""
from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

import bpy
from mathutils import Matrix, Quaternion, Vector

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(ROOT / "addon"), str(ROOT / "scripts"), os.environ["RUMPLE_NATIVE"]]
import rumple  # noqa: E402
from contact_sheet import compose  # noqa: E402
from rumple.core.presets import MESH_PRESETS  # noqa: E402

REFERENCE = {"Surprise": 21, "Anger": 51}  # frames that hold these expressions
SHOWN = {"Neutral": 1, "Surprise": 21, "Anger": 51, "One brow of Anger": 51, "Laughing": 81, "Crying": 111}
BROW = ("oculi01.L", "oculi02.L")  # all that is posed in "One brow of Anger"
PRONOUNCED = 1.25  # "these expressions should be strongly pronounced" (section 4)
VIEW = Vector((0.35, -1.0, 0.05)).normalized()


def exaggerate(rig: bpy.types.Object, frame: int) -> None:
    """Every bone goes farther than in that frame."""
    bpy.context.scene.frame_set(frame)
    for bone in rig.pose.bones:
        axis, angle = bone.matrix_basis.to_quaternion().to_axis_angle()
        place = PRONOUNCED * bone.matrix_basis.to_translation()
        bone.matrix_basis = Matrix.Translation(place) @ Quaternion(axis, PRONOUNCED * angle).to_matrix().to_4x4()
    bpy.context.view_layer.update()


def wrinkle(head: bpy.types.Object, rig: bpy.types.Object) -> None:
    """Two reference poses, their maps baked from a Wrinkle Mesh, shown in the material."""
    bpy.context.view_layer.objects.active = head
    bpy.ops.object.rumple_add(method="MAPS")
    for name, frame in REFERENCE.items():
        exaggerate(rig, frame)
        bpy.ops.rumple.pose_add(name=name)
    skin = dict(MESH_PRESETS["SKIN"].values, wavelength=0.005, radius=0.5, hem_rings=3)
    for name, value in skin.items():
        setattr(head.rumple.mesh, name, value)
    head.rumple_maps.bake_size = 2048
    assert bpy.ops.rumple.maps_bake(every=True) == {"FINISHED"}
    assert bpy.ops.rumple.maps_show() == {"FINISHED"}


def stage(head: bpy.types.Object) -> None:
    """Skin, a low sun and a camera before the face; Cycles."""
    scene = bpy.context.scene
    for light in [o for o in bpy.data.objects if o.type == "LIGHT"]:
        bpy.data.objects.remove(light)
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.data.angle = 3.5, 0.05
    sun.rotation_euler = Vector((0.6, -0.6, 1.3)).to_track_quat("Z", "Y").to_euler()
    scene.collection.objects.link(sun)
    scene.world = bpy.data.worlds.new("Studio")
    if scene.world.node_tree is None:
        scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = (0.25, 0.27, 0.32, 1.0)
    shader = next(n for n in head.data.materials[0].node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = (0.55, 0.36, 0.28, 1.0)
    shader.inputs["Roughness"].default_value = 0.5
    camera, middle = scene.camera, head.matrix_world @ Vector((-0.005, -0.066, 0.79))
    camera.data.type, camera.data.ortho_scale = "ORTHO", 0.19
    camera.location = middle + 2.0 * VIEW
    camera.rotation_euler = VIEW.to_track_quat("Z", "Y").to_euler()
    render = scene.render
    render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 40, False
    render.resolution_x, render.resolution_y, render.resolution_percentage = 330, 400, 100


def only(rig: bpy.types.Object, names: tuple[str, ...]) -> None:
    """All other bones go to rest, and stay there when a render plays the frame."""
    rig.animation_data.action = None
    for bone in rig.pose.bones:
        if bone.name not in names:
            bone.matrix_basis.identity()


def influences(head: bpy.types.Object) -> bpy.types.Material:
    """A material that shows the masks: the first pose in red, the second in green."""
    material = head.data.materials[0].copy()
    tree = material.node_tree
    shader = next(n for n in tree.nodes if n.type == "BSDF_PRINCIPLED")
    masks, colour = tree.nodes.new("ShaderNodeAttribute"), tree.nodes.new("ShaderNodeVectorMath")
    masks.attribute_name = "rumple_poses_0"
    colour.operation = "MULTIPLY_ADD"
    colour.inputs[1].default_value, colour.inputs[2].default_value = (0.7, 0.5, 0.0), (0.08, 0.08, 0.08)
    tree.links.new(masks.outputs["Vector"], colour.inputs[0])
    tree.links.new(colour.outputs["Vector"], shader.inputs["Base Color"])
    return material


def picture(head: bpy.types.Object, muted: bool, material: bpy.types.Material, path: Path) -> Path:
    head.data.materials[0] = material
    for pose in head.rumple_maps.poses:
        pose.muted = muted
    bpy.context.view_layer.update()
    bpy.context.scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return path


def main() -> None:
    rumple.register()
    head, rig = bpy.data.objects["Head"], bpy.data.objects["HeadRig"]
    wrinkle(head, rig)
    stage(head)
    skin = head.data.materials[0]
    coloured = influences(head)
    with tempfile.TemporaryDirectory() as folder:
        tiles = []
        clip = rig.animation_data.action
        for name, frame in SHOWN.items():
            rig.animation_data.action = clip
            bpy.context.scene.frame_set(frame)
            if name == "One brow of Anger":
                only(rig, BROW)
            for label, muted, material in ((name, True, skin), ("Influences", False, coloured),
                                           ("Wrinkle Maps", False, skin)):
                tiles.append((label, picture(head, muted, material, Path(folder) / f"{len(tiles)}.png")))
        compose(tiles, 3, Path(folder) / "sheet.png")
        from PIL import Image
        Image.open(Path(folder) / "sheet.png").save(HERE / "s4_face.jpg", quality=88, optimize=True)


main()
