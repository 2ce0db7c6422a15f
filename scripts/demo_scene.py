# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo scene of Rumple: shirt and trousers on a moving mannequin, made from nothing.

    blender -b --factory-startup --python scripts/demo_scene.py -- --out FILE.blend

Works alike in Blender 3.4, 4.3 and 5.2. The garment is smooth: wrinkles are the
add-on's business.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

sys.path.insert(0, str(Path(__file__).resolve().parent))

import demo_body  # noqa: E402
import demo_rig  # noqa: E402
import demo_shirt  # noqa: E402
import demo_trousers  # noqa: E402
from demo_body import Array  # noqa: E402

GARMENTS = ("Trousers", "Shirt")  # what is worn under others first
FRAME_START, FRAME_END, FRAMES_PER_SECOND = 1, 72, 24
RESOLUTION = (864, 1080)
CAMERA_POSITION, CAMERA_TARGET, CAMERA_LENS = (1.55, -4.65, 1.25), (0.03, 0.0, 0.93), 80.0
STUDIO_LIGHT = "studio.sl"
BACKGROUND = (0.30, 0.33, 0.37)

# Material: linear colour, roughness.
MATERIALS = {
    "Shirt cloth": ((0.24, 0.44, 0.62), 0.85),
    "Shirt trim": ((0.045, 0.085, 0.145), 0.85),
    "Mannequin": ((0.72, 0.56, 0.45), 0.60),
    "Trousers cloth": ((0.42, 0.35, 0.25), 0.85),
}
# Area light: position, energy in watts, size in metres, colour.
LIGHTS = {
    "Key": ((-1.9, -1.7, 2.6), 85.0, 0.9, (1.0, 0.96, 0.90)),
    "Fill": ((2.4, -1.6, 1.4), 9.0, 2.0, (0.85, 0.92, 1.0)),
    "Rim": ((1.2, 2.0, 2.4), 60.0, 0.8, (0.95, 0.97, 1.0)),
}


def clear_scene() -> None:
    """Remove all objects and the meshes, cameras and lights they leave behind."""
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing, do_unlink=True)
    for store in (bpy.data.meshes, bpy.data.cameras, bpy.data.lights, bpy.data.armatures,
                  bpy.data.materials, bpy.data.actions):
        for thing in [t for t in store if t.users == 0]:
            store.remove(thing)


