# SPDX-License-Identifier: GPL-3.0-or-later
"""Small renders of the sleeve from above, in which folds count: surfaces show their normals."""
import os
import tempfile

import bpy
import numpy as np
import sleeve
from rumple.blender import operators

SIZE = 96


def eevee():
    """EEVEE's identifier changed twice."""
    known = bpy.types.RenderSettings.bl_rna.properties["engine"].enum_items.keys()
    return "BLENDER_EEVEE_NEXT" if "BLENDER_EEVEE_NEXT" in known else "BLENDER_EEVEE"


def can_draw():
    """Workbench and EEVEE need a screen; 5.x makes its own."""
    return bpy.app.version >= (5, 0, 0) or bool(os.environ.get("DISPLAY"))


def normal_material(mesh):
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


def stage(engine):
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
        scene.cycles.samples, scene.cycles.use_denoising = 8, False
    if engine == "EEVEE":
        scene.eevee.taa_render_samples = 4
    with sleeve.context():
        bpy.context.view_layer.update()
    return obj


def read(path):
    image = bpy.data.images.load(path)
    pixels = np.array(image.pixels[:], np.float32).reshape(SIZE, SIZE, 4)
    bpy.data.images.remove(image)
    return pixels


def still(frame):
    """The picture of one frame."""
    bpy.context.scene.frame_set(frame)
    with tempfile.TemporaryDirectory() as folder:
        bpy.context.scene.render.filepath = os.path.join(folder, "still.png")
        bpy.ops.render.render(write_still=True)
        return read(os.path.join(folder, "still.png"))


def clip(first, last):
    """The pictures of some frames, rendered as an animation."""
    scene = bpy.context.scene
    former = scene.frame_end
    scene.frame_end = last
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = os.path.join(folder, "f")
        bpy.ops.render.render(animation=True)
        scene.frame_end = former
        return {frame: read(os.path.join(folder, f"f{frame:04d}.png")) for frame in range(first, last + 1)}


def frozen(obj, frame, subframe=0.0):
    """A frame with an ordinary mesh in place of the wrinkled object: what the render has to look like."""
    sleeve.at(frame, subframe)
    with sleeve.context():
        mesh = operators.evaluated_mesh(bpy.context, obj)
    copy = bpy.data.objects.new("Frozen", mesh)
    bpy.context.scene.collection.objects.link(copy)
    obj.hide_render = True
    picture = still(frame)
    obj.hide_render = False
    bpy.data.objects.remove(copy)
    return picture


def difference(a, b):
    return float(np.abs(a - b).mean())


def check(case, engine):
    """Whether the frame rendered is the frame solved: in an animation, as a still, and not one frame late."""
    if engine != "CYCLES" and not can_draw():
        case.skipTest("this Blender needs a screen to draw; the window suite does it")
    obj = stage(engine)
    pictures = clip(1, 6)
    right, before = frozen(obj, 6), frozen(obj, 5)
    late = difference(right, before)
    case.assertGreater(late, 0.0)
    case.assertLess(difference(pictures[6], right), 0.1 * late)
    case.assertLess(difference(pictures[5], before), 0.1 * late)
    case.assertLess(difference(still(5), before), 0.1 * late)
    case.assertEqual(obj.rumple.message, "")
