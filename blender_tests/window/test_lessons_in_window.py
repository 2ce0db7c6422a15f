# SPDX-License-Identifier: GPL-3.0-or-later
"""The lessons of docs/lessons, followed in a window by somebody who has their words, mouse and keys.

Every name that stands in bold in a lesson's steps is read on the screen (support/artist.py), and what is left is what
the lesson's script leaves in a Blender of its own: the same settings, the same vertices, the same picture, which is
that of the lesson's page. The suite follows the first lesson; all of them: RUMPLE_LONG=1 scripts/suite window
test_lessons_in_window, ten minutes.
"""
from __future__ import annotations

import json
import os
import subprocess
import tempfile
import unittest
from pathlib import Path
from typing import Iterator, Sequence
from unittest import mock

import bpy
import numpy as np
from mathutils import Vector
from rumple.blender.nodes import wrinkle_tree
from rumple.blender.objects import modifier, runtimes
from rumple.blender.ui import examples
from support import lesson_result, sleeve
from support.artist import Artist
from support.one_blender import in_one_blender, long_one

LESSONS = ("first_wrinkles", "skirt", "painting", "face", "bake")
# A window turns the preview on, a script has no viewport. Poses follow the bones that are selected in Pose Mode.
BY_HAND = ("rumple.field.gpu_preview", "rumple_maps.bones[2]")
PAGE = 0.5  # how near to the picture of the page, in distances of the picture before the lesson from it
PAINTED = 0.8  # the same of strokes: the script has no hand, and writes what they might leave
STROKES = 3  # at most: a window that draws slowly drops a part of one, and somebody who sees that paints again
CHEST, SHIRT, SKIRT, FACE = (0.05, -0.12, 1.2), "Shirt", "Skirt", "Face"


def child(*command: str | Path) -> subprocess.Popen[str]:
    return subprocess.Popen(command, cwd=lesson_result.ROOT, text=True, stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT)


ALL = "RUMPLE_LONG" in os.environ


