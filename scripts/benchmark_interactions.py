# SPDX-License-Identifier: GPL-3.0-or-later
"""Run by Blender in a window: how long each thing that an artist does takes, and the longest that the window stood
still meanwhile. By mouse and keys where the time is theirs.

    d=$(mktemp -d); RUMPLE_NATIVE=build/release/python RUMPLE_FRAMEBUFFER=$d/Xvfb_screen0 RUMPLE_OUT=$d \
        xvfb-run -a -s "-screen 0 960x720x24 -fbdir $d" blender --factory-startup --enable-event-simulate \
        --window-geometry 0 0 960 720 ../shared/data/S1_walk_shirt.blend \
        --python scripts/benchmark_interactions.py -- shirt 3

Which garment, how many rounds. Prints a table in Markdown: the median and the worst of the rounds. A redraw by the
processor is part of them; its row says what that costs. What the main thread was busy in a standstill hangs least on
what else the machine does.
"""
from __future__ import annotations

import os
import statistics
import sys
import time
from pathlib import Path
from typing import Callable, Iterator

import bpy

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "addon"), str(ROOT / "blender_tests"), os.environ["RUMPLE_NATIVE"]]
import rumple  # noqa: E402
from rumple.blender import scheduler  # noqa: E402
from rumple.blender.objects import runtimes  # noqa: E402
from support.artist import Artist  # noqa: E402

GARMENT, ROUNDS = sys.argv[sys.argv.index("--") + 1], int(sys.argv[sys.argv.index("--") + 2])
TICK = 0.01  # seconds between two looks at the clock
FRAME, FAR = 20, 60

artist = Artist()
taken: dict[str, list[tuple[float, float, float]]] = {}  # (until it is seen, longest standstill, and busy in one), s


class Clock:
    """How long the window stood still, between two turns of Blender's event loop."""

    def __init__(self) -> None:
        self.last = self.worst = self.busy_last = self.busy = 0.0

    def begin(self) -> None:
        self.last, self.worst, self.busy_last, self.busy = time.perf_counter(), 0.0, time.thread_time(), 0.0

    def tick(self) -> None:
        now = time.perf_counter()
        self.worst, self.last = max(self.worst, now - self.last), now
        now = time.thread_time()
        self.busy, self.busy_last = max(self.busy, now - self.busy_last), now


clock = Clock()


def garment() -> bpy.types.Object:
    return bpy.data.objects[GARMENT]


def is_settled() -> bool:
    runtime = runtimes.known(garment())
    return (runtime is None or not runtime.stale) and not scheduler.running_builds()


def measured(name: str, act: Callable[[], Iterator[float] | None], until: Callable[[], bool] = is_settled
             ) -> Iterator[float]:
    """Do it, and wait until it is seen."""
    began = time.perf_counter()
    clock.begin()
    steps = act()
    if steps is not None:
        yield from steps
    yield TICK
    while not until():
        yield TICK
    yield TICK  # a redraw
    taken.setdefault(name, []).append((time.perf_counter() - began, clock.worst, clock.busy))


def operator(call: Callable[..., object], **how: object) -> Callable[[], None]:
    def act() -> None:
        with artist.area():
            call(**how)
    return act


def dragged(label: str, pixels: int) -> Callable[[], Iterator[float]]:
    """A slider of the maximised modifier tab, there and back half the way."""
    def act() -> Iterator[float]:
        x, y = places[label]
        yield from artist.move((x, y))
        artist.event("LEFTMOUSE", "PRESS")
        for step in (*range(1, 13), *range(11, 5, -1)):
            artist.here = (x + pixels * step // 12, y)
            artist.event("MOUSEMOVE", "NOTHING")
            yield TICK
        artist.event("LEFTMOUSE", "RELEASE")
    return act


places: dict[str, tuple[int, int]] = {}


def rounds() -> Iterator[float]:
    for number in range(ROUNDS):
        yield from measured("redraw alone", lambda: None)
        yield from measured("add, the first click", operator(bpy.ops.object.rumple_add, method="MESH"))
        yield from measured("jump to a frame", lambda: bpy.context.scene.frame_set(FAR + number))
        yield from measured("the next frame", lambda: bpy.context.scene.frame_set(FAR + number + 1))
        yield from measured("preset", operator(bpy.ops.object.rumple_preset, preset="DENIM"))
        with artist.area():
            bpy.ops.ed.undo_push(message="Denim")
            bpy.ops.object.rumple_preset(preset="SILK")
            bpy.ops.ed.undo_push(message="Silk")
        yield 1.0
        yield from measured("undo of a preset", operator(bpy.ops.ed.undo))
        yield from artist.modifier_tab()
        for label in ("Folds", "Wavelength"):
            places[label] = yield from artist.beside(label)
        yield from measured("drag of Folds (solved while it is dragged)", dragged("Folds", -120))
        yield from measured("drag of Wavelength (built when it is let go)", dragged("Wavelength", 36))
        yield from artist.maximise("PROPERTIES")
        yield from paint()
        with artist.area():
            bpy.ops.object.rumple_remove()
            garment().vertex_groups.remove(garment().vertex_groups["Rumple Drape"])
            for name in list(garment().rumple.mesh.keys()):
                garment().rumple.mesh.property_unset(name)
        bpy.context.scene.frame_set(FRAME)
        yield 1.0


def paint() -> Iterator[float]:
    with artist.area():
        bpy.ops.object.rumple_paint(group="drape")
    yield 1.0
    x, y = artist.box("VIEW_3D").middle
    yield from measured("stroke of Weight Paint, 24 steps",
                        lambda: artist.stroke([(x - 48 + 4 * step, y) for step in range(25)]))
    with artist.area():
        bpy.ops.object.rumple_paint(group="drape")


def steps() -> Iterator[float]:
    bpy.context.preferences.view.show_splash = False
    artist.setUp()
    for obj in bpy.context.view_layer.objects:
        obj.select_set(obj == garment())
    bpy.context.view_layer.objects.active = garment()
    bpy.context.scene.frame_set(FRAME)
    with artist.area():
        bpy.ops.view3d.view_selected()
    yield 1.0
    yield from rounds()
    print(f"\nBlender {bpy.app.version_string}, {GARMENT}, {ROUNDS} rounds\n")
    print("| | until it is seen, s | worst | longest standstill, s | worst | its main thread, s | worst |\n"
          "|---|---|---|---|---|---|---|")
    for name, found in taken.items():
        cells = (f"{number:.2f}" for column in zip(*found) for number in (statistics.median(column), max(column)))
        print(f"| {name} | {' | '.join(cells)} |")
    sys.stdout.flush()


def main() -> None:
    rumple.register()
    running, due = steps(), [time.perf_counter() + 2.0]

    def advance() -> float:
        clock.tick()
        if time.perf_counter() >= due[0]:
            try:
                due[0] = time.perf_counter() + (next(running) or 0.0)
            except StopIteration:
                os._exit(0)
            except BaseException as error:
                print(f"broke off: {error!r}", flush=True)
                os._exit(1)
        return TICK

    bpy.app.timers.register(advance, first_interval=2.0)


main()
