# SPDX-License-Identifier: GPL-3.0-or-later
"""What of the mesh is baked: its UV maps, its shading, its fold guides, what renders show of it."""
from __future__ import annotations

import contextlib
import io
import unittest
from typing import Any, Callable
from unittest import mock

import bpy
import numpy as np
import test_guides
from rumple.blender import compat
from rumple.blender.maps import bake
from support import face, sleeve
from test_maps_bake import everything, texels

SIZE = 64


def baked(obj: bpy.types.Object) -> np.ndarray:
    obj.rumple_maps.bake_size = SIZE
    assert bpy.ops.rumple.maps_bake() == {"FINISHED"}
    return texels(obj.rumple_maps.poses[obj.rumple_maps.active].image)


def centre(image: np.ndarray) -> tuple[float, float]:
    """Where the wrinkles are, in UV space."""
    lean = (np.abs(image[:, :, :2] - 0.5) ** 2).max(2)
    places = (np.arange(SIZE) + 0.5) / SIZE
    return float((lean * places[None, :]).sum() / lean.sum()), float((lean * places[:, None]).sum() / lean.sum())


class UvMaps(unittest.TestCase):
    """The map was baked to the UV map that was active in the mesh's panel, whatever the material reads."""

    def setUp(self) -> None:
        self.obj, self.rig = face.scene()
        face.pose(self.rig, brow_L=-0.012)
        bpy.ops.rumple.pose_add(name="Left")
        self.layers = self.obj.data.uv_layers
        first = compat.uv_values(self.layers["UVMap"])
        turned = self.layers.new(name="Turned")
        turned.data.foreach_set("uv", np.ascontiguousarray(1.0 - first).ravel())
        self.obj.rumple_maps.uv_map = "UVMap"
        self.place = np.array(centre(baked(self.obj)))
        self.assertGreater(np.abs(self.place - 0.5).max(), 0.1, "not a case of it")

    def check(self, turned: bool) -> None:
        np.testing.assert_allclose(centre(baked(self.obj)), 1.0 - self.place if turned else self.place, atol=0.05)

    def test_the_one_that_is_chosen_counts(self) -> None:
        for active in ("UVMap", "Turned"):
            for chosen in ("UVMap", "Turned"):
                self.layers.active, self.obj.rumple_maps.uv_map = self.layers[active], chosen
                self.check(chosen == "Turned")
                self.assertEqual(self.layers.active.name, active)

    def test_where_none_is_chosen_it_is_the_one_that_materials_read(self) -> None:
        self.obj.rumple_maps.uv_map = ""
        for active in ("UVMap", "Turned"):
            for read in ("UVMap", "Turned"):
                self.layers.active, self.layers[read].active_render = self.layers[active], True
                self.check(read == "Turned")

    def test_one_that_is_gone_is_named(self) -> None:
        former, before = self.obj.rumple_maps.poses[0].image, everything()
        self.layers["UVMap"].name = "Skin"
        with self.assertRaisesRegex(RuntimeError, 'Face: it has no UV map "UVMap": give it its name back'):
            baked(self.obj)
        self.assertEqual((self.obj.rumple_maps.poses[0].image, everything()), (former, before))