def material(name: str) -> bpy.types.Material:
    """A cloth-like or skin-like material, for Workbench and for the path tracers."""
    colour, roughness = MATERIALS[name]
    made = bpy.data.materials.new(name)
    made.diffuse_color = (*colour, 1.0)
    made.roughness = roughness
    made.use_nodes = True
    shader = next(n for n in made.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = (*colour, 1.0)
    shader.inputs["Roughness"].default_value = roughness
    return made


def mesh_object(name: str, points: Array, quads: Array, materials: tuple[str, ...],
                second_material: Array | None = None) -> bpy.types.Object:
    """Smooth-shaded mesh object; the flag says which faces have the second of its materials."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.tolist(), [], quads.tolist())
    for slot in materials:
        mesh.materials.append(material(slot))
    if second_material is not None:
        mesh.polygons.foreach_set("material_index", second_material.astype(np.int32))
    mesh.polygons.foreach_set("use_smooth", np.ones(len(quads), dtype=bool))
    mesh.update()
    made = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(made)
    return made


def build_shirt_object(skeleton: bpy.types.Object) -> bpy.types.Object:
    """The coarse shirt with UVs, seams, materials and skin."""
    shirt = demo_shirt.build_shirt()
    made = mesh_object("Shirt", shirt.points, shirt.quads, ("Shirt cloth", "Shirt trim"),
                       shirt.is_trim)
    add_uv_map(made, shirt.uvs)
    for edge in made.data.edges:
        edge.use_seam = tuple(sorted(edge.vertices)) in shirt.seams
    demo_rig.skin(made, shirt.points, skeleton)
    return made


def build_trousers_object(skeleton: bpy.types.Object) -> bpy.types.Object:
    """The coarse trousers with UVs, material and skin."""
    trousers = demo_trousers.build_trousers()
    made = mesh_object("Trousers", trousers.points, trousers.quads, ("Trousers cloth",))
    add_uv_map(made, trousers.uvs)
    demo_rig.skin(made, trousers.points, skeleton, hangs=True)
    return made


def add_uv_map(garment: bpy.types.Object, uvs: Array) -> None:
    """uvs (m, 4, 2), one per corner."""
    garment.data.uv_layers.new(name="UVMap").data.foreach_set("uv", uvs.astype(np.float32).ravel())


def build_mannequin_object(skeleton: bpy.types.Object, spacing: float = 0.0075) -> bpy.types.Object:
    """The body under the clothes. spacing: of its points, metres."""
    points, quads = demo_body.build_body(spacing)
    made = mesh_object("Mannequin", points, quads, ("Mannequin",))
    demo_rig.skin(made, points, skeleton)
    return made


def aim(thing: bpy.types.Object, target: tuple) -> None:
    """Turn a camera or light to a point."""
    direction = Vector(target) - thing.location
    thing.rotation_euler = direction.to_track_quat("-Z", "Y").to_euler()


def add_camera_and_lights() -> None:
    """Camera, three area lights and an even world."""
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.lens = CAMERA_LENS
    camera.location = CAMERA_POSITION
    aim(camera, CAMERA_TARGET)
    scene.collection.objects.link(camera)
    scene.camera = camera
    for name, (position, energy, size, colour) in LIGHTS.items():
        data = bpy.data.lights.new(name, "AREA")
        data.energy, data.size, data.color = energy, size, colour
        light = bpy.data.objects.new(name, data)
        light.location = position
        aim(light, CAMERA_TARGET)
        scene.collection.objects.link(light)
    world = scene.world or bpy.data.worlds.new("World")
    scene.world = world
    world.color = BACKGROUND
    world.use_nodes = True
    sky = next(n for n in world.node_tree.nodes if n.type == "BACKGROUND")
    sky.inputs["Color"].default_value = (*BACKGROUND, 1.0)
    sky.inputs["Strength"].default_value = 0.40


def set_up_render() -> None:
    """Workbench with studio light and shadows; modest settings for Cycles."""
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = FRAME_START, FRAME_END
    scene.render.fps = FRAMES_PER_SECOND
    scene.render.resolution_x, scene.render.resolution_y = RESOLUTION
    scene.render.resolution_percentage = 100
    scene.render.engine = "BLENDER_WORKBENCH"
    scene.view_settings.view_transform = "Standard"
    shading = scene.display.shading
    shading.light, shading.color_type = "STUDIO", "MATERIAL"
    if STUDIO_LIGHT in {light.name for light in bpy.context.preferences.studio_lights}:
        shading.studio_light = STUDIO_LIGHT
    shading.show_cavity = shading.show_object_outline = False
    shading.show_shadows, shading.shadow_intensity = True, 0.45
    scene.display.light_direction = Vector((-0.45, 0.55, 0.70)).normalized()
    scene.display.render_aa = "8"
    if hasattr(scene, "cycles"):
        scene.cycles.samples = 64
        scene.cycles.use_denoising = False


def build_figure(body_spacing: float) -> bpy.types.Object:
    """An empty scene with the figure alone, at rest. body_spacing: metres. Returns its skeleton."""
    clear_scene()
    set_up_render()
    skeleton = demo_rig.build_armature(bpy.context.scene.collection)
    build_mannequin_object(skeleton, body_spacing)
    return skeleton


def build_demo_scene(body_spacing: float = 0.0075) -> bpy.types.Object:
    """Replace the open scene's objects by the demo and return the shirt. body_spacing: metres."""
    skeleton = build_figure(body_spacing)
    build_trousers_object(skeleton)
    shirt = build_shirt_object(skeleton)
    demo_rig.animate(skeleton)
    add_camera_and_lights()
    bpy.context.view_layer.objects.active = shirt
    bpy.context.scene.frame_set(FRAME_START)
    return shirt


def add_wrinkles(method: str) -> list[bpy.types.Object]:
    """One click of the add-on for each garment of the demo; the shirt stays the active object. Returns the garments."""
    garments = [bpy.data.objects[name] for name in GARMENTS]
    for garment in garments:
        bpy.context.view_layer.objects.active = garment
        if bpy.ops.object.rumple_add(method=method) != {"FINISHED"}:
            raise SystemExit(garment.rumple.message)
    return garments


def main() -> None:
    """Build the scene and save it where --out says."""
    parser = argparse.ArgumentParser(prog="demo_scene.py", description=__doc__.split("\n")[0])
    parser.add_argument("--out", type=Path, required=True, help="the .blend file to write")
    own = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    out = parser.parse_args(own).out.resolve()
    out.parent.mkdir(parents=True, exist_ok=True)
    build_demo_scene()
    bpy.ops.wm.save_as_mainfile(filepath=str(out))


if __name__ == "__main__":
    main()
