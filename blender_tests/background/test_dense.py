# SPDX-License-Identifier: GPL-3.0-or-later
"""Garments that are modelled densely: solved on a coarse mesh, shown on their own, in every way that Blender asks."""
from __future__ import annotations

import unittest
from typing import Any, Iterator

import bmesh
import bpy
import numpy as np
from rumple.blender import scheduler
from rumple.blender.objects import properties, runtimes
from support import cloth_scenes, sleeve

LAST = 5


def dense(method: str = "MESH") -> bpy.types.Object:
    """A sleeve of 3,000 vertices over an arm, wrinkled by one click."""
    obj = sleeve.scene(wrinkles=False)
    body = sleeve.under(obj, radius=0.8)
    mesh = bmesh.new()
    mesh.from_mesh(obj.data)
    bmesh.ops.subdivide_edges(mesh, edges=mesh.edges, cuts=3, use_grid_fill=True)
    mesh.to_mesh(obj.data)
    mesh.free()
    for settings in (obj.rumple.mesh, obj.rumple.field, obj.rumple.paths):
        settings.property_unset("base_cloth")
    sleeve.make_active(obj)
    bpy.ops.object.rumple_add(method=method)
    bpy.context.view_layer.update()
    assert obj.rumple.body == body and properties.group_of(obj).base_cloth == "HANG"
    return obj


class Dense(cloth_scenes.Cloth):
    def setUp(self) -> None:
        self.obj = dense()

    def fine(self) -> Any:
        return runtimes.of(self.obj).evaluator

    def test_one_click_solves_it_on_a_coarse_mesh(self) -> None:
        self.assertEqual(self.obj.rumple.message, "")
        self.assertLess(self.fine().coarse.surface.vertex_count, 0.2 * len(self.obj.data.vertices))
        sleeve.play(LAST)
        bare = np.array([v.co for v in self.obj.data.vertices])
        self.assertGreaterEqual(len(sleeve.shown(self.obj)), len(bare))
        self.assertEqual(self.obj.rumple.message, "")

    def test_played_frames_look_the_same_in_any_order(self) -> None:
        seen = cloth_scenes.played(self.obj, LAST)
        self.same(seen, cloth_scenes.pictures(self.obj, (5, 1, LAST, 3)))

    def test_base_cloth_off_takes_its_own_vertices_and_the_way_back_is_exact(self) -> None:
        seen = cloth_scenes.played(self.obj, LAST)
        settings = self.obj.rumple.mesh
        settings.base_cloth = "OFF"
        scheduler.sync_all()
        self.assertIsNone(self.fine().coarse)
        cloth_scenes.played(self.obj, 2)
        self.assertEqual(self.obj.rumple.message, "")
        settings.base_cloth = "HANG"
        scheduler.sync_all()
        self.assertIsNotNone(self.fine().coarse)
        self.same(seen, cloth_scenes.played(self.obj, LAST))

    def test_paint_starts_with_a_value_for_every_vertex_and_pins_the_cloth(self) -> None:
        sleeve.play(LAST)
        free = np.linalg.norm(runtimes.of(self.obj).result.offset, axis=1)
        bpy.ops.object.rumple_paint(group="follow")
        bpy.ops.object.mode_set(mode="OBJECT")
        group = self.obj.vertex_groups["Rumple Follow"]
        weights = [next((g.weight for g in v.groups if g.group == group.index), None) for v in self.obj.data.vertices]
        self.assertTrue(all(weight is not None for weight in weights))
        group.add(range(len(weights)), 1.0, "REPLACE")
        self.obj.rumple.mesh.radius = 0.0
        scheduler.sync_all()
        sleeve.play(LAST)
        pinned = np.linalg.norm(runtimes.of(self.obj).result.offset, axis=1)
        self.assertLess(np.median(pinned), 0.1 * np.median(free))

    def test_it_stays_out_of_the_body(self) -> None:
        body = self.obj.rumple.body
        found = cloth_scenes.depths(self.obj, body, range(1, LAST + 1))
        self.check_no_deeper(found, cloth_scenes.depths(cloth_scenes.bared(self.obj), body, found))

    def test_saved_and_opened_again_it_looks_the_same(self) -> None:
        seen = cloth_scenes.played(self.obj, 4)
        path = self.saved()
        bpy.ops.wm.save_mainfile(filepath=path)
        bpy.ops.wm.open_mainfile(filepath=path)
        self.same(seen, cloth_scenes.played(bpy.data.objects["Sleeve"], 4))

    def test_another_garment_is_worn_over_it(self) -> None:
        coat = cloth_scenes.hang(sleeve.under(self.obj, "Coat", 1.1))
        coat.rumple.body = self.obj
        sleeve.play(4)
        self.assertEqual((self.obj.rumple.message, coat.rumple.message), ("", ""))


