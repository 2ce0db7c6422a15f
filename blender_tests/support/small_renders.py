# SPDX-License-Identifier: GPL-3.0-or-later
"""Small renders of the sleeve from above, in which folds count: surfaces show their normals."""
from __future__ import annotations

import math
import os
import tempfile

import bpy
import numpy as np
from support import sleeve

SIZE = 96


def eevee() -> str:
    """EEVEE's identifier changed twice."""
    known = bpy.types.RenderSettings.bl_rna.properties["engine"].enum_items.keys()
    return "BLENDER_EEVEE_NEXT" if "BLENDER_EEVEE_NEXT" in known else "BLENDER_EEVEE"


def can_draw() -> bool:
    """Workbench and EEVEE need a screen; 5.x makes its own."""
    return bpy.app.version >= (5, 0, 0) or bool(os.environ.get("DISPLAY"))


def normal_material(mesh: bpy.types.Mesh) -> None:
    """Emits the surface normal: independent of lights, equal in Cycles and EEVEE."""
    material = bpy.data.materials.new("Normals")
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    geometry, emission, output = (tree.nodes.new(kind) for kind in ("ShaderNodeNewGeometry", "ShaderNodeEmission",
                                                                    "ShaderNodeOutputMaterial"))
    tree.links.new(geometry.outputs["Normal"], emission.inputs["Color"])
    tree.links.new(emission.outputs[0], output.inputs[0])
    for slot in range(len(mesh.materials)):
        mesh.materials[slot] = material


def plain_eevee(scene: bpy.types.Scene, samples: int) -> None:
    """For surfaces that emit what they show. From 4.2 on shadows and the probe of the world take most of the time of a
    picture that the processor draws."""
    scene.eevee.taa_render_samples = samples
    if hasattr(scene.eevee, "use_shadows"):
        scene.eevee.use_shadows = False
    if hasattr(scene.world, "probe_resolution"):
        scene.world.probe_resolution = "128"


def stage(engine: str) -> bpy.types.Object:
    """The wrinkled sleeve under a camera."""
    obj = sleeve.scene()
    normal_material(obj.data)
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.data.type, camera.data.ortho_scale = (0.25, 0.15, 3.0), "ORTHO", 0.8
    scene.collection.objects.link(camera)
    scene.camera = camera
    render = scene.render
    render.engine = eevee() if engine == "EEVEE" else engine
    render.resolution_x = render.resolution_y = SIZE
    render.resolution_percentage = 100
    render.film_transparent = True
    scene.view_settings.view_transform = "Raw" if engine != "BLENDER_WORKBENCH" else "Standard"
    if engine == "CYCLES":
        scene.cycles.samples, scene.cycles.use_denoising = 16, False
    if engine == "EEVEE":
        scene.world = bpy.data.worlds.new("World")
        plain_eevee(scene, 4)
    with sleeve.context():
        bpy.context.view_layer.update()
    return obj


def blur(shutter: float) -> None:
    """Motion blur of the whole scene, over so many frames around each; 0: none. Workbench has none in any version."""
    render, eevee = bpy.context.scene.render, bpy.context.scene.eevee
    for owner in (render, eevee):  # EEVEE had switches of its own until 4.2
        if hasattr(owner, "use_motion_blur"):
            owner.use_motion_blur, owner.motion_blur_shutter = shutter > 0.0, shutter
    eevee.motion_blur_steps = 4  # each takes a share of the samples


def read(path: str) -> np.ndarray:
    image = bpy.data.images.load(path)
    pixels = np.array(image.pixels[:], np.float32).reshape(SIZE, SIZE, 4)
    bpy.data.images.remove(image)
    return pixels


def still(frame: float) -> np.ndarray:
    """The picture of one frame, which may stand between two."""
    whole = math.floor(frame)
    sleeve.at(whole, frame - whole)
    with tempfile.TemporaryDirectory() as folder:
        bpy.context.scene.render.filepath = os.path.join(folder, "still.png")
        bpy.ops.render.render(write_still=True)
        return read(os.path.join(folder, "still.png"))


def clip(first: int, last: int) -> dict[int, np.ndarray]:
    """The pictures of some frames, rendered as an animation."""
    scene = bpy.context.scene
    former = scene.frame_end
    scene.frame_end = last
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = os.path.join(folder, "f")
        bpy.ops.render.render(animation=True)
        scene.frame_end = former
        return {frame: read(os.path.join(folder, f"f{frame:04d}.png")) for frame in range(first, last + 1)}
