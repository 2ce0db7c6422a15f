# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the examples inside Blender: scenes of demo, lessons and gallery. Started by scripts/examples.

The fine meshes are not in the file: they are made when it is opened. So it stays small. Every file has a text, Read Me:
what it shows, what to try, its licence.
"""
from __future__ import annotations

import os
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

import bpy

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "addon"), os.environ["RUMPLE_NATIVE"]]
import demo_scene  # noqa: E402
import gallery_live  # noqa: E402
import gallery_scenes  # noqa: E402
import lesson_scenes  # noqa: E402
import rumple  # noqa: E402
from gallery_clips import DATA  # noqa: E402
from rumple.blender import handlers  # noqa: E402
from rumple.blender.objects import modifier, output_mesh  # noqa: E402

MOST_BYTES = 2_000_000
DANCE_END = 110  # frame
MAP_SIZE = 1024  # texels: the file stays small
BODY_SPACING = 0.0095  # metres: the file stays small
LICENCE = """\
Licence: GPL-3.0-or-later, as Rumple itself, whose scripts made everything here from nothing. What you render is
yours."""
MAKEHUMAN = """\
Licence: body, garments and rig are MakeHuman's, CC0 1.0 (no conditions). """
CMU = MAKEHUMAN + """The motion is free for any use, but must
not be sold as it is: "The data used in this project was obtained from mocap.cs.cmu.edu. The database was created with
funding from NSF EIA-0196217." (clip 05_%s, BVH conversion by B. Hahne)"""
MIT = MAKEHUMAN + """The motion is of AnimatedDrawings (jumping.bvh),
MIT licence, Copyright (c) Meta Platforms, Inc. and affiliates: permission is hereby granted, free of charge, to any
person obtaining a copy, to deal in it without restriction, provided that this notice is included in all copies or
substantial portions. It is provided "as is", without warranty of any kind."""


def dress(names: tuple[str, ...], preset: str = "") -> None:
    """One click for each garment, what is worn under others first."""
    for name in names:
        garment = bpy.context.view_layer.objects.active = bpy.data.objects[name]
        if bpy.ops.object.rumple_add(method="MESH") != {"FINISHED"}:
            raise SystemExit(garment.rumple.message)
        if preset:
            bpy.ops.object.rumple_preset(preset=preset)


def make_shirt() -> None:
    demo_scene.build_demo_scene(BODY_SPACING)
    demo_scene.add_wrinkles("MESH")


def make_cape() -> None:
    gallery_scenes.build_cape()
    dress(("Trousers", "Shirt", "Cape"))


def make_jeans() -> None:
    gallery_scenes.build_jeans()
    dress(("Jeans",), "DENIM")


def make_sit() -> None:
    gallery_scenes.build_sit()
    dress(("Trousers", "Shirt"))


def make_sweater() -> None:
    gallery_scenes.build_elbow()
    dress(("Shirt",), "WOOL")


def make_twist() -> None:
    gallery_scenes.build_twist()
    dress(("Trousers", "Shirt"))


def make_painted() -> None:
    """The demo in motion, its chest painted as in the clip."""
    shirt = gallery_live.build_painted()
    gallery_live.wrinkle_painted(shirt)
    gallery_live.paint_until(shirt, gallery_live.PAINT_FRAMES[1])
    del shirt[gallery_live.DONE]
    bpy.data.objects.remove(bpy.data.objects[gallery_live.RING])
    skeleton = bpy.data.objects["Skeleton"]
    skeleton.animation_data_clear()
    demo_scene.demo_rig.animate(skeleton)
    bpy.context.scene.frame_end = demo_scene.FRAME_END
    bpy.context.scene.frame_set(demo_scene.FRAME_START)


def make_expressions() -> None:
    """The face of the clip, with its maps: they are in the file."""
    bpy.ops.wm.open_mainfile(filepath=str(DATA / "S4_face_expressions.blend"))
    face = gallery_live.build_face()
    with tempfile.TemporaryDirectory() as folder:  # what is baked is written beside a file
        bpy.ops.wm.save_as_mainfile(filepath=str(Path(folder) / "face.blend"))
        gallery_live.wrinkle_face(face, MAP_SIZE)
        bpy.ops.file.pack_all()


def of_data(file: str, *garments: str) -> Callable[[], None]:
    """A file of ../shared/data, wrinkled."""
    def make() -> None:
        bpy.ops.wm.open_mainfile(filepath=str(DATA / f"{file}.blend"))
        dress(garments)
    return make


def make_dance() -> None:
    """Its first seconds: the file stays small."""
    of_data("S3_skirt_sim", "skirt")()
    scene, skirt = bpy.context.scene, bpy.data.objects["skirt"]
    for key in list(skirt.data.shape_keys.key_blocks)[DANCE_END + 1:]:  # behind the one of rest, one for each frame
        skirt.shape_key_remove(key)
    scene.frame_end = DANCE_END


