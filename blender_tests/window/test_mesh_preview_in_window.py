# SPDX-License-Identifier: GPL-3.0-or-later
"""The GPU preview of the Wrinkle Mesh: its solve against the library, its pictures against the fine mesh."""
from __future__ import annotations

import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from typing import Iterator

import bpy
import gpu
import numpy as np
import rumple_native as native
from rumple.blender import compat
from rumple.blender.objects import modifier
from rumple.blender.viewport import gpu_mesh, preview, preview_mesh
from rumple.blender.viewport.gpu_arrays import read
from support import sleeve, walking_shirt
from support.preview_case import PreviewCase, smooth


class MeshCase(PreviewCase):
    method = "MESH"

    def begun(self, **settings: object) -> Iterator[float]:
        """The sleeve with one layer of wrinkles, drawn at the clip's first frame."""
        yield from self.make(**{"layers": "ONE", "density": "LEVEL", "level": 2, "display_steps": 0, **settings})
        yield from self.drawn_at(1)

    def places(self) -> np.ndarray:
        """(d, 3) of the shown mesh, from the card."""
        shown = self.held().drawing.shown
        return read(shown.places, self.runtime().evaluator.shown.vertex_count)[:, :3]

    def off(self) -> np.ndarray:
        """(d,) metres: how far the card's shown vertices are from those that renders show."""
        return np.linalg.norm(self.places() - self.in_renders().positions, axis=1)

    def offsets(self) -> np.ndarray:
        return offsets_of(self.held().drawing.mesh)


def offsets_of(mesh: gpu_mesh.GpuMesh) -> np.ndarray:
    """(v, 3) in the library's order, from the card."""
    out = np.empty((mesh.count, 3), np.float32)
    out[mesh.vertex] = read(mesh.offsets, mesh.count)[:, :3]
    return out


has_compute = unittest.skipUnless(hasattr(gpu, "compute"), "this Blender has no compute shaders")


