# SPDX-License-Identifier: GPL-3.0-or-later
"""The frame rendered is the frame solved: renders against plain meshes that were solved apart."""
from __future__ import annotations

import unittest

import bpy
import numpy as np
from rumple.blender.frame import clip_status
from rumple.blender.objects import modifier, runtimes
from support import reference_solve, render_cases, sleeve, small_renders, vanilla_blender


class Engines(render_cases.Engines, unittest.TestCase):
    """In -b; the window suite has the same."""


class Setups(unittest.TestCase):
    """Cycles, which renders without a screen everywhere."""

    def check(self, obj: bpy.types.Object, frames: range) -> None:
        """An animation of these frames shows them; the first of them is the start of the clip."""
        bpy.context.scene.frame_start = frames[0]
        found = small_renders.clip(frames[0], frames[-1])
        for frame, picture in zip(frames, reference_solve.expected(obj, frames)):
            self.assertLessEqual(reference_solve.unlike(found[frame], picture), render_cases.STRAY, f"frame {frame}")
        self.assertGreater(reference_solve.unlike(found[frames[0]], found[frames[-1]]), render_cases.OTHER)
        self.assertEqual(obj.rumple.message, "")

    def test_switched_off_in_the_viewport_it_renders(self) -> None:
        obj = small_renders.stage("CYCLES")
        modifier.find(obj).show_viewport = False
        self.check(obj, range(9, 13))

    def test_hidden_in_the_viewport_it_renders(self) -> None:
        obj = small_renders.stage("CYCLES")
        obj.hide_viewport = True
        found = small_renders.clip(1, 5)
        obj.hide_viewport = False
        last = reference_solve.expected(obj, range(1, 6))[-1]
        self.assertLessEqual(reference_solve.unlike(found[5], last), render_cases.STRAY)

    def test_switched_off_for_renders_the_coarse_mesh_renders(self) -> None:
        obj = small_renders.stage("CYCLES")
        wrinkled = small_renders.still(14)
        modifier.find(obj).show_render = False
        coarse = small_renders.still(14)
        obj.modifiers.remove(modifier.find(obj))
        self.assertLessEqual(reference_solve.unlike(coarse, small_renders.still(14)), render_cases.STRAY)
        self.assertGreater(reference_solve.unlike(coarse, wrinkled), render_cases.OTHER)

    def test_subdivision_after_with_other_levels_in_renders(self) -> None:
        obj = small_renders.stage("CYCLES")
        later = obj.modifiers.new("Subdivision", "SUBSURF")
        later.levels, later.render_levels = 0, 2
        self.check(obj, range(9, 13))

    def test_shape_keys_before(self) -> None:
        obj = small_renders.stage("CYCLES")
        obj.shape_key_add(name="Basis")
        wide = obj.shape_key_add(name="Wide")
        for point in wide.data:
            point.co.y *= 1.6
        for frame, value in ((9, 0.0), (12, 1.0)):
            wide.value = value
            wide.keyframe_insert("value", frame=frame)
        self.check(obj, range(9, 13))

    def test_a_figure_that_moves_and_turns(self) -> None:
        obj = small_renders.stage("CYCLES")
        rig = bpy.data.objects["Arm"]
        obj.parent = rig
        for frame, place, turn in ((9, 0.0, 0.0), (12, 0.1, 0.5)):
            rig.location.y, rig.rotation_euler.z = place, turn
            rig.keyframe_insert("location", frame=frame)
            rig.keyframe_insert("rotation_euler", frame=frame)
        self.check(obj, range(9, 13))

    def test_the_viewport_keeps_its_frame_after_an_animation(self) -> None:
        obj = small_renders.stage("CYCLES")
        sleeve.play()
        sleeve.at(15)
        seen = sleeve.shown(obj)
        small_renders.clip(2, 5)
        sleeve.at(15)
        np.testing.assert_array_equal(sleeve.shown(obj), seen)

    def test_motion_blur_switched_off_for_the_object(self) -> None:
        obj = small_renders.stage("CYCLES")
        sharp = small_renders.clip(1, 4)[4]
        small_renders.blur(1.0)
        obj.cycles.use_motion_blur = False
        self.assertLessEqual(reference_solve.unlike(sharp, small_renders.clip(1, 4)[4]), render_cases.STRAY)


