# SPDX-License-Identifier: GPL-3.0-or-later
"""Run by Blender: what a frame of playback costs without wrinkles, with Blender's Subdivision and with each system, and
where it goes; what the first click and a bake cost. Nothing is drawn.

    RUMPLE_NATIVE=build/release/python blender -b --factory-startup ../shared/data/S1_walk_shirt.blend \
        --python scripts/benchmark_frames.py -- 3 shirt trousers

How many rounds, garments. In every round each way is set up and played, one after the other, so that all see the same
load of the machine. Prints tables in Markdown: milliseconds, the least and the median over frames of all rounds.
"""
from __future__ import annotations

import collections
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Callable

import bpy
import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1] / "addon"), os.environ["RUMPLE_NATIVE"]]
import rumple  # noqa: E402
from rumple.blender import scheduler  # noqa: E402
from rumple.blender.frame import first_pass, solve  # noqa: E402
from rumple.blender.objects import bodies, output_mesh, posed_coarse  # noqa: E402
from rumple.native import kernels  # noqa: E402

ROUNDS = int(sys.argv[sys.argv.index("--") + 1])
GARMENTS = [bpy.data.objects[name] for name in sys.argv[sys.argv.index("--") + 2:]]
FRAMES, WARM = 10, 2  # played, and of these not counted
BAKED = 30

# What a way is: system, smoothing in viewports, base cloth and body; or the levels of Subdivision.
WAYS: dict[str, tuple[str, int, bool]] = {
    "bare": ("", 0, False),
    "Subdivision 2": ("SUBSURF", 2, False),
    "Subdivision 3": ("SUBSURF", 3, False),
    "Mesh, one click": ("MESH", 0, True),
    "Mesh, one click, smoothing 1": ("MESH", 1, True),
    "Mesh, one layer on the animation": ("MESH", 0, False),
    "Field in shading": ("FIELD", 0, True),
    "Field in shading, on the animation": ("FIELD", 0, False),
    "Paths": ("PATHS", 0, True),
    "Paths, on the animation": ("PATHS", 0, False),
}
# Functions and what they do for a frame. A stage that is part of another counts in both.
STAGES: tuple[tuple[Any, str, str], ...] = (
    (solve, "process", "handler, all"),
    (first_pass, "hand_on_coarse", "before the frame"),
    (posed_coarse, "positions", "posed positions read"),
    (bodies, "read", "bodies read"),
    (kernels, "solve_base_cloth", "base cloth"),
    (kernels, "solve_wrinkle_layers", "layers solved"),
    (kernels, "show_wrinkle_layers", "layers shown"),
    (kernels, "show_wrinkle_transfer", "layers shown"),  # of garments that are solved on a coarse mesh
    (kernels, "solve_wrinkle_mesh", "one layer solved"),
    (kernels, "show_wrinkle_mesh", "one layer shown"),
    (output_mesh, "write_result", "result written"),
)
spent: dict[str, float] = collections.defaultdict(float)


def timed(function: Callable[..., Any], stage: str) -> Callable[..., Any]:
    def counted(*arguments: Any, **named: Any) -> Any:
        began = time.perf_counter()
        try:
            return function(*arguments, **named)
        finally:
            spent[stage] += 1e3 * (time.perf_counter() - began)
    return counted


def active(obj: bpy.types.Object) -> Any:
    bpy.context.view_layer.objects.active = obj
    return bpy.context.temp_override(object=obj, active_object=obj, selected_objects=[obj])


def set_up(system: str, steps: int, worn: bool) -> float:
    """Milliseconds of the clicks."""
    took = 0.0
    for obj in GARMENTS:
        if system == "SUBSURF":
            obj.modifiers.new("Subdivision", "SUBSURF").levels = steps
            obj.modifiers.new("Reader", "NODES").node_group = empty_tree()  # else it waits until somebody draws it
        if system in ("", "SUBSURF"):
            continue
        with active(obj):
            began = time.perf_counter()
            bpy.ops.object.rumple_add(method=system)
            took += 1e3 * (time.perf_counter() - began)
        settings = getattr(obj.rumple, system.lower())
        obj.rumple.viewport_steps = steps
        if not worn:
            settings.base_cloth, obj.rumple.body, obj.rumple.body_collection = "OFF", None, None
            if system == "MESH":
                settings.layers = "ONE"
    scheduler.sync_all()
    bpy.context.view_layer.update()
    return took


