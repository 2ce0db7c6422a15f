# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes of the gallery that nothing else has, made in Blender from the demo's figure and clothes. The add-on must be
registered: some garments come with settings of their own.

Metres, z up, the figure faces -y. Each function replaces the open scene and leaves nothing wrinkled.
"""
from __future__ import annotations

import math
from typing import Callable, Sequence

import bpy
import demo_body
import demo_rig
import demo_scene
import demo_shirt
import demo_trousers
import numpy as np
import scene_motions
from demo_body import Array
from demo_rig import Pose

BODY_SPACING = 0.012  # metres: files stay small
SEAT_HALF, SEAT_EDGE = (0.21, 0.19), 0.03  # metres: half width and depth, the radius of its edges
SEAT_SINK = 0.015  # metres that the seat gives way under the trousers
# Of the cape, from the neck to the hem: height, half width, half depth, degrees to each side of the spine.
CAPE = np.array([[1.503, 0.085, 0.076, 130.0], [1.475, 0.150, 0.104, 120.0], [1.430, 0.220, 0.125, 106.0],
                 [1.360, 0.262, 0.150, 90.0], [1.200, 0.310, 0.200, 86.0], [0.480, 0.540, 0.420, 80.0]])
CAPE_ACROSS, CAPE_ALONG, CAPE_ROOM = 40, 36, (0.008, 0.010, 0.012)  # vertices, vertices; metres off the shirt, by row
WIND_SPEED, WIND_TURNS = 5.0, (0.2, 0.25)  # metres a second; radians, up and down and to the sides
CAPE_PINNED = (1.0, 1.0, 0.6, 0.2)  # of its highest rows
CAPE_SMOOTH = (1.0, 0.9, 0.5, 0.2)  # of them as well
CAPE_AS_SHIRT = (1.0, 0.8, 0.5, 0.25, 0.1)  # how far they follow the shirt's collar, not the chest alone
NECKBAND, NECKBAND_AROUND, CLASP = 0.009, 10, 0.014  # radius, metres; vertices; radius of its two ends
BELT = (0.972, 1.008)  # heights, metres
BELT_AROUND, BELT_OFF, BELT_THICK = 56, 0.0035, 0.004  # vertices; metres off the trousers; metres
BUCKLE, BAR = (0.028, 0.025), 0.006  # half width, half height of its frame; half thickness of its bars, metres
LOOP = (0.010, 0.054, 0.004)  # of a belt loop: width, height, thickness, metres
LOOPS, KEEPER = (28.0, 80.0, 138.0, 180.0, 222.0, 280.0, 332.0), 345.0  # degrees from the buckle; a loop of leather


def figure(motion: Sequence[Pose], frames: tuple[int, int]) -> bpy.types.Object:
    """An empty scene with the figure in motion. Returns its skeleton."""
    skeleton, scene = demo_scene.build_figure(BODY_SPACING), bpy.context.scene
    scene.frame_start, scene.frame_end = frames
    demo_rig.animate(skeleton, motion)
    return skeleton


def ready(active: str) -> bpy.types.Object:
    """Camera, light, the first frame. Returns the garment that the scene is about."""
    demo_scene.add_camera_and_lights()
    garment = bpy.context.view_layer.objects.active = bpy.data.objects[active]
    bpy.context.scene.frame_set(bpy.context.scene.frame_start)
    return garment


def dressed(motion: Sequence[Pose]) -> bpy.types.Object:
    """Shirt and trousers on the figure. Returns its skeleton."""
    skeleton = figure(motion, (motion[0].frame, motion[-1].frame))
    demo_scene.build_trousers_object(skeleton)
    demo_scene.build_shirt_object(skeleton)
    return skeleton


def build_sit() -> bpy.types.Object:
    """A stool, and somebody who sits down on it."""
    dressed(scene_motions.sit())
    add_seat()
    return ready("Trousers")


def add_seat() -> None:
    """A rounded block under the seated trousers."""
    scene, trousers = bpy.context.scene, bpy.data.objects["Trousers"]
    scene.frame_set(round(0.5 * sum(scene_motions.SIT_HELD)))
    worn = trousers.evaluated_get(bpy.context.evaluated_depsgraph_get())
    points = np.array([worn.matrix_world @ vertex.co for vertex in worn.data.vertices])
    middle = np.array([0.0, points[:, 1].max() - SEAT_HALF[1] - 0.01])
    top = float(points[points[:, 1] > middle[1], 2].min()) + SEAT_SINK
    points, quads = rounded_block((2 * SEAT_HALF[0], 2 * SEAT_HALF[1], top), SEAT_EDGE)
    seat = demo_scene.mesh_object("Seat", points + (*middle, 0.5 * top), quads, ("Shirt trim",))
    seat.data.materials[0].name = "Seat"


def rounded_block(size: tuple[float, float, float], radius: float, steps: int = 14) -> tuple[Array, Array]:
    """A block around the origin with rounded edges: points (n, 3), quads (m, 4), normals outward."""
    half = 0.5 * np.array(size)
    line = np.sin(0.5 * math.pi * np.linspace(-1.0, 1.0, steps + 1))  # closer at the edges
    number: dict[tuple[float, ...], int] = {}
    quads = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            u, v = (axis + 1) % 3, (axis + 2) % 3
            cells = np.zeros((steps + 1, steps + 1, 3))
            cells[..., axis], cells[..., u], cells[..., v] = sign, line[:, None], line[None, :]
            index = [[number.setdefault(tuple(np.round(p, 9)), len(number)) for p in row] for row in cells.tolist()]
            for i in range(steps):
                for j in range(steps):
                    quad = [index[i][j], index[i + 1][j], index[i + 1][j + 1], index[i][j + 1]]
                    quads.append(quad if sign > 0.0 else quad[::-1])
    points = np.array(list(number)) * half
    inner = np.clip(points, radius - half, half - radius)
    out = points - inner
    return inner + radius * out / np.maximum(np.linalg.norm(out, axis=1), 1e-9)[:, None], np.array(quads)


def build_twist() -> bpy.types.Object:
    """The torso turns to both sides."""
    dressed(scene_motions.twist())
    return ready("Shirt")


def build_elbow() -> bpy.types.Object:
    """A sleeve whose elbow bends."""
    dressed(scene_motions.bend_elbow())
    return ready("Shirt")


def build_jeans() -> bpy.types.Object:
    """Trousers with a belt, and knees that bend."""
    motion = scene_motions.shift_weight()
    skeleton = figure(motion, (motion[0].frame, motion[-1].frame))
    trousers = demo_trousers.build_trousers()
    belt_points, belt_quads, belt_slots = belt()
    first = len(trousers.points)
    points, quads = np.vstack([trousers.points, belt_points]), np.vstack([trousers.quads, first + belt_quads])
    made = demo_scene.mesh_object("Jeans", points, quads, ("Trousers cloth", "Shirt trim"))
    demo_scene.add_uv_map(made, np.concatenate([trousers.uvs, np.zeros((len(belt_quads), 4, 2))]))
    cloth, leather = made.data.materials
    recolour(cloth, "Denim", (0.055, 0.095, 0.20), 0.9)
    recolour(leather, "Belt", (0.085, 0.040, 0.018), 0.45)
    made.data.materials.append(demo_scene.material("Shirt trim"))
    recolour(made.data.materials[2], "Buckle", (0.62, 0.55, 0.42), 0.3, 1.0)
    slots = np.zeros(len(quads), np.int32)
    slots[len(trousers.quads):] = belt_slots
    made.data.polygons.foreach_set("material_index", slots)
    demo_rig.skin(made, points, skeleton)
    made.vertex_groups.new(name="Rumple Rigid").add(range(first, len(points)), 1.0, "REPLACE")
    around = 2 * demo_trousers.HALF  # what the belt holds
    for name, weights in (("Rumple Follow", (1.0, 1.0, 0.3)), ("Rumple Keep Smooth", (1.0, 0.9, 0.3))):
        group = made.vertex_groups.new(name=name)
        group.add(range(len(points)), 0.0, "REPLACE")
        for ring, weight in enumerate(weights):
            group.add(range(ring * around, (ring + 1) * around), weight, "REPLACE")
    return ready("Jeans")


def recolour(material: bpy.types.Material, name: str, colour: tuple[float, float, float], roughness: float,
             metallic: float = 0.0) -> None:
    material.name, material.diffuse_color, material.roughness = name, (*colour, 1.0), roughness
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = (*colour, 1.0)
    shader.inputs["Roughness"].default_value, shader.inputs["Metallic"].default_value = roughness, metallic


def waist(height: float, off: float, angles: Array) -> Array:
    """Points (n, 3) around the trousers' waist, off the cloth, metres. Angles in radians from the back."""
    wide, deep, middle = (demo_body.smooth_interpolation(np.array(height), demo_trousers.HIPS[:, 0],
                                                         demo_trousers.HIPS[:, k]) for k in (1, 2, 3))
    return np.stack([(wide + off) * np.sin(angles), middle + (deep + off) * np.cos(angles),
                     np.full(len(angles), height)], axis=1)


