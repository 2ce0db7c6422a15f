# SPDX-License-Identifier: GPL-3.0-or-later
"""Handlers never throw, and what goes wrong with one object stays with it."""
from __future__ import annotations

import unittest
from unittest import mock
from typing import Any, Callable, Iterable

import bpy
import numpy as np
from rumple.blender import handlers, scheduler
from rumple.blender.frame import clip_status, path_curves, rebuild, solve
from rumple.blender.objects import bodies, changes, evaluator, modifier, painted_maps, runtimes
from rumple.core.base.wording import UserError
from support import sleeve


def two_sleeves() -> tuple[bpy.types.Object, bpy.types.Object]:
    """Two garments of one file, both wrinkled."""
    one = sleeve.scene()
    other = sleeve.skinned(sleeve.tube("Other"), bpy.data.objects["Arm"], "Other")
    other.rumple.mesh.density, other.rumple.mesh.level, other.rumple.mesh.display_steps = "LEVEL", 1, 0
    sleeve.make_active(other)
    bpy.ops.object.rumple_add(method="MESH")
    return one, other


def raises_for(name: str, function: Callable[..., Any], error: Exception) -> Callable[..., Any]:
    """The function, but for the object of that name it raises."""
    def broken(obj: bpy.types.Object, *arguments: object) -> Any:
        if getattr(obj, "name", "") == name:
            raise error
        return function(obj, *arguments)
    return broken


class OneOfTwo(unittest.TestCase):

    def test_its_error_is_its_message_and_the_other_goes_on(self) -> None:
        # What goes wrong before a rebuild is no matter where the solve after it does well.
        places = ((bodies, "is_connected"), (evaluator, "sources"), (painted_maps, "read"), (solve, "_posed"),
                  (solve, "_note_groups"), (rebuild, "_split_shared_output"))
        for error in (UserError("on purpose"), RuntimeError("on purpose")):
            for module, name in places:
                with self.subTest(f"{module.__name__}.{name}, {type(error).__name__}"):
                    one, other = two_sleeves()
                    sleeve.play(1, 3)
                    for obj in (one, other):
                        runtimes.of(obj).stale = True
                    runtimes.of(other).output_key = 0
                    with mock.patch.object(module, name, raises_for("Other", getattr(module, name), error)):
                        sleeve.at(8)
                        if name not in ("_posed", "_split_shared_output"):
                            self.assertIn("on purpose", runtimes.message(other))
                        self.assertEqual((runtimes.of(one).inputs.frame, one.rumple.message), (8.0, ""))
                        self.assertTrue(np.isfinite(sleeve.shown(other)).all())
                    sleeve.at(9)
                    for obj in (one, other):
                        runtimes.of(obj).stale = True
                        obj.update_tag()
                    sleeve.at(10)
                    self.assertEqual((runtimes.of(other).inputs.frame, other.rumple.message), (10.0, ""))


class Handlers(unittest.TestCase):

    def test_none_throws_and_a_render_is_guarded_all_the_same(self) -> None:
        obj = sleeve.scene()
        sleeve.play(1, 2)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        broken = [(changes, "note_updates"), (solve, "process"), (clip_status, "check_before_render"),
                  (path_curves, "sync"), (scheduler, "sync_all"), (bodies, "in_order")]
        for module, name in broken:
            with self.subTest(name), mock.patch.object(module, name, side_effect=MemoryError("on purpose")):
                for handler in (handlers._before_frame, handlers._on_frame, handlers._on_update):
                    handler(bpy.context.scene, depsgraph)
                handlers._on_undo()
                handlers._on_save()
                handlers._on_render_start()
                self.assertTrue(scheduler.rendering())
                handlers._on_render_end()
                self.assertFalse(scheduler.rendering())
        with mock.patch.object(modifier, "wrinkled_objects", side_effect=MemoryError("on purpose")):
            scheduler.sync_all()  # the timer of a window calls it
        sleeve.at(7)
        self.assertEqual((runtimes.of(obj).inputs.frame, obj.rumple.message), (7.0, ""))

    def test_the_pose_of_a_rebuild_is_forgotten_whatever_fails(self) -> None:
        """The next frame was solved from it."""
        obj = sleeve.scene()
        sleeve.play(1, 2)
        runtimes.of(obj).stale = True
        with mock.patch.object(bodies, "in_levels", side_effect=MemoryError("on purpose")), \
                mock.patch.object(solve, "_posed", wraps=solve._posed) as posed:
            sleeve.at(3)
        posed.assert_called_once()
        self.assertIsNone(runtimes.of(obj).pose)