class Tiles(unittest.TestCase):
    """The baker fills one tile. Of faces outside of it there was no word, and a mesh in another tile got a flat map."""

    def setUp(self) -> None:
        self.obj, rig = face.scene()
        face.pose(rig, brow_L=-0.012)
        bpy.ops.rumple.pose_add(name="Left")
        self.layer = self.obj.data.uv_layers["UVMap"]
        self.uv = compat.uv_values(self.layer)

    def bake(self, uv: np.ndarray) -> tuple[np.ndarray, str]:
        """The map, and the warnings that a bake prints."""
        self.layer.data.foreach_set("uv", np.ascontiguousarray(uv, np.float32).ravel())
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            found = baked(self.obj)
        self.assertNotIn("Face bake", printed.getvalue())
        return found, "\n".join(line for line in printed.getvalue().splitlines() if line.startswith("Warning"))

    def test_a_mesh_that_is_whole_in_another_tile_gets_the_same_map(self) -> None:
        first, said = self.bake(self.uv)
        self.assertEqual(said, "")
        for tile in ((1.0, 0.0), (2.0, 1.0), (-1.0, 0.0)):
            moved, said = self.bake(self.uv + tile)
            self.assertEqual(said, "")
            np.testing.assert_allclose(moved, first, atol=0.02)
            np.testing.assert_allclose(compat.uv_values(self.layer), self.uv + np.float32(tile), atol=1e-6)

    def test_faces_outside_of_it_are_counted(self) -> None:
        rows = (np.arange(len(self.uv)) // 4 // (face.SIDE - 1))[:, None]
        _map, said = self.bake(np.where(rows < 2, self.uv + (1.0, 0.0), self.uv))
        self.assertEqual(said, f"Warning: Face: {2 * (face.SIDE - 1)} of its faces lie outside of the first tile (0 to "
                         "1) of the UV map \"UVMap\", so the maps do not have their folds: move them into it in the UV "
                         "Editor, and bake again")

    def test_what_is_said_of_a_copy_names_the_object(self) -> None:
        self.obj.rumple_maps.bake_source = "MESH"
        self.obj.scale.x = 2.0
        bpy.context.view_layer.update()
        self.assertRegex(self.bake(self.uv)[1], "Warning: Face: the scale of")


class FromAWrinkleMesh(unittest.TestCase):
    """The map had no fold of the guides, and the points of the viewport's mesh."""

    def setUp(self) -> None:
        self.obj = sleeve.scene(wrinkles=False)
        sleeve.make_active(self.obj)
        bpy.ops.rumple.maps_add()
        self.obj.rumple_maps.bake_source = "MESH"
        self.obj.rumple.mesh.density, self.obj.rumple.mesh.level, self.obj.rumple.mesh.display_steps = "LEVEL", 1, 2
        sleeve.at(sleeve.LAST)
        bpy.ops.rumple.pose_add(name="Bent")
        bpy.ops.object.rumple_add(method="MESH")
        sleeve.at(1)

    def baked(self) -> tuple[np.ndarray, int]:
        """The map, and how many points the wrinkled copy had."""
        counts, frozen = [], bake.MapBake._frozen

        def counting(*given: Any) -> bpy.types.Object:
            made = frozen(*given)
            counts.append(len(made.data.vertices))
            return made
        with mock.patch.object(bake.MapBake, "_frozen", counting):
            return baked(self.obj), max(counts)

    def test_guides_make_their_folds(self) -> None:
        bare, _ = self.baked()
        curve = test_guides.guided(self.obj)
        self.assertEqual(self.obj.children[:], (curve,))
        before = everything()
        guided, _ = self.baked()
        self.assertEqual(everything(), before)
        self.assertGreater(np.abs(guided - bare).max(), 0.1)
        bpy.ops.object.rumple_guide_remove()
        np.testing.assert_allclose(self.baked()[0], bare, atol=0.01)

    def test_it_is_the_mesh_that_renders_show(self) -> None:
        points = set()
        for steps in (0, 1, 2):
            self.obj.rumple.viewport_steps = steps
            points.add(self.baked()[1])
        sleeve.at(1)  # where the last one shows the same in viewports
        self.assertEqual(points, {len(sleeve.shown(self.obj))})
        self.assertEqual(self.obj.rumple.viewport_steps, 2)


class Shading(unittest.TestCase):
    """Facets of the mesh were baked as folds, because the wrinkled copy alone was shaded smooth."""

    def check(self, change: Callable[[bpy.types.Mesh], None]) -> None:
        obj = sleeve.scene(wrinkles=False)
        sleeve.make_active(obj)
        bpy.ops.rumple.maps_add()
        obj.rumple_maps.bake_source = "FIELD"
        sleeve.at(sleeve.LAST)
        bpy.ops.rumple.pose_add(name="Bent")
        smooth = baked(obj)
        change(obj.data)
        obj.data.update()
        np.testing.assert_allclose(baked(obj), smooth, atol=0.01)

    def test_flat_faces(self) -> None:
        self.check(lambda mesh: mesh.polygons.foreach_set("use_smooth", np.zeros(len(mesh.polygons), bool)))

    def test_sharp_edges(self) -> None:
        def sharpen(mesh: bpy.types.Mesh) -> None:
            mesh.edges.foreach_set("use_edge_sharp", np.ones(len(mesh.edges), bool))
            if compat.HAS_AUTO_SMOOTH:
                mesh.use_auto_smooth = True
        self.check(sharpen)

    def test_custom_normals(self) -> None:
        def lean(mesh: bpy.types.Mesh) -> None:
            if compat.HAS_AUTO_SMOOTH:
                mesh.use_auto_smooth = True
            mesh.normals_split_custom_set_from_vertices(np.tile((0.6, 0.0, 0.8), (len(mesh.vertices), 1)))
        self.check(lean)