def belt() -> tuple[Array, Array, Array]:
    """A band around the waist, its loops and its buckle: points (n, 3), quads (m, 4), the material of each (m,): 0 is
    denim, 1 leather, 2 metal."""
    around = np.arange(BELT_AROUND)
    following = (around + 1) % BELT_AROUND
    points = np.concatenate([waist(height, off, 2.0 * np.pi * around / BELT_AROUND) for height, off in (
        (BELT[0], BELT_OFF), (BELT[0], BELT_OFF + BELT_THICK), (BELT[1], BELT_OFF + BELT_THICK), (BELT[1], BELT_OFF))])
    quads = np.concatenate([np.stack([a * BELT_AROUND + around, a * BELT_AROUND + following,
                                      b * BELT_AROUND + following, b * BELT_AROUND + around], axis=1)
                            for a, b in ((0, 1), (1, 2), (2, 3), (3, 0))])[:, ::-1]
    parts = [(points, quads, 1)]
    wide, high, bar = *BUCKLE, 2.0 * BAR
    for size, across, up in (((2.0 * wide, 2.0 * BAR, bar), 0.0, high), ((2.0 * wide, 2.0 * BAR, bar), 0.0, -high),
                             ((2.0 * BAR, 2.0 * high, bar), wide, 0.0), ((2.0 * BAR, 2.0 * high, bar), -wide, 0.0),
                             ((2.0 * wide, BAR, BAR), 0.0, 0.0)):  # the last one is its pin
        parts.append((*on_belt(size, 0.0, across, up), 2))
    parts += [(*on_belt(LOOP, degrees), 0) for degrees in LOOPS]
    parts.append((*on_belt((1.2 * LOOP[0], BELT[1] - BELT[0] + 0.006, LOOP[2]), KEEPER), 1))
    firsts = np.cumsum([0, *(len(part[0]) for part in parts)])
    return (np.vstack([part[0] for part in parts]), np.vstack([first + part[1] for first, part in zip(firsts, parts)]),
            np.concatenate([np.full(len(part[1]), part[2], np.int32) for part in parts]))


