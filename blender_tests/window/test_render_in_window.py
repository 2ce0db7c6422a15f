# SPDX-License-Identifier: GPL-3.0-or-later
"""The frame rendered is the frame solved, in a window: all engines, and F12 as it runs for an artist."""
from __future__ import annotations

import functools
import os
import tempfile
from pathlib import Path
from types import SimpleNamespace
from typing import Iterator
from unittest import mock

import bpy
import numpy as np
from rumple.blender import compat, handlers, render_lock, scheduler
from rumple.blender.frame import clip_status
from rumple.blender.objects import runtimes
from support import reference_solve, render_cases, sleeve, small_renders
from support.window_case import WindowCase


class Engines(render_cases.Engines, WindowCase):
    """In a window; the background suite has the same."""


class RenderJob(WindowCase):
    """Ctrl-F12 and F12: the handlers run in the thread of the job, while the window draws."""

    def files(self, engine: str, **how: object) -> Iterator[float]:
        """A job on a new stage."""
        self.obj = small_renders.stage(engine)
        yield from self.until(self.settled)
        yield from self.pictures(**how)

    def pictures(self, **how: object) -> Iterator[float]:
        """A job that leaves pictures in self.found, by their names."""
        scene = bpy.context.scene
        scene.render.use_lock_interface = True
        with tempfile.TemporaryDirectory() as folder:
            scene.render.filepath = os.path.join(folder, "f")
            scene.frame_start, scene.frame_end = 1, 5
            yield from self.render_job(**how)
            self.found = {path.stem: small_renders.read(str(path)) for path in sorted(Path(folder).iterdir())}

    def settled(self) -> bool:
        """The material of the stage has reached the output object: a job takes what is there."""
        return sleeve.output_object(self.obj).data.materials[0] == self.obj.data.materials[0]

    def check_animation(self, engine: str) -> Iterator[float]:
        yield from self.files(engine, animation=True)
        self.assertEqual(len(self.found), 5)
        for name, picture in zip(self.found, reference_solve.expected(self.obj, range(1, 6))):
            self.assertLessEqual(reference_solve.unlike(self.found[name], picture), render_cases.STRAY, name)
        self.assertEqual(self.obj.rumple.message, "")

    def setUp(self) -> None:
        view = bpy.context.preferences.view
        self.addCleanup(setattr, view, "render_display_type", view.render_display_type)
        view.render_display_type = "NONE"

    def test_a_job_puts_nothing_into_the_queue_of_the_windows(self) -> Iterator[float]:
        """The queue has no lock. Once in many jobs Blender 5.2 looked for a notice in it without end."""
        told, real = [], compat.values_changed

        def recorded(mesh: bpy.types.Mesh) -> None:
            real(SimpleNamespace(update=lambda: told.append(scheduler.in_main_thread()),
                                 update_tag=lambda: told.append(None)))
            real(mesh)

        with mock.patch.object(compat, "values_changed", recorded):
            yield from self.files("BLENDER_WORKBENCH", animation=True)
        self.assertIn(None, told)
        self.assertNotIn(False, told)

    def test_workbench_animation(self) -> Iterator[float]:
        yield from self.check_animation("BLENDER_WORKBENCH")

    def test_cycles_animation(self) -> Iterator[float]:
        yield from self.check_animation("CYCLES")

    def test_eevee_animation(self) -> Iterator[float]:
        yield from self.check_animation("EEVEE")

    def test_cycles_still(self) -> Iterator[float]:
        yield from self.files("CYCLES", write_still=True)
        (name, picture), = self.found.items()
        right, = reference_solve.expected(self.obj, [bpy.context.scene.frame_current])
        self.assertLessEqual(reference_solve.unlike(picture, right), render_cases.STRAY, name)

    def test_the_window_shows_its_own_frame_afterwards(self) -> Iterator[float]:
        yield from self.files("CYCLES", animation=True)
        with sleeve.context():
            sleeve.play()
            sleeve.at(15)
            seen = sleeve.shown(self.obj)
            bpy.context.scene.frame_end = 3
        yield from self.render_job(animation=True)
        yield 0.2
        with sleeve.context():
            self.assertEqual(bpy.context.scene.frame_current, 15)
            np.testing.assert_array_equal(sleeve.shown(self.obj), seen)

    def test_no_job_starts_a_timer(self) -> Iterator[float]:
        """Blender's list of timers is not guarded against threads, and the main thread may be going through it."""
        started, register = [], bpy.app.timers.register

        def note(*what: object, **how: object) -> None:
            started.append(scheduler.in_main_thread())
            register(*what, **how)

        patch = mock.patch.object(bpy.app.timers, "register", note)
        patch.start()
        self.addCleanup(patch.stop)
        yield from self.files("CYCLES", write_still=True)
        tagged: list[str] = []
        bpy.app.handlers.depsgraph_update_post.append(updated := lambda *_: tagged.append("updated"))
        self.addCleanup(bpy.app.handlers.depsgraph_update_post.remove, updated)
        yield from self.until(lambda: tagged)  # the window gets its own meshes back all the same
        self.assertTrue(tagged)
        self.assertNotIn(False, started)

    def test_a_job_waits_for_what_was_changed_just_before(self) -> Iterator[float]:
        """It took what was there, and after an edit nothing: what was pending waited for the end of the job."""
        self.obj = small_renders.stage("CYCLES")
        yield from self.until(self.settled)
        count = self.vertices()
        yield from self.pictures(just_before=functools.partial(setattr, self.obj.rumple.mesh, "level", 2),
                                 write_still=True)
        self.assertGreater(self.vertices(), 3 * count)
        (name, picture), = self.found.items()
        right, = reference_solve.expected(self.obj, [bpy.context.scene.frame_current])
        self.assertLessEqual(reference_solve.unlike(picture, right), render_cases.STRAY, name)

    def test_a_job_waits_for_an_edited_mesh(self) -> Iterator[float]:
        self.obj = small_renders.stage("CYCLES")
        yield from self.until(self.settled)
        seen: list[int] = []

        def note(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
            if depsgraph.mode == "RENDER":
                seen.append(len(self.obj.evaluated_get(depsgraph).data.vertices))

        bpy.app.handlers.frame_change_post.append(note)
        self.addCleanup(bpy.app.handlers.frame_change_post.remove, note)
        with sleeve.context():
            sleeve.make_active(self.obj)
            bpy.ops.object.mode_set(mode="EDIT")
            bpy.ops.mesh.select_all(action="SELECT")
            bpy.ops.mesh.subdivide()
            bpy.ops.object.mode_set(mode="OBJECT")
        bpy.context.view_layer.update()
        self.assertTrue(runtimes.of(self.obj).stale)
        coarse = len(self.obj.data.vertices)
        yield from self.pictures(animation=True)
        self.assertEqual(len(seen), 5)
        self.assertGreater(min(seen), 2 * coarse)
        self.assertEqual(self.obj.rumple.message, "")

    def test_a_job_does_not_wait_for_ever_and_says_what_it_lacks(self) -> Iterator[float]:
        # Nothing may be rebuilt in the thread of a job: the window draws what would be removed.
        self.obj = small_renders.stage("CYCLES")
        yield from self.until(self.settled)
        before, count, said = small_renders.still(15), self.vertices(), []
        self.addCleanup(setattr, scheduler, "DELAY", scheduler.DELAY)
        scheduler.DELAY = 8.0  # a busy machine may take longer than it to start the job
        for module, name, value in ((handlers, "_PATIENCE", 0.2), (clip_status, "print", said.append)):
            patch = mock.patch.object(module, name, value, create=True)
            patch.start()
            self.addCleanup(patch.stop)
        finer = functools.partial(setattr, self.obj.rumple.mesh, "level", 2)
        yield from self.pictures(just_before=finer, write_still=True)
        (name, picture), = self.found.items()
        self.assertLessEqual(reference_solve.unlike(picture, before), render_cases.STRAY, name)
        self.assertRegex("\n".join(said), "before rendering: .*: it was changed, and its folds are not made anew yet")
        yield from self.until(lambda: self.vertices() > 3 * count)
        self.assertGreater(self.vertices(), 3 * count)

    def test_the_interface_stays_locked_where_a_render_solves(self) -> Iterator[float]:
        """Without the lock the window evaluated what the job wrote, and Blender 4.3 crashed. Garments come into scenes
        in which nobody clicked: they are linked and appended."""
        sleeve.scene(wrinkles=False)
        other = bpy.data.scenes.new("Other")
        yield 2.0 * scheduler.LOOK
        self.assertFalse(other.render.use_lock_interface)
        with sleeve.context():
            sleeve.make_active(bpy.data.objects["Sleeve"])
            bpy.ops.object.rumple_add(method="MESH")
        yield from self.until(lambda: other.render.use_lock_interface)
        self.assertTrue(other.render.use_lock_interface)
        with mock.patch.object(render_lock, "is_baked", lambda _nodes_mod: True):
            other.render.use_lock_interface = False
            yield 2.0 * scheduler.LOOK
            self.assertFalse(other.render.use_lock_interface)

    def vertices(self) -> int:
        return len(sleeve.output_object(self.obj).data.vertices)

    def test_a_render_from_a_script_takes_what_the_script_just_set(self) -> None:
        # It runs in the main thread, before any timer has had its turn.
        obj = small_renders.stage("CYCLES")
        obj.rumple.mesh.level = 2
        found = small_renders.still(15)
        right, = reference_solve.expected(obj, [15])
        self.assertLessEqual(reference_solve.unlike(found, right), render_cases.STRAY)
