# SPDX-License-Identifier: GPL-3.0-or-later
"""Garments of the real scenes as cloth: one click, play a part of the clip, look at every frame, hold the last pose.

What was measured goes to RUMPLE_OUT, a JSON file for each clip.
"""
from __future__ import annotations

import json
import time
import unittest
from collections import Counter
from dataclasses import asdict, dataclass

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree
from rumple.blender import compat
from rumple.blender.objects import modifier, runtimes
from support.one_blender import in_one_blender
from support.real_clip import Clip, digest, sides
from support.real_garment import DATA, OUT, EveryFrame

DEEP = 5e-4  # metres inside the body
NEAR = 0.05  # metres: what lies farther from the body does not lie on it
# Share of the points that may be deep beside those of the bare garment: in a somersault a hem cuts 3 mm into a heel.
MORE_DEEP = 0.004
EVERY = 5  # of the shown points that are asked how deep they are
# No shown edge is longer than this many times the same edge on the bare garment, or at rest. 3 everywhere but in the
# armpit of the shirt, where skinning stretches coarse edges to 15 times their length: there above 3 in 5 of 45
# frames, 3.45 in one.
LONGEST = 3.5
EVERY_CROSSING = 6  # frames
MORE_CROSSINGS = 1.125  # times the crossing pairs of the bare garment: without the bound of the layers 1.6 times
REST = 15  # frames after which a held pose has come to rest ...
STILL = 3  # ... and for which it is then looked at


@dataclass
class Seen:
    """What was seen and measured at one frame."""

    frame: int
    message: str
    finite: bool
    digest: str  # of the shown positions, all bits
    spike: float  # largest shown edge over the same edge unwrinkled, or at rest
    comparable: int  # asked points that lie on the body and face as it does there, both shown and bare
    deep: int  # of those: deep inside
    deep_bare: int  # of the bare garment
    deep_beside: int  # shown points deep inside whose bare ones are not comparable: an arm that hangs into the shirt
    deepest: float  # millimetres
    deepest_bare: float
    known: float  # share of the coarse vertices that have a body under them
    from_animation: float  # mean, millimetres
    milliseconds: float  # for the whole frame in Blender