@has_compute
class Solved(MeshCase):

    def test_it_goes_on_by_itself_as_the_library_does(self) -> Iterator[float]:
        """A thousandth of a fine edge in the mean after each frame, a twentieth anywhere: folds multiply roundings."""
        for settings in (dict(), dict(attachment="PN", collision="NONE", nudge=0.1),
                         dict(attachment="LINEAR", buckling_threshold=0.02)):
            yield from self.begun(**settings)
            begun: list[int] = []
            self.watch(gpu_mesh.GpuMesh, "take_over", begun)
            edge = float(self.runtime().evaluator.model.local_edge.mean())
            for frame in range(2, 9):
                yield from self.drawn_at(frame)
                self.assertTrue(self.runtime().evaluator.frame_cache.get(float(frame)).waits)
                state = self.runtime().evaluator.wrinkles_of(float(frame))
                off = np.linalg.norm(self.offsets() - state.offset, axis=1)
                self.assertLess(off.mean(), 1e-3 * edge, (settings, frame))
                self.assertLess(off.max(), 5e-2 * edge, (settings, frame))
            self.assertEqual(begun, [])
            self.assertGreater(np.linalg.norm(state.offset, axis=1).max(), 0.3 * edge)
            self.assertLess(self.off().mean(), 1e-3 * edge)

    def test_a_jump_takes_the_state_of_the_engine(self) -> Iterator[float]:
        yield from self.begun()
        yield from self.drawn_at(9)
        self.assertLess(self.off().max(), 2e-6)
        yield from self.drawn_at(10)
        edge = float(self.runtime().evaluator.model.local_edge.mean())
        self.assertLess(self.off().mean(), 1e-3 * edge)

    def test_a_pose_that_is_held_keeps_every_bit(self) -> Iterator[float]:
        yield from self.begun()
        sleeve.bend_until(4)
        for frame in range(1, 7):
            yield from self.drawn_at(frame)
        held = self.offsets()
        yield from self.drawn_at(7)
        np.testing.assert_array_equal(self.offsets(), held)

    def test_far_behind_the_card_starts_by_itself(self) -> Iterator[float]:
        """A step back after a long play would wait until the library has solved all frames before it."""
        yield from self.begun()
        for frame in range(2, 8):
            yield from self.drawn_at(frame)
        cache, begun = self.runtime().evaluator.frame_cache, []
        self.watch(gpu_mesh.GpuMesh, "solve_from_start", begun)
        for frame in range(2, 8):
            cache.get(float(frame)).solve_seconds = 10.0
        yield from self.drawn_at(5)
        self.assertEqual(len(begun), 1)
        self.assertTrue(cache.get(5.0).waits)
        evaluator, inputs = self.runtime().evaluator, self.runtime().inputs
        options = evaluator._native_settings(inputs.settings)
        start, _ = native.solve_wrinkle_mesh(evaluator.model, options, evaluator._paint, inputs.positions)
        off = np.linalg.norm(self.offsets() - start.offset, axis=1)
        self.assertLess(off.mean(), 1e-3 * float(evaluator.model.local_edge.mean()))
        self.assertGreater(np.linalg.norm(start.offset, axis=1).max(), 1e-3)
        cache.get(7.0).state  # a render gets the library's frames all the same
        self.assertFalse(cache.get(5.0).waits)

    def test_another_first_frame_begins_another_clip(self) -> Iterator[float]:
        yield from self.begun()
        yield from self.drawn_at(2)
        bpy.context.scene.frame_start = self.obj.rumple.bake_start = 2
        begun: list[int] = []
        self.watch(gpu_mesh.GpuMesh, "take_over", begun)
        yield from self.drawn_at(3)
        self.assertEqual(len(begun), 1)
        self.assertLess(self.off().max(), 2e-6)

    def test_the_card_goes_on_where_the_engine_does(self) -> Iterator[float]:
        yield from self.begun()
        inputs = self.runtime().inputs
        at = [replace(inputs, frame=frame) for frame in (2.0, 2.5, 3.0, 3.5, 4.0)]
        self.assertTrue(at[2].goes_on_from(at[0]))
        self.assertFalse(at[4].goes_on_from(at[0]))
        self.assertFalse(at[3].goes_on_from(at[1]), "a subframe is solved from a whole frame")
        self.assertFalse(at[0].goes_on_from(at[2]))
        self.assertFalse(replace(at[2], start=3).goes_on_from(replace(at[0], start=3)), "the first frame")
        self.assertFalse(replace(at[2], start=2).goes_on_from(at[0]), "another clip")
        alone = replace(inputs.settings, stateless=True)
        self.assertFalse(replace(at[2], settings=alone).goes_on_from(replace(at[0], settings=alone)))

    def test_settings_take_effect(self) -> Iterator[float]:
        yield from self.begun()
        yield from self.drawn_at(8)
        yield from self.drawn_at(9)
        self.obj.rumple.mesh.radius = 0.3
        yield from self.until(lambda: self.runtime().inputs.settings.radius == np.float32(0.3))
        yield from self.until_drawn(9)
        self.assertLess(self.off().max(), 2e-6)
        largest = np.linalg.norm(self.offsets(), axis=1) / self.runtime().evaluator.model.local_edge
        self.assertLess(largest.max(), 0.3 * 1.001)
        yield from self.drawn_at(10)  # which the card solves
        self.assertTrue(self.runtime().evaluator.frame_cache.get(10.0).waits)
        largest = np.linalg.norm(self.offsets(), axis=1) / self.runtime().evaluator.model.local_edge
        self.assertLess(largest.max(), 0.3 * 1.001)

    def test_keyed_settings_take_effect(self) -> Iterator[float]:
        yield from self.begun()
        for frame, radius in ((7, 1.0), (8, 0.3)):
            self.obj.rumple.mesh.radius = radius
            self.obj.keyframe_insert("rumple.mesh.radius", frame=frame)
        yield 0.3
        for frame in range(4, 9):
            yield from self.drawn_at(frame)
        largest = np.linalg.norm(self.offsets(), axis=1) / self.runtime().evaluator.model.local_edge
        self.assertLess(largest.max(), 0.3 * 1.001)


@has_compute
class RealClip(unittest.TestCase):

    def test_a_walking_shirt_on_the_card_alone(self) -> None:
        """60 frames from the library's first: a thousandth of an edge (8 micrometres) in the mean, a tenth anywhere."""
        surface, frames = walking_shirt.surface_and_frames()
        model, frames = native.build_wrinkle_mesh(surface), frames[:60]
        settings, paint = native.WrinkleMeshSettings(), native.WrinkleMeshPaint(model)
        edge = float(model.local_edge.mean())
        state, _ = native.solve_wrinkle_mesh(model, settings, paint, frames[0])
        mesh = gpu_mesh.GpuMesh(gpu_mesh.Kernels(), native.WrinkleMeshPasses(model, settings, paint), settings)
        mesh.pose(*model.weld_pose(frames[0])[:2])
        mesh.take_over(state.offset, state.solved_length)
        for frame, positions in enumerate(frames[1:], 1):
            state, _ = native.solve_wrinkle_mesh(model, settings, paint, positions, state)
            mesh.pose(*model.weld_pose(positions)[:2])
            mesh.solve()
            if frame % 20 == 19:
                off = np.linalg.norm(offsets_of(mesh) - state.offset, axis=1) / edge
                self.assertLess(off.mean(), 1e-3, frame)
                self.assertLess(off.max(), 0.1, frame)
        self.assertGreater(np.linalg.norm(state.offset, axis=1).mean(), 0.3 * edge)


