# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo, as a visitor has it: a figure whose feet stand while it crouches, dressed by one click for each garment."""
from __future__ import annotations

import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree
from rumple.blender import compat
from rumple.blender.objects import bodies
from support import sleeve

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
if str(SCRIPTS) not in sys.path:
    sys.path.insert(0, str(SCRIPTS))
CROUCH = 48
THROUGH = 0.002  # metres
MORE_CROSSINGS = 3.2  # times those of the base cloth: 181 and 59 pairs; before hems hung 189 and 75
MOST_THROUGH = 0.01  # share of the shown points; the bare trousers have 0.013 of theirs in the crouch


def crossings(garment: bpy.types.Object) -> int:
    """Pairs of shown polygons that pass through each other and share no corner."""
    mesh = garment.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    polygons = [tuple(polygon.vertices) for polygon in mesh.polygons]
    tree = BVHTree.FromPolygons(compat.positions(mesh).tolist(), polygons)
    return sum(a < b and set(polygons[a]).isdisjoint(polygons[b]) for a, b in tree.overlap(tree))


class Demo(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        import demo_scene
        build = demo_scene.demo_body.build_body
        with sleeve.context(), mock.patch.object(demo_scene.demo_body, "build_body", lambda _spacing: build(0.012)):
            demo_scene.build_demo_scene()
            demo_scene.add_wrinkles("MESH")

    def test_what_each_is_worn_over(self) -> None:
        self.assertEqual({body.name for body in bodies.of(bpy.data.objects["Trousers"])}, {"Mannequin"})
        self.assertEqual({body.name for body in bodies.of(bpy.data.objects["Shirt"])}, {"Mannequin", "Trousers"})

    def test_the_feet_stand(self) -> None:
        """Between the poses too: they went eight centimetres through the ground on the way down."""
        bones, places = bpy.data.objects["Skeleton"].pose.bones, []
        for frame in (1, 20, 28, 36, 42, 48, 66, 60):
            sleeve.at(frame)
            places.append([tuple(bones[f"foot.{side}"].head) for side in "LR"])
        self.assertLess(np.ptp(np.array(places), axis=0).max(), 0.001)
        self.assertLess(bones["hips"].head.z, bones["hips"].bone.head_local.z - 0.01)

    def test_no_skin_comes_through_the_trousers(self) -> None:
        sleeve.play(30, CROUCH)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        skin = BVHTree.FromObject(bpy.data.objects["Mannequin"], depsgraph)
        shown = compat.positions(bpy.data.objects["Trousers"].evaluated_get(depsgraph).data)
        deep = [(place - nearest).dot(normal) < -THROUGH
                for place, (nearest, normal, _, _) in ((p, skin.find_nearest(p)) for p in map(Vector, shown.tolist()))]
        self.assertLess(np.mean(deep), MOST_THROUGH)

    def test_folds_add_few_crossings_in_the_hollows_of_the_knees(self) -> None:
        """The base cloth crosses itself there. Folds over a crossing were free along it, and multiplied it."""
        trousers = bpy.data.objects["Trousers"]
        sleeve.play(30, 44)
        with_folds = []
        for frame in range(45, 52):
            sleeve.at(frame)
            with_folds.append(crossings(trousers))
        settings = trousers.rumple.mesh
        for layer in ("drape", "folds", "detail"):
            setattr(settings, layer, 0.0)
        of_cloth = []
        for frame in range(45, 52):
            sleeve.at(frame)
            of_cloth.append(crossings(trousers))
        for layer in ("drape", "folds", "detail"):
            settings.property_unset(layer)
        self.assertGreater(sum(of_cloth), 10, "nothing crosses: the law says nothing")
        self.assertLess(sum(with_folds), MORE_CROSSINGS * sum(of_cloth))


class Run(unittest.TestCase):

    def test_the_frames_that_are_asked_for(self) -> None:
        """1-400 was cut without a word, "12" and "-5-20" ended in a traceback, and wrinkled.blend had another Start."""
        import demo_run
        seen, said, rendered = [], mock.Mock(), []
        nothing = {name: mock.DEFAULT for name in ("find_garments", "add_wrinkles", "studio", "render",
                                                   "render_sheet", "render_clip")}

        def play(_garment: object, frames: range) -> mock.Mock:
            seen.append((bpy.context.scene.frame_start, frames))
            rendered.append((str(demo_run.render.mock_calls[-1].args[0])[-18:], bpy.context.scene.frame_current))
            return mock.MagicMock()
        with tempfile.TemporaryDirectory() as folder, mock.patch.multiple(demo_run, **nothing), \
                mock.patch.object(demo_run, "play", play), mock.patch.object(demo_run, "say", said), \
                mock.patch.object(demo_run.rumple, "register"):
            for text in ("12", "-5-20", "7-400"):
                sleeve.empty_file()
                with mock.patch.object(sys, "argv", ["--", "--out", folder, "--frames", text]):
                    demo_run.main()
                bpy.ops.wm.open_mainfile(filepath=f"{folder}/wrinkled.blend")
                self.assertEqual(bpy.context.scene.frame_start, 1)
        # Blender has no Start below 0.
        self.assertEqual(seen, [(12, range(12, 13)), (0, range(-5, 21)), (7, range(7, 257))])
        # One picture, before any frame is played: what scripts/demo says the time of.
        self.assertEqual(rendered, [("/first_picture.png", frame) for frame in (12, 8, 132)])
        self.assertIn("of the frames 7-400 the first 250 are shown", str(said.mock_calls))


if __name__ == "__main__":
    unittest.main()