class ClothClip(Clip):
    """A garment of one file that one click made cloth; its body is where the file has it."""

    def __init__(self, file: str, name: str, frames: range) -> None:
        bpy.ops.wm.open_mainfile(filepath=str(DATA / f"{file}.blend"))
        self.scene, self.frames = bpy.context.scene, frames
        self.garment, self.body = bpy.data.objects[name], bpy.data.objects["Body"]
        self.garments = [self.garment]
        self.scene.frame_start = frames[0]
        self.scene.frame_set(frames[0])
        bpy.context.view_layer.objects.active = self.garment
        self.garment.rumple.viewport_steps = self.garment.rumple.mesh.display_steps  # the mesh of renders is measured
        assert bpy.ops.object.rumple_add(method="MESH") == {"FINISHED"}, self.garment.rumple.message
        self.fine = runtimes.of(self.garment).evaluator
        self.edges = sides(self.fine.polygon_start, self.fine.corner_vertex)
        self.rest_lengths = self.lengths(self.fine.positions_rest)
        self.at_border = self.polygons_at_borders()

    def polygons_at_borders(self) -> np.ndarray:
        """Of the body, (p,) bool: it has no limbs under clothes, and beside a hole inside means nothing."""
        polygons = self.body.data.polygons
        count = Counter(edge for polygon in polygons for edge in polygon.edge_keys)
        open_ones = {vertex for edge, faces in count.items() if faces == 1 for vertex in edge}
        return np.array([not open_ones.isdisjoint(polygon.vertices) for polygon in polygons])

    def look(self, frame: int) -> Seen:
        began = time.perf_counter()
        shown = self.show(frame).copy()
        took = 1e3 * (time.perf_counter() - began)
        picture = runtimes.of(self.garment).result
        bare = shown - picture.offset
        over, over_bare = self.heights(shown), self.heights(bare)
        beside = int((over[np.isnan(over_bare)] < -DEEP).sum())
        both = np.isfinite(over) & np.isfinite(over_bare)
        over, over_bare = over[both], over_bare[both]
        cloth = picture.report.cloth
        return Seen(frame, self.garment.rumple.message, bool(np.isfinite(shown).all()), digest(shown),
                    self.spike(shown, picture), int(both.sum()), int((over < -DEEP).sum()),
                    int((over_bare < -DEEP).sum()), beside, -1e3 * float(over.min()), -1e3 * float(over_bare.min()),
                    cloth.body_known, 1e3 * cloth.offset_mean, took)

    def crossings(self, positions: np.ndarray) -> int:
        """Pairs of polygons that pass through each other and share no vertex."""
        starts, corners = self.fine.polygon_start, self.fine.corner_vertex
        polygons = corners.reshape(-1, 4)
        assert (np.diff(starts) == 4).all()
        tree = BVHTree.FromPolygons(positions.tolist(), polygons.tolist())
        pairs = np.array(tree.overlap(tree), np.int32).reshape(-1, 2)
        pairs = pairs[pairs[:, 0] < pairs[:, 1]]
        first, second = polygons[pairs[:, 0]], polygons[pairs[:, 1]]
        return int((first[:, :, None] != second[:, None, :]).all(axis=(1, 2)).sum())

    def heights(self, positions: np.ndarray) -> np.ndarray:
        """Above the body, metres, of every so many points; NaN where they do not lie on it."""
        into = self.body.matrix_world.inverted() @ self.garment.matrix_world
        body = self.body.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        tree = BVHTree.FromPolygons([Vector(place) for place in compat.positions(body).tolist()],
                                    [tuple(polygon.vertices) for polygon in body.polygons])
        out = []
        for place, normal in zip(positions[::EVERY].tolist(), self.normals(positions)[::EVERY].tolist()):
            point = into @ Vector(place)
            nearest, facing, polygon, way = tree.find_nearest(point)
            lies = way < NEAR and not self.at_border[polygon] and facing.dot(into.to_3x3() @ Vector(normal)) > 0.0
            out.append((point - nearest).dot(facing) if lies else np.nan)
        return np.array(out)

    def normals(self, positions: np.ndarray) -> np.ndarray:
        """Of every vertex, not of unit length."""
        starts, corners = self.fine.polygon_start[:-1], self.fine.corner_vertex
        normals = np.zeros(positions.shape)
        first, second, third, last = (corners[starts + k] for k in (0, 1, 2, np.diff(self.fine.polygon_start) - 1))
        of_polygon = np.cross(positions[third] - positions[first], positions[last] - positions[second])
        for corner in (first, second, third, last):
            np.add.at(normals, corner, of_polygon)
        return normals


