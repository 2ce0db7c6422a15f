# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders one clip of the gallery inside Blender: every column played through, then all of them side by side."""
from __future__ import annotations

import argparse
import os
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "addon"), os.environ["RUMPLE_NATIVE"]]
import gallery_light  # noqa: E402
import gallery_live  # noqa: E402
import gallery_scenes  # noqa: E402
import rumple  # noqa: E402
from contact_sheet import LABEL, LENS, label_font  # noqa: E402
from gallery_clips import CLIPS, Clip, Column  # noqa: E402

LEAD_IN = 12  # frames that are played before the first one that is shown
CALM = 12  # frames over which the camera's way is averaged


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="scripts/gallery")
    parser.add_argument("--clip", required=True, choices=CLIPS)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--still", type=int, help="one frame alone, as a PNG, to look at")
    return parser.parse_args(sys.argv[sys.argv.index("--") + 1:])


def open_scene(clip: Clip) -> bpy.types.Scene:
    """The file, or the demo's scene, with nothing wrinkled."""
    if clip.file == "skirt":
        import lesson_scenes
        lesson_scenes.build_skirt_scene()
    elif clip.file in gallery_scenes.SCENES:
        gallery_scenes.SCENES[clip.file]()
    elif clip.file == "painted":
        gallery_live.build_painted()
    elif clip.path is None:
        import demo_scene
        demo_scene.build_demo_scene()
    else:
        bpy.ops.wm.open_mainfile(filepath=str(clip.path))
    if clip.is_skin:
        gallery_live.build_face()
    return bpy.context.scene


def wrinkle(clip: Clip, column: Column) -> None:
    """One click for every garment, and the fabric."""
    if clip.file == "painted":
        return gallery_live.wrinkle_painted(bpy.data.objects["Shirt"])
    if column.method == "MAPS":
        return gallery_live.wrinkle_face(bpy.data.objects["Head"])
    for name in clip.garments if column.method else ():
        obj = bpy.context.view_layer.objects.active = bpy.data.objects[name]
        if bpy.ops.object.rumple_add(method=column.method) != {"FINISHED"}:
            raise SystemExit(obj.rumple.message)
        for name, value in column.settings:
            setattr(settings_of(obj), name, value)
        if column.preset and bpy.ops.object.rumple_preset(preset=column.preset) != {"FINISHED"}:
            raise SystemExit(obj.rumple.message)


def settings_of(obj: bpy.types.Object) -> bpy.types.PropertyGroup:
    """Of the system that an object has."""
    return getattr(obj.rumple, obj.rumple.method.lower())


def corners(clip: Clip) -> list[Vector]:
    """Of the boxes around what the camera looks at in the present frame, world space."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    seen = [bpy.data.objects[name].evaluated_get(depsgraph) for name in clip.looks_at or clip.garments]
    return [obj.matrix_world @ Vector(corner) for obj in seen for corner in obj.bound_box]


def middles(clip: Clip) -> dict[int, Vector]:
    """What the camera looks at in every frame, world space: a calm way along the middle of the garments."""
    scene, first, found = open_scene(clip), clip.frames[0], []
    for frame in range(first, clip.frames[1] + 1):
        scene.frame_set(frame)
        box = corners(clip)
        skeleton = bpy.data.objects.get("Skeleton")
        found.append((np.min(box, axis=0) + np.max(box, axis=0)) / 2.0 if not clip.bone else
                     np.array(skeleton.matrix_world @ skeleton.pose.bones[clip.bone].head))
    padded = np.pad(np.array(found), ((CALM, CALM), (0, 0)), mode="edge")
    calm = [padded[number:number + 2 * CALM + 1].mean(axis=0) for number in range(len(found))]
    return {first + number: Vector(middle) + Vector((0.0, 0.0, clip.raised)) for number, middle in enumerate(calm)}


def place_camera(clip: Clip, ways: dict[int, Vector]) -> None:
    scene, view = bpy.context.scene, Vector(clip.view).normalized()
    camera = bpy.data.objects.new("Gallery", bpy.data.cameras.new("Gallery"))
    scene.collection.objects.link(camera)
    scene.camera, camera.data.lens = camera, LENS
    camera.rotation_euler = (-view).to_track_quat("-Z", "Y").to_euler()
    for frame, middle in ways.items():
        camera.location = middle + clip.distance * view
        camera.keyframe_insert("location", frame=frame)


def place_floor(clip: Clip, ways: dict[int, Vector]) -> None:
    """Under the middle of the picture, which it follows, and under the feet: a figure's origin may be at its hips."""
    bpy.context.scene.frame_set(clip.frames[0])
    floor = gallery_light.add_floor(bpy.context.scene)
    floor.location.z = min(0.0, *(corner.z for corner in corners(clip)))
    for frame, middle in ways.items():
        floor.location.xy = middle.xy
        floor.keyframe_insert("location", frame=frame)


