# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist does first, by mouse and keys in Blender's window."""
from __future__ import annotations

from typing import Any, Iterator
from unittest import mock

import bpy
from rumple.blender.objects import runtimes
from rumple.core.wrinkle_mesh import WrinkleMesh
from support import sleeve
from support.artist import Artist

PAUSE = 0.6  # seconds: longer than a rebuild is put off after a change


class Hand(Artist):
    """A sleeve, and the modifier tab in full."""

    def begin(self, wrinkles: bool = True) -> Iterator[float]:
        """wrinkles: as the first click makes them."""
        sleeve.scene(wrinkles=False).rumple.mesh.property_unset("base_cloth")
        if wrinkles:
            with sleeve.context():
                bpy.ops.object.rumple_add(method="MESH")
                bpy.ops.ed.undo_push(message="begun")
        sleeve.at(10)
        yield 0.5

    @property
    def obj(self) -> bpy.types.Object:
        """Looked up each time: undo makes another one."""
        return bpy.data.objects["Sleeve"]

    def drag(self, places: list[tuple[int, int]], pause: float = PAUSE) -> Iterator[float]:
        """Press, along these with a pause at the last, and no release yet."""
        yield from self.move(places[0])
        self.event("LEFTMOUSE", "PRESS")
        yield 0.05
        for self.here in places[1:]:
            self.event("MOUSEMOVE", "NOTHING")
            yield 0.05
        yield pause

    def let_go(self) -> Iterator[float]:
        self.event("LEFTMOUSE", "RELEASE")
        yield 0.1


class Drag(Hand):
    """The first drag of Wavelength froze Blender for two minutes."""

    def watch_builds(self) -> list[float]:
        """The wavelengths for which fine meshes are made from now on."""
        builds, plain = [], WrinkleMesh.build

        def build(base: Any, settings: Any, **more: Any) -> WrinkleMesh:
            builds.append(settings.wavelength)
            return plain(base, settings, **more)

        patch = mock.patch.object(WrinkleMesh, "build", build)
        patch.start()
        self.addCleanup(patch.stop)
        return builds

    def along(self, label: str, pixels: int) -> Iterator[Any]:
        """Places on a slider, from its middle to so many pixels right of it."""
        x, y = yield from self.beside(label)
        return [(x + round(pixels * step / 6), y) for step in range(7)]

    def test_a_fine_mesh_waits_for_the_release(self) -> Iterator[float]:
        yield from self.begin()
        yield from self.modifier_tab()
        builds, before = self.watch_builds(), self.obj.rumple.mesh.wavelength
        places = yield from self.along("Wavelength", 24)
        yield from self.drag(places)
        held = self.obj.rumple.mesh.wavelength
        self.assertNotAlmostEqual(held, before, 4)
        self.assertLess(abs(held - before), 0.02 * before * 24)  # 24 pixels
        self.assertEqual(builds, [])
        yield PAUSE
        self.assertEqual(builds, [])
        yield from self.let_go()
        yield from self.until(lambda: builds and not runtimes.of(self.obj).stale)
        self.assertEqual(len(builds), 1)
        self.assertAlmostEqual(builds[0], self.obj.rumple.mesh.wavelength, 6)
        self.assertEqual(self.obj.rumple.message, "")
        yield from self.maximise("PROPERTIES")

    def test_what_is_cheap_follows_while_it_is_dragged(self) -> Iterator[float]:
        yield from self.begin()
        yield from self.modifier_tab()
        builds, shown = self.watch_builds(), sleeve.attribute(self.obj, "rumple_offset").copy()
        places = yield from self.along("Folds", -40)
        yield from self.drag(places, 0.1)
        yield from self.until(lambda: abs(sleeve.attribute(self.obj, "rumple_offset") - shown).max() > 1e-5)
        self.assertGreater(abs(sleeve.attribute(self.obj, "rumple_offset") - shown).max(), 1e-5)
        yield from self.let_go()
        yield PAUSE
        self.assertEqual(builds, [])
        yield from self.maximise("PROPERTIES")

    def test_esc_while_dragging_leaves_value_and_folds(self) -> Iterator[float]:
        yield from self.begin()
        yield from self.modifier_tab()
        builds, before = self.watch_builds(), self.obj.rumple.mesh.wavelength
        places = yield from self.along("Wavelength", 24)
        yield from self.drag(places)
        yield from self.press("ESC")
        yield PAUSE
        yield from self.let_go()
        self.assertAlmostEqual(self.obj.rumple.mesh.wavelength, before, 7)
        self.assertEqual(builds, [])
        self.assertFalse(runtimes.of(self.obj).stale)
        yield from self.maximise("PROPERTIES")

    def test_a_typed_value_waits_for_no_mouse(self) -> Iterator[float]:
        yield from self.begin()
        yield from self.modifier_tab()
        builds = self.watch_builds()
        yield from self.enter("Wavelength", "5 cm")
        yield from self.until(lambda: builds)
        self.assertEqual([round(wavelength, 4) for wavelength in builds], [0.05])
        yield from self.maximise("PROPERTIES")
