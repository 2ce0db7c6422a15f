# SPDX-License-Identifier: GPL-3.0-or-later
"""Handlers never throw, and what goes wrong with one object stays with it."""
import unittest
from unittest import mock

import bpy
import numpy as np
from rumple.blender import handlers, scheduler
from rumple.blender.frame import clip_status, path_curves, rebuild, solve
from rumple.blender.objects import bodies, changes, evaluator, runtimes
from rumple.core.engine import UserError
from support import sleeve


def two_sleeves():
    """Two garments of one file, both wrinkled."""
    one = sleeve.scene()
    other = sleeve.skinned(sleeve.tube("Other"), bpy.data.objects["Arm"], "Other")
    other.rumple.mesh.density, other.rumple.mesh.level, other.rumple.mesh.display_steps = "LEVEL", 1, 0
    sleeve.make_active(other)
    bpy.ops.object.rumple_add(method="MESH")
    return one, other


def raises_for(name, function, error):
    """The function, but for the object of that name it raises."""
    def broken(obj, *arguments):
        if getattr(obj, "name", "") == name:
            raise error
        return function(obj, *arguments)
    return broken


class OneOfTwo(unittest.TestCase):

    def test_its_error_is_its_message_and_the_other_goes_on(self):
        # What goes wrong before a rebuild is no matter where the solve after it does well.
        places = ((bodies, "is_connected"), (evaluator, "sources"), (solve, "_inputs"), (solve, "_posed"),
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

    def test_none_throws_and_a_render_is_guarded_all_the_same(self):
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
        sleeve.at(7)
        self.assertEqual((runtimes.of(obj).inputs.frame, obj.rumple.message), (7.0, ""))


if __name__ == "__main__":
    unittest.main()