def on_belt(size: tuple[float, float, float], degrees: float, across: float = 0.0,
            up: float = 0.0) -> tuple[Array, Array]:
    """A rounded block (width, height, thickness, metres) on the outside of the belt, degrees from the buckle."""
    points, quads = rounded_block(size, 0.45 * min(size), 4)
    angle = np.pi - math.radians(degrees)
    place = waist(0.5 * sum(BELT), BELT_OFF + BELT_THICK + 0.4 * size[2], np.array([angle]))[0]
    outward = np.array([math.sin(angle), math.cos(angle), 0.0])
    side, above = np.array([-outward[1], outward[0], 0.0]), np.array([0.0, 0.0, 1.0])
    return place + (points + (across, up, 0.0)) @ np.stack([side, above, outward]), quads


def build_cape() -> bpy.types.Object:
    """A runner in a cape that swings. The runner stays in place, and the air comes along."""
    cape, rows = add_cape(dressed(scene_motions.run()))
    add_head_wind()
    for name, weights in (("Rumple Follow", CAPE_PINNED), ("Rumple Keep Smooth", CAPE_SMOOTH)):
        group = cape.vertex_groups.new(name=name)
        for vertex, weight in enumerate(by_row(weights, rows).tolist()):
            group.add([vertex], weight, "REPLACE")
    worn_over(cape, "Mannequin", ("Shirt", "Trousers"))
    settings = cape.rumple.mesh
    settings.base_cloth, settings.layers, settings.wavelength, settings.hem_rings = "SWING", "CLOTH", 0.1, 0
    settings.room, settings.locomotion, settings.swing_damping, settings.drag = 1.5, 1.0, 1.0, 1.0
    settings.slack, settings.thickness, settings.mass = 1.05, 0.006, 0.3
    return ready("Cape")


