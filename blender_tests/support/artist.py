# SPDX-License-Identifier: GPL-3.0-or-later
"""Somebody who follows a text in Blender's window: reads what stands there, and has mouse and keys and nothing else.

Where a word stands is found in the picture of the window (reader.py). Tests look into Blender's data only to see what
came of it, and to know when it has come.
"""
from __future__ import annotations

from typing import Generator, Iterator

import bpy
from bpy_extras import view3d_utils
from mathutils import Vector
from support import reader
from support.reader import Box
from support.window_case import WindowCase

KEYS = {"0": "ZERO", "1": "ONE", "2": "TWO", "3": "THREE", "4": "FOUR", "5": "FIVE", "6": "SIX", "7": "SEVEN",
        "8": "EIGHT", "9": "NINE", ".": "PERIOD", "-": "MINUS", " ": "SPACE"}
HELD = {"shift": "LEFT_SHIFT", "ctrl": "LEFT_CTRL", "alt": "LEFT_ALT"}
TAB = 12  # pixels from one try to the next in a column of tabs
NOTCHES = 4  # of the wheel at once
PANES = 25  # turns of it, at most


class Artist(WindowCase):
    """Mouse, keys and eyes."""

    def setUp(self) -> None:
        bpy.context.preferences.view.show_tooltips = False  # they hide words below the mouse, some time after it came
        self.here = (400, 300)
        self.read: set[str] = set()

    # ---- the hand
    @property
    def window(self) -> bpy.types.Window:
        return bpy.context.window_manager.windows[0]

    def event(self, kind: str, value: str, **keys: object) -> None:
        self.window.event_simulate(kind, value, x=self.here[0], y=self.here[1], **keys)

    def move(self, place: tuple[int, int], **keys: bool) -> Iterator[float]:
        """Two steps: what opens under the mouse wants it to come from somewhere."""
        before = self.here
        for self.here in (tuple((a + 3 * b) // 4 for a, b in zip(before, place)), place):
            self.event("MOUSEMOVE", "NOTHING", **keys)
            yield 0.02

    def click(self, place: tuple[int, int], **keys: bool) -> Iterator[float]:
        yield from self.move(place, **keys)
        yield from self.press("LEFTMOUSE", **keys)

    def press(self, key: str, **keys: bool) -> Iterator[float]:
        """A key, or a button of the mouse. What was held with it is let go, too: Blender takes a drag of the mouse to
        be with the modifiers of the last key, and once the drag of a tool after Ctrl Space did nothing."""
        for value in ("PRESS", "RELEASE"):
            self.event(key, value, **keys)
            yield 0.03
        for name in filter(keys.get, keys):
            self.event(HELD[name], "RELEASE")
        yield 0.1

    def type(self, text: str) -> Iterator[float]:
        for letter in text:
            key = KEYS.get(letter, letter.upper())
            self.event(key, "PRESS", unicode=letter, shift=letter.isupper())
            self.event(key, "RELEASE")
            yield 0.01

    def stroke(self, places: list[tuple[int, int]], **keys: bool) -> Iterator[float]:
        """The button held down along these."""
        yield from self.move(places[0], **keys)
        self.event("LEFTMOUSE", "PRESS", **keys)
        yield 0.02
        for self.here in places[1:]:
            self.event("MOUSEMOVE", "NOTHING", **keys)
            yield 0.02
        self.event("LEFTMOUSE", "RELEASE", **keys)
        yield 0.1

    # ---- the eyes
    def box(self, editor: str) -> Box:
        """Where an editor stands; WINDOW: everything."""
        if editor == "WINDOW":
            return Box(0, 0, self.window.width, self.window.height)
        area = self.editor(editor)
        return Box(area.x, area.y, area.x + area.width, area.y + area.height)

    def editor(self, kind: str) -> bpy.types.Area:
        return max((area for area in self.window.screen.areas if area.type == kind), key=lambda a: a.width * a.height)

    def region(self, editor: str, kind: str = "WINDOW") -> bpy.types.Region:
        return next(region for region in self.editor(editor).regions if region.type == kind)

    def places(self, words: str, editor: str = "WINDOW", alone: bool = True) -> list[Box]:
        return reader.find(self.pixels(), words, self.box(editor), alone=alone)

    def see(self, words: str, editor: str = "WINDOW", which: int = 0,
            seconds: float = 4.0) -> Generator[float, None, Box]:
        """Where words stand, as soon as they do; which of them, from above."""
        self.read.add(words)
        found: list[Box] = []

        def look() -> bool:
            """The same twice: what moves is not there yet."""
            before, found[:] = list(found), self.places(words, editor)
            return len(found) > max(which, 0) and found == before

        yield 0.05
        yield from self.until(look, seconds)
        if len(found) <= max(which, 0):
            self.fail(f"\"{words}\" stands nowhere in {editor}: {self.screenshot('not_found')}")
        return found[which]

    def see_tab(self, words: str, editor: str) -> Generator[float, None, Box]:
        """The same of what is written upwards, beside an editor."""
        self.read.add(words)
        found: list[Box] = []

        def look() -> bool:
            found[:] = reader.find(self.pixels(), words, self.box(editor), upwards=True)
            return bool(found)

        yield from self.until(look, 4.0)
        if not found:
            self.fail(f"no tab \"{words}\" in {editor}: {self.screenshot('not_found')}")
        return found[0]

    def choose(self, path: str, editor: str = "WINDOW", which: int = 0) -> Iterator[float]:
        """Click on the first word where it stands, on the others as menus open."""
        for number, words in enumerate(path.split(" > ")):
            box = yield from self.see(words, "WINDOW" if number else editor, 0 if number else which)
            yield from self.click(box.middle)
            yield 0.15

    def scroll_to(self, words: str, which: int = 0) -> Generator[float, None, Box]:
        """The same in the Properties editor: from the top, by the wheel, until as many stand there."""
        yield 0.1
        if len(self.places(words, "PROPERTIES")) <= which:
            yield from self.move(self.box("PROPERTIES").middle)
            yield from self.wheel("WHEELUPMOUSE", 100)
            for _ in range(PANES):
                if len(self.places(words, "PROPERTIES")) > which:
                    break
                yield from self.wheel("WHEELDOWNMOUSE", NOTCHES)
        return (yield from self.see(words, "PROPERTIES", which, 1.0))

    def wheel(self, kind: str, notches: int) -> Iterator[float]:
        for _ in range(notches):
            self.event(kind, "PRESS")
        yield 0.15

    # ---- what everybody knows of Blender
    def maximise(self, editor: str) -> Iterator[float]:
        """Ctrl Space over an editor; again: back."""
        yield from self.move(self.box(editor).middle)
        yield from self.press("SPACE", ctrl=True)
        yield 0.3

    def modifier_tab(self) -> Iterator[float]:
        """The editor of the properties in full, and one tab after another until it is that of the modifiers."""
        yield from self.maximise("PROPERTIES")
        bar, space = self.region("PROPERTIES", "NAVIGATION_BAR"), self.editor("PROPERTIES").spaces.active
        for y in range(bar.y + bar.height - TAB, bar.y, -TAB):
            if space.context == "MODIFIER":
                return
            yield from self.click((bar.x + bar.width // 2, y))
        self.fail("no tab is that of the modifiers")

    def add(self, system: str) -> Iterator[float]:
        """Wrinkles, from the menu of the modifier tab."""
        box = yield from self.see("Add Modifier", "PROPERTIES")
        if bpy.app.version >= (4, 0, 0):
            yield from self.click(box.middle)
        yield from self.choose(f"Wrinkles > {system}")
        yield 0.3

    def button(self, words: str, which: int = 0) -> Iterator[float]:
        """Press a button of the Properties editor."""
        box = yield from self.scroll_to(words, which)
        yield from self.click(box.middle)
        yield 0.15

    def beside(self, label: str, above: str = "") -> Generator[float, None, tuple[int, int]]:
        """The middle of the field whose name stands left of it. above: what stands below it, where that name is not the
        only one."""
        box, region = (yield from self.scroll_to(above or label)), self.region("PROPERTIES")
        if above:
            self.read.add(label)
            box = [one for one in self.places(label, "PROPERTIES") if one.low > box.high][-1]
        return (box.right + region.x + region.width) // 2, box.middle[1]

    def enter(self, label: str, value: str) -> Iterator[float]:
        """Click on a number, and type another."""
        yield from self.click((yield from self.beside(label)))
        yield from self.type(value)
        yield from self.press("RET")
        yield 0.1

    def pick(self, label: str, choice: str, above: str = "") -> Iterator[float]:
        """Click on a menu that has a name, and choose from it."""
        yield from self.click((yield from self.beside(label, above)))
        box = yield from self.see(choice, "PROPERTIES", -1)
        yield from self.click(box.middle)
        yield 0.1

    def brush(self, label: str) -> Iterator[float]:
        """The small button at the right end of a row."""
        box, region = (yield from self.scroll_to(label)), self.region("PROPERTIES")
        yield from self.click((region.x + region.width - 30, box.middle[1]))
        yield 0.2

    def seen_at(self, place: Vector) -> tuple[int, int]:
        """The pixel of the window where the viewport shows a point of the world."""
        region, space = self.region("VIEW_3D"), self.editor("VIEW_3D").spaces.active
        at = view3d_utils.location_3d_to_region_2d(region, space.region_3d, place)
        return int(region.x + at.x), int(region.y + at.y)

    def go_to_frame(self, frame: int) -> Iterator[float]:
        """A click into the timeline's ruler."""
        region = self.region("DOPESHEET_EDITOR")
        x, _ = region.view2d.view_to_region(frame, 0.0, clip=False)
        yield from self.click((region.x + x, region.y + region.height - 8))
        yield from self.until(lambda: bpy.context.scene.frame_current == frame)
        self.assertEqual(bpy.context.scene.frame_current, frame)

    def play_to(self, frame: int) -> Iterator[float]:
        """Space, and Space again when it is there; a frame too far is gone back to: it is stored."""
        yield from self.move(self.box("VIEW_3D").middle)
        yield from self.press("SPACE")
        yield from self.until(lambda: bpy.context.scene.frame_current >= frame, 120.0)
        yield from self.press("SPACE")
        yield from self.until(lambda: not self.window.screen.is_animation_playing)
        while bpy.context.scene.frame_current > frame:
            yield from self.press("LEFT_ARROW")
        self.assertEqual(bpy.context.scene.frame_current, frame)