class WavesAndPaths(cloth_scenes.Cloth):
    """Their base cloth is solved on a coarse mesh, and they on all vertices."""

    def each(self) -> Iterator[tuple[bpy.types.Object, Any]]:
        for method in ("FIELD", "PATHS"):
            obj = dense(method)
            yield obj, properties.group_of(obj)

    def cloth(self, obj: bpy.types.Object) -> Any:
        runtime = runtimes.of(obj)
        return runtime.evaluator.state_of(runtime.inputs.frame).cloth

    def test_one_click_solves_their_cloth_on_a_coarse_mesh(self) -> None:
        for obj, _ in self.each():
            sleeve.play(LAST)
            cloth = self.cloth(obj)
            self.assertEqual(obj.rumple.message, "")
            self.assertLess(3 * len(cloth.solved), len(obj.data.vertices))
            self.assertEqual({len(cloth.positions), len(cloth.gap), len(cloth.body_hint)}, {len(obj.data.vertices)})

    def test_they_stay_out_of_the_body(self) -> None:
        for obj, settings in self.each():
            body = obj.rumple.body
            found = cloth_scenes.depths(obj, body, range(1, LAST + 1))
            settings.base_cloth, obj.rumple.body = "OFF", None
            self.check_no_deeper(found, cloth_scenes.depths(obj, body, found))

    def test_played_saved_and_opened_they_look_the_same_in_any_order(self) -> None:
        for obj, _ in self.each():
            seen = cloth_scenes.played(obj, LAST)
            self.same(seen, cloth_scenes.pictures(obj, (4, 1, LAST, 3)))
            path = self.saved()
            bpy.ops.wm.save_mainfile(filepath=path)
            bpy.ops.wm.open_mainfile(filepath=path)
            self.same(seen, cloth_scenes.played(bpy.data.objects["Sleeve"], LAST))

    def test_base_cloth_off_and_the_way_back_is_exact(self) -> None:
        for obj, settings in self.each():
            seen = cloth_scenes.played(obj, LAST)
            settings.base_cloth = "OFF"
            scheduler.sync_all()
            cloth_scenes.played(obj, 2)
            self.assertEqual((obj.rumple.message, self.cloth(obj).solved is None), ("", True))
            settings.base_cloth = "HANG"
            scheduler.sync_all()
            self.same(seen, cloth_scenes.played(obj, LAST))


class AsModelled(cloth_scenes.Cloth):
    """Subdivision and Triangulate, applied or live above the wrinkles: the cloth is that of the mesh before."""

    def wrinkled(self, kinds: tuple[str, ...], applied: bool) -> bpy.types.Object:
        """One click on a sleeve with these modifiers above its armature's."""
        obj = sleeve.scene(wrinkles=False)
        sleeve.under(obj, radius=0.8)
        sleeve.make_active(obj)
        for place, kind in enumerate(kinds):
            name = obj.modifiers.new(kind, kind).name
            bpy.ops.object.modifier_move_to_index(modifier=name, index=0 if applied else place)
            if applied:
                bpy.ops.object.modifier_apply(modifier=name)
        obj.rumple.mesh.property_unset("base_cloth")
        bpy.ops.object.rumple_add(method="MESH")
        bpy.context.view_layer.update()
        return obj

    def test_it_is_solved_on_the_mesh_before(self) -> None:
        once, twice, cut = ("SUBSURF",), ("SUBSURF", "SUBSURF"), ("TRIANGULATE",)
        for kinds, applied in ((once, True), (twice, False), (cut, True), (cut, False), (once + cut, True)):
            obj = self.wrinkled(kinds, applied)
            sleeve.play(LAST)
            coarse = runtimes.of(obj).evaluator.coarse
            self.assertEqual(coarse.surface.vertex_count, sleeve.AROUND * sleeve.ALONG, (kinds, applied))
            self.assertEqual(obj.rumple.message, "")


if __name__ == "__main__":
    unittest.main()
