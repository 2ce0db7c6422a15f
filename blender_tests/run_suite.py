# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs one suite of unittest cases inside any Blender, or in plain Python. Started by scripts/suite.

    blender -b --factory-startup --python blender_tests/run_suite.py -- background [words...]
    blender --factory-startup --python blender_tests/run_suite.py -- window [words...]
    python3 blender_tests/run_suite.py python [words...]

Files run in the order of their names, classes and tests as they stand in the file; with words, only tests
whose name has one of them. In a window a test may be a generator: each `yield` goes back to Blender's event
loop for one redraw, `yield 0.5` for half a second (see support/window_case.py).

A traceback that is printed while a test runs fails the test, whoever printed it: handlers, operators,
panels and timers swallow their exceptions. For this everything that a test prints, Blender's own output
included, goes to a file and is shown only for a test that failed.

Environment: RUMPLE_THIRDS=2,3, two thirds of the files; RUMPLE_NATIVE, folder of librumple; RUMPLE_OUT, where tests
leave pictures; RUMPLE_DATA, the real scenes. The last line is `SUITE name ran=N failed=N skipped=N`.
"""
from __future__ import annotations

import ctypes
import faulthandler
import functools
import importlib
import inspect
import os
import sys
import tempfile
import time
import traceback
import unittest
from pathlib import Path
from types import ModuleType
from typing import Any, Callable, Generator, Iterator

HERE = Path(__file__).resolve().parent
FOLDERS = {"python": "without_blender"}     # the others are named as their suites
SHORT = 0.1  # seconds: in a pause below this Blender redraws what it thinks that it has to, and not everything
TRACEBACK = "Traceback (most recent call last)"


class Output:
    """Takes what the process prints, C code included, away from the terminal and hands it out in portions."""

    def __init__(self) -> None:
        self.terminal = os.fdopen(os.dup(1), "w", buffering=1, encoding="utf-8")
        self.file = tempfile.TemporaryFile()
        os.dup2(self.file.fileno(), 1)
        os.dup2(self.file.fileno(), 2)
        faulthandler.enable(self.terminal)      # a crash says where, before the process is gone
        self.read = 0

    def say(self, text: str, end: str = "\n") -> None:
        self.terminal.write(text + end)
        self.terminal.flush()

    def take(self) -> str:
        """What was printed since the last call."""
        sys.stdout.flush()
        sys.stderr.flush()
        ctypes.CDLL(None).fflush(None)
        end = os.fstat(self.file.fileno()).st_size
        data = os.pread(self.file.fileno(), end - self.read, self.read)
        self.read = end
        return data.decode(errors="replace")


def as_steps(function: Callable[..., Any]) -> Iterator[float]:
    """Calls it; a generator's yields are passed on."""
    result = function()
    if not inspect.isgenerator(result):
        return
    for pause in result:
        if getattr(sys.modules.get("support.sleeve"), "open_overrides", 0):
            # Blender's event loop would look into the override without holding Python's lock: while a render job
            # runs handlers in its thread, 3.4 crashes there, with no Python frame in the main thread.
            result.close()
            raise AssertionError("a test yields inside a context override: end it first")
        yield pause


class Trial:
    """One test while it runs: what went wrong, or why it was skipped."""

    def __init__(self) -> None:
        self.problems: list[str] = []
        self.skipped: str | None = None

    def attempt(self, function: Callable[..., Any]) -> Generator[float, None, bool]:
        """Steps; returns whether the function went through."""
        try:
            yield from as_steps(function)
            return True
        except unittest.SkipTest as reason:
            self.skipped = str(reason)
        except Exception:
            self.problems.append(traceback.format_exc())
        return False

    def run(self, test: unittest.TestCase, method: Callable[..., Any]) -> Iterator[float]:
        reason = getattr(method, "__unittest_skip_why__", None) or getattr(test, "__unittest_skip_why__", None)
        if reason is not None:
            self.skipped = reason
            return
        if (yield from self.attempt(test.setUp)):
            yield from self.attempt(method)
            yield from self.attempt(test.tearDown)
        while test._cleanups:
            function, arguments, keywords = test._cleanups.pop()
            yield from self.attempt(functools.partial(function, *arguments, **keywords))


