# SPDX-License-Identifier: GPL-3.0-or-later
"""Run by Blender: what a frame of playback costs bare and with Wrinkle Maps. Nothing is drawn.

    RUMPLE_NATIVE=build/release/python blender -b --factory-startup ../shared/data/S4_face_expressions.blend \
        --python scripts/benchmark_maps.py -- Head 21 51

The object, and the frames that hold its reference poses. Plays the scene bare and with the masks in turns, so that both
see the same load of the machine. Prints milliseconds: the least and the median over frames.
"""
from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import bpy
import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1] / "addon"), os.environ["RUMPLE_NATIVE"]]
import rumple  # noqa: E402
from rumple.blender.maps import modifier  # noqa: E402

ROUNDS = 3
NAME, *HELD = sys.argv[sys.argv.index("--") + 1:]


def add_maps(obj: bpy.types.Object) -> None:
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.rumple_add(method="MAPS")
    for frame in HELD:
        bpy.context.scene.frame_set(int(frame))
        bpy.ops.rumple.pose_add(name=f"Frame {frame}")


def play() -> list[float]:
    """Milliseconds of every frame."""
    scene, took = bpy.context.scene, []
    for frame in range(scene.frame_start, scene.frame_end + 1):
        began = time.perf_counter()
        scene.frame_set(frame)
        took.append(1e3 * (time.perf_counter() - began))
    return took


def main() -> None:
    rumple.register()
    obj = bpy.data.objects[NAME]
    add_maps(obj)
    took: dict[str, list[float]] = {"bare": [], "with Wrinkle Maps": []}
    for _ in range(ROUNDS):
        for shown, way in enumerate(took):
            modifier.find(obj).show_viewport = bool(shown)
            took[way] += play()
    for way, frames in took.items():
        print(f"{NAME} {way}: {min(frames):.2f}, {np.median(frames):.2f} ms a frame")


main()
