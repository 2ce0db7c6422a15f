# SPDX-License-Identifier: GPL-3.0-or-later
"""What the CPU leaves out while all viewports draw the waves of a Wrinkle Field on the graphics card."""
from __future__ import annotations

from typing import Iterator

from rumple.blender.objects import output_mesh, runtimes
from rumple.core.systems.wrinkle_field import WrinkleField
from support import sleeve
from support.preview_case import PreviewCase


class Waiting(PreviewCase):

    def test_a_frame_is_not_solved_on_both_sides(self) -> Iterator[float]:
        """While it plays only the first frame is solved on the CPU, and nothing is written to the output mesh. Renders,
        other shadings and jumps have the bits of a garment that was never previewed."""
        yield from self.make(gpu_preview=False)
        expected = {}
        for frame in range(1, sleeve.LAST + 1):
            sleeve.at(frame)
            expected[frame] = sleeve.picture(self.obj)
        yield from self.make()
        evaluator = runtimes.of(self.obj).evaluator
        evaluator.frame_cache.clear()
        solved, written = [], []
        self.watch(WrinkleField, "_solve", solved)
        self.watch(output_mesh, "write_result", written)
        sleeve.at(1)
        self.area.tag_redraw()
        yield from self.until_drawn(1)
        self.assertEqual((len(solved), len(written)), (1, 0))
        for frame in range(2, sleeve.LAST + 1):
            sleeve.at(frame)
            self.area.tag_redraw()
            yield from self.until_drawn(frame)
        self.assertEqual((len(solved), len(written)), (1, 0))
        self.assertEqual(self.obj.rumple.message, "")
        self.area.spaces.active.shading.type = "WIREFRAME"
        yield from self.until(lambda: not runtimes.of(self.obj).inputs.for_preview)
        self.assertEqual(len(solved), sleeve.LAST)
        self.assertTrue(sleeve.picture(self.obj).shows_the_same(expected[sleeve.LAST]))
        self.area.spaces.active.shading.type = "SOLID"
        yield from self.until(lambda: runtimes.of(self.obj).inputs.for_preview)
        for frame in (5, 12, 2):
            sleeve.at(frame)
            self.area.tag_redraw()
            yield from self.until_drawn(frame)
            self.assertTrue(self.in_renders().shows_the_same(expected[frame]), frame)
        self.assertEqual(len(solved), sleeve.LAST)

    def test_what_reads_the_mesh_has_its_attributes(self) -> Iterator[float]:
        """Nodes behind the waves, a base cloth, a body: every frame is written as without the preview."""
        yield from self.make()
        self.assertTrue(runtimes.of(self.obj).inputs.for_preview)
        behind = self.obj.modifiers.new("Reads", "NODES")
        yield from self.until(lambda: not runtimes.of(self.obj).inputs.for_preview)
        sleeve.at(4)
        self.assertTrue(sleeve.picture(self.obj).shows_the_same(self.in_renders()))
        behind.show_viewport = False
        yield from self.until(lambda: runtimes.of(self.obj).inputs.for_preview)
        self.obj.rumple.field.base_cloth = "HANG"
        yield from self.until(lambda: not runtimes.of(self.obj).inputs.for_preview)
