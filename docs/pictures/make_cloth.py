# SPDX-License-Identifier: GPL-3.0-or-later
"""Garments that become cloth, on scenes of ../shared/data and on the demo: s1_cloth.jpg, s2_cloth.jpg, one_mesh.jpg,
rigid_parts.jpg, solid_parts.jpg, layers.jpg, fabrics.jpg, density.jpg, demo.jpg, dress.jpg and cape.jpg beside this
file.

    scripts/build
    RUMPLE_NATIVE=build/release/python blender -b --factory-startup --python-exit-code 1 \
        --python docs/pictures/make_cloth.py [-- NAME ...]      # of PICTURES, at the end
"""
from __future__ import annotations

import math
import os
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import bmesh
import bpy
import numpy as np
from mathutils import Matrix, Vector

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(ROOT / "addon"), str(ROOT / "scripts"), os.environ["RUMPLE_NATIVE"]]
import demo_rig  # noqa: E402
import gallery_light  # noqa: E402
import rumple  # noqa: E402
from contact_sheet import TILE, compose, studio  # noqa: E402
from rumple.blender import scheduler  # noqa: E402
from rumple.blender.objects import bodies, modifier, properties  # noqa: E402

LEAD_IN = 15  # frames that are played before the first one that is shown
Tile = tuple[str, Path]


@dataclass
class Scene:
    """A file of ../shared/data and how to look at it."""

    file: str
    garments: tuple[str, ...]  # what is wrinkled, in this order
    middle_of: tuple[str, ...]  # what the camera looks at
    frames: tuple[int, ...]
    view: Vector  # from the middle to the camera, metres
    lens: float = 82.0
    raised: float = 0.0  # metres: how far above that middle it looks


S1 = Scene("S1_walk_shirt", ("trousers", "shirt"), ("shirt", "trousers"), (40, 61, 100), Vector((1.5, -2.6, 0.5)),
           raised=0.2)
S2 = Scene("S2_squat_trousers", ("trousers", "sweater"), ("sweater", "trousers"), (30, 51, 63),
           Vector((-1.2, -2.7, 0.35)), raised=0.06)
SHIRT = Scene("S1_walk_shirt", ("trousers", "shirt"), ("shirt",), (61,), Vector((1.0, -1.75, 0.25)), 84.0)
FIGURE = replace(S1, frames=(61,), lens=100.0, raised=0.31)
ONE_LAYER = {"base_cloth": "OFF", "layers": "ONE"}


def subdivide(obj: bpy.types.Object, steps: int) -> None:
    """As if it had been modelled so densely."""
    if steps == 0:
        return
    modifier = obj.modifiers.new("Dense", "SUBSURF")
    modifier.levels = steps
    with bpy.context.temp_override(object=obj, active_object=obj):
        bpy.ops.object.modifier_move_to_index(modifier="Dense", index=0)
        bpy.ops.object.modifier_apply(modifier="Dense")


def open_scene(scene: Scene, settings: dict[str, object] | None, preset: str = "COTTON", steps: int = 0) -> None:
    """Its garments wrinkled, with some settings that were made before the click; None: bare. steps: of subdivision of
    their meshes."""
    bpy.ops.wm.open_mainfile(filepath=str(ROOT.parent / "shared" / "data" / f"{scene.file}.blend"))
    for name in scene.garments if settings is not None else ():
        obj = bpy.context.view_layer.objects.active = bpy.data.objects[name]
        subdivide(obj, steps)
        for setting, value in settings.items():
            setattr(obj.rumple.mesh, setting, value)
        assert bpy.ops.object.rumple_add(method="MESH") == {"FINISHED"}
        if preset != "COTTON":
            assert bpy.ops.object.rumple_preset(preset=preset) == {"FINISHED"}
        values = properties.group_of(obj)
        print("CLOTH", scene.file, name, values.base_cloth, values.layers, f"{values.wavelength:.3f}",
              [body.name for body in bodies.of(obj)], obj.rumple.message)
    scheduler.sync_all()
    set_up_render(scene.garments)


def set_up_render(garments: tuple[str, ...], size: tuple[int, int] = (520, 560)) -> None:
    """The light and the cloth of the gallery."""
    scene = bpy.context.scene
    gallery_light.light(scene)
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = *size, 100
    for name in garments:
        gallery_light.as_cloth(bpy.data.objects[name])