class Suite:
    def __init__(self, name: str, words: list[str]) -> None:
        self.name, self.words = name, words
        self.output = Output()
        self.ran = self.failed = self.skipped = 0

    def steps(self) -> Iterator[float]:
        """The whole run, as steps."""
        folder = HERE / FOLDERS.get(self.name, self.name)
        sys.path[:0] = [str(folder), str(HERE)]
        if (yield from self.judge("start", self.start)):
            thirds = os.environ.get("RUMPLE_THIRDS", "1,2,3")
            for number, path in enumerate(sorted(folder.glob("test_*.py"))):
                if str(1 + number % 3) in thirds:
                    yield from self.run_module(path.stem)

    def start(self, trial: Trial) -> Iterator[float]:
        yield from trial.attempt(functools.partial(make_ready, self.name))

    def run_module(self, name: str) -> Iterator[float]:
        cases = []

        def load(trial: Trial) -> Iterator[float]:
            yield from trial.attempt(lambda: cases.extend(cases_of(importlib.import_module(name))))

        if not (yield from self.judge(name, load)):
            return
        for case in cases:
            yield from self.run_case(case)

    def run_case(self, case: type[unittest.TestCase]) -> Iterator[float]:
        names = unittest.defaultTestLoader.getTestCaseNames(case)
        names = [name for name in names if self.wanted(f"{case.__module__}.{case.__name__}.{name}")]
        if not names:
            return
        names.sort(key=lambda name: line_of(getattr(case, name)))
        title = f"{case.__module__}.{case.__name__}"
        if not getattr(case, "__unittest_skip__", False):
            if not (yield from self.judge(title, lambda trial: trial.attempt(case.setUpClass))):
                return
        for name in names:
            test = case(name)
            yield from self.judge(f"{title}.{name}", lambda trial: trial.run(test, getattr(test, name)), counts=True)
        yield from self.judge(title, lambda trial: trial.attempt(case.tearDownClass))
        yield from self.judge(title, lambda trial: trial.attempt(case.doClassCleanups))

    def wanted(self, title: str) -> bool:
        return not self.words or any(word in title for word in self.words)

    def judge(self, title: str, run: Callable[[Trial], Iterator[float]],
              counts: bool = False) -> Generator[float, None, bool]:
        """Runs something and reports it; what is no test (counts False) only where it fails."""
        if counts:
            self.output.say(f"{title} ... ", end="")
        trial, start = Trial(), time.perf_counter()
        yield from run(trial)
        seconds = time.perf_counter() - start
        yield       # timers and handlers that the test has set going may still have something to say
        printed = self.output.take()
        if TRACEBACK in printed:
            trial.problems.append("a traceback was printed")
        if not counts and trial.problems:
            self.output.say(f"{title} ... ", end="")
        self.count(title, trial, counts, seconds)
        for text in trial.problems + ([f"It printed:\n{printed}"] if trial.problems and printed else []):
            self.output.say("    " + text.rstrip().replace("\n", "\n    "))
        return not trial.problems and (counts or trial.skipped is None)

    def count(self, title: str, trial: Trial, counts: bool, seconds: float) -> None:
        if trial.problems:
            self.ran += 1
            self.failed += 1
            self.output.say(f"FAILED {seconds:.2f} s")
        elif trial.skipped is not None:
            self.skipped += 1
            self.output.say(f"skipped: {trial.skipped}")
        elif counts:
            self.ran += 1
            self.output.say(f"ok {seconds:.2f} s")
        elif seconds > 1.0:
            self.output.say(f"{title}: made ready, or cleared away, in {seconds:.0f} s")

    def finish(self) -> None:
        """Says the last line and ends the process; wm.quit_blender would hang in 4.3."""
        self.output.say(f"SUITE {self.name} ran={self.ran} failed={self.failed} skipped={self.skipped}")
        os._exit(1 if self.failed or not self.ran else 0)


def cases_of(module: ModuleType) -> list[type[unittest.TestCase]]:
    """Its own test cases, in the order of the file."""
    classes = [value for value in vars(module).values() if isinstance(value, type)]
    cases = [value for value in classes if issubclass(value, unittest.TestCase) and value.__module__ == module.__name__]
    return sorted(cases, key=lambda case: inspect.getsourcelines(case)[1])


def line_of(method: Callable[..., Any]) -> int:
    return inspect.unwrap(method).__code__.co_firstlineno


def make_ready(suite: str) -> None:
    """Puts the add-on and the module on the path and, inside Blender, enables the add-on as Blender does."""
    if suite in ("package", "site"):    # test what Blender installs, and what a browser shows: not this tree
        return
    sys.path[:0] = [str(HERE.parent / "addon"), os.environ["RUMPLE_NATIVE"]]
    if suite in ("python", "farm", "engines"):
        return
    import addon_utils
    import bpy
    import rumple_native    # noqa: F401  a missing library fails here, in words, and not in every test
    if suite == "window" and bpy.app.background:
        raise RuntimeError("the window suite was started with -b: it needs a window (scripts/suite window)")
    errors: list[BaseException] = []
    if addon_utils.enable("rumple", default_set=True, persistent=True, handle_error=errors.append) is None:
        raise errors[0] if errors else RuntimeError("the add-on rumple could not be enabled")


def run_at_once(suite: Suite) -> None:
    for _ in suite.steps():
        pass
    suite.finish()


def draw_less(*_handler_arguments: object) -> None:
    """Viewports without their grid, axes and outlines, by which the processor takes twice as long to draw them."""
    import bpy
    for area in (area for screen in bpy.data.screens for area in screen.areas if area.type == "VIEW_3D"):
        overlay = area.spaces.active.overlay
        overlay.show_floor = overlay.show_axis_x = overlay.show_axis_y = overlay.show_outline_selected = False


def run_from_timer(suite: Suite) -> None:
    """One step for each turn of the event loop, with everything redrawn in between."""
    import bpy
    bpy.context.preferences.view.show_splash = False
    bpy.context.preferences.system.viewport_aa = "OFF"      # a third of a redraw by the processor
    bpy.context.preferences.system.use_overlay_smooth_wire = False
    draw_less()
    bpy.app.handlers.load_post.append(bpy.app.handlers.persistent(draw_less))
    steps = suite.steps()

    def tick() -> float:
        try:
            pause = next(steps)
        except StopIteration:
            suite.finish()
        except BaseException:
            suite.failed += 1
            suite.output.say(traceback.format_exc())
            suite.finish()
        if not pause or pause >= SHORT:
            for window in bpy.context.window_manager.windows:
                for area in window.screen.areas:
                    area.tag_redraw()
        return pause or 0.0

    bpy.app.timers.register(tick, first_interval=0.5, persistent=True)


def main() -> None:
    arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
    suite = Suite(arguments[0], arguments[1:])
    if suite.name == "window" and "bpy" in sys.modules and not sys.modules["bpy"].app.background:
        run_from_timer(suite)
    else:
        run_at_once(suite)


if __name__ == "__main__":
    main()