class WithoutTheAddOn(vanilla_blender.InAFolder, unittest.TestCase):
    """The file, opened by a Blender of its own that does not know Rumple."""

    def setUp(self) -> None:
        super().setUp()
        self.obj = small_renders.stage("CYCLES")
        self.save()

    def elsewhere(self, times: tuple[float, ...], render: int = 0) -> dict[float, np.ndarray]:
        """What the other Blender shows at these times."""
        seen = vanilla_blender.look(self.folder, "Sleeve", times, render)
        return {time: seen[time][vanilla_blender.POSITION] for time in times}

    def here(self, time: float) -> np.ndarray:
        whole = int(np.floor(time))
        sleeve.at(whole, time - whole)
        return sleeve.shown(self.obj)

    def test_the_saved_frame_is_all_there_and_the_mesh_follows_the_pose(self) -> None:
        sleeve.play()
        sleeve.at(12)
        self.save()
        fine = runtimes.of(self.obj).evaluator
        seen = self.elsewhere((12.0, 1.0, 20.0, 12.0))
        np.testing.assert_allclose(seen[12.0], self.here(12.0), atol=1e-6)
        for time in (1.0, 20.0):
            self.assertEqual(len(seen[time]), fine.vertex_count)
            self.assertLess(float(np.abs(seen[time] - self.here(time)).max()), 2.5 * fine.edge_mean)
        self.assertGreater(float(np.abs(seen[20.0] - seen[1.0]).max()), 0.2)

    def test_a_baked_clip_is_all_there(self) -> None:
        self.obj.rumple.bake_samples = 2
        bpy.ops.object.rumple_bake()
        self.save()
        times = (1.0, 7.0, 20.0, 7.5, 3.0)
        seen = self.elsewhere(times, render=7)
        for time in times:
            np.testing.assert_allclose(seen[time], self.here(time), atol=1e-6, err_msg=f"frame {time}")
        there = small_renders.read(str(self.folder / vanilla_blender.STILL))
        bpy.ops.object.rumple_bake_free()
        bpy.ops.object.rumple_clear_frames()
        right = reference_solve.expected(self.obj, range(1, 8))[-1]
        self.assertLessEqual(reference_solve.unlike(there, right), render_cases.STRAY)

    def test_baked_and_then_changed_it_shows_the_last_bake(self) -> None:
        bpy.ops.object.rumple_bake()
        baked = self.here(14.0)
        self.obj.rumple.mesh.radius = 0.0
        self.save()
        np.testing.assert_allclose(self.elsewhere((14.0,))[14.0], baked, atol=1e-6)

    def test_with_its_clip_lost_it_shows_the_fine_mesh_still(self) -> None:
        bpy.ops.object.rumple_bake()
        self.save()
        clip_status.clip_path(self.obj).unlink()
        seen = self.elsewhere((20.0,))[20.0]
        self.assertEqual(len(seen), len(self.here(20.0)))
        self.assertTrue(np.isfinite(seen).all())

    def test_saved_there_it_is_live_again_here(self) -> None:
        sleeve.play()
        live = self.here(18.0)
        self.save()
        self.elsewhere((5.0,))
        self.assertTrue((self.folder / vanilla_blender.SAVED).is_file())
        bpy.ops.wm.open_mainfile(filepath=str(self.folder / vanilla_blender.SAVED))
        self.obj = bpy.data.objects["Sleeve"]
        sleeve.play()
        np.testing.assert_array_equal(self.here(18.0), live)


if __name__ == "__main__":
    unittest.main()
