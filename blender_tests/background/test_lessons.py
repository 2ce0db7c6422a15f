# SPDX-License-Identifier: GPL-3.0-or-later
"""The lessons of docs/lessons: what they name is there, what they do works, and what it leaves is seen in a render."""
from __future__ import annotations

import re
import tempfile
import unittest
from pathlib import Path
from typing import Any, Callable, Iterator
from unittest import mock

import bpy
import numpy as np
from rumple.blender import bake, brush, maps, ui
from rumple.blender.objects import modifier, runtimes
from support import sleeve
from support.lesson_result import ROOT, lessons, named, steps
from support.one_blender import in_one_blender

PAGES = {path.stem: path.read_text(encoding="utf-8") for path in sorted((ROOT / "docs" / "lessons").glob("*.md"))}
SIZE = 64


def rna_names(rna: Any) -> Iterator[str]:
    """The name of a type of Blender's, and of its properties and their choices."""
    yield rna.name
    for one in rna.properties:
        yield one.name
        if one.type == "ENUM":
            yield from (item.name for item in one.enum_items_static)


def own_groups(rna: Any) -> Iterator[Any]:
    """The types of what the add-on keeps with an object."""
    yield rna
    for one in rna.properties:
        kind = getattr(one, "fixed_type", None)
        if kind is not None and kind.identifier.startswith("RUMPLE"):
            yield from own_groups(kind)


def known_names() -> set[str]:
    """Every name that Blender or the add-on may show, and the texts that the panels give their buttons."""
    found = {"Wrinkle Mesh", "Wrinkle Field", "Wrinkle Paths", "Wrinkle Maps", "Shirt", "Skirt", "Face", "X"}
    for kind in (getattr(bpy.types, name) for name in dir(bpy.types)):
        if hasattr(kind, "bl_rna"):
            found.update(rna_names(kind.bl_rna), (getattr(kind, name, "") for name in ("bl_label", "bl_category")))
    for kind, name in ((bpy.types.Object, "rumple"), (bpy.types.Object, "rumple_maps"),
                       (bpy.types.Scene, "rumple_brush")):
        for rna in own_groups(kind.bl_rna.properties[name].fixed_type):
            found.update(rna_names(rna))
    for operators in (bpy.ops.object, bpy.ops.rumple):
        for name in dir(operators):
            found.update(rna_names(getattr(operators, name).get_rna_type()))
    for package in (ui, bake, brush, maps):
        for path in Path(package.__file__).parent.glob("*.py"):
            found.update(re.findall(r'text="([^"{}]+)"', path.read_text(encoding="utf-8")))
    return found


def coarse_body(run: Any) -> Callable[..., Any]:
    """The mannequin with a quarter of its vertices, which is made sooner; the face as it is."""
    build = run.demo_scene.demo_body.build_body
    return lambda spacing, *bottom: build(0.015 if spacing > run.lesson_scenes.FACE_SPACING else spacing, *bottom)


def picture(run: Any, name: str, folder: Path) -> np.ndarray:
    image = bpy.data.images.load(str(run.render(folder / f"{name}.png")))
    pixels = np.array(image.pixels[:], np.float32)
    bpy.data.images.remove(image)
    return pixels


class Names(unittest.TestCase):
    def test_what_a_lesson_names_is_there(self) -> None:
        known = known_names()
        for name, page in PAGES.items():
            if name == "index":
                continue
            words = named(steps(page))
            self.assertGreater(len(words), 5, name)
            missing = {word for word in words if word not in known and not re.fullmatch(r"Baked \d+–\d+", word)}
            self.assertEqual(missing, set(), name)

    def test_a_name_that_is_nowhere_is_missed(self) -> None:
        self.assertNotIn("Wrinkle Everything", known_names())
        self.assertEqual(named("Press **Add\n   Modifier > Wrinkles**, *not* this"), {"Add Modifier", "Wrinkles"})

    def test_each_lesson_ends_in_its_picture_and_has_a_scene(self) -> None:
        self.assertEqual(PAGES.keys() - {"index"}, lessons().LESSONS.keys())
        for name in lessons().LESSONS:
            self.assertIn(f"](../pictures/lessons/{name}.jpg)", PAGES[name])
            path = ROOT / "docs" / "pictures" / "lessons" / f"{name}.jpg"
            self.assertLess(path.stat().st_size, lessons().MOST_BYTES)


class Steps(unittest.TestCase):
    """A lesson takes up to a minute: one of them in each Blender, all in one. The first is followed in a window."""

    def follow(self, name: str) -> bpy.types.Object:
        """Does the lesson in a saved file, and sees that the last picture is another than without the wrinkles."""
        run = lessons()
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        sleeve.empty_file()
        bpy.ops.wm.save_as_mainfile(filepath=str(Path(folder.name) / "lesson.blend"))
        with mock.patch.object(run.demo_scene.demo_body, "build_body", coarse_body(run)):
            obj = run.follow(name)
        self.assertEqual(runtimes.message(obj), "")
        run.look(run.LESSONS[name], 4)
        render = bpy.context.scene.render
        render.resolution_x = render.resolution_y = SIZE
        off = [one for one in obj.modifiers if not one.show_render]
        after = picture(run, "after", Path(folder.name))
        run.bare(obj, False, off)
        before = picture(run, "before", Path(folder.name))
        changed = np.abs(after - before).reshape(-1, 4)[:, :3].max(axis=1) > 0.02
        self.assertGreater(changed.mean(), 0.01)
        run.bare(obj, True, off)
        return obj

    def test_skirt(self) -> None:
        """The hem is elsewhere than its animation, the waistband is not."""
        skirt = self.follow("skirt")
        runtime = runtimes.of(skirt)
        evaluator, animated = runtime.evaluator, runtime.inputs.positions
        cloth = evaluator.state_of(runtime.inputs.frame).cloth  # of the coarse mesh that stands for the skirt
        away = np.linalg.norm(cloth.positions - evaluator.coarse.positions(animated), axis=1)
        at_waist = evaluator.coarse.base_vertex < lessons().lesson_scenes.SKIRT_AROUND
        self.assertGreater(away.max(), 0.01)
        self.assertLess(away[at_waist].max(), 0.02)

    @in_one_blender
    def test_painting(self) -> None:
        """Folds stand down the chest, none on the sleeve that was painted away."""
        shirt = self.follow("painting")
        amplitude = sleeve.attribute(shirt, "rumple_amplitude")[:, 0]
        places = sleeve.shown(shirt)
        chest = (np.abs(places[:, 0]) < 0.05) & (places[:, 1] < -0.05) & (places[:, 2] > 1.3)
        self.assertGreater(amplitude[chest].mean(), 1e-3)
        self.assertLess(amplitude[places[:, 0] < -0.3].max(), 1e-4)

    @in_one_blender
    def test_face(self) -> None:
        face = self.follow("face")
        self.assertEqual([pose.name for pose in face.rumple_maps.poses], ["Surprise", "Frown"])
        self.assertAlmostEqual(face.rumple_maps.poses[0].present, 1.0, 3)
        self.assertTrue(all(pose.image is not None for pose in face.rumple_maps.poses))

    @in_one_blender
    def test_bake(self) -> None:
        shirt = self.follow("bake")
        self.assertTrue(modifier.plays_clip(modifier.find(shirt)))


if __name__ == "__main__":
    unittest.main()
