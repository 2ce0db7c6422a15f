# SPDX-License-Identifier: GPL-3.0-or-later
"""What the trial of docs/habits.md photographed, as it is now: one PNG for each of its pictures. For both garments:

    d=$(mktemp -d); RUMPLE_NATIVE=build/release/python RUMPLE_FRAMEBUFFER=$d/Xvfb_screen0 \
        xvfb-run -a -s "-screen 0 1600x1000x24 -fbdir $d" blender --factory-startup --enable-event-simulate \
        --window-geometry 0 0 1600 1000 ../shared/data/S1_walk_shirt.blend \
        --python docs/pictures/make_habits.py -- shirt OUT
    ... S2_squat_trousers.blend ... -- sweater OUT
    docs/pictures/pair_habits.py BEFORE OUT     # the trial's pictures beside these: habits.jpg
"""
from __future__ import annotations

import sys
from pathlib import Path
from typing import Iterator

import bpy
from mathutils import Euler, Vector

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE)]
from windowed import play, window_case  # noqa: E402
from support.artist import Artist  # noqa: E402

GARMENT, OUT = sys.argv[sys.argv.index("--") + 1], Path(sys.argv[-1])
FRONT = Euler((1.5708, 0.0, 0.0)).to_quaternion()
PLACE = Vector((0.0, 0.0, 1.15))  # metres
STROKE = [Vector((0.13 - 0.012 * step, -0.15, 1.36 - 0.008 * step)) for step in range(10)]

artist = Artist()


def in_front(frame: int) -> Iterator[float]:
    """The garment selected, and seen from the front."""
    bpy.context.scene.frame_set(frame)
    obj = bpy.data.objects[GARMENT]
    with artist.area():
        bpy.ops.object.select_all(action="DESELECT")
        obj.select_set(True)
        bpy.context.view_layer.objects.active = obj
    space = artist.editor("VIEW_3D").spaces.active
    space.shading.type, view = "SOLID", space.region_3d
    view.view_perspective, view.view_rotation = "ORTHO", FRONT
    view.view_location, view.view_distance = PLACE, 1.9
    artist.editor("PROPERTIES").spaces.active.context = "MODIFIER"
    yield 1.0


def added(method: str) -> Iterator[float]:
    with artist.area():
        bpy.ops.object.rumple_add("EXEC_DEFAULT", True, method=method)
    for modifier in bpy.context.object.modifiers:
        modifier.show_expanded = False
    yield 2.0


def photographed(name: str) -> Iterator[float]:
    yield 1.5
    (OUT / f"{name}.png").write_bytes(window_case.png(artist.pixels()))


def painted() -> Iterator[float]:
    with artist.area():
        bpy.ops.object.rumple_paint(group="drape")
    yield 1.0
    yield from artist.stroke([artist.seen_at(place) for place in STROKE])
    yield from photographed("painted")
    with artist.area():
        bpy.ops.object.rumple_paint(group="drape")
    yield 0.5


def outside_a_bake() -> Iterator[float]:
    obj = bpy.context.object
    obj.rumple.bake_start, obj.rumple.bake_end = 1, 4
    with artist.area():
        bpy.ops.object.rumple_bake()
    yield 1.0
    bpy.context.scene.frame_set(3)
    yield from photographed("baked")
    bpy.context.scene.frame_set(40)
    yield from photographed("outside")


def steps() -> Iterator[float]:
    if GARMENT == "shirt":
        yield from in_front(1)
        yield from added("MESH")
        yield from photographed("added")
        yield from painted()
        yield from outside_a_bake()
        return
    yield from in_front(45)
    yield from added("PATHS")
    bpy.context.object.rumple.paths.show_overlay = True
    for frame in range(45, 52):
        bpy.context.scene.frame_set(frame)
    yield from photographed("overlay")


play(steps())
