# SPDX-License-Identifier: GPL-3.0-or-later
"""Outfits of MakeHuman from the first click to a sheet of renders, inside Blender. Started by scripts/outfits."""
from __future__ import annotations

import argparse
import math
import os
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from mathutils import Quaternion, Vector

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "addon"), os.environ["RUMPLE_NATIVE"]]
import demo_scene  # noqa: E402
import gallery_light  # noqa: E402
import makehuman  # noqa: E402

OUTFITS = ("female_casualsuit01", "female_casualsuit02", "female_elegantsuit01", "female_sportsuit01",
           "male_casualsuit01", "male_casualsuit02", "male_casualsuit03", "male_casualsuit04", "male_casualsuit05",
           "male_casualsuit06", "male_elegantsuit01", "male_worksuit01")
WELDED = ("male_welded",)  # one mesh: the clothes are faces of the figure. Rendered only where it is named
FABRICS = {"female_sportsuit01": "STRETCH", "male_elegantsuit01": "SUIT"}  # the others: as the click leaves them
FRAMES, SHOWN = 66, (1, 30, 48, 66)
TILE, OVERVIEW_WIDTH = (360, 480), 190  # pixels
X, Y, Z = Vector((1.0, 0.0, 0.0)), Vector((0.0, 1.0, 0.0)), Vector((0.0, 0.0, 1.0))
# Bone: axis in the world at rest, then (frame, degrees).
CLIP = {
    "upperarm01.L": (Y, (1, 0), (12, 25), (30, -70), (48, 10), (66, 30)),
    "upperarm01.R": (Y, (1, 0), (12, -25), (30, -20), (48, -10), (66, -35)),
    "lowerarm01.L": (X, (1, 0), (12, 10), (30, 60), (48, 70), (66, 20)),
    "lowerarm01.R": (X, (1, 0), (12, 10), (30, 80), (48, 70), (66, 10)),
    "upperleg01.L": (X, (1, 0), (30, 0), (48, 75), (66, 0)),
    "upperleg01.R": (X, (1, 0), (30, 0), (48, 75), (66, 0)),
    "lowerleg01.L": (X, (1, 0), (30, 0), (48, -100), (66, 0)),
    "lowerleg01.R": (X, (1, 0), (30, 0), (48, -100), (66, 0)),
    "foot.L": (X, (1, 0), (30, 0), (48, 25), (66, 0)),
    "foot.R": (X, (1, 0), (30, 0), (48, 25), (66, 0)),
    "spine03": (Z, (1, 0), (48, 0), (66, 35)),
    "spine05": (X, (1, 0), (30, 0), (48, 25), (66, 0)),
}
# Linear colours of cloth, one after the other; and of skin.
CLOTH, SKIN = ((0.20, 0.36, 0.52), (0.42, 0.16, 0.13), (0.20, 0.30, 0.22), (0.40, 0.33, 0.22)), (0.62, 0.44, 0.34)
JEANS = (0.10, 0.13, 0.30)
# Of clothes that are welded: bones of the hands, the head and the feet by the starts of their names, and the share of
# their weights from which on a face is bare.
BARE = ((("lowerarm", "wrist", "finger", "metacarpal"), 0.35), (("neck", "head", "jaw", "oris", "special"), 0.4),
        (("foot", "toe"), 0.5))
WAIST, COLLAR = 0.585, 0.88  # shares of the figure's height
LIFT, Z_AXIS = 0.008, 2  # metres off the skin


@dataclass
class Row:
    """What one outfit cost. Seconds and milliseconds by the clock, on a machine that may be busy."""

    name: str
    vertices: int
    shown: int = 0
    click: float = 0.0
    frame: float = 0.0
    said: str = ""

    def __str__(self) -> str:
        return (f"| {self.name} | {self.vertices:,} | {self.shown:,} | {self.click:.1f} | {self.frame:.0f} "
                f"| {self.said or '-'} |")


def skinned(name: str, mesh: makehuman.Polygons, weights: np.ndarray, bones: list[str], rig: bpy.types.Object,
            colour: tuple[float, float, float]) -> bpy.types.Object:
    """A smooth object of some polygons that follows the rig."""
    data = bpy.data.meshes.new(name)
    data.from_pydata(mesh.points.tolist(), [], mesh.corners)
    data.polygons.foreach_set("use_smooth", np.ones(len(mesh.corners), bool))
    if len(mesh.uvs) == len(mesh.corners):
        uv = np.concatenate([np.array(polygon, np.float32) for polygon in mesh.uvs])
        data.uv_layers.new(name="UVMap").data.foreach_set("uv", np.ascontiguousarray(uv).ravel())
    data.materials.append(painted(name, colour))
    obj = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(obj)
    for column, bone in enumerate(bones):
        vertices = np.flatnonzero(weights[:, column] > 1e-4)
        group = obj.vertex_groups.new(name=bone) if len(vertices) else None
        for vertex in vertices.tolist():
            group.add([vertex], float(weights[vertex, column]), "REPLACE")
    obj.modifiers.new("Armature", "ARMATURE").object = rig
    return obj


