# SPDX-License-Identifier: GPL-3.0-or-later
"""A garment that arrives broken, from the first click to a render, beside the same garment whole."""
from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Callable

import addon_utils
import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree
from rumple.blender import compat, scheduler
from rumple.blender.objects import modifier, properties, runtimes
from support import damage
from support.real_clip import sides

PICTURE = (300, 360)  # pixels
VIEW = Vector((-0.55, -1.0, 0.22)).normalized()  # from the garment to the camera
LOOK = dict(samples=8, use_adaptive_sampling=False, use_denoising=False, max_bounces=2)


class Damaged:
    """Laws of one garment and one way of damage: mix it into a TestCase."""

    way: Callable[[Any], None]
    frames: range
    method = "MESH"
    nearer = 0.95  # times as far from the whole garment as bare, at most
    # No shown edge is as many times as long as on the bare garment, or at rest: test_real_cloth.py. Eight of the
    # 145,000 of a tee in two layers are 4.1 to 4.3 times as long.
    longest = 4.5

    @classmethod
    def opened(cls) -> bpy.types.Object:
        """The garment as its maker meant it, in its scene."""
        raise NotImplementedError

    @classmethod
    def setUpClass(cls) -> None:
        cls.whole = cls.whole_garment()
        obj = cls.obj = cls.opened()
        damage.damage(obj, cls.way)
        cls.faces = len(obj.data.polygons)
        bpy.context.scene.frame_set(cls.frames[-1])
        cls.bare = cls.rendered("bare")
        cls.fine = runtimes.of(cls.clicked(obj)).evaluator
        cls.shown = cls.played(obj)
        cls.said = obj.rumple.message
        cls.picture = cls.rendered("wrinkled")

    @classmethod
    def whole_garment(cls) -> BVHTree:
        """As it is shown at the last frame."""
        return cls.tree(cls.played(cls.clicked(cls.opened()))[-1], runtimes.of(bpy.context.object).evaluator)

    @classmethod
    def clicked(cls, obj: bpy.types.Object) -> bpy.types.Object:
        """The one click, where the clip begins."""
        bpy.context.view_layer.objects.active = obj
        bpy.context.scene.frame_set(cls.frames[0])
        obj.rumple.field.output = "GEOMETRY"
        obj.rumple.viewport_steps = getattr(properties.group_of(obj), "display_steps", 0)
        assert bpy.ops.object.rumple_add(method=cls.method) == {"FINISHED"}, obj.rumple.message
        return obj

    @classmethod
    def played(cls, obj: bpy.types.Object) -> list[np.ndarray]:
        out = []
        for frame in cls.frames:
            bpy.context.scene.frame_set(frame)
            out.append(compat.positions(cls.mesh(obj)).copy())
        return out

    @classmethod
    def mesh(cls, obj: bpy.types.Object) -> bpy.types.Mesh:
        return obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data

    @classmethod
    def tree(cls, positions: np.ndarray, fine: Any) -> BVHTree:
        polygons = np.split(fine.corner_vertex, fine.polygon_start[1:-1])
        return BVHTree.FromPolygons(positions.tolist(), [polygon.tolist() for polygon in polygons])

    @classmethod
    def rendered(cls, what: str) -> np.ndarray:
        """The frame as Cycles has it, (height, width, 3). Its picture goes to RUMPLE_OUT."""
        scene, obj = bpy.context.scene, cls.obj
        addon_utils.enable("cycles")
        scene.render.engine = "CYCLES"
        for name, value in LOOK.items():
            setattr(scene.cycles, name, value)
        scene.render.resolution_x, scene.render.resolution_y = PICTURE
        scene.render.resolution_percentage = 100
        scene.render.image_settings.file_format, scene.render.image_settings.color_mode = "PNG", "RGB"
        corners = np.array([obj.matrix_world @ Vector(corner) for corner in obj.bound_box])
        camera = bpy.data.objects.get("Damaged") or bpy.data.objects.new("Damaged", bpy.data.cameras.new("Damaged"))
        if what == "bare":
            scene.collection.objects.link(camera)
            camera.data.lens, scene.camera = 85.0, camera
            scene.world = bpy.data.worlds.new("Damaged")
            scene.world.use_nodes = True
            sky = next(node for node in scene.world.node_tree.nodes if node.type == "BACKGROUND")
            sky.inputs["Color"].default_value, sky.inputs["Strength"].default_value = (0.5, 0.5, 0.5, 1.0), 0.6
            camera.rotation_euler = (-VIEW).to_track_quat("-Z", "Y").to_euler()
            distance = 2.2 * float(np.linalg.norm(np.ptp(corners, axis=0)))
            camera.location = Vector((corners.min(0) + corners.max(0)) / 2) + distance * VIEW
        path = Path(os.environ["RUMPLE_OUT"]) / "damaged" / f"{cls.__name__}_{what}.png"
        scene.render.filepath = str(path)
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(str(path))
        return np.array(image.pixels[:], np.float32).reshape(PICTURE[1], PICTURE[0], -1)[:, :, :3]

    def test_one_click_plays_without_a_message(self) -> None:
        self.assertEqual(self.said, "")
        for frame, shown in zip(self.frames, self.shown):
            self.assertTrue(np.isfinite(shown).all(), frame)

    def test_every_face_is_shown(self) -> None:
        found = np.unique(compat.read_attribute(self.mesh(self.obj).attributes["number"]))
        np.testing.assert_array_equal(found, np.arange(self.faces))

    def test_no_spikes(self) -> None:
        edges = sides(self.fine.polygon_start, self.fine.corner_vertex)
        shown, result = self.shown[-1], runtimes.of(self.obj).result

        def lengths(points: np.ndarray) -> np.ndarray:
            return np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)

        rest = lengths(self.fine.positions_rest)
        # What is left of a torn garment hangs by threads: short sides, that are stretched to the length of others.
        allowed = np.maximum(np.maximum(lengths(shown - result.offset), rest), rest.mean())
        self.assertLess(float((lengths(shown) / allowed).max()), self.longest)

    def test_it_lies_where_the_whole_garment_does(self) -> None:
        with scheduler.suspended():
            modifier.find(self.obj).show_viewport = False
            bpy.context.view_layer.update()
            bare = compat.positions(self.mesh(self.obj)).copy()
            modifier.find(self.obj).show_viewport = True
            bpy.context.view_layer.update()
        for wrinkled, before in zip(self.from_whole(self.shown[-1]), self.from_whole(bare)):
            self.assertLess(wrinkled, self.nearer * before)

    def from_whole(self, positions: np.ndarray) -> np.ndarray:
        """Metres from the whole garment: of half the points, and of 95 in 100."""
        return np.percentile([self.whole.find_nearest(point)[3] for point in map(Vector, positions[::7].tolist())],
                             (50, 95))

    def test_the_render_shows_folds(self) -> None:
        """Another picture than the bare one, and as bright: no holes, nothing over the camera."""
        self.assertGreater(np.abs(self.picture - self.bare).mean(), 1e-3)
        self.assertLess(abs(self.picture.mean() - self.bare.mean()), 0.03)
