# SPDX-License-Identifier: GPL-3.0-or-later
"""Cloth that swings: played, reached by a jump, baked, rendered, blown about."""
from __future__ import annotations

import contextlib
import io
import math
import unittest

import bpy
import numpy as np
from rumple.blender.objects import runtimes
from rumple.blender.ui import panels
from support import sleeve
from support.cloth_scenes import Cloth, bared, depths, difference, dressed, final, garment, pictures, played

JUMPED = "reached by a jump"


def speed(obj: bpy.types.Object) -> float:
    """Of the fastest vertex of the base cloth, m/s."""
    runtime = runtimes.of(obj)
    velocity = runtime.evaluator.state_of(runtime.inputs.frame).cloth.state.velocity
    return float(np.linalg.norm(velocity, axis=1).max())


def says(obj: bpy.types.Object) -> str:
    return "\n".join(line for line, _icon in panels.status_lines(obj))


def blow(strength: float) -> bpy.types.Object:
    """A wind along y."""
    wind = bpy.data.objects.new("Wind", None)
    bpy.context.scene.collection.objects.link(wind)
    wind.rotation_euler = (-math.pi / 2, 0.0, 0.0)
    with sleeve.context(object=wind, active_object=wind, selected_objects=[wind]):
        sleeve.make_active(wind)
        bpy.ops.object.forcefield_toggle()
    wind.field.type, wind.field.strength, wind.field.noise = "WIND", strength, 0.0
    bpy.context.view_layer.update()
    return wind