def painted(name: str, colour: tuple[float, float, float]) -> bpy.types.Material:
    """A rough material of one colour."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = next(node for node in made.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = (*colour, 1.0)
    shader.inputs["Roughness"].default_value = 0.85
    return made


def build_rig(bones: dict[str, tuple[str | None, np.ndarray, np.ndarray]]) -> bpy.types.Object:
    """An armature of these bones, with the clip."""
    rig = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
    bpy.context.scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    for name, (parent, head, tail) in bones.items():
        bone = rig.data.edit_bones.new(name)
        bone.head, bone.tail = Vector(head), Vector(tail)
        bone.parent = rig.data.edit_bones[parent] if parent else None
    bpy.ops.object.mode_set(mode="OBJECT")
    for name, (axis, *keys) in CLIP.items():
        bone = rig.pose.bones[name]
        bone.rotation_mode = "QUATERNION"
        around = bone.bone.matrix_local.to_3x3().inverted() @ axis
        for frame, degrees in keys:
            bone.rotation_quaternion = Quaternion(around, math.radians(degrees))
            bone.keyframe_insert("rotation_quaternion", frame=frame)
    keep_feet_in_place(rig)
    return rig


def keep_feet_in_place(rig: bpy.types.Object) -> None:
    """Keys the root in every frame of the clip, so that the hips go down where the knees bend."""
    root, feet = rig.pose.bones["root"], [rig.pose.bones[name] for name in ("foot.L", "foot.R")]
    to_root = root.bone.matrix_local.to_3x3().inverted()
    for frame in range(1, FRAMES + 1):
        bpy.context.scene.frame_set(frame)
        away = sum((foot.bone.head_local - foot.head for foot in feet), Vector()) / len(feet)
        root.location += to_root @ away
        root.keyframe_insert("location", frame=frame)


def weld_clothes(body: bpy.types.Object, weights: np.ndarray, bones: list[str]) -> None:
    """Makes faces of a figure those of a shirt and of jeans, with materials of their own, and lifts them off the skin
    around them. weights: (vertices, bones)."""
    mesh = body.data
    shares = [weights[:, [bone.startswith(starts) for bone in bones]].sum(axis=1) / least for starts, least in BARE]
    points, normals = (np.array([getattr(vertex, name) for vertex in mesh.vertices]) for name in ("co", "normal"))
    height = (points[:, Z_AXIS] - points[:, Z_AXIS].min()) / np.ptp(points[:, Z_AXIS])
    lifted = np.ones(len(points), bool)
    for material, colour in (("Shirt", CLOTH[0]), ("Jeans", JEANS)):
        mesh.materials.append(painted(material, colour))
    for polygon in mesh.polygons:
        corners = list(polygon.vertices)
        at = height[corners].mean()
        bare = at > COLLAR or max(share[corners].mean() for share in shares) > 1.0
        polygon.material_index = 0 if bare else 1 if at > WAIST else 2
        lifted[corners] &= not bare
    mesh.vertices.foreach_set("co", np.float32(points + LIFT * lifted[:, None] * normals).ravel())
    mesh.update()


def build_scene(data: Path, clothes: Path, name: str, colour: tuple[float, float, float]) -> bpy.types.Object:
    """An empty file with the figure in its outfit. Returns the outfit."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    kind = name.split("_")[0]
    figure = makehuman.read_figure(data, (f"macrodetails/caucasian-{kind}-young",
                                          f"macrodetails/universal-{kind}-young-averagemuscle-averageweight"))
    rig, bones = build_rig(figure.bones), list(figure.bones)
    if name in WELDED:
        mesh, weights = makehuman.skin_of(figure, set())
        obj = skinned(name, mesh, weights, bones, rig, SKIN)
        obj.data.materials[0].name = "Skin"
        weld_clothes(obj, weights, bones)
    else:
        outfit = makehuman.read_outfit(clothes / name / f"{name}.mhclo", figure)
        skinned("Body", *makehuman.skin_of(figure, outfit.hidden), bones, rig, SKIN)
        obj = skinned(name, outfit.mesh, outfit.weights, bones, rig, colour)
    demo_scene.add_camera_and_lights()
    camera = bpy.context.scene.camera
    camera.location = Vector((1.9, -4.05, 0.36))
    demo_scene.aim(camera, (0.0, 0.0, -0.02))
    bpy.context.scene.frame_end = FRAMES
    bpy.context.view_layer.objects.active = obj
    return obj


