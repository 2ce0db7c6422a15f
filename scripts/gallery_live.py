# SPDX-License-Identifier: GPL-3.0-or-later
"""Two scenes of the gallery in which more than frames goes by: a hand that paints folds, and a face with Wrinkle Maps.

The hand is a path that is written here. Its strokes are those of the add-on's own brush: the same dabs on the same
canvas, so many for each frame. Blender keys no painting: what is rendered is what an artist sees while the hand moves.
"""
from __future__ import annotations

from dataclasses import dataclass

import bpy
import demo_rig
import face_poses
import gallery_scenes
import numpy as np
from mathutils import Vector
from rumple.blender import scheduler
from rumple.blender.brush import canvas

# Strokes: from and to, metres across the chest and above the ground, as the camera sees them.
STROKES = (((-0.045, 1.415), (-0.125, 1.02)), ((0.045, 1.415), (0.125, 1.02)), ((0.0, 1.385), (0.0, 1.00)))
STROKE_FRAMES, PAUSE, LAST_FRAMES = 16, 4, 10  # of a stroke, before the next, behind the last
PAINT_FRAMES = (1, len(STROKES) * (STROKE_FRAMES + PAUSE) + LAST_FRAMES)
RADIUS, SPACING, STRENGTH, LENGTH = 0.034, 0.008, 0.4, 0.6  # metres, metres from dab to dab, of the brush
FIELD_WAVELENGTH, FIELD_IRREGULARITY = 0.055, 0.45
TOWARDS = (0.0, 1.0, 0.0)  # the view
RING = "Brush"
DONE = "painted dabs"  # property of the shirt: how many of them
SKIN = (0.55, 0.36, 0.28)  # linear colour
FACE_SIZE = 2048  # texels of its maps


def build_painted() -> bpy.types.Object:
    """The figure at rest, in a shirt that is to be painted on."""
    gallery_scenes.dressed([demo_rig.Pose(frame) for frame in PAINT_FRAMES])
    return gallery_scenes.ready("Shirt")


@dataclass(frozen=True)
class Dab:
    """Where the brush is set down, and where the hand goes: metres in the picture."""

    place: tuple[float, float]
    way: tuple[float, float]


def dabs_until(frame: int) -> list[Dab]:
    """All of them, up to a frame."""
    found = []
    for number, (start, end) in enumerate(STROKES):
        done = (frame - PAINT_FRAMES[0] - number * (STROKE_FRAMES + PAUSE)) / STROKE_FRAMES
        if done <= 0.0:
            break
        way = np.subtract(end, start)
        length = float(np.hypot(*way))
        for along in np.arange(0.0, min(done, 1.0) * length, SPACING) / length:
            found.append(Dab(tuple(np.add(start, along * way)), tuple(way / length)))
    return found


def paint_until(shirt: bpy.types.Object, frame: int) -> None:
    """Go on to paint what the hand has painted up to a frame; the ring of the brush stands where the hand is."""
    ready = canvas.canvas_of(shirt)
    ready.pose(shirt, bpy.context.evaluated_depsgraph_get())
    before = canvas.read(shirt.data)
    painted = np.zeros((len(shirt.data.vertices), 3), np.float32) if before is None else before
    dabs = dabs_until(frame)
    for dab in dabs[shirt.get(DONE, 0):]:
        hit = ready.hit(Vector((dab.place[0], -1.0, dab.place[1])), Vector(TOWARDS))
        if hit is None:
            continue
        painted = ready.easel.dab(painted, False, touch="PAINT", centre=tuple(hit[0]), normal=tuple(hit[1]),
                                  view=TOWARDS, direction=(dab.way[0], 0.0, dab.way[1]), across=False, radius=RADIUS,
                                  strength=STRENGTH, length=LENGTH, falloff="SMOOTH")
        set_ring(*hit)
    shirt[DONE] = len(dabs)
    canvas.write(shirt.data, painted)
    scheduler.sync_all()


def set_ring(place: Vector, normal: Vector) -> None:
    """The circle of the brush, as its overlay draws it in a viewport."""
    ring = bpy.data.objects.get(RING)
    if ring is None:
        bpy.ops.curve.primitive_bezier_circle_add(radius=RADIUS)
        ring = bpy.context.object
        ring.name, ring.data.bevel_depth = RING, 0.0012
        ring.data.materials.append(glowing())
    ring.location = place + 0.012 * normal
    ring.rotation_euler = normal.to_track_quat("Z", "Y").to_euler()


def glowing() -> bpy.types.Material:
    made = bpy.data.materials.new(RING)
    made.use_nodes = True
    made.node_tree.nodes.clear()
    light, out = (made.node_tree.nodes.new(f"ShaderNode{kind}") for kind in ("Emission", "OutputMaterial"))
    light.inputs["Color"].default_value = (1.0, 0.45, 0.1, 1.0)
    made.node_tree.links.new(light.outputs[0], out.inputs["Surface"])
    return made


def wrinkle_painted(shirt: bpy.types.Object) -> None:
    """A Wrinkle Field as geometry, as in the lesson."""
    bpy.context.view_layer.objects.active = shirt
    if bpy.ops.object.rumple_add(method="FIELD") != {"FINISHED"}:
        raise SystemExit(shirt.rumple.message)
    settings = shirt.rumple.field
    settings.output, settings.wavelength, settings.irregularity = "GEOMETRY", FIELD_WAVELENGTH, FIELD_IRREGULARITY
    scheduler.sync_all()


def show_paint(shirt: bpy.types.Object) -> None:
    """The bare shirt, redder where more is painted."""
    for modifier in shirt.modifiers:
        if modifier.type == "NODES":
            modifier.show_render = False
    for slot in shirt.material_slots:
        tree = slot.material.node_tree
        shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
        paint, length, colour = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("Attribute", "VectorMath", "MixRGB"))
        paint.attribute_name = "rumple_rest_wrinkle"
        length.operation = "LENGTH"
        colour.inputs[1].default_value = shader.inputs["Base Color"].default_value
        colour.inputs[2].default_value = (0.80, 0.10, 0.04, 1.0)
        tree.links.new(paint.outputs["Vector"], length.inputs[0])
        tree.links.new(length.outputs["Value"], colour.inputs[0])
        tree.links.new(colour.outputs[0], shader.inputs["Base Color"])


def build_face() -> bpy.types.Object:
    """The open scene's face, whose brows rise when it is surprised."""
    head, rig = bpy.data.objects["Head"], bpy.data.objects["HeadRig"]
    face_poses.key_brows(rig)
    shader = next(node for node in head.data.materials[0].node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value, shader.inputs["Roughness"].default_value = (*SKIN, 1.0), 0.5
    return head


def wrinkle_face(head: bpy.types.Object, size: int = FACE_SIZE) -> None:
    """Two reference poses, their maps baked as one click has them. size: texels."""
    face_poses.add_maps(head, bpy.data.objects["HeadRig"], size)
    bpy.context.scene.frame_set(bpy.context.scene.frame_start)
    if head.rumple.message:
        raise SystemExit(head.rumple.message)