@has_compute
class Pictures(MeshCase):

    def test_it_looks_like_the_fine_mesh(self) -> Iterator[float]:
        yield from self.begun()
        yield from self.drawn_at(sleeve.LAST)
        mesh = self.obj.rumple.mesh
        mesh.gpu_preview = False
        yield from self.settled(False)
        yield from self.shot()
        fine = self.seen
        self.screenshot("mesh_fine")
        mesh.gpu_preview = True
        yield from self.settled()
        yield from self.shot()
        self.screenshot("mesh_preview")
        self.assertEqual(len(preview._on_gpu), 1)
        self.assertEqual(self.held().refusal, "")
        here = np.abs(fine - fine[5, 5]) > 8.0
        difference = np.abs(self.seen - fine)[here]
        self.assertLess(np.median(difference), 4.0)
        self.assertLess(difference.mean(), 8.0)
        detail = [np.abs(picture - smooth(picture))[here].mean() for picture in (self.seen, fine)]
        self.assertAlmostEqual(detail[0] / detail[1], 1.0, delta=0.2)

    def test_its_normals_are_blenders(self) -> Iterator[float]:
        """They had been weighted by area: in folded cloth every tenth was 9 degrees off."""
        yield from self.begun()
        yield from self.drawn_at(sleeve.LAST)
        fine = bpy.data.meshes.new("Fine")
        self.addCleanup(bpy.data.meshes.remove, fine)
        shown = self.runtime().evaluator
        compat.fill_polygons(fine, self.places(), shown.polygon_start, shown.corner_vertex)
        expected = np.empty((len(fine.vertices), 3), np.float32)
        fine.vertices.foreach_get("normal", expected.ravel())
        drawn = read(self.held().drawing.shown.normals, len(expected))[:, :3]
        drawn /= np.linalg.norm(drawn, axis=1, keepdims=True)
        off = np.degrees(np.arccos(np.clip((drawn * expected).sum(1), -1.0, 1.0)))
        self.assertLess(np.percentile(off, 90), 2.0)

    def test_with_a_subdivided_mesh_and_one_for_viewports(self) -> Iterator[float]:
        in_viewport = []
        for viewport_steps in (0, 2):
            yield from self.begun(display_steps=2, level=1)
            self.obj.rumple.viewport_steps = viewport_steps
            yield 0.5
            for frame in (2, 3):
                yield from self.drawn_at(frame)
            evaluator, inputs = self.runtime().evaluator, self.runtime().inputs
            drawn = evaluator.in_viewport if inputs.in_viewport else evaluator
            places = read(self.held().drawing.shown.places, drawn.shown.vertex_count)[:, :3]
            expected = native.show_wrinkle_mesh(
                evaluator.model, evaluator._native_settings(inputs.settings), inputs.positions,
                evaluator.wrinkles_of(inputs.frame), in_viewport=inputs.in_viewport).positions
            edge = float(evaluator.model.local_edge.mean())
            self.assertLess(np.linalg.norm(places - expected, axis=1).mean(), 1e-3 * edge)
            in_viewport.append(inputs.in_viewport)
        self.assertEqual(in_viewport, [True, False])


class WithoutComputeShaders(MeshCase):

    @unittest.skipIf(hasattr(gpu, "compute"), "this Blender has them")
    def test_the_fine_mesh_is_shown(self) -> Iterator[float]:
        yield from self.make(layers="ONE", density="LEVEL", level=2)
        sleeve.at(5)
        yield from self.settled(False)
        self.assertEqual(len(preview._on_gpu), 0)
        self.assertEqual(preview.refusal(self.obj), "")


