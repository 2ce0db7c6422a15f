# SPDX-License-Identifier: GPL-3.0-or-later
"""Estimates how long a bake takes, from measured times. Shown before a bake and while it runs."""
from __future__ import annotations

import bpy

from .. import compat
from ..objects import bodies, modifier, runtimes, units

LEAST = 5.0  # seconds: shorter bakes get no message


def note(objects: list[bpy.types.Object], scene: bpy.types.Scene) -> str:
    """A message before these objects are baked one after the other. Empty for a short bake, or if one of them was never
    solved."""
    each = [_seconds(obj, scene) for obj in objects]
    if not each or not all(each) or sum(each) < LEAST:
        return ""
    if len(objects) > 1:
        return f"Bake All takes about {in_words(sum(each))}, as the last frames took"
    return f"A bake takes about {in_words(each[0])}, as the last frame took"


def bake_all(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """The objects that Bake All bakes, in order."""
    pairs = [pair for pair in modifier.wrinkled_objects()
             if pair[0].name in scene.objects and compat.is_editable(pair[0])]
    return [obj for obj, _ours in bodies.in_order(pairs)]


def left(elapsed: float, done: int, count: int) -> str:
    """The remaining time of a bake with `done` of `count` samples; empty if it is short or not known yet."""
    seconds = elapsed * (count - done) / done if done else 0.0
    return in_words(seconds) if elapsed > 1.0 and seconds >= LEAST else ""


def in_words(seconds: float) -> str:
    """A time as text, with two digits, because it is an estimate."""
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * size:
            return f"{float(f'{seconds / size:.2g}'):g} {unit}"
    return f"{float(f'{seconds:.2g}'):g} s"


def _seconds(obj: bpy.types.Object, scene: bpy.types.Scene) -> float:
    """Estimated time of all frames that a bake solves, including those before its first one."""
    runtime = runtimes.known(obj)
    if modifier.find(obj) is None or runtime is None:
        return 0.0
    start, end = units.bake_range(obj, scene)
    before = max(start - units.first_frame(obj, scene), 0)
    return runtime.frame_seconds * (before + max(end - start, 0) * obj.rumple.bake_samples + 1)