def render(folder: Path, frames: tuple[int, ...], row: Row | None, obj: bpy.types.Object) -> list[Path]:
    """Plays the clip; leaves a picture of each of these frames. row: gets the time of a frame and what was said."""
    scene, pictures, seconds = bpy.context.scene, [], 0.0
    for frame in range(1, FRAMES + 1):
        begun = time.perf_counter()
        scene.frame_set(frame)
        seconds += time.perf_counter() - begun
        if row is not None:
            check(obj, frame)
        if frame in frames:
            pictures.append(folder / f"{obj.name}_{'bare' if row is None else 'wrinkled'}_{frame}.png")
            gallery_light.render(pictures[-1])
    if row is not None:
        row.frame, row.said = 1e3 * seconds / FRAMES, obj.rumple.message
    return pictures


def check(obj: bpy.types.Object, frame: int) -> None:
    """Every position of a frame is finite, and within a metre and a half of the middle of the figure."""
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    points = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", points)
    evaluated.to_mesh_clear()
    if not np.abs(points).max(initial=0.0) < 1.5:
        raise ValueError(f"{obj.name}: frame {frame} has positions that are wild")


def sheet(rows: list[list[Path]], path: Path, width: int = TILE[0]) -> None:
    """Pictures in rows, as JPEG, their middles of this width."""
    from PIL import Image
    out, left = Image.new("RGB", (width * len(rows[0]), TILE[1] * len(rows))), (TILE[0] - width) // 2
    for y, row in enumerate(rows):
        for x, picture in enumerate(row):
            with Image.open(picture) as tile:
                out.paste(tile.convert("RGB").crop((left, 0, left + width, TILE[1])), (x * width, y * TILE[1]))
    out.save(path, quality=85, optimize=True)


def render_one(options: argparse.Namespace, folder: Path, name: str,
               colour: tuple[float, float, float]) -> tuple[Row, list[Path], list[Path]]:
    """Leaves the scene and the sheet of an outfit. Returns what it cost, and its pictures, bare and wrinkled."""
    obj = build_scene(options.data, options.clothes, name, colour)
    bpy.ops.wm.save_as_mainfile(filepath=str(options.out / f"{name}.blend"), compress=True)
    scene = bpy.context.scene
    gallery_light.light(scene, soft=True)
    if name not in WELDED:
        gallery_light.as_cloth(obj)
    scene.cycles.samples = options.samples
    scene.render.resolution_x, scene.render.resolution_y = TILE
    bare = render(folder, SHOWN, None, obj)
    scene.frame_set(1)
    row = Row(name, len(obj.data.vertices))
    begun = time.perf_counter()
    bpy.ops.object.rumple_add(method=options.method)
    row.click = time.perf_counter() - begun
    if name in FABRICS and options.method == "MESH":
        bpy.ops.object.rumple_preset(preset=FABRICS[name])
    wrinkled = render(folder, SHOWN, row, obj)
    row.shown = len(obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.vertices)
    sheet([bare, wrinkled], options.out / f"{name}.jpg")
    return row, bare, wrinkled


def render_all(options: argparse.Namespace, folder: Path) -> None:
    """folder: for pictures that go into the sheets."""
    pairs: list[Path] = []
    names = options.only.split(",") if options.only else OUTFITS
    for number, name in enumerate(names):
        row, bare, wrinkled = render_one(options, folder, name, CLOTH[number % len(CLOTH)])
        pairs += [bare[-1], wrinkled[-1]]
        print(f"| {row}", flush=True)
    across = 2 * min(4, len(names))
    rows = [pairs[begin:begin + across] for begin in range(0, len(pairs), across)]
    sheet(rows, options.out / "outfits.jpg", OVERVIEW_WIDTH)


def main() -> None:
    parser = argparse.ArgumentParser(prog="scripts/outfits")
    for name in ("data", "clothes", "out"):
        parser.add_argument(f"--{name}", type=Path, required=True)
    parser.add_argument("--only", default="")
    parser.add_argument("--method", default="MESH", choices=("MESH", "FIELD", "PATHS"))
    parser.add_argument("--samples", type=int, default=24)
    options = parser.parse_args(sys.argv[sys.argv.index("--") + 1:])
    import rumple
    rumple.register()
    print("| | outfit | vertices | shown | first click, s | a frame, ms | said |")
    print("| |---|---|---|---|---|---|", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        render_all(options, Path(folder))


main()
