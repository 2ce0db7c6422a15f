# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on in Blender's language."""
from __future__ import annotations

import ast
import contextlib
import re
import unittest
from pathlib import Path
from typing import Any, Iterator
from unittest import mock

import blf
import bpy
from bl_ui.utils import PresetPanel
from rumple.blender import compat, translation, ui_base
from rumple.blender.objects import painted_maps, properties
from rumple.blender.ui import panels
from support import sentences, sleeve
from support.registered import own_classes, own_properties

CODES = {"en": ("en_US",), "de": ("de", "de_DE"), "fr": ("fr", "fr_FR"), "es": ("es",), "ja": ("ja", "ja_JP"),
         "zh": ("zh_CN", "zh_HANS")}
ADDON = Path(translation.__file__).resolve().parents[1]
TABLES = {path.stem: translation.read(path) for path in sorted(translation.FOLDER.glob("*.po"))}
_NOT_WORDS = re.compile(r"-?[XYZ]|[a-z_]+|")  # axes, and properties that nobody sees: their name is their identifier
VALUES = re.compile(r"\{\d\}")


def properties_shown() -> Iterator[Any]:
    for cls in own_classes(bpy.types.PropertyGroup):
        yield from own_properties(cls)
    for cls in own_classes(bpy.types.Operator):
        group, name = cls.bl_idname.split(".")
        yield from getattr(getattr(bpy.ops, group), name).get_rna_type().properties


def labels() -> set[str]:
    """Of all that is registered."""
    found = {cls.bl_label for base in (bpy.types.Operator, bpy.types.Panel, bpy.types.Menu)
             for cls in own_classes(base) if not issubclass(cls, PresetPanel)}  # has the name of the last preset
    for prop in properties_shown():
        found.add(prop.name)
        if prop.type == "ENUM" and prop.identifier != "rna_type":
            found |= {item.name for item in prop.enum_items}
    return {label for label in found if not _NOT_WORDS.fullmatch(label)} - {"RNA"}


def tooltips() -> set[str]:
    found = {cls.__doc__ or "" for cls in own_classes(bpy.types.Operator)}
    for prop in properties_shown():
        found.add(prop.description)
        if prop.type == "ENUM" and prop.identifier != "rna_type":
            found |= {item.description for item in prop.enum_items}
    return found


class Files(unittest.TestCase):
    def test_each_language_has_the_same_entries(self) -> None:
        self.assertEqual(list(TABLES), ["de", "es", "fr", "ja", "zh_HANS"])
        for language, table in TABLES.items():
            self.assertEqual(table.keys(), TABLES["de"].keys(), language)
            # Nothing of a file is left unread, as an entry in more than one line would be.
            text = (translation.FOLDER / f"{language}.po").read_text(encoding="utf-8")
            self.assertEqual(text.count("msgid "), len(table))

    def test_every_label_has_an_entry(self) -> None:
        self.assertGreater(len(labels()), 200)
        self.assertEqual(labels() - TABLES["de"].keys(), set())

    def test_every_tooltip_has_an_entry(self) -> None:
        """But those that nobody sees: of Blender's own, and of what presets and undo keep."""
        unseen = {"", "RNA type definition", "Name of the preset, used to make the path name",
                  "Take settings from text: what saved presets call",
                  "Settings as they were before that choice, for the next one to bring back"}
        self.assertGreater(len(tooltips()), 250)
        self.assertEqual(tooltips() - unseen - TABLES["de"].keys(), set())

    def test_a_tooltip_is_one_line_of_the_source(self) -> None:
        """Pythons differ in the blanks that a docstring keeps, and an entry has to be the same in all."""
        self.assertEqual({tip for tip in tooltips() if "\n " in tip}, set())

    def test_every_text_of_a_button_has_an_entry(self) -> None:
        texts = {node.value.value for file in (ADDON / "blender").rglob("*.py")
                 for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
                 if isinstance(node, ast.keyword) and node.arg == "text" and isinstance(node.value, ast.Constant)}
        self.assertGreater(len(texts), 15)
        self.assertEqual(texts - {""} - TABLES["de"].keys(), set())

    def test_every_entry_is_shown(self) -> None:
        """None is left of a text that has changed."""
        shown = sentences.of_sources(ADDON) | labels() | tooltips()
        self.assertEqual(TABLES["de"].keys() - shown, set())

    def test_values_are_those_of_the_english_text(self) -> None:
        for language, table in TABLES.items():
            for english, text in table.items():
                self.assertEqual(sorted(VALUES.findall(text)), sorted(VALUES.findall(english)), f"{language}: {text}")
                self.assertEqual(text, text.strip())
                self.assertTrue(text)