def middles(scene: Scene) -> dict[int, Vector]:
    """Of the bounds of the bare garments, world space, for every frame that is shown."""
    open_scene(scene, None)
    found = {}
    for frame in scene.frames:
        bpy.context.scene.frame_set(frame)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        corners = [obj.matrix_world @ Vector(corner) for obj in (bpy.data.objects[name].evaluated_get(depsgraph)
                                                                 for name in scene.middle_of)
                   for corner in obj.bound_box]
        found[frame] = Vector((min(c[i] for c in corners) + max(c[i] for c in corners)) / 2.0 for i in range(3))
        found[frame].z += scene.raised
    return found


def render(path: Path) -> None:
    if bpy.context.scene.render.engine == "CYCLES":
        return gallery_light.render(path)
    bpy.context.scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def play(scene: Scene, at: dict[int, Vector], label: Callable[[int], str], folder: Path) -> list[Tile]:
    """Play the open file and render the frames that are shown."""
    camera = bpy.data.objects.new("View", bpy.data.cameras.new("View"))
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera, camera.data.lens = camera, scene.lens
    camera.rotation_euler = (-scene.view).to_track_quat("-Z", "Y").to_euler()
    tiles = []
    for frame in range(scene.frames[0] - LEAD_IN, scene.frames[-1] + 1):
        bpy.context.scene.frame_set(frame)
        if frame in scene.frames:
            camera.location = at[frame] + scene.view
            tiles.append((label(frame), folder / f"{len(list(folder.iterdir()))}.png"))
            render(tiles[-1][1])
    for name in scene.garments:
        assert not bpy.data.objects[name].rumple.message, bpy.data.objects[name].rumple.message
    return tiles


def rows(scene: Scene, folder: Path) -> tuple[list[Tile], int]:
    """Bare, as it was before, and as cloth."""
    at, tiles = middles(scene), []
    for label, settings in (("Bare", None), ("One layer, no base cloth", ONE_LAYER), ("Cloth: one click", {})):
        open_scene(scene, settings)
        tiles.append(play(scene, at, lambda frame, label=label: f"{label}, frame {frame}", folder))
    return [tile for column in zip(*tiles) for tile in column], 3


def one_mesh(folder: Path) -> tuple[list[Tile], int]:
    """The figure and its clothes as one mesh, as characters of games are."""
    at, tiles = middles(S1), []
    for label, wrinkled in (("One mesh, as animated", False), ("One click", True)):
        open_scene(S1, None)
        body = bpy.context.view_layer.objects.active = bpy.data.objects["Body"]
        for obj in bpy.context.scene.objects:
            obj.select_set(obj == body or obj.name in S1.garments)
        bpy.ops.object.join()
        if wrinkled:
            assert bpy.ops.object.rumple_add(method="MESH") == {"FINISHED"}
            scheduler.sync_all()
        tiles.append(play(replace(S1, garments=("Body",)), at, lambda frame, label=label: f"{label}, frame {frame}",
                          folder))
    return [tile for column in zip(*tiles) for tile in column], 2


def solid_parts(folder: Path) -> tuple[list[Tile], int]:
    """A helmet and two pouches in the mesh of the demo's shirt, from near."""
    cloth, solid = (from_near((0.2, 0.8, 0.45, 1.0), 160, solids, rigid, 18, folder) for rigid in (False, True))
    return [cloth[0], (cloth[1][0] + "as cloth", cloth[1][1]), (solid[1][0] + "solid parts", solid[1][1])], 1


def rigid_parts(folder: Path) -> tuple[list[Tile], int]:
    """Buttons in the mesh of the demo's shirt, from near."""
    cloth, rigid = (from_near((0.34, 0.58, 0.51, 0.76), 420, buttons, rigid, 18, folder)[1] for rigid in (False, True))
    return [(cloth[0] + "as cloth", cloth[1]), (rigid[0] + "rigid", rigid[1])], 1