class Worn(EveryFrame):
    """The laws of a clip that was played through once, with what the first click sets."""

    file: str
    name: str
    frames: range

    @classmethod
    def setUpClass(cls) -> None:
        cls.clip = ClothClip(cls.file, cls.name, cls.frames)
        cls.seen = [cls.clip.look(frame) for frame in cls.frames]
        settings = cls.clip.garment.rumple.mesh
        OUT.mkdir(parents=True, exist_ok=True)
        summary = dict(file=cls.file, garment=cls.name, blender=bpy.app.version_string, frames=len(cls.seen),
                       base_cloth=settings.base_cloth, layers=settings.layers, wavelength=settings.wavelength,
                       body=cls.clip.garment.rumple.body.name, shown_vertices=cls.clip.fine.vertex_count,
                       worst_spike=max(s.spike for s in cls.seen), deepest=max(s.deepest for s in cls.seen),
                       most_deep=max((s.deep - s.deep_bare) / max(s.comparable, 1) for s in cls.seen),
                       milliseconds=float(np.median([s.milliseconds for s in cls.seen])))
        text = json.dumps(dict(summary=summary, frames=[asdict(s) for s in cls.seen]), indent=1)
        (OUT / f"real_cloth_{cls.file}_{cls.name}.json").write_text(text)

    def test_one_click_made_it_cloth_over_its_body(self) -> None:
        garment = self.clip.garment
        self.assertEqual((garment.rumple.mesh.base_cloth, garment.rumple.mesh.layers), ("HANG", "CLOTH"))
        self.assertEqual(garment.rumple.body, self.clip.body)
        self.for_every_frame(lambda s: s.known > 0.15)  # of the trousers the upper part: the body has no legs

    def test_every_frame_is_there_and_finite(self) -> None:
        self.for_every_frame(lambda s: s.message == "" and s.finite)
        self.assertEqual(len({s.digest for s in self.seen}), len(self.seen))

    def test_it_hangs(self) -> None:
        self.for_every_frame(lambda s: s.from_animation > 1.0)

    def test_no_spikes(self) -> None:
        self.for_every_frame(lambda s: s.spike < LONGEST)

    def test_it_is_not_deeper_in_the_body_than_the_bare_garment(self) -> None:
        self.for_every_frame(lambda s: s.comparable > 700 and s.deep <= s.deep_bare + MORE_DEEP * s.comparable)

    def test_in_the_whole_clip_no_more_is_deep_in_the_body_than_of_the_bare_garment(self) -> None:
        self.assertLessEqual(sum(s.deep for s in self.seen), sum(s.deep_bare for s in self.seen))

    def test_at_most_an_eighth_more_polygons_cross_each_other_than_of_the_bare_garment(self) -> None:
        # The base cloth moves crossings that skinning made: frame by frame some are a few pairs up, so the sum counts.
        pairs = {}
        for frame in self.frames[::EVERY_CROSSING]:
            shown = self.clip.show(frame).copy()
            bare = shown - runtimes.of(self.clip.garment).result.offset
            pairs[frame] = self.clip.crossings(shown), self.clip.crossings(bare)
        shown_sum, bare_sum = np.sum(list(pairs.values()), axis=0)
        self.assertGreater(bare_sum, 100, "nothing is crossed: the law says nothing")
        self.assertLessEqual(shown_sum, MORE_CROSSINGS * bare_sum, f"(shown, bare) by frame: {pairs}")

    def test_replayed_in_any_order_to_the_bit(self) -> None:
        for index in (-1, 0, 7, 3, len(self.seen) // 2):
            seen = self.seen[index]
            self.assertEqual(digest(self.clip.show(seen.frame)), seen.digest, f"frame {seen.frame}")

    def test_jumps_before_playing_leave_no_trace(self) -> None:
        bpy.context.view_layer.objects.active = self.clip.garment
        bpy.ops.object.rumple_clear_frames()
        for place in (12, 3, 19):
            self.clip.show(self.frames[0] + place)
        for seen in self.seen[:10]:
            self.assertEqual(digest(self.clip.show(seen.frame)), seen.digest, f"frame {seen.frame}")

    def test_a_held_pose_comes_to_rest(self) -> None:
        for frame in self.frames:
            self.clip.show(frame)
        last = self.frames[-1]
        self.clip.hold_from(last)
        held = [digest(self.clip.show(frame)) for frame in range(last, last + REST + STILL + 1)]
        self.assertEqual(held[REST:], held[REST:REST + 1] * (STILL + 1), f"it moved at {held}")


class Shirt(Worn, unittest.TestCase):
    file, name, frames = "S1_walk_shirt", "shirt", range(1, 46)


@in_one_blender
class Trousers(Worn, unittest.TestCase):
    file, name, frames = "S2_squat_trousers", "trousers", range(30, 64)


class NothingIsAnimated(unittest.TestCase):
    """Between friction and contacts the base cloth slipped to and fro for ever, and folds over it popped."""

    def test_it_comes_to_rest(self) -> None:
        for file, name, pose in (("S1_walk_shirt", "shirt", 1), ("S2_squat_trousers", "sweater", 20)):
            with self.subTest(name):
                bpy.ops.wm.open_mainfile(filepath=str(DATA / f"{file}.blend"))
                scene, garment = bpy.context.scene, bpy.data.objects[name]
                scene.frame_set(pose)
                for rig in (other for other in scene.objects if other.type == "ARMATURE"):
                    rig.animation_data_clear()
                scene.frame_set(scene.frame_start)
                bpy.context.view_layer.objects.active = garment
                self.assertEqual(bpy.ops.object.rumple_add(method="MESH"), {"FINISHED"}, garment.rumple.message)
                held = []
                for frame in range(scene.frame_start, scene.frame_start + REST + STILL + 1):
                    scene.frame_set(frame)
                    held.append(digest(runtimes.of(garment).result.positions))
                self.assertEqual(held[REST:], held[REST:REST + 1] * (STILL + 1), f"it moved at {held}")


class Simulated(unittest.TestCase):
    """A simulation is compressed by a percent everywhere: all of that showed as small random folds on those it had."""

    frames = range(50, 61)

    def noise(self, file: str, name: str, **settings: str | float) -> float:
        """How far the folds of a point differ from those of its neighbours, mean of the last frame, metres."""
        bpy.ops.wm.open_mainfile(filepath=str(DATA / f"{file}.blend"))
        self.garment = bpy.data.objects[name]
        bpy.context.view_layer.objects.active = self.garment
        self.garment.rumple.viewport_steps = self.garment.rumple.mesh.display_steps  # the mesh of renders is measured
        self.assertEqual(bpy.ops.object.rumple_add(method="MESH"), {"FINISHED"}, self.garment.rumple.message)
        for name, value in settings.items():
            setattr(self.garment.rumple.mesh, name, value)
        for frame in self.frames:
            bpy.context.scene.frame_set(frame)
        runtime = runtimes.of(self.garment)
        self.assertEqual(runtime.message, "")
        a, b = sides(runtime.evaluator.polygon_start, runtime.evaluator.corner_vertex).T
        offset, count = runtime.result.offset, np.zeros(runtime.evaluator.vertex_count)
        around = np.zeros(offset.shape)
        for one, other in ((a, b), (b, a)):
            np.add.at(around, one, offset[other])
            np.add.at(count, one, 1.0)
        return float(np.linalg.norm(offset - around / count[:, None], axis=1).mean())

    def clicked(self, file: str, name: str) -> float:
        """noise() of what one click made."""
        found, settings = self.noise(file, name), self.garment.rumple.mesh
        self.assertEqual((settings.base_cloth, settings.layers), ("OFF", "CLOTH"))
        return found

    def test_one_click_gives_a_skirt_folds_without_noise(self) -> None:
        skirt = "S3_skirt_sim", "skirt"
        clicked = self.clicked(*skirt)
        self.assertGreater(np.linalg.norm(runtimes.of(self.garment).result.offset, axis=1).max(), 0.005)
        self.assertLess(clicked, 0.9 * self.noise(*skirt, buckling_threshold=0.0))
        self.assertLess(clicked, 0.65 * self.noise(*skirt, buckling_threshold=0.0, layers="ONE"))

    def test_one_click_gives_a_flag_less_noise_than_without_the_threshold(self) -> None:
        flag = "S5_flag", "flag"
        self.assertLess(self.clicked(*flag), 0.9 * self.noise(*flag, buckling_threshold=0.0))


class OneMesh(unittest.TestCase):
    """The figure of S1 and its clothes as one mesh, as characters of games are."""

    def test_skin_stays_as_it_is_animated_and_clothes_fold(self) -> None:
        bpy.ops.wm.open_mainfile(filepath=str(DATA / "S1_walk_shirt.blend"))
        figure = bpy.context.view_layer.objects.active = bpy.data.objects["Body"]
        of_skin = len(figure.data.vertices)
        for obj in bpy.context.scene.objects:
            obj.select_set(obj.name in ("Body", "shirt", "trousers"))
        bpy.ops.object.join()
        bpy.ops.object.rumple_add(method="MESH")
        for frame in range(1, 13):
            bpy.context.scene.frame_set(frame)
        runtime = runtimes.of(figure)
        self.assertEqual(runtime.message, "")
        taken = runtime.evaluator.base.rigid
        self.assertEqual(np.sort(taken.vertex).tolist(), list(range(of_skin)))
        self.assertEqual(int(taken.is_skin.sum()), 5)  # two arms, two feet, a head; and two eyes, far from all cloth
        shown = runtime.result.positions
        np.testing.assert_array_equal(shown[-of_skin:], runtime.inputs.positions[taken.vertex])
        folds = np.linalg.norm(runtime.result.offset[:-of_skin], axis=1)
        self.assertGreater(np.percentile(folds, 90), 0.004)
        modifier.find(figure).show_viewport = False
        np.testing.assert_allclose(compat.positions(figure.evaluated_get(
            bpy.context.evaluated_depsgraph_get()).data)[taken.vertex], shown[-of_skin:], atol=1e-5)


if __name__ == "__main__":
    unittest.main()
