# SPDX-License-Identifier: GPL-3.0-or-later
"""A fine mesh that takes long is made in a thread: the window goes on, and Esc leaves what was."""
from __future__ import annotations

import threading
from types import SimpleNamespace
from typing import Any, Iterator
from unittest import mock

import bpy
import numpy as np
from rumple.blender import scheduler
from rumple.blender.objects import evaluator, modifier, runtimes
from rumple.blender.ui import rebuild_progress
from rumple.core.base.wording import UserError
from rumple.core.systems.all_systems import SYSTEMS
from rumple.core.systems.wrinkle_mesh import WrinkleMesh
from support import sleeve
from support.window_case import WindowCase


class Slow(WindowCase):
    _error: UserError | None = None

    def make(self, wrinkled: bool = True) -> Iterator[float]:
        """A sleeve whose next fine meshes are not ready before `go` is set."""
        obj = sleeve.scene(wrinkles=wrinkled)
        max(bpy.context.window_manager.windows[0].screen.areas, key=lambda a: a.width * a.height).type = "VIEW_3D"
        yield 0.5
        self.go, self.builds = threading.Event(), []
        self.slow(WrinkleMesh)
        self.addCleanup(self.go.set)
        self.before = self.count(obj) if wrinkled else 0

    def slow(self, system: Any) -> None:
        plain = system.build

        def build(*arguments: Any, **more: Any) -> Any:
            self.builds.append(threading.current_thread())
            self.go.wait(60.0)
            if self._error is not None:
                raise self._error
            return plain(*arguments, **more)

        patch = mock.patch.object(system, "build", build)
        patch.start()
        self.addCleanup(patch.stop)

    @property
    def obj(self) -> bpy.types.Object:
        return bpy.data.objects["Sleeve"]

    def count(self, obj: bpy.types.Object) -> int:
        return runtimes.of(obj).evaluator.vertex_count

    def esc(self) -> Iterator[float]:
        window = bpy.context.window_manager.windows[0]
        for value in ("PRESS", "RELEASE"):
            window.event_simulate("ESC", value, x=window.width // 2, y=window.height // 2)
        yield 0.3

    def shown(self) -> bool:
        return rebuild_progress._shown_in != -1

    def test_the_window_goes_on_and_the_new_mesh_comes(self) -> Iterator[float]:
        yield from self.make()
        self.obj.rumple.mesh.level = 2
        yield from self.until(self.shown)
        self.assertTrue(self.shown())
        self.assertIsNot(self.builds[0], threading.main_thread())
        with self.area():
            sleeve.at(7)  # frames are solved by the former one
        yield 0.2
        self.assertEqual(self.count(self.obj), self.before)
        self.assertEqual(runtimes.of(self.obj).inputs.frame, 7.0)
        self.screenshot("rebuild_under_way")
        self.go.set()
        yield from self.until(lambda: self.count(self.obj) > 3 * self.before)
        self.assertGreater(self.count(self.obj), 3 * self.before)
        yield from self.until(lambda: not self.shown())
        self.assertFalse(self.shown())
        np.testing.assert_allclose(sleeve.shown(self.obj), sleeve.picture(self.obj).positions, atol=1e-6)
        self.assertEqual((len(self.builds), self.obj.rumple.message), (1, ""))

    def click(self, method: str = "MESH") -> Iterator[float]:
        """Adds wrinkles from the menu, whose fine mesh is not ready yet."""
        yield from self.make(wrinkled=False)
        if method != "MESH":
            self.slow(SYSTEMS[method].wrinkles)
        with self.area():
            bpy.ops.view3d.view_selected()
            bpy.ops.ed.undo_push(message="bare")  # scripts leave no step
            self.assertEqual(bpy.ops.object.rumple_add("INVOKE_DEFAULT", True, method=method), {"FINISHED"})
        self.assertIsNone(modifier.output_object(modifier.find(self.obj)))
        yield from self.until(self.shown)
        self.assertTrue(self.shown())

    def test_the_first_click_leaves_the_window_alive(self) -> Iterator[float]:
        yield from self.click()
        self.assertIsNot(self.builds[0], threading.main_thread())
        with self.area():
            sleeve.at(7)  # the mesh is shown as it is animated meanwhile
        yield 0.2
        self.screenshot("first_click_under_way")
        self.assertEqual((len(sleeve.shown(self.obj)), self.obj.rumple.message), (len(self.obj.data.vertices), ""))
        self.go.set()
        yield from self.until(lambda: runtimes.of(self.obj).result is not None and not self.shown())
        self.assertFalse(self.shown())
        np.testing.assert_allclose(sleeve.shown(self.obj), sleeve.picture(self.obj).positions, atol=1e-6)
        self.assertEqual((len(self.builds), self.obj.rumple.message), (1, ""))

    def test_so_do_the_other_systems(self) -> Iterator[float]:
        """The preview of a Field is on before there is a Field."""
        for method in ("FIELD", "PATHS"):
            yield from self.click(method)
            with self.area():
                sleeve.at(7)
            yield 0.3
            self.assertEqual(self.obj.rumple.message, "")
            self.go.set()
            yield from self.until(lambda: runtimes.of(self.obj).result is not None and not self.shown())
            self.assertEqual((runtimes.of(self.obj).result is not None, self.obj.rumple.message), (True, ""), method)

    def test_esc_takes_the_first_click_back(self) -> Iterator[float]:
        yield from self.click()
        yield from self.esc()
        yield from self.until(lambda: modifier.find(self.obj) is None)
        self.go.set()  # what was dropped comes too late
        yield 0.5
        self.assertIsNone(modifier.find(self.obj))
        self.assertEqual((self.obj.rumple.method, self.obj.rumple.message, self.shown()), ("NONE", "", False))
        with self.area():
            self.assertEqual(bpy.ops.object.rumple_add("INVOKE_DEFAULT", method="MESH"), {"FINISHED"})  # and again
        yield from self.until(lambda: runtimes.of(self.obj).evaluator is not None)
        self.assertGreater(self.count(self.obj), len(self.obj.data.vertices))

    def test_undo_takes_the_first_click_back(self) -> Iterator[float]:
        yield from self.click()
        with self.area():
            bpy.ops.ed.undo()
        yield from self.until(lambda: not self.shown())
        # The thread is told to stop, and nobody waits for it.
        self.assertEqual((modifier.find(self.obj), scheduler.running_builds(), self.shown()), (None, [], False))
        with self.area():
            bpy.ops.ed.redo()
        yield from self.until(self.shown)  # made anew, and the window goes on
        self.assertIsNot(self.builds[-1], threading.main_thread())
        self.go.set()
        yield from self.until(lambda: runtimes.of(self.obj).result is not None and not self.shown())
        self.assertEqual((runtimes.of(self.obj).result is not None, self.obj.rumple.message), (True, ""))

    def test_a_script_gets_its_wrinkles_at_once(self) -> Iterator[float]:
        yield from self.make(wrinkled=False)
        threading.Timer(0.5, self.go.set).start()
        with self.area():
            bpy.ops.object.rumple_add(method="MESH")
        self.assertGreater(self.count(self.obj), len(self.obj.data.vertices))
        self.assertEqual(scheduler.running_builds(), [])

    def test_a_first_click_that_cannot_be_made_is_said(self) -> Iterator[float]:
        for error, said in ((UserError("Sleeve: no"), "^Sleeve: no$"), (MemoryError(), "^Sleeve: there is not enough")):
            yield from self.click()
            self._error = error
            self.go.set()
            yield from self.until(lambda: self.obj.rumple.message)
            self.assertRegex(self.obj.rumple.message, said)
            for frame in (3, 4):  # and is not tried again and again
                with self.area():
                    sleeve.at(frame)
                yield 0.4
            self.assertEqual(len(self.builds), 1)
            self._error = None

    def test_apply_waits_for_the_first_click(self) -> Iterator[float]:
        yield from self.click()
        coarse = len(self.obj.data.vertices)
        threading.Timer(0.3, self.go.set).start()
        with self.area():
            self.assertEqual(bpy.ops.object.rumple_apply(), {"FINISHED"})
        self.assertGreater(len(self.obj.data.vertices), coarse)

    def test_esc_leaves_folds_and_settings_as_they_were(self) -> Iterator[float]:
        yield from self.make()
        folds = sleeve.shown(self.obj).copy()
        self.obj.rumple.mesh.level = 2
        yield from self.until(self.shown)
        yield from self.esc()
        self.assertEqual(self.obj.rumple.mesh.level, 1)
        yield from self.until(lambda: not runtimes.of(self.obj).stale)
        self.assertFalse(self.shown())
        self.go.set()  # what was dropped comes too late
        yield 0.5
        self.assertEqual((self.count(self.obj), self.obj.rumple.message), (self.before, ""))
        np.testing.assert_allclose(sleeve.shown(self.obj), folds, atol=1e-6)
        self.obj.rumple.mesh.level = 2  # and it can be asked for again
        yield from self.until(lambda: self.count(self.obj) > 3 * self.before)
        self.assertGreater(self.count(self.obj), 3 * self.before)

    def test_esc_where_no_setting_was_changed_says_so(self) -> Iterator[float]:
        yield from self.make()
        self.obj.data.vertices[0].co.z += 0.01
        self.obj.data.update()
        yield from self.until(self.shown)
        yield from self.esc()
        yield from self.until(lambda: self.obj.rumple.message)
        self.assertRegex(self.obj.rumple.message, "^Sleeve: Esc stopped the building of its fine mesh")
        self.assertEqual(self.count(self.obj), self.before)
        self.go.set()
        self.obj.rumple.mesh.level = 2
        yield from self.until(lambda: self.count(self.obj) > 3 * self.before)
        self.assertEqual(self.obj.rumple.message, "")

    def test_another_value_meanwhile_is_the_one_that_counts(self) -> Iterator[float]:
        yield from self.make()
        self.obj.rumple.mesh.level = 2
        yield from self.until(self.shown)
        former = runtimes.of(self.obj).build.running
        self.obj.rumple.mesh.level = 0
        yield 0.5
        self.assertNotIn(former, scheduler.running_builds())
        self.go.set()
        yield from self.until(lambda: self.count(self.obj) < self.before)
        self.assertLess(self.count(self.obj), self.before)
        yield from self.until(lambda: not self.shown())
        self.assertFalse(self.shown())

    def test_what_cannot_be_made_is_said(self) -> Iterator[float]:
        yield from self.make()
        with mock.patch.object(WrinkleMesh, "build", mock.Mock(side_effect=UserError("Sleeve: no"))):
            self.obj.rumple.mesh.level = 2
            yield from self.until(lambda: self.obj.rumple.message)
        self.assertEqual((self.obj.rumple.message, self.count(self.obj)), ("Sleeve: no", self.before))

    def test_who_cannot_wait_gets_it_now(self) -> Iterator[float]:
        """As a render does."""
        yield from self.make()
        self.obj.rumple.mesh.level = 2
        yield from self.until(self.shown)
        threading.Timer(0.5, self.go.set).start()
        scheduler.sync_all()
        self.assertGreater(self.count(self.obj), 3 * self.before)
        self.assertEqual(len(self.builds), 1)
        yield from self.until(lambda: not self.shown())
        self.assertFalse(self.shown())

    def test_another_file_meanwhile(self) -> Iterator[float]:
        yield from self.make()
        self.obj.rumple.mesh.level = 2
        yield from self.until(self.shown)
        sleeve.empty_file()
        yield 0.5
        self.go.set()
        yield 0.5
        self.assertEqual(scheduler.running_builds(), [])
        self.assertEqual(evaluator.cancel(None, runtimes.Runtime()), "")

    def test_the_mouse_is_asked_for_between_builds(self) -> Iterator[float]:
        """It calls an operator in an override of the context. Until Python 3.12 that breaks Python's memory if a thread
        uses Python at that moment: Blender 3.4 crashed after 17,000 to 240,000 of these calls beside busy threads."""
        yield from self.make()
        beside_a_build: list[bool] = []
        self.addCleanup(scheduler.set_mouse_held_test, scheduler._is_mouse_held)
        scheduler.set_mouse_held_test(lambda: bool(beside_a_build.append(bool(scheduler.running_builds()))))
        for level in (3, 2):
            self.obj.rumple.mesh.level = level
            yield from self.until(self.shown)
        self.go.set()
        yield from self.until(lambda: not self.shown())
        self.assertEqual(set(beside_a_build), {False})

    def test_the_thread_of_a_job_sleeps_until_the_work_is_done(self) -> Iterator[float]:
        """For the same reason: it looked every 50 ms."""
        yield from self.until(lambda: not scheduler.work_is_due())
        build = SimpleNamespace(name="Sleeve", seconds=0.0, is_running=lambda: True)
        looks = mock.patch.object(scheduler, "work_is_due", mock.Mock(wraps=scheduler.work_is_due))
        counted = looks.start()
        self.addCleanup(looks.stop)
        scheduler.add_build(build)
        self.addCleanup(scheduler.remove_build, build)
        job = threading.Thread(target=scheduler.wait_for_work, args=(30.0,))
        job.start()
        yield 0.5
        self.assertEqual((job.is_alive(), counted.call_count), (True, 1))
        scheduler.remove_build(build)
        job.join(10.0)
        self.assertFalse(job.is_alive())