def empty_tree() -> bpy.types.NodeTree:
    """Hands its geometry on."""
    tree = bpy.data.node_groups.get("Reader") or bpy.data.node_groups.new("Reader", "GeometryNodeTree")
    if not tree.nodes:
        if hasattr(tree, "interface"):
            for way in ("INPUT", "OUTPUT"):
                tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
        else:
            tree.inputs.new("NodeSocketGeometry", "Geometry")
            tree.outputs.new("NodeSocketGeometry", "Geometry")
        begin, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
        tree.links.new(begin.outputs[0], end.inputs[0])
    return tree


def tear_down() -> None:
    for obj in GARMENTS:
        if obj.rumple.method != "NONE":
            with active(obj):
                bpy.ops.object.rumple_remove()
            for name in [name for name in obj.rumple.keys()]:
                obj.rumple.property_unset(name)  # the next click is the first one
        for name in ("Reader", "Subdivision"):
            if name in obj.modifiers:
                obj.modifiers.remove(obj.modifiers[name])


def play() -> list[dict[str, float]]:
    """Stages of every frame that counts, milliseconds; "frame": all of it."""
    rows, start = [], bpy.context.scene.frame_start
    for frame in range(start, start + FRAMES):
        spent.clear()
        began = time.perf_counter()
        bpy.context.scene.frame_set(frame)
        spent["frame"] = 1e3 * (time.perf_counter() - began)
        rows.append(dict(spent))
    return rows[WARM:]


def shown_points() -> int:
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return sum(len(obj.evaluated_get(depsgraph).data.vertices) for obj in GARMENTS)


def baked() -> float:
    """Frames a second of the first garment as clicked."""
    obj, scene = GARMENTS[0], bpy.context.scene
    scene.frame_end = obj.rumple.bake_end = scene.frame_start + BAKED - 1
    with active(obj):
        began = time.perf_counter()
        bpy.ops.object.rumple_bake()
        took = time.perf_counter() - began
        bpy.ops.object.rumple_bake_free(delete_file=True)
    return BAKED / took


def low_and_middle(values: list[float]) -> str:
    return f"{min(values):.1f}, {np.median(values):.1f}"


def main() -> None:
    rumple.register()
    for module, name, stage in STAGES:
        setattr(module, name, timed(getattr(module, name), stage))
    frames: dict[str, list[dict[str, float]]] = collections.defaultdict(list)
    replayed: dict[str, list[float]] = collections.defaultdict(list)
    clicks: dict[str, list[float]] = collections.defaultdict(list)
    points, rates = {}, []
    folder = Path(tempfile.mkdtemp())
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "frames.blend"))  # clips lie beside it
    for _ in range(ROUNDS):
        for way, options in WAYS.items():
            clicks[way].append(set_up(*options))
            frames[way] += play()
            replayed[way] += [row["frame"] for row in play()]
            points[way] = shown_points()
            if way == "Mesh, one click":
                rates.append(baked())
            tear_down()
    print(f"\n{Path(sys.argv[sys.argv.index('-b') + 2]).name}, {', '.join(obj.name for obj in GARMENTS)}; "
          f"Blender {bpy.app.version_string}\n")
    print("| | points | a frame | played again | clicks |\n|---|---|---|---|---|")
    for way, rows in frames.items():
        click = low_and_middle(clicks[way]) if max(clicks[way]) else ""
        print(f"| {way} | {points[way]:,} | {low_and_middle([row['frame'] for row in rows])} | "
              f"{low_and_middle(replayed[way])} | {click} |")
    stages = list(dict.fromkeys(["frame", *(stage for _module, _name, stage in STAGES)]))
    ours = [way for way, (system, *_rest) in WAYS.items() if system not in ("", "SUBSURF")]
    print(f"\n| stage | {' | '.join(ours)} |\n|{'---|' * (len(ours) + 1)}")
    for stage in stages:
        cells = [np.median([row.get(stage, 0.0) for row in frames[way]]) for way in ours]
        print(f"| {stage} | " + " | ".join(f"{cell:.1f}" if cell else "" for cell in cells) + " |")
    print(f"\nbake of {GARMENTS[0].name}, {BAKED} frames: {max(rates):.1f} frames a second, median "
          f"{np.median(rates):.1f}")


main()