def from_near(border: tuple[float, float, float, float], percent: int, parts: Callable[[], list[bmesh.types.BMesh]],
              rigid: bool, frame: int, folder: Path) -> list[Tile]:
    """The demo's shirt with parts in its mesh, in a frame, bare and wrinkled: a part of the picture."""
    import demo_scene
    demo_scene.build_demo_scene()
    render = bpy.context.scene.render
    render.use_border = render.use_crop_to_border = True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = border
    shirt = bpy.data.objects["Shirt"]
    join(shirt, parts())
    shirt.rumple.mesh.rigid_parts = rigid
    place = folder / str(rigid)
    place.mkdir()
    garments = demo_scene.add_wrinkles("MESH")
    shown = before_and_after(garments, (frame,), place, percent)[0]
    return [(name.replace("after", ""), path) for name, path in shown]


def solids() -> list[bmesh.types.BMesh]:
    """Two pouches on the demo's shirt, and a helmet."""
    parts = []
    for place, size, is_pouch in (((0.09, -0.145, 1.15), (0.1, 0.06, 0.12), True),
                                  ((-0.09, -0.145, 1.15), (0.1, 0.06, 0.12), True),
                                  ((0.0, -0.01, 1.7), (0.22, 0.27, 0.3), False)):
        mesh = bmesh.new()
        if is_pouch:
            bmesh.ops.create_cube(mesh, size=1.0)
            bmesh.ops.bevel(mesh, geom=[*mesh.verts, *mesh.edges], offset=0.15, segments=3, profile=0.5,
                            affect="EDGES", clamp_overlap=True)
        else:
            bmesh.ops.create_uvsphere(mesh, u_segments=32, v_segments=20, radius=0.5)
            bmesh.ops.delete(mesh, geom=[v for v in mesh.verts if v.co.z < -0.15], context="VERTS")
        bmesh.ops.transform(mesh, matrix=Matrix.LocRotScale(Vector(place), None, Vector(size)), verts=mesh.verts)
        parts.append(mesh)
    return parts


def buttons() -> list[bmesh.types.BMesh]:
    """Down the middle of the demo's shirt."""
    import demo_body
    import demo_shirt
    places = np.array([(0.0, -0.17, height) for height in np.linspace(1.36, 1.06, 6)])
    places = demo_body.project_to_surface(places, demo_shirt.shirt_distance, steps=8)
    parts = []
    for place, out in zip(places, demo_body.distance_gradient(places, demo_shirt.shirt_distance)):
        mesh = bmesh.new()
        bmesh.ops.create_cone(mesh, cap_ends=True, segments=16, radius1=0.011, radius2=0.011, depth=0.005)
        turn = Vector(out).to_track_quat("Z", "Y")
        bmesh.ops.transform(mesh, matrix=Matrix.LocRotScale(Vector(place + 0.003 * out), turn, None), verts=mesh.verts)
        parts.append(mesh)
    return parts


def join(shirt: bpy.types.Object, meshes: list[bmesh.types.BMesh]) -> None:
    """Parts of the demo's shirt, skinned as it is."""
    parts = []
    for mesh in meshes:
        part = bpy.data.objects.new("Part", bpy.data.meshes.new("Part"))
        mesh.to_mesh(part.data)
        part.data.materials.append(bpy.data.materials["Shirt trim"])
        part.data.polygons.foreach_set("use_smooth", [len(face.vertices) <= 4 for face in part.data.polygons])
        bpy.context.scene.collection.objects.link(part)
        demo_rig.skin(part, np.array([vertex.co for vertex in part.data.vertices]), shirt.parent)
        parts.append(part)
    with bpy.context.temp_override(active_object=shirt, selected_editable_objects=[shirt, *parts]):
        bpy.ops.object.join()


def layers(folder: Path) -> tuple[list[Tile], int]:
    at, tiles = middles(SHIRT), []
    for shown in (("drape",), ("folds",), ("detail",), ("drape", "folds", "detail")):
        open_scene(SHIRT, {name: float(name in shown) for name in ("drape", "folds", "detail")})
        label = f"{shown[0].title()} only" if len(shown) == 1 else "All three"
        tiles += play(SHIRT, at, lambda frame, label=label: label, folder)
    return tiles, 1


def fabrics(folder: Path) -> tuple[list[Tile], int]:
    """Shirt and trousers of one fabric, with its colour and gloss."""
    at = middles(FIGURE)
    open_scene(FIGURE, None)
    tiles = play(FIGURE, at, lambda frame: "As animated", folder)
    for preset in ("SILK", "JERSEY", "COTTON", "WOOL", "DENIM", "LEATHER", "STRETCH"):
        open_scene(FIGURE, {}, preset)
        for name in FIGURE.garments:
            gallery_light.dye(bpy.data.objects[name], preset)
        tiles += play(FIGURE, at, lambda frame, preset=preset: preset.title(), folder)
    return tiles, 2