@dataclass(frozen=True)
class Example:
    """A file: what makes its scene, what its text says; the file of ../shared/data that it needs."""

    make: Callable[[], object]
    says: str
    licence: str = LICENCE
    data: str = ""


EXAMPLES = {
    "Shirt": Example(make_shirt, """\
A shirt over trousers, one click each. Select the shirt: its panel stands in the tab of modifiers. Choose another fabric
at its top, and play again."""),
    "Skirt": Example(lesson_scenes.build_skirt_scene, """\
A skirt that turns as if it were of wood. The lesson "A skirt that swings over a body" makes cloth of it."""),
    "Face": Example(lesson_scenes.build_face_scene, """\
A face with two brows and a jaw to pose. The lesson "A face with maps" wrinkles it."""),
    "Cape": Example(make_cape, """\
A runner in place, in a head wind (the object Wind). The cape is a sheet whose upper rows are painted Pinned to the
animation; Base Cloth is Swing. Play it from the first frame. Then try Mass, Swing Damping, and the strength of the
wind."""),
    "Jeans": Example(make_jeans, """\
Denim with a belt. The belt and its buckle are painted Rigid; under them the waist is painted Pinned to the animation
and Keep Smooth. Look at them in the part Paint of the panel."""),
    "Sitting_Down": Example(make_sit, """\
Trousers and a shirt, one click each. Nothing is set by hand. Look behind the knees and at the lap."""),
    "Sweater": Example(make_sweater, """\
A sleeve of wool from near. Try silk and leather at the top of the panel, and Wavelength below it."""),
    "Twist": Example(make_twist, """\
A torso that turns: folds run across it, to the shoulder that goes ahead. Try Drape, Folds and Detail."""),
    "Painted_Shirt": Example(make_painted, """\
Folds that were painted down the chest with the brush of the Wrinkle Field. Go on: select the shirt and press Paint Rest
Wrinkles in the part Rest Wrinkles of its panel."""),
    "Expressions": Example(make_expressions, """\
A face that is surprised, angry, laughs and cries, with Wrinkle Maps: normal maps that appear with the pose, baked in
two of its poses. Solid viewports show no materials: go to Material Preview. In Pose Mode move one brow, the bone
oculi01.L, alone.""",
                           MAKEHUMAN, "S4_face_expressions"),
    "Walk": Example(of_data("S1_walk_shirt", "trousers", "shirt"), """\
A captured walk in T-shirt and trousers, one click each. Nothing is set by hand. Try silk, denim and leather at the top
of the shirt's panel.""", CMU % "01", "S1_walk_shirt"),
    "Jump": Example(of_data("S2_squat_trousers", "trousers", "sweater"), """\
A captured jump in sweater and trousers, one click each. Nothing is set by hand. Look at the knees in the
crouch.""", MIT, "S2_squat_trousers"),
    "Dance": Example(make_dance, """\
A skirt that was simulated on a coarse mesh, and folds on it: it stays where the simulation has it. Try Wavelength, and
Buckling Limit below it, which keeps the noise of the simulation from folding.""", CMU % "02", "S3_skirt_sim"),
}


def leave_fine_meshes_out() -> None:
    """They are made again when the file is opened."""
    for nodes_mod in filter(None, map(modifier.find, bpy.context.scene.objects)):
        modifier.set_output_object(nodes_mod, None, 0)
        modifier.set_viewport_output(nodes_mod, None)
    for hidden in [obj for obj in bpy.data.objects if output_mesh.KEY in obj]:
        modifier.delete_hidden(hidden)


def make(name: str, path: Path) -> None:
    """One file."""
    bpy.ops.wm.read_homefile(use_empty=True)
    example = EXAMPLES[name]
    example.make()
    handlers.unregister()  # else the fine meshes are made again at once
    leave_fine_meshes_out()
    bpy.data.texts.new("Read Me").write(f"{example.says}\n\n{example.licence}\n")
    path.unlink(missing_ok=True)  # else Blender keeps the former one as .blend1
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=True, copy=True)
    handlers.register()
    size = path.stat().st_size
    print(f"| {path.name} {size / 1e6:.2f} MB", flush=True)
    if size > MOST_BYTES:
        raise SystemExit(f"{path.name} is larger than {MOST_BYTES} bytes")


def main() -> None:
    rumple.register()
    out, *names = sys.argv[sys.argv.index("--") + 1:]
    possible = [name for name, one in EXAMPLES.items() if not one.data or (DATA / f"{one.data}.blend").is_file()]
    for name in names or possible:
        make(name, Path(out) / f"{name}.blend")


if __name__ == "__main__":
    main()