class InLanguage(unittest.TestCase):
    def setUp(self) -> None:
        self.speak("de")
        self.addCleanup(self.speak, "en")

    def speak(self, language: str) -> None:
        """Whatever this Blender calls it."""
        for code in CODES[language]:
            with contextlib.suppress(TypeError):
                bpy.context.preferences.view.language = code
        self.assertTrue((bpy.app.translations.locale or "en").startswith(language))


class InGerman(InLanguage):
    def test_labels_and_tooltips_come_from_the_table(self) -> None:
        words = bpy.app.translations
        self.assertEqual(words.pgettext_iface("Base Cloth"), "Grundstoff")
        self.assertEqual(words.pgettext_iface("Add Wrinkles", "Operator"), "Falten hinzufügen")
        self.assertEqual(words.pgettext_iface("Waves", translation.OWN_CONTEXT), "Wellen")
        self.assertIn("Falte zu Falte", words.pgettext_tip(properties.RUMPLE_MeshSettings.bl_rna.properties[
            "wavelength"].description))

    def test_messages_keep_their_values(self) -> None:
        self.assertEqual(
            translation.said("Shirt: frame 3 is outside the bake (10 to 20), so live folds are shown there"),
            "Shirt: Bild 3 liegt außerhalb des Gebackenen (10 bis 20), dort sind die Falten live")
        self.assertEqual(
            translation.said("Shirt: a-Shirt-1.pc2 is being baked by process 7 on n1, last heard of 3 s ago: wait for "
                             "it"),
            "Shirt: a-Shirt-1.pc2 wird gerade von process 7 on n1 gebacken, zuletzt vor 3 s gehört: darauf warten")
        self.assertEqual(translation.said("Body: nothing to wrinkle"), "Body: nichts, was Falten werfen kann")
        self.assertEqual(translation.said("A: B: nothing to wrinkle"), "A: B: nichts, was Falten werfen kann")
        self.assertEqual(translation.said("Choose a mesh object first"), "Erst ein Mesh-Objekt wählen")
        self.assertEqual(translation.said("Shirt: each of 12 edges (the first is edge 7-8) has more faces than two, or "
                                          "none that faces the same way: wrinkles end there"),
                         "Shirt: 12 Kanten (die erste ist 7-8) haben mehr als zwei Fl\u00e4chen oder keine, die gleich "
                         "herum zeigt: dort enden Falten")
        self.assertEqual(translation.said("Shirt: something new"), "Shirt: something new")
        self.assertEqual(translation.said(""), "")

    def test_the_reason_in_a_message_too(self) -> None:
        self.assertIn("Max. Punkte erhöhen", translation.said(
            "Shirt: finer folds are asked for than 250000 vertices allow: raise Most Vertices"))
        self.assertEqual(
            translation.said("Shirt: pose Smile cannot be baked: the disk of /clips is full: make room, or choose "
                             "another folder"),
            "Shirt: Pose Smile kann nicht gebacken werden: die Platte von /clips ist voll: Platz schaffen oder einen "
            "anderen Ordner wählen")

    def test_every_template_is_found_by_what_it_makes(self) -> None:
        made = 0
        for template, german in TABLES["de"].items():
            numbers = sorted(set(VALUES.findall(template)))
            if numbers and not template.endswith(f"{numbers[-1]}{numbers[-2:][0]}"):
                values = [f"v{number[1]}" for number in numbers]
                if "{1}{2}" in template:
                    values = [values[0], "", values[2]]
                self.assertEqual(translation.said(template.format(*values)), german.format(*values))
                made += 1
        self.assertGreater(made, 40)

    def test_refusals_and_reports_are_in_german(self) -> None:
        obj = sleeve.scene()
        with self.assertRaisesRegex(RuntimeError, "andere Objekte mit Falten-Mesh"):
            bpy.ops.object.rumple_copy_settings()
        self.assertTrue(obj.rumple.message == "")
        bpy.context.view_layer.objects.active = None
        with self.assertRaisesRegex(RuntimeError, "Erst ein Mesh-Objekt"):
            bpy.ops.object.rumple_apply()

    def test_the_tooltip_of_the_menu(self) -> None:
        tip = bpy.types.OBJECT_OT_rumple_add.description(bpy.context, mock.Mock(method="FIELD"))
        self.assertTrue(tip.startswith("Shading oder Geometrie: parallele Wellen"), tip)

    def test_status_lines(self) -> None:
        obj = sleeve.scene()
        sleeve.at(2)
        lines = " ".join(translation.said(line) for line, _icon in panels.status_lines(obj))
        self.assertRegex(lines, r"\d Punkte werden gezeigt")
        self.assertIn("Millisekunden: ", lines)


