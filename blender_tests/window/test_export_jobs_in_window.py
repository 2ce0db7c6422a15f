# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports that Blender makes in the thread of a job, while the window goes on. Debian's Blender has neither Alembic nor
USD: a thread that calls the handlers, as their jobs do, stands for them."""
from __future__ import annotations

import threading
import unittest
from typing import Iterator
from unittest import mock

import bpy
from rumple.blender import handlers, scheduler
from rumple.blender.objects import runtimes
from support import sleeve
from support.window_case import WindowCase


class ExportJobs(WindowCase):

    def test_nothing_is_made_anew_under_one(self) -> Iterator[float]:
        """The job's depsgraph marked every garment as edited, and the window's timer removed data-blocks under it."""
        obj = sleeve.scene()
        yield from self.until(lambda: not bpy.app.timers.is_registered(scheduler._on_timer))
        built = runtimes.of(obj).evaluator
        depsgraph = bpy.context.evaluated_depsgraph_get()

        def export() -> None:
            handlers._on_frame(bpy.context.scene, depsgraph)
            runtimes.of(obj).stale = True
            scheduler.request()

        with mock.patch.object(scheduler, "JOB", 2.0):
            job = threading.Thread(target=export)
            job.start()
            job.join()
            self.assertFalse(bpy.app.timers.is_registered(scheduler._on_timer))
            obj.rumple.mesh.level = 3
            yield 1.0
            self.assertIs(runtimes.of(obj).evaluator, built)
            self.assertTrue(runtimes.of(obj).stale)
            yield from self.until(lambda: not runtimes.of(obj).stale)
        self.assertIsNot(runtimes.of(obj).evaluator, built)

    def test_what_a_job_asked_for_is_made_after_it(self) -> Iterator[float]:
        obj = sleeve.scene()
        yield 0.5

        def export() -> None:
            runtimes.of(obj).stale = True
            scheduler.request()

        job = threading.Thread(target=export)
        job.start()
        job.join()
        sleeve.at(2)
        yield from self.until(lambda: not runtimes.of(obj).stale)
        self.assertFalse(runtimes.of(obj).stale)


if __name__ == "__main__":
    unittest.main()
