# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkle Paths on a jump of ../shared/data: the cloths, paths_presets.jpg, and curves, paths_curves.jpg.

    scripts/build
    RUMPLE_NATIVE=build/release/python blender -b --factory-startup --python-exit-code 1 \
        --python docs/pictures/make_paths.py
"""
from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import bpy

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE)]
from make_systems import FIRST, FRAME, ROOT, compose, look, rumple  # noqa: E402
from rumple.blender import compat  # noqa: E402
from rumple.blender.frame import path_curves  # noqa: E402
from rumple.blender.nodes import path_curves_tree  # noqa: E402
from rumple.core.settings.presets import PATHS_PRESETS  # noqa: E402

GARMENTS = ("trousers", "sweater")


def jump(preset: str) -> None:
    """The clip up to the deepest crouch, in that cloth."""
    bpy.ops.wm.open_mainfile(filepath=str(ROOT.parent / "shared" / "data" / "S2_squat_trousers.blend"))
    for garment in GARMENTS:
        bpy.context.view_layer.objects.active = bpy.data.objects[garment]
        assert bpy.ops.object.rumple_add(method="PATHS") == {"FINISHED"}
        assert bpy.ops.object.rumple_preset(preset=preset) == {"FINISHED"}
    for frame in range(FIRST, FRAME + 1):
        bpy.context.scene.frame_set(frame)
    assert not any(bpy.data.objects[garment].rumple.message for garment in GARMENTS)


def presets(folder: Path) -> None:
    tiles = []
    for key, preset in PATHS_PRESETS.items():
        jump(key)
        tiles.append((f"{preset.label}: {preset.tip.splitlines()[0]}", folder / f"{key}.png"))
        look(tiles[-1][1], lens=95.0)
    compose([tiles[i] for i in (0, 2, 1, 3)], 2, folder / "sheet.png")  # it fills columns
    from PIL import Image
    Image.open(folder / "sheet.png").save(HERE / "paths_presets.jpg", quality=88, optimize=True)


def curves(folder: Path) -> None:
    """Tubes along the paths, as a modifier behind the curves colours them by their height."""
    jump("COTTON")
    for garment, radius in (("trousers", 0.0025), ("sweater", 0.0025)):
        bpy.context.view_layer.objects.active = bpy.data.objects[garment]
        assert bpy.ops.object.rumple_curves_add() == {"FINISHED"}
        child, = path_curves.of(bpy.data.objects[garment])
        ours = path_curves.find(child)
        identifier = compat.group_sockets(ours.node_group, "INPUT")[path_curves_tree.RADIUS]
        compat.set_modifier_input(ours, identifier, radius)
        child.modifiers.new("Colours", "NODES").node_group = coloured()
    bpy.context.scene.frame_set(FRAME)
    look(folder / "curves.png", lens=95.0)
    from PIL import Image
    Image.open(folder / "curves.png").convert("RGB").save(HERE / "paths_curves.jpg", quality=88, optimize=True)


def coloured() -> bpy.types.NodeTree:
    """A node group that gives a material: blue where a path is flat, red where it is a centimetre high."""
    material = bpy.data.materials.new("Paths")
    compat.use_nodes(material)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    height, ramp = nodes.new("ShaderNodeAttribute"), nodes.new("ShaderNodeValToRGB")
    height.attribute_name = path_curves_tree.PATH_HEIGHT
    scale = nodes.new("ShaderNodeMath")
    scale.operation, scale.inputs[1].default_value = "MULTIPLY", 100.0
    ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (0.0, 0.1, 1.0, 1.0), (1.0, 0.02, 0.0, 1.0)
    links.new(height.outputs["Fac"], scale.inputs[0])
    links.new(scale.outputs[0], ramp.inputs[0])
    links.new(ramp.outputs[0], next(n for n in nodes if n.type == "BSDF_PRINCIPLED").inputs["Base Color"])
    group = bpy.data.node_groups.new("Colours", "GeometryNodeTree")
    for in_out in ("INPUT", "OUTPUT"):
        compat.new_group_socket(group, "Geometry", in_out, "NodeSocketGeometry")
    compat.mark_as_modifier(group)
    start, give, end = (group.nodes.new(kind) for kind in ("NodeGroupInput", "GeometryNodeSetMaterial",
                                                           "NodeGroupOutput"))
    give.inputs["Material"].default_value = material
    group.links.new(start.outputs[0], give.inputs[0])
    group.links.new(give.outputs[0], end.inputs[0])
    return group


def main() -> None:
    rumple.register()
    with tempfile.TemporaryDirectory() as folder:
        for picture in (presets, curves):
            if picture.__name__ in sys.argv[-1] or "--" not in sys.argv:  # one of them: -- presets
                picture(Path(folder))


main()