class Swing(Cloth):

    def setUp(self) -> None:
        self.obj = garment(base_cloth="SWING")
        sleeve.bend_until(8)

    def test_it_lags_behind_what_hangs_and_settles_into_it(self) -> None:
        swung = played(self.obj)
        self.assertEqual(self.obj.rumple.message, "")
        self.obj.rumple.mesh.base_cloth = "HANG"
        hung = played(self.obj)
        self.assertGreater(difference(swung[7], hung[7]), 2e-3)
        self.obj.rumple.mesh.base_cloth = "SWING"
        bpy.context.scene.frame_end = 60
        long = played(self.obj, 60)
        self.same(long, swung)
        self.assertLess(speed(self.obj), 1e-2)
        np.testing.assert_array_equal(long[59], long[60])

    def test_frames_replay_to_the_bit_whatever_was_looked_at_before(self) -> None:
        first = played(self.obj)
        self.same(pictures(self.obj, (15, 3, 9, 1, 20)), first)
        self.assertTrue(sleeve.picture(self.obj).replayed)
        bpy.ops.object.rumple_clear_frames()
        pictures(self.obj, (12, 6, 17))
        self.same(played(self.obj), first)

    def test_a_frame_reached_by_a_jump_hangs_and_says_so_until_it_is_played(self) -> None:
        sleeve.at(6)
        self.assertFalse(final(self.obj, 6.0))
        self.assertEqual(speed(self.obj), 0.0)
        self.assertIn(JUMPED, says(self.obj))
        self.assertIn("play from frame 1", says(self.obj))
        jumped = sleeve.shown(self.obj)
        through = played(self.obj, 6)
        self.assertTrue(final(self.obj, 6.0))
        self.assertNotIn(JUMPED, says(self.obj))
        self.assertGreater(speed(self.obj), 0.05)
        self.assertGreater(difference(jumped, through[6]), 1e-3)

    def test_what_hangs_says_nothing_of_a_jump(self) -> None:
        self.obj.rumple.mesh.base_cloth = "HANG"
        sleeve.at(6)
        self.assertNotIn(JUMPED, says(self.obj))

    def test_a_render_after_a_jump_says_so(self) -> None:
        scene = bpy.context.scene
        # Cycles: Workbench ends Blender 4.3 where there is neither a screen nor libEGL.
        scene.render.engine, scene.render.resolution_x, scene.render.resolution_y = "CYCLES", 16, 16
        scene.cycles.samples, scene.cycles.use_denoising = 1, False
        camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        scene.collection.objects.link(camera)
        scene.camera, scene.frame_current = camera, 1
        scene.frame_set(9)
        for times in (1, 0):  # solved by the viewport already; the second render of it says nothing new
            said = io.StringIO()
            with contextlib.redirect_stdout(said):
                bpy.ops.render.render()
            self.assertEqual(said.getvalue().count(JUMPED), times)

    def test_independent_frames_hang(self) -> None:
        self.obj.rumple.mesh.stateless = True
        swung = pictures(self.obj, (3, 7))
        self.assertNotIn(JUMPED, says(self.obj))
        self.obj.rumple.mesh.base_cloth = "HANG"
        self.same(pictures(self.obj, (3, 7)), swung)

    def test_an_animated_setting_does_not_stop_it(self) -> None:
        settings = self.obj.rumple.mesh
        for frame, gravity in ((1, 1.0), (20, 1.001)):
            settings.gravity = gravity
            self.obj.keyframe_insert("rumple.mesh.gravity", frame=frame)
        played(self.obj, 7)
        self.assertGreater(speed(self.obj), 0.05)

    def test_an_animated_setting_wakes_what_had_come_to_rest(self) -> None:
        settings = self.obj.rumple.mesh
        for frame, slack in ((1, 1.0), (58, 1.0), (59, 1.1)):
            settings.slack = slack
            self.obj.keyframe_insert("rumple.mesh.slack", frame=frame)
        bpy.context.scene.frame_end = 60
        shown = played(self.obj, 60)
        np.testing.assert_array_equal(shown[57], shown[58])
        self.assertEqual(runtimes.of(self.obj).evaluator.state_of(58.0).cloth.report.steps, 0)
        self.assertGreater(runtimes.of(self.obj).evaluator.state_of(59.0).cloth.report.steps, 0)

    def test_the_motion_of_the_object_is_felt(self) -> None:
        """The armature carries the garment, and a child of it moves with it: no bone is posed."""
        def moved(locomotion: float) -> float:
            obj = garment(base_cloth="SWING", locomotion=locomotion)
            sleeve.bend_until(1000)
            rig = bpy.data.objects["Arm"]
            obj.parent = rig
            for frame, y in ((8, 0.0), (12, 1.0)):
                rig.location.y = y
                rig.keyframe_insert("location", frame=frame)
            shown = pictures(obj, range(1, 11))
            return difference(shown[10], shown[8])
        self.assertLess(moved(0.0), 2e-3)
        self.assertGreater(moved(1.0), 8e-3)

    def test_wind_moves_it_and_a_change_of_the_wind_counts(self) -> None:
        sleeve.bend_until(1000)
        calm = played(self.obj, 10)
        wind = blow(8.0)
        windy = played(self.obj, 10)
        away = (windy[10] - calm[10])[:, 1]
        self.assertGreater(away.max(), 3e-3)
        self.assertGreater(away.mean(), 1e-3)
        wind.field.strength = 0.0
        bpy.context.view_layer.update()
        sleeve.at(10)
        self.assertGreater(difference(sleeve.shown(self.obj), windy[10]), 1e-4)
        self.same(played(self.obj, 10), calm)
        wind.field.strength = 8.0
        self.obj.rumple.mesh.drag = 0.0
        self.assertLess(difference(played(self.obj, 10)[10], calm[10]), 2e-3)

    def test_a_far_wind_does_not_reach_it(self) -> None:
        sleeve.bend_until(1000)
        calm = played(self.obj, 5)
        wind = blow(8.0)
        wind.location.y, wind.field.use_max_distance, wind.field.distance_max = -3.0, True, 2.0
        bpy.context.view_layer.update()
        self.same(played(self.obj, 5), calm)

    def test_another_frame_rate_shows_the_same_motion(self) -> None:
        """Of a bend that takes the same time, at the same moment."""
        scene = bpy.context.scene
        scene.render.fps = 30
        slow = played(self.obj, 8)[8]
        hung = pictures(self.obj, [20])[20]
        scene.render.fps, scene.frame_end = 60, 40
        sleeve.bend_until(15)
        fast = played(self.obj, 15)[15]
        self.assertLess(np.linalg.norm(fast - slow, axis=1).mean(), 1.5e-3)
        self.assertGreater(np.linalg.norm(hung - slow, axis=1).mean(), 1.5e-3)

    def test_a_bake_is_what_was_played(self) -> None:
        shown = played(self.obj)
        self.saved()
        bpy.ops.object.rumple_clear_frames()
        sleeve.at(9)
        self.obj.rumple.bake_start, self.obj.rumple.bake_end = 5, 12
        sleeve.make_active(self.obj)
        self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})
        for frame in (5, 9, 12):
            sleeve.at(frame)
            baked = sleeve.evaluated(self.obj).data
            positions = np.empty(len(baked.vertices) * 3, np.float32)
            baked.vertices.foreach_get("co", positions)
            self.assertLess(difference(positions.reshape(-1, 3), shown[frame]), 1e-5)

    def test_it_stays_off_the_body(self) -> None:
        for radius in (0.8, 0.95):
            obj, body = dressed(radius, base_cloth="SWING", level=2)
            sleeve.bend_until(6)
            found = depths(obj, body, range(1, 11))
            self.assertEqual(obj.rumple.message, "")
            self.assertGreater(sleeve.picture(obj).report.cloth.body_known, 0.5)
            self.check_no_deeper(found, depths(bared(obj), body, found), radius)


if __name__ == "__main__":
    unittest.main()
