# SPDX-License-Identifier: GPL-3.0-or-later
"""Run by Blender: frames of a sheet that is squeezed, with wrinkles and with what Blender has itself, in turns.

Prints `RATIO number name` for each pair: processor time of the rival over ours, both with everything that Blender does
in a frame. Wrinkle Mesh: Subdivision to as many points. Wrinkle Field in shading: a tension map in Geometry Nodes,
which knows one number and no direction. Started by scripts/benchmark_ratios.py.
"""
from __future__ import annotations

import os
import sys
import time
from pathlib import Path
from typing import Callable

import bpy

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "addon"), os.environ["RUMPLE_NATIVE"]]
import benchmark_tension  # noqa: E402
import rumple  # noqa: E402
from rumple.blender import scheduler  # noqa: E402

FRAMES, ROUNDS = 12, 4


def squeezed(columns: int, rows: int) -> bpy.types.Object:
    """The sheet of the tension map, by a shape key that goes from its flat self to twice the squeeze."""
    obj = benchmark_tension.sheet(columns, rows)
    mesh = obj.data
    rest, posed = ([0.0] * (3 * len(mesh.vertices)) for _ in range(2))
    mesh.attributes[benchmark_tension.REST].data.foreach_get("vector", rest)
    mesh.vertices.foreach_get("co", posed)
    mesh.vertices.foreach_set("co", rest)
    obj.shape_key_add(name="Rest")
    key = obj.shape_key_add(name="Squeezed")
    key.data.foreach_set("co", posed)
    for frame, value in ((1, 0.2), (FRAMES, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    return obj


def with_wrinkles(obj: bpy.types.Object, method: str) -> None:
    bpy.context.view_layer.objects.active = obj
    with bpy.context.temp_override(object=obj, active_object=obj, selected_objects=[obj]):
        bpy.ops.object.rumple_add(method=method)


def subdivided(obj: bpy.types.Object, levels: int) -> None:
    obj.modifiers.new("Subdivision", "SUBSURF").levels = levels
    # Blender 5 leaves a Subdivision that comes last to who draws it.
    obj.modifiers.new("Reader", "NODES").node_group = benchmark_tension.Tree(False).group


def with_tension(obj: bpy.types.Object) -> None:
    obj.modifiers.new("Tension", "NODES").node_group = benchmark_tension.Tree(True).group


def frames() -> float:
    """Least processor time of a frame, milliseconds."""
    times = []
    for frame in range(1, FRAMES + 1):
        began = time.process_time()
        bpy.context.scene.frame_set(frame)
        times.append(1e3 * (time.process_time() - began))
    return min(times[2:])


def points(obj: bpy.types.Object) -> int:
    return len(obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.vertices)


def ratio(name: str, size: tuple[int, int], ours: Callable[[bpy.types.Object], None],
          rival: Callable[[bpy.types.Object], None]) -> None:
    times: dict[int, list[float]] = {0: [], 1: []}
    shown = [0, 0]
    for _ in range(ROUNDS):
        for number, set_up in enumerate((ours, rival)):
            obj = squeezed(*size)
            set_up(obj)
            scheduler.sync_all()
            times[number].append(frames())
            shown[number] = points(obj)
            bpy.data.objects.remove(obj)
            scheduler.sync_all()
    if shown[0] != shown[1]:
        raise RuntimeError(f"{name}: {shown[0]} points beside {shown[1]}")
    print(f"RATIO {min(times[1]) / min(times[0]):.3f} {name}", flush=True)


def main() -> None:
    bpy.ops.wm.read_homefile(use_empty=True)
    rumple.register()
    ratio("A frame of the Wrinkle Mesh: Subdivision to as many points", (35, 52),
          lambda obj: with_wrinkles(obj, "MESH"), lambda obj: subdivided(obj, 2))
    ratio("A frame of the Wrinkle Field in shading: tension map", (43, 139),
          lambda obj: with_wrinkles(obj, "FIELD"), with_tension)


main()