def shown(clip: Clip, still: int | None) -> range:
    """The frames that are rendered; those between are played."""
    if still is not None:
        return range(still, still + 1)
    return range(clip.frames[0], clip.frames[1] + 1, max(bpy.context.scene.render.fps // clip.rate, 1))


def render(clip: Clip, column: Column, ways: dict[int, Vector], frames: range, folder: Path) -> None:
    """Its pictures, in a folder."""
    scene = open_scene(clip)
    wrinkle(clip, column)
    gallery_light.light(scene, clip.is_skin)
    for name in clip.garments if not clip.is_skin else ():
        gallery_light.as_cloth(bpy.data.objects[name])
        if clip.dyed:
            gallery_light.dye(bpy.data.objects[name], column.preset)
    place_camera(clip, ways)
    if not clip.is_skin:
        place_floor(clip, ways)
    if column.paint:
        gallery_live.show_paint(bpy.data.objects["Shirt"])
    scene.render.resolution_x, scene.render.resolution_y = clip.size
    scene.render.resolution_percentage = 100
    scene.render.use_persistent_data = True  # the same pictures to the bit, sooner
    scene.frame_start = max(clip.frames[0] - LEAD_IN, scene.frame_start)
    for frame in range(scene.frame_start, frames[-1] + 1):
        if clip.file == "painted" and frame in frames:
            gallery_live.paint_until(bpy.data.objects["Shirt"], frame)
        scene.frame_set(frame)
        if frame in frames:
            gallery_light.render(folder / f"{frame:04d}.png")


def side_by_side(clip: Clip, frames: range, folders: list[Path], out: Path, rate: float) -> None:
    """Pictures for a video, and an animated WebP."""
    from PIL import Image, ImageDraw
    font = label_font()
    width, height = clip.size
    pages = []
    for frame in frames:
        page = Image.new("RGB", (width * len(folders), height + LABEL), (24, 24, 26))
        pen = ImageDraw.Draw(page)
        for number, (folder, column) in enumerate(zip(folders, clip.columns)):
            page.paste(Image.open(folder / f"{frame:04d}.png").convert("RGB"), (number * width, LABEL))
            pen.text((number * width + 8, 5), column.label, fill=(225, 225, 225), font=font)
        page.save(out / f"{frame:04d}.png")
        pages.append(page)
    pages[0].save(out.with_suffix(".webp"), save_all=True, append_images=pages[1:], loop=0, quality=75, method=6,
                  duration=round(1000.0 / rate))


def main() -> None:
    options = arguments()
    clip, out = CLIPS[options.clip], options.out / options.clip
    out.mkdir(parents=True, exist_ok=True)
    rumple.register()
    ways = middles(clip)
    frames = shown(clip, options.still)
    with tempfile.TemporaryDirectory() as temporary:
        folders = [Path(temporary) / str(number) for number in range(len(clip.columns))]
        for column, folder in zip(clip.columns, folders):
            folder.mkdir()
            render(clip, column, ways, frames, folder)
        rate = bpy.context.scene.render.fps / frames.step
        side_by_side(clip, frames, folders, out, rate)
    (out / "fps").write_text(f"{rate:g}")


if __name__ == "__main__":
    main()