class WildFrame(unittest.TestCase):
    """One vertex flies off for one frame, as where a simulation explodes. The state of Wrinkle Mesh was never finite
    again, and Blender died: in Wrinkle Field a phase that is no number was a place in a table."""

    def played(self, method: str, wild: float | None,
               frames: Iterable[int]) -> dict[int, tuple[np.ndarray, np.ndarray, str]]:
        """(solved, shown, message) of frames; vertex 50 is wild in frame 7, or nothing is."""
        obj = sleeve.scene(wrinkles=False)
        obj.rumple.mesh.density, obj.rumple.mesh.level, obj.rumple.mesh.display_steps = "LEVEL", 1, 0
        obj.rumple.field.output, obj.rumple.paths.width = "GEOMETRY", 0.05
        obj.shape_key_add(name="Basis")
        key = obj.shape_key_add(name="Wild")
        if wild is not None:
            key.data[50].co.x = wild
        for frame, value in ((6, 0.0), (7, 1.0), (8, 0.0)):
            key.value = value
            key.keyframe_insert("value", frame=frame)
        sleeve.make_active(obj)
        bpy.ops.object.rumple_add(method=method)
        found = {}
        for frame in frames:
            sleeve.at(frame)
            found[frame] = self.solved(), sleeve.shown(obj), obj.rumple.message
        return found

    def solved(self) -> np.ndarray:
        return runtimes.of(bpy.data.objects["Sleeve"]).result.positions.copy()

    def test_it_is_said_and_the_frames_after_it_go_on_from_the_last_good_one(self) -> None:
        before, after = range(1, 7), range(8, 13)
        for method in ("MESH", "FIELD", "PATHS"):
            without = self.played(method, None, range(1, 13))
            jumped = self.played(method, None, [*before, *after])
            for wild in (1e9, 1e14, 1e20, 3e38, float("nan")):
                with self.subTest(method, wild=wild):
                    found = self.played(method, wild, range(1, 13))
                    self.assertRegex(found[7][2], "^Sleeve: vertex 50 (is|has) .* in this frame")
                    np.testing.assert_array_equal(found[7][0], found[6][0])
                    for frame in (*before, *after):
                        self.assertEqual(found[frame][2], "")
                        self.assertTrue(all(np.isfinite(positions).all() for positions in found[frame][:2]))
                    for frame in before:
                        np.testing.assert_array_equal(found[frame][0], without[frame][0])
                    away, jump = (max(np.abs(frames[frame][0] - without[frame][0]).max() for frame in after)
                                  for frames in (found, jumped))
                    self.assertGreater(jump, 0.01)
                    self.assertLess(away, 0.8 * jump)  # they began anew: folds of half a clip were lost
                    # Mended and played again, nothing is left of it.
                    key = bpy.data.objects["Sleeve"].data.shape_keys.key_blocks["Wild"]
                    key.data[50].co = key.relative_key.data[50].co
                    for frame, (positions, _, _) in without.items():
                        sleeve.at(frame)
                        np.testing.assert_array_equal(self.solved(), positions)


