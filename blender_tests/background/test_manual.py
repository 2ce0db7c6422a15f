# SPDX-License-Identifier: GPL-3.0-or-later
"""Right-click > Online Manual, and the button beside a message."""
from __future__ import annotations

import contextlib
import io
import tempfile
import unittest
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, Iterator
from unittest import mock

import bpy
from rumple.blender import manual
from rumple.core.settings import guide
from support.registered import own_classes, own_properties

_BY_HAND = {"name"}  # of every PropertyGroup: Blender's


def names() -> Iterator[str]:
    """Blender's names of all that a right-click may be on."""
    for cls in own_classes(bpy.types.Operator):
        yield f"bpy.ops.{cls.bl_idname}"
    for cls in own_classes(bpy.types.PropertyGroup):
        yield from (f"bpy.types.{cls.__name__}.{prop.identifier}" for prop in own_properties(cls)
                    if not prop.is_hidden and prop.identifier not in _BY_HAND)


class OnlineManual(unittest.TestCase):
    def setUp(self) -> None:
        folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        (folder / guide.PAGE).touch()
        self.enterContext(mock.patch.object(guide, "FOLDERS", (folder,)))

    def looked_up(self, name: str) -> str:
        """By Blender's own search."""
        with contextlib.redirect_stdout(io.StringIO()):
            return bpy.types.WM_OT_doc_view_manual._lookup_rna_url(name) or ""

    def test_every_setting_and_button_has_a_place_in_the_guide(self) -> None:
        anchors = {anchor for _pattern, anchor in guide.places()}
        found = list(names())
        self.assertGreater(len(found), 200)
        for name in found:
            page, _, anchor = self.looked_up(name).partition("#")
            self.assertEqual(page, guide.address(), name)
            self.assertIn(anchor, anchors, name)
        self.assertTrue(self.looked_up("bpy.types.RUMPLE_PathsSettings.mass").endswith("#swing"))
        self.assertTrue(self.looked_up("bpy.types.RUMPLE_PathsSettings.seed").endswith("#folds-and-persistence"))
        self.assertTrue(self.looked_up("bpy.ops.object.rumple_bake_free").endswith("#bake"))

    def test_every_place_is_of_something(self) -> None:
        lower = [name.lower() for name in names()]
        for pattern, _anchor in guide.places():
            self.assertTrue(any(fnmatchcase(name, pattern) for name in lower), pattern)

    def test_others_settings_are_not_ours(self) -> None:
        self.assertNotIn(guide.address(), self.looked_up("bpy.types.ClothSettings.mass"))

    def test_without_a_guide_nothing_is_promised(self) -> None:
        (guide.FOLDERS[0] / guide.PAGE).unlink()
        self.assertNotIn("rumple", self.looked_up("bpy.types.RUMPLE_Object.body"))


class More(unittest.TestCase):
    class Layout:
        def __init__(self) -> None:
            self.opened: list[Any] = []

        def operator(self, name: str, **_how: object) -> Any:
            self.opened.append(button := mock.Mock(spec=("url",)))
            button.operator = name
            return button

    def test_a_message_that_the_guide_explains_has_a_button(self) -> None:
        layout = self.Layout()
        with mock.patch.object(guide, "WEBSITE", "https://example.org"):
            manual.draw_more(layout, "Shirt: its scale is zero")
            manual.draw_more(layout, "Shirt: something new")
        self.assertEqual([(button.operator, button.url) for button in layout.opened], [
            ("wm.url_open", "https://example.org/user_guide.html#the-mesh-and-its-modifiers")])