@has_compute
class Manners(MeshCase):

    def test_a_driver_that_refuses_it_leaves_the_fine_mesh(self) -> Iterator[float]:
        yield from self.begun()
        tried = self.refuse(preview_mesh)
        self.area.tag_redraw()
        yield from self.settled(False)
        self.assertEqual(len(tried), 1)
        self.assertEqual(preview.refusal(self.obj), preview.REFUSED)

    def test_each_material_has_its_triangles(self) -> Iterator[float]:
        yield from self.begun()
        self.assertEqual(self.held().drawing.slots(), [0, 1])
        self.assertTrue(self.held().drawing.has_uv)

    def test_an_edited_uv_map_is_drawn(self) -> Iterator[float]:
        yield from self.begun()
        before = self.held().drawing._batches
        layer = self.obj.data.uv_layers[0]
        values = np.zeros(2 * len(self.obj.data.loops), np.float32)
        layer.data.foreach_get("uv", values)
        layer.data.foreach_set("uv", values + np.float32(0.25))
        self.obj.data.update()
        yield 0.3
        yield from self.drawn_at(2)
        self.assertIsNot(self.held().drawing._batches, before)
        self.obj.data.uv_layers.remove(self.obj.data.uv_layers[0])
        yield 0.3
        yield from self.drawn_at(3)
        self.assertFalse(self.held().drawing.has_uv)
        self.assertEqual(self.held().refusal, "")

    def test_what_is_bound_to_its_points_gets_the_fine_mesh(self) -> Iterator[float]:
        yield from self.begun()
        other = bpy.data.objects.new("Button", bpy.data.meshes.new("Button"))
        bpy.context.scene.collection.objects.link(other)
        other.modifiers.new("Bound", "SURFACE_DEFORM").target = self.obj
        yield from self.settled(False)

    def test_blender_evaluates_the_coarse_mesh_meanwhile(self) -> Iterator[float]:
        yield from self.begun()
        coarse = len(self.obj.data.vertices)
        for frame in (2, 3, 9):  # the last one after a jump
            yield from self.drawn_at(frame)
            evaluated = self.obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
            self.assertEqual(len(evaluated.data.vertices), coarse)
        self.obj.rumple.mesh.gpu_preview = False
        yield from self.settled(False)
        evaluated = self.obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        self.assertGreater(len(evaluated.data.vertices), 10 * coarse)

    def test_a_garment_that_it_cannot_solve_shows_its_fine_mesh(self) -> Iterator[float]:
        for settings in (dict(layers="CLOTH"), dict(base_cloth="HANG"), dict(collision="NEIGHBOURHOOD"),
                         dict(rest_shape="ADAPTIVE")):
            yield from self.make(**{"layers": "ONE", "density": "LEVEL", "level": 2, **settings})
            sleeve.at(5)
            yield from self.settled(False)
            self.assertEqual(len(preview._on_gpu), 0, settings)
            nodes_mod = modifier.find(self.obj)
            self.assertFalse(preview.uses_proxy(self.obj, nodes_mod), settings)
            self.assertEqual(preview.refusal(self.obj), preview.NOT_DRAWN)

    def test_what_is_baked_saved_and_applied_has_the_bits_of_the_library(self) -> Iterator[float]:
        """Frames that wait because the card has drawn them are solved by the library, from the clip's first frame."""
        yield from self.make(layers="ONE", density="LEVEL", level=1, display_steps=0, gpu_preview=False)
        last = 6
        sleeve.play(last=last)
        fine = sleeve.shown(self.obj)
        self.obj.rumple.mesh.gpu_preview = True
        yield from self.drawn_at(1)
        self.runtime().evaluator.frame_cache.clear()
        yield from self.drawn_at(2)
        for frame in range(1, last + 1):
            yield from self.drawn_at(frame)
        self.assertTrue(self.runtime().evaluator.frame_cache.get(float(last)).waits)
        with tempfile.TemporaryDirectory() as folder:
            blend = str(Path(folder) / "preview.blend")
            with sleeve.context():
                bpy.ops.wm.save_as_mainfile(filepath=blend)
            yield from self.settled()
            self.obj.rumple.bake_end = last
            with sleeve.context():
                sleeve.make_active(self.obj)
                bpy.ops.object.rumple_bake()
            sleeve.at(last)
            np.testing.assert_allclose(sleeve.shown(self.obj), fine, atol=2e-7)  # live meshes are embedded: rounded
            yield from self.opened_again(blend, fine)
            yield 0.3
            sleeve.play(last=last)
            with sleeve.context():
                sleeve.make_active(self.obj)
                bpy.ops.object.rumple_apply()
        found = np.empty(3 * len(self.obj.data.vertices), np.float32)
        self.obj.data.vertices.foreach_get("co", found)
        np.testing.assert_array_equal(found.reshape(-1, 3), fine)