def density(folder: Path) -> tuple[list[Tile], int]:
    """The shirt modelled as it is, twice and four times as densely."""
    at, tiles = middles(SHIRT), []
    for steps in range(3):
        open_scene(SHIRT, {}, steps=steps)
        count = len(bpy.data.objects["shirt"].data.vertices)
        tiles += play(SHIRT, at, lambda frame, count=count: f"{count} vertices", folder)
    return tiles, 1


def demo(folder: Path) -> tuple[list[Tile], int]:
    """Shirt and trousers of scripts/demo, in its studio: an arm that rises, one that turns, a crouch."""
    import demo_scene
    demo_scene.build_demo_scene()
    return before_and_after(demo_scene.add_wrinkles("MESH"), (18, 30, 48), folder)


def dress(folder: Path) -> tuple[list[Tile], int]:
    """The same figure in a dress."""
    import dress_scene
    garment = dress_scene.build_dress_scene()
    assert bpy.ops.object.rumple_add(method="MESH") == {"FINISHED"}
    return before_and_after([garment], (10, 30, 48), folder, gallery=True)


def cape(folder: Path) -> tuple[list[Tile], int]:
    """The same figure in shirt, trousers and a cape, from behind."""
    import gallery_scenes
    import scene_motions
    skeleton = gallery_scenes.dressed(scene_motions.twist())
    gallery_scenes.add_cape(skeleton)
    gallery_scenes.ready("Cape")
    skeleton.rotation_euler.z = math.radians(160.0)
    garments = [bpy.data.objects[name] for name in ("Trousers", "Shirt", "Cape")]
    for garment in garments:
        bpy.context.view_layer.objects.active = garment
        assert bpy.ops.object.rumple_add(method="MESH") == {"FINISHED"}
    return before_and_after(garments, (1, 24), folder, gallery=True)


def before_and_after(garments: list[bpy.types.Object], frames: tuple[int, ...], folder: Path,
                     percent: int = 100, gallery: bool = False) -> tuple[list[Tile], int]:
    """In the studio of the demo, or in the light of the gallery, played from the start."""
    if gallery:
        set_up_render(tuple(garment.name for garment in garments), TILE)
        gallery_light.add_floor(bpy.context.scene)
    else:
        studio(bpy.context.scene)
    bpy.context.scene.render.resolution_percentage = percent
    tiles: list[Tile] = []
    for frame in range(1, frames[-1] + 1):
        bpy.context.scene.frame_set(frame)
        for shown, label in ((False, "before"), (True, "after")) if frame in frames else ():
            for garment in garments:
                modifier.find(garment).show_render = shown
            tiles.append((f"frame {frame}, {label}", folder / f"{len(tiles)}.png"))
            render(tiles[-1][1])
    for garment in garments:
        assert not garment.rumple.message, garment.rumple.message
    return tiles, 2


PICTURES: dict[str, tuple[str, Callable[[Path], tuple[list[Tile], int]]]] = {
    "s1": ("s1_cloth.jpg", lambda folder: rows(S1, folder)),
    "one_mesh": ("one_mesh.jpg", one_mesh),
    "rigid_parts": ("rigid_parts.jpg", rigid_parts),
    "solid_parts": ("solid_parts.jpg", solid_parts),
    "s2": ("s2_cloth.jpg", lambda folder: rows(S2, folder)),
    "layers": ("layers.jpg", layers),
    "fabrics": ("fabrics.jpg", fabrics),
    "density": ("density.jpg", density),
    "demo": ("demo.jpg", demo),
    "dress": ("dress.jpg", dress),
    "cape": ("cape.jpg", cape),
}


def main() -> None:
    rumple.register()
    from PIL import Image
    for word in sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else PICTURES:
        name, make = PICTURES[word]
        with tempfile.TemporaryDirectory() as folder:
            compose(*make(Path(folder)), Path(folder) / "sheet.png")
            Image.open(Path(folder) / "sheet.png").save(HERE / name, quality=82, optimize=True)


if __name__ == "__main__":
    main()