def add_cape(skeleton: bpy.types.Object) -> tuple[bpy.types.Object, Array]:
    """A cape over the shirt, with the row of each vertex (n,)."""
    points, quads = cape_mesh()
    band_points, band_quads = neckband(points[:CAPE_ACROSS])
    cape = demo_scene.mesh_object("Cape", np.vstack([points, band_points]),
                                  np.vstack([quads, len(points) + band_quads]), ("Shirt trim", "Trousers cloth"))
    recolour(cape.data.materials[0], "Cape", (0.36, 0.035, 0.040), 0.8)
    recolour(cape.data.materials[1], "Neckband", (0.30, 0.17, 0.05), 0.6)
    cape.data.polygons.foreach_set("material_index", np.repeat([0, 1], [len(quads), len(band_quads)]))
    rows = np.concatenate([np.arange(len(points)) // CAPE_ACROSS, np.zeros(len(band_points), int)])
    skin_as(cape, bpy.data.objects["Shirt"], by_row(CAPE_AS_SHIRT, rows))
    cape.modifiers.new("Armature", "ARMATURE").object = skeleton
    cape.parent = skeleton
    return cape, rows


def by_row(weights: Sequence[float], rows: Array) -> Array:
    """Of each vertex by its row (n,); 0 in the lower rows."""
    return np.append(weights, 0.0)[np.minimum(rows, len(weights))]


def skin_as(garment: bpy.types.Object, worn: bpy.types.Object, shares: Array) -> None:
    """Skin a garment as the nearest vertex of another one is, by a share (n,); for the rest to the chest."""
    rest = np.array([vertex.co for vertex in worn.data.vertices])
    groups = {group.index: garment.vertex_groups.new(name=group.name) for group in worn.vertex_groups}
    for vertex, share in zip(garment.data.vertices, shares.tolist()):
        nearest = worn.data.vertices[int(((rest - vertex.co) ** 2).sum(axis=1).argmin())]
        for group in nearest.groups if share > 0.0 else ():
            groups[group.group].add([vertex.index], share * group.weight, "ADD")
        garment.vertex_groups["chest"].add([vertex.index], 1.0 - share, "ADD")


def neckband(edge: Array) -> tuple[Array, Array]:
    """A round cord along an edge (n, 3), thicker at its ends: points, quads, normals outward."""
    along = np.gradient(edge, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    side = np.cross(along, (0.0, 0.0, 1.0))
    side /= np.linalg.norm(side, axis=1)[:, None]
    radius = np.full(len(edge), NECKBAND)
    radius[[1, -2]], radius[[0, -1]] = CLASP, 0.004
    angles = 2.0 * np.pi * np.arange(NECKBAND_AROUND) / NECKBAND_AROUND
    rings = edge[:, None] + radius[:, None, None] * (np.cos(angles)[None, :, None] * side[:, None]
                                                     + np.sin(angles)[None, :, None] * np.cross(along, side)[:, None])
    around = np.arange(NECKBAND_AROUND)
    following = (around + 1) % NECKBAND_AROUND
    first = NECKBAND_AROUND * np.arange(len(edge) - 1)[:, None]
    quads = np.stack([first + around, first + following, first + NECKBAND_AROUND + following,
                      first + NECKBAND_AROUND + around], axis=-1).reshape(-1, 4)
    return np.round(rings.reshape(-1, 3), 6), quads


def add_head_wind() -> None:
    """It turns to and fro, and comes in gusts by that. What is keyed is an empty that holds it: of a keyed force field
    Blender 3.4 complains in the console."""
    vane = bpy.data.objects.new("Weather Vane", None)
    bpy.context.scene.collection.objects.link(vane)
    vane.location, vane.empty_display_size = (0.0, -2.0, 1.2), 0.2
    bpy.ops.object.effector_add(type="WIND")
    wind = bpy.context.object
    wind.field.strength, wind.parent = WIND_SPEED, vane
    for frame in range(scene_motions.RUN_FRAMES[0], scene_motions.RUN_FRAMES[1] + 1, 2):
        vane.rotation_euler = (-0.5 * math.pi + WIND_TURNS[0] * math.sin(0.2 * frame), 0.0,
                               WIND_TURNS[1] * math.sin(0.13 * frame))
        vane.keyframe_insert("rotation_euler", frame=frame)


def worn_over(garment: bpy.types.Object, body: str, clothes: Sequence[str]) -> None:
    """What the cloth stays outside of."""
    garment.rumple.body = bpy.data.objects[body]
    under = garment.rumple.body_collection = bpy.data.collections.new(f"{garment.name} Is Worn Over")
    for name in clothes:
        under.objects.link(bpy.data.objects[name])


def cape_mesh() -> tuple[Array, Array]:
    """Points (n, 3) and quads (m, 4), normals outward; rows from the neck down."""
    down = np.linspace(0.0, 1.0, CAPE_ALONG)
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(CAPE[:, [0, 2]], axis=0).T))])
    height, wide, deep, span = (np.interp(down, lengths / lengths[-1], CAPE[:, column]) for column in range(4))
    angles = np.radians(span)[:, None] * np.linspace(-1.0, 1.0, CAPE_ACROSS)[None, :]
    points = np.stack([wide[:, None] * np.sin(angles), 0.02 + deep[:, None] * np.cos(angles),
                       np.repeat(height[:, None], CAPE_ACROSS, 1)], axis=-1).reshape(-1, 3)
    room = np.repeat(np.append(CAPE_ROOM, np.full(CAPE_ALONG - len(CAPE_ROOM), CAPE_ROOM[-1])), CAPE_ACROSS)
    for _ in range(6):
        edge = points[:CAPE_ACROSS]
        edge[1:-1] += 0.5 * (0.5 * (edge[:-2] + edge[2:]) - edge[1:-1])
        short = np.maximum(room - demo_shirt.shirt_distance(points), 0.0)
        points = points + short[:, None] * demo_body.distance_gradient(points, demo_shirt.shirt_distance)
    quads = [(row * CAPE_ACROSS + i, row * CAPE_ACROSS + i + 1, (row + 1) * CAPE_ACROSS + i + 1,
              (row + 1) * CAPE_ACROSS + i) for row in range(CAPE_ALONG - 1) for i in range(CAPE_ACROSS - 1)]
    return np.round(points, 6), np.array(quads)


SCENES: dict[str, Callable[[], bpy.types.Object]] = {
    "sit": build_sit, "twist": build_twist, "elbow": build_elbow, "jeans": build_jeans, "cape": build_cape}