@in_one_blender
class Lessons(Artist):
    @classmethod
    def setUpClass(cls) -> None:
        """The examples, and what the scripts of the lessons that are followed leave: they run while the first is."""
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.scripted = Path(folder.name)
        made = child("scripts/examples", cls.scripted, *((SHIRT, SKIRT, FACE) if ALL else (SHIRT,)))
        printed, _ = made.communicate()
        if made.returncode != 0:
            raise AssertionError(printed)
        cls.log = open(cls.scripted / "log", "w+", encoding="utf-8")
        cls.addClassCleanup(cls.log.close)
        cls.by_script = subprocess.Popen(
            ["blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python", lesson_result.__file__, "--",
             cls.scripted, cls.scripted, *(LESSONS if ALL else LESSONS[:1])], stdout=cls.log, stderr=subprocess.STDOUT)
        cls.addClassCleanup(cls.by_script.wait)
        cls.addClassCleanup(cls.by_script.kill)

    # ---- what the lessons have in common
    def begin(self, example: str, place: tuple[float, float, float]) -> Iterator[float]:
        """Open an example from the menu, in a new file, and click on what it is about."""
        patch = mock.patch.object(examples, "FOLDER", self.scripted)
        patch.start()
        self.addCleanup(patch.stop)
        with sleeve.context():
            bpy.ops.wm.read_homefile(use_empty=True)
        yield 0.3
        yield from self.choose(f"Help > Wrinkles: Open Example > {example}")
        yield from self.until(lambda: example in bpy.data.objects)
        yield 0.5
        yield from self.select(example, place)

    def select(self, name: str, place: Sequence[float]) -> Iterator[float]:
        yield from self.click(self.seen_at(Vector(place)))
        self.assertEqual(bpy.context.object.name, name)

    def see_all(self, *words: str) -> Iterator[float]:
        for one in words:
            yield from self.scroll_to(one)

    # ---- what came of it
    def check(self, name: str, obj: bpy.types.Object, painted: bool = False) -> Iterator[float]:
        """painted: by hand, so that neither vertices nor pixels are those of the script."""
        page = (lesson_result.ROOT / "docs" / "lessons" / f"{name}.md").read_text(encoding="utf-8")
        self.assertEqual(lesson_result.named(lesson_result.steps(page)) - self.read, set())
        self.assertEqual(runtimes.message(obj), "")
        picture, of_script = self.scripted / f"{name}_here.png", self.scripted / f"{name}.png"
        yield from self.until(lambda: of_script.exists() or self.by_script.poll() is not None, 300.0)
        yield 0.5
        if not of_script.exists():
            self.fail((self.scripted / "log").read_text(encoding="utf-8"))
        self.assertEqual(self.settings(json.loads(json.dumps(lesson_result.settings(obj)))),
                         self.settings(json.loads((self.scripted / f"{name}.json").read_text(encoding="utf-8"))))
        if not painted:
            np.testing.assert_array_equal(lesson_result.vertices(obj), np.load(self.scripted / f"{name}.npy"))
        lesson_result.prepare(name)
        with self.area():
            lesson_result.lessons().render(picture)
        seen = lesson_result.pixels(picture)
        if not painted:
            np.testing.assert_allclose(seen, lesson_result.pixels(of_script), atol=2.0 / 255.0)
        of_page = lesson_result.ROOT / "docs" / "pictures" / "lessons" / f"{name}.jpg"
        before, after = (lesson_result.pixels(of_page, half) for half in (0, 1))
        changed = np.abs(after - before).max(axis=2) > 0.02
        self.assertLess(np.abs(seen - after)[changed].mean(),
                        (PAINTED if painted else PAGE) * np.abs(seen - before)[changed].mean())

    @staticmethod
    def settings(found: dict[str, object]) -> dict[str, object]:
        return {name: value for name, value in found.items() if not name.startswith((*BY_HAND, "mode"))}

    # ---- the lessons
    def test_a_word_is_found_where_it_stands_and_no_other(self) -> Iterator[float]:
        yield 0.3
        self.assertEqual([len(self.places(word)) for word in ("Help", "Helm", "Hel", "Render", "Reader")],
                         [1, 0, 0, 1, 0])

    def test_first_wrinkles(self) -> Iterator[float]:
        yield from self.begin(SHIRT, CHEST)
        yield from self.play_to(4)
        yield from self.modifier_tab()
        yield from self.button("Remove")
        self.assertIsNone(modifier.find(bpy.context.object))
        yield from self.add("Wrinkle Mesh")
        for fabrics in ("Cotton > Wool", "Wool > Cotton"):
            yield from self.choose(fabrics, "PROPERTIES")
        yield from self.enter("Wavelength", "3 cm")
        yield from self.enter("Drape", "0.8")
        yield from self.maximise("PROPERTIES")
        yield from self.go_to_frame(30)
        yield from self.play_to(36)
        self.screenshot("lesson_first_wrinkles")
        yield from self.check("first_wrinkles", bpy.context.object)

    @long_one
    def test_skirt(self) -> Iterator[float]:
        yield from self.begin(SKIRT, (0.0, -0.27, 0.6))
        yield from self.play_to(4)
        yield from self.modifier_tab()
        yield from self.add("Wrinkle Mesh")
        yield from self.button("Body")
        yield from self.see("Mannequin", "PROPERTIES")
        yield from self.scroll_to("Thickness")
        yield from self.button("Cloth")
        yield from self.scroll_to("Layers")
        yield from self.pick("Base Cloth", "Swing")
        for label in ("Wavelength", "Room", "Free Room", "Hangs Free"):
            yield from self.scroll_to(label)
        for label, value in (("Slack", "1.08"), ("Bending Length", "3 cm"), ("Locomotion", "1"),
                             ("Swing Damping", "2")):
            yield from self.enter(label, value)
        self.screenshot("lesson_skirt_panel")
        yield from self.maximise("PROPERTIES")
        yield from self.go_to_frame(1)
        yield from self.play_to(42)
        self.screenshot("lesson_skirt")
        yield from self.check("skirt", bpy.context.object)

    @long_one
    def test_painting(self) -> Iterator[float]:
        yield from self.begin(SHIRT, CHEST)
        obj = bpy.context.object
        yield from self.press("NUMPAD_PERIOD")
        yield from self.modifier_tab()
        yield from self.paint_sleeve(obj, "Drape")
        yield from self.button("Remove")
        yield from self.add("Wrinkle Field")
        yield from self.pick("Output", "Geometry")
        yield from self.enter("Wavelength", "3 cm")
        yield from self.button("Waves")
        yield from self.enter("Irregularity", "0.4")
        for button in ("Rest Wrinkles", "Scatter", "Clear", "Paint Rest Wrinkles"):
            yield from self.button(button)
        yield from self.see_all("Depth", "Mirror X")
        for way in ("Across", "Along"):
            yield from self.pick("Folds Run", way)
        yield from self.maximise("PROPERTIES")
        for x in (-0.1, -0.05, 0.0, 0.05, 0.1):
            ends = [Vector(self.seen_at(Vector((x, -0.12, z)))) for z in (1.42, 1.1)]
            yield from self.stroke([tuple(int(c) for c in ends[0].lerp(ends[1], step / 8)) for step in range(9)])
        yield from self.maximise("PROPERTIES")
        yield from self.paint_sleeve(obj, "Mask")
        yield from self.maximise("PROPERTIES")
        yield from self.go_to_frame(1)
        yield from self.play_to(2)
        self.screenshot("lesson_painting")
        amplitude, places = sleeve.attribute(obj, "rumple_amplitude")[:, 0], sleeve.shown(obj)
        chest = (np.abs(places[:, 0]) < 0.05) & (places[:, 1] < -0.05) & (places[:, 2] > 1.3)
        self.assertGreater(amplitude[chest].mean(), 1e-3)
        yield from self.check("painting", obj, painted=True)

    def paint_sleeve(self, obj: bpy.types.Object, name: str) -> Iterator[float]:
        """From the maximised editor: press the brush beside a name, paint the right sleeve, press it again."""
        yield from self.brush(name)
        self.assertEqual(obj.mode, "WEIGHT_PAINT")
        yield from self.maximise("PROPERTIES")
        yield from self.see("Weight Paint", "VIEW_3D")
        rest = np.array([vertex.co for vertex in obj.data.vertices])
        posed = sleeve.attribute(obj, wrinkle_tree.BASE_POSITION)[:len(rest)]
        middles = [posed[(rest[:, 0] < x) & (rest[:, 0] > x - 0.06)].mean(axis=0)
                   for x in np.linspace(-0.22, rest[:, 0].min() + 0.07, 8)]
        places = [self.seen_at(Vector(middle)) for middle in middles]
        right = (rest[:, 0] < -0.25) & (posed[:, 1] < np.median(posed[rest[:, 0] < -0.25, 1]))  # and in front
        for _ in range(STROKES):
            yield from self.stroke(places + places[::-1])
            yield 0.3
            if np.median(self.weights(obj, name)[right]) < 0.2:
                break
        self.screenshot(f"lesson_painting_{name.lower()}")
        yield from self.maximise("PROPERTIES")
        yield from self.brush(name)
        self.assertEqual(obj.mode, "OBJECT")
        self.assertLess(np.median(self.weights(obj, name)[right]), 0.2)
        self.assertGreater(self.weights(obj, name)[rest[:, 0] > -0.1].min(), 0.99)

    @staticmethod
    def weights(obj: bpy.types.Object, name: str) -> np.ndarray:
        """(n,) of a map that every vertex has."""
        index = obj.vertex_groups[f"Rumple {name}"].index
        return np.array([group.weight for vertex in obj.data.vertices for group in vertex.groups
                         if group.group == index])

    @long_one
    def test_face(self) -> Iterator[float]:
        yield from self.begin(FACE, (0.0, -0.1, 1.66))
        obj = bpy.context.object
        yield from self.modifier_tab()
        yield from self.add("Wrinkle Maps")
        yield from self.maximise("PROPERTIES")
        yield from self.pose_mode()
        yield from self.press("N")
        box = yield from self.see_tab("Rumple", "VIEW_3D")
        yield from self.click(box.middle)
        yield 0.3
        yield from self.bones("LR")
        yield from self.pull("Z", "0.012")
        yield from self.add_pose(obj, "Surprise")
        yield from self.move(self.seen_at(Vector((0.0, -0.1, 1.60))))
        yield from self.press("G", alt=True)
        yield from self.pull("Z", "-0.005")
        for side, way in (("L", "-0.01"), ("R", "0.01")):
            yield from self.bones(side)
            yield from self.pull("X", way)
        yield from self.add_pose(obj, "Frown")
        yield from self.choose("Pose Mode > Object Mode", "VIEW_3D")
        yield from self.select(FACE, (0.0, -0.1, 1.66))
        yield from self.modifier_tab()
        yield from self.bake_maps(obj)
        yield from self.maximise("PROPERTIES")
        yield from self.pose_mode()
        yield from self.bones("LR")
        yield from self.press("G", alt=True)
        yield from self.pull("Z", "0.012")
        self.screenshot("lesson_face")
        yield from self.check("face", obj)

    def bake_maps(self, obj: bpy.types.Object) -> Iterator[float]:
        """What the lesson does in the panel of the maps, after the poses."""
        yield from self.button("Bake Maps")
        yield from self.scroll_to("Size")
        yield from self.button("All Poses")
        yield from self.until(lambda: all(pose.image is not None for pose in obj.rumple_maps.poses), 60.0)
        yield from self.scroll_to("Shading")
        yield from self.button("Show in Materials")
        yield from self.enter("Gain", "2")
        self.screenshot("lesson_face_panel")

    def pose_mode(self) -> Iterator[float]:
        yield from self.select("Face Rig", bpy.data.objects["Face Rig"].pose.bones["brow.L"].tail)
        yield from self.choose("Object Mode > Pose Mode", "VIEW_3D")
        yield from self.move(self.box("VIEW_3D").middle)

    def bones(self, sides: str) -> Iterator[float]:
        """Click on brows."""
        rig = bpy.data.objects["Face Rig"]
        for number, side in enumerate(sides):
            yield from self.click(self.seen_at(rig.pose.bones[f"brow.{side}"].tail), shift=number > 0)
        selected = {bone.name for bone in bpy.context.selected_pose_bones or ()}
        self.assertEqual(selected, {f"brow.{side}" for side in sides})

    def pull(self, axis: str, metres: str) -> Iterator[float]:
        for key in ("G", axis):
            yield from self.press(key)
        yield from self.type(metres)
        yield from self.press("RET")

    def add_pose(self, obj: bpy.types.Object, name: str) -> Iterator[float]:
        """Ctrl and a click name it as a double click does, which cannot be simulated."""
        yield from self.choose("Add Reference Pose", "VIEW_3D")
        box = yield from self.see("Pose", "VIEW_3D", 1)  # below that of the header
        yield from self.click(box.middle, ctrl=True)
        yield from self.type(name)
        yield from self.press("RET")
        self.assertIn(name, obj.rumple_maps.poses)

    @long_one
    def test_bake(self) -> Iterator[float]:
        view = bpy.context.preferences.view
        former, view.filebrowser_display_type = view.filebrowser_display_type, "SCREEN"
        self.addCleanup(setattr, view, "filebrowser_display_type", former)
        yield from self.begin(SHIRT, CHEST)
        obj = bpy.context.object
        yield from self.press("S", ctrl=True)
        yield from self.until(lambda: any(area.type == "FILE_BROWSER" for area in self.window.screen.areas))
        yield 0.5
        yield from self.press("RET")
        yield from self.until(lambda: bpy.data.filepath)
        self.assertNotEqual(bpy.data.filepath, "")
        yield from self.modifier_tab()
        yield from self.button("Bake")
        yield from self.button("Scene Range")
        self.assertFalse(obj.rumple.bake_scene_range)
        yield from self.enter("Start", "20")
        yield from self.enter("End", "40")
        yield from self.scroll_to("Bake to Shape Keys")
        yield from self.button("Bake", 1)
        yield from self.until(lambda: modifier.plays_clip(modifier.find(obj)), 120.0)
        yield from self.scroll_to("Baked 20\u201340")
        yield from self.button("Free Bake")
        self.assertFalse(modifier.is_baked(modifier.find(obj)))
        yield from self.button("Bake", 1)
        yield from self.until(lambda: modifier.plays_clip(modifier.find(obj)), 120.0)
        self.screenshot("lesson_bake_panel")
        yield from self.maximise("PROPERTIES")
        yield from self.go_to_frame(40)
        yield from self.check("bake", obj)


if __name__ == "__main__":
    unittest.main()