class Widths(InLanguage):
    """No label is cut off in the properties editor at its default width. As Blender lays it out: 95 pixels, and
    102 since the panels are wider."""
    MOST = 95.0 if bpy.app.version < (4, 0, 0) else 102.0
    SHOWN_OTHERWISE = {"display_steps", "viewport_steps"}   # by another text

    def test_every_language(self) -> None:
        blf.size(0, 11)
        words = {prop.name for cls in own_classes(bpy.types.PropertyGroup) for prop in own_properties(cls)
                 if prop.type != "BOOLEAN" and not prop.is_hidden and not _NOT_WORDS.fullmatch(prop.name)
                 and prop.identifier not in self.SHOWN_OTHERWISE} | {"Smooth Viewport", "Render"}
        words |= set(painted_maps.LABELS.values())
        self.assertGreater(len(words), 90)
        for language in CODES:
            self.speak(language)
            shown = {word: bpy.app.translations.pgettext_iface(word) for word in words}
            self.assertGreater(sum(text != word for word, text in shown.items()), 80 if language != "en" else -1)
            wide = {text: blf.dimensions(0, text)[0] for text in shown.values()}
            self.assertEqual({text: pixels for text, pixels in wide.items() if pixels > self.MOST}, {}, language)


class Registering(unittest.TestCase):
    def test_again_and_gone(self) -> None:
        self.addCleanup(translation.register)
        translation.unregister()
        self.assertEqual(translation._templates, [])
        translation.register()
        self.assertGreater(len(translation._templates), 40)
        with self.assertRaises(ValueError):
            bpy.app.translations.register(translation.__name__, {})
        translation.unregister()
        bpy.app.translations.register(translation.__name__, {})     # nothing of that name is left
        bpy.app.translations.unregister(translation.__name__)


class Lines(unittest.TestCase):
    """Labels do not wrap by themselves, and Chinese and Japanese have no blanks to break at."""

    def lines(self, text: str, pixels: int) -> list[str]:
        context = mock.Mock()
        context.region.width, context.preferences.system.ui_scale = pixels, 1.0
        with mock.patch.object(ui_base.bpy, "context", context):
            return ui_base.wrapped(text)

    def test_nothing_is_lost_and_each_fits(self) -> None:
        width = 30
        for text in ("Shirt: nothing above it deforms the mesh, so it has no folds: put an Armature above it",
                     "Shirt: アーマチュアにポーズを付けて参照ポーズを追加してください。布は揺れずに垂れています",
                     "Shirt：跳转到帧 1200，布料只悬垂不摆动：请从帧 1 播放或烘焙，帧在烘焙范围之外"):
            lines = self.lines(text, int(width * ui_base.LETTER_PIXELS))
            self.assertGreater(len(lines), 1)
            self.assertEqual("".join(lines).replace(" ", ""), text.replace(" ", ""))
            for line in lines:
                self.assertLessEqual(ui_base.letters(line), width + 2, line)  # a full stop may hang
                self.assertNotRegex(line, "^[。、，：]")

    def test_a_header_that_is_too_long_is_cut_before_its_buttons(self) -> None:
        self.assertEqual(ui_base.shortened("Wrinkle Mesh", 12), "Wrinkle Mesh")
        self.assertEqual(ui_base.shortened("Wrinkle Mesh", 8), "Wrinkle\u2026")
        self.assertLessEqual(ui_base.letters(ui_base.shortened("\u3057\u308f\u30e1\u30c3\u30b7\u30e5", 7)), 7)
        self.assertEqual(ui_base.shortened("Wrinkle Mesh", -3), "")

    def test_a_word_that_is_too_long_has_a_line(self) -> None:
        self.assertEqual(self.lines("A " + 40 * "x" + " b", 200), ["A", 40 * "x", "b"])
        self.assertEqual(self.lines("", 200), [""])


class Without(unittest.TestCase):
    def test_english_is_as_it_was_written(self) -> None:
        with mock.patch.object(compat, "translated_report", side_effect=AssertionError):
            self.assertEqual(translation.said("Shirt: nothing to wrinkle"), "Shirt: nothing to wrinkle")