class SharedMesh(unittest.TestCase):

    def test_while_one_of_two_is_edited_the_other_says_nothing_unexpected(self) -> None:
        for method in ("MESH", "FIELD", "PATHS"):
            for settings in (dict(), dict(rest_shape="FRAME")):
                with self.subTest(method, **settings):
                    obj = sleeve.scene(wrinkles=False)
                    obj.data.attributes.new("rumple_rest_wrinkle", "FLOAT_VECTOR", "POINT")
                    obj.vertex_groups.new(name="Rumple Radius").add([1, 2, 3], 0.5, "REPLACE")
                    obj.rumple.mesh.density, obj.rumple.mesh.level, obj.rumple.mesh.display_steps = "LEVEL", 1, 0
                    bpy.ops.object.rumple_add(method=method)
                    if settings:
                        bpy.ops.object.rumple_capture_rest(frame=1)
                    sleeve.at(3)
                    bpy.ops.object.duplicate(linked=True)
                    other = bpy.context.object
                    scheduler.sync_all()
                    sleeve.at(4)
                    sleeve.make_active(other)
                    bpy.ops.object.mode_set(mode="EDIT")
                    last = runtimes.of(obj).result
                    for frame, prepared in ((5, "stale"), (6, "paint"), (7, "evaluator"), (8, "result")):
                        runtime = runtimes.of(obj)
                        if prepared == "stale":
                            runtime.stale = True
                        elif prepared == "paint":
                            runtime.paint.values = None
                        elif prepared == "evaluator":
                            runtime.evaluator, runtime.build.shape = None, ""
                        else:
                            runtime.invalidate()
                        scheduler.sync_all()
                        sleeve.at(frame)
                        self.assertEqual((obj.rumple.message, other.rumple.message), ("", ""), prepared)
                    self.assertIsNotNone(last)
                    bpy.ops.object.mode_set(mode="OBJECT")
                    sleeve.at(9)
                    scheduler.sync_all()
                    sleeve.at(10)
                    for each in (obj, other):
                        self.assertEqual((each.rumple.message, runtimes.of(each).inputs.frame), ("", 10.0))

    def test_while_an_own_mesh_is_edited_the_last_picture_stays(self) -> None:
        obj = sleeve.scene()
        own = bpy.data.objects.new("Fine", obj.data.copy())
        bpy.context.scene.collection.objects.link(own)
        obj.rumple.own_mesh = own
        obj.rumple.mesh.source = "OBJECT"
        scheduler.sync_all()
        sleeve.at(4)
        self.assertEqual((obj.rumple.message, len(sleeve.shown(obj))), ("", len(own.data.vertices)))
        sleeve.make_active(own)
        bpy.ops.object.mode_set(mode="EDIT")
        for frame in (5, 6):
            runtimes.of(obj).stale = True
            scheduler.sync_all()
            sleeve.at(frame)
            self.assertEqual((obj.rumple.message, len(sleeve.shown(obj))), ("", len(own.data.vertices)))
        bpy.ops.object.mode_set(mode="OBJECT")
        sleeve.at(8)
        self.assertEqual((obj.rumple.message, runtimes.of(obj).inputs.frame), ("", 8.0))


class TwoScenes(unittest.TestCase):

    def test_a_look_from_another_scene_leaves_the_stored_frames(self) -> None:
        # Each look emptied the history: 13 mm of difference at the same frame.
        for method in ("MESH", "FIELD", "PATHS"):
            for what in ("same", "rate", "start", "units", "all"):
                with self.subTest(method, what=what):
                    obj = sleeve.scene(wrinkles=False)
                    obj.rumple.mesh.density, obj.rumple.mesh.level, obj.rumple.mesh.display_steps = "LEVEL", 1, 0
                    obj.rumple.field.output = "GEOMETRY"
                    bpy.ops.object.rumple_add(method=method)
                    here, there = bpy.context.scene, bpy.data.scenes.new("Zweite")
                    obj.rumple.bake_start = 5  # or the clip begins at 1 in both
                    for each in (obj, bpy.data.objects["Arm"]):
                        there.collection.objects.link(each)
                    there.frame_start, there.frame_end = here.frame_start, here.frame_end
                    if what in ("rate", "all"):
                        there.render.fps = 60
                    if what in ("start", "all"):
                        there.frame_start = 5
                    if what in ("units", "all"):
                        there.unit_settings.scale_length = 0.01
                    for frame in range(1, 16):
                        here.frame_set(frame)
                    before, frames = sleeve.shown(obj), runtimes.of(obj).evaluator.frame_cache.frames()
                    self.assertEqual(frames, [(float(frame), True) for frame in range(1, 16)])
                    there.frame_set(15)
                    there.frame_set(9)
                    here.frame_set(15)
                    np.testing.assert_array_equal(sleeve.shown(obj), before)
                    self.assertEqual(runtimes.of(obj).evaluator.frame_cache.frames(), frames)
                    self.assertTrue(runtimes.of(obj).result.replayed)


if __name__ == "__main__":
    unittest.main()
