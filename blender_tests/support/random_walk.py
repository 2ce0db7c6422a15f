# SPDX-License-Identifier: GPL-3.0-or-later
"""Random walks through what an artist may do. A walk has steps, methods do_*(), and a law, check(), that holds after
every step."""
from __future__ import annotations

import os
import random
from typing import Any, Iterator

import bpy
from rumple.blender.objects import kept_lists
from support import sleeve

MOST_OBJECTS = 4


def seeds(count: int) -> range:
    """Of walks: so many, and $RUMPLE_LONG times as many where that is set, from $RUMPLE_FIRST_SEED on."""
    first = int(os.environ.get("RUMPLE_FIRST_SEED", "0"))
    return range(first, first + count * int(os.environ.get("RUMPLE_LONG", "1")))


class RandomWalk:
    """steps() yields after each step, so that a window can redraw in between."""

    REOPEN = 0.02  # chance of saving and opening the file before a step
    OFTEN: tuple[str, ...] = ()  # names of steps that come up more often

    def __init__(self, seed: int, folder: str) -> None:
        print(f"walk with seed {seed}")  # shown where it fails
        self.random = random.Random(seed)
        self.path = os.path.join(folder, "walk.blend")
        self.done = []

    def steps(self, count: int) -> Iterator[Any]:
        self.start()
        with sleeve.context():
            bpy.ops.ed.undo_push(message="start")
        names = [name for name in dir(self) if name.startswith("do_")] + list(self.OFTEN)
        for _ in range(count):
            name = self.choose(names)
            self.done.append(name)
            if self.random.random() < self.REOPEN:
                self.save_and_open()
            with sleeve.context():
                self.leave_mode()
                getattr(self, name)()
                if bpy.context.view_layer.objects.active and name not in ("do_undo", "do_redo"):
                    bpy.ops.ed.undo_push(message=name)
            yield from self.between()
            with sleeve.context():
                self.check()

    # --- for a walk of its own
    def start(self) -> None:
        """Makes the scene."""
        raise NotImplementedError

    def choose(self, names: list[str]) -> str:
        """The next step."""
        return self.random.choice(names)

    def is_ours(self, obj: bpy.types.Object) -> bool:
        """Whether an object has what the walk is about."""
        raise NotImplementedError

    def between(self) -> Iterator[Any]:
        """What goes on in a window after a step, before the law is looked at."""
        yield

    def check(self) -> None:
        """The law."""
        raise NotImplementedError

    # --- helpers
    def check_lists(self) -> None:
        """What is kept of the file's objects is what a search finds."""
        for kept in kept_lists._all:
            found, searched = ([obj.name_full for obj, _ in pairs] for pairs in (kept, kept._searched()))
            assert found == searched, f"after {self.done[-8:]}: {found} are kept, {searched} are there"

    def leave_mode(self) -> None:
        active = bpy.context.view_layer.objects.active
        if active is not None and active.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")

    def save_and_open(self) -> None:
        """Outside any context override: the windows of the file before are gone."""
        bpy.ops.wm.save_as_mainfile(filepath=self.path)
        bpy.ops.wm.open_mainfile(filepath=self.path)

    def pick(self, ours: bool = True) -> Any:
        """Makes one mesh object active; None where there is none."""
        found = [o for o in bpy.context.scene.objects if o.type == "MESH" and self.is_ours(o) == ours]
        if not found:
            return None
        sleeve.make_active(self.random.choice(found))
        return bpy.context.view_layer.objects.active

    # --- steps of every walk
    def do_duplicate(self) -> None:
        if len(bpy.context.scene.objects) < MOST_OBJECTS + 1 and self.pick():
            bpy.ops.object.duplicate(linked=self.random.random() < 0.5)

    def do_delete(self) -> None:
        if len([o for o in bpy.context.scene.objects if o.type == "MESH"]) > 1 and self.pick():
            bpy.ops.object.delete()

    def do_undo(self) -> None:
        for _ in range(self.random.randint(1, 3)):
            if bpy.ops.ed.undo.poll():
                bpy.ops.ed.undo()

    def do_redo(self) -> None:
        if bpy.ops.ed.redo.poll():
            bpy.ops.ed.redo()
