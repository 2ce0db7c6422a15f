# SPDX-License-Identifier: GPL-3.0-or-later
"""The bake of a clip that is under way, if there is one: which garments it reads.

While it runs, both of Blender's passes output the coarse mesh (first_pass.py), the solved result is not written, and
garments that the bake does not read are not solved.
"""
from __future__ import annotations

import bpy

from ..nodes.output_flags import Flag, change_flag
from ..objects import bodies, modifier, runtimes

_names: frozenset[str] | None = None  # full names of the garments that the bake reads; None: no bake is running


def begin(obj: bpy.types.Object) -> None:
    """A bake begins, which reads the solved result of an object."""
    global _names
    _names = frozenset(one.name_full for one in (obj, *bodies.all_under(obj)))


def end() -> None:
    """The bake has ended: everything is shown again."""
    global _names
    _names = None
    for one, nodes_mod in modifier.wrinkled_objects():
        output = modifier.output_object(nodes_mod)
        if output is not None and change_flag(output, Flag.COARSE_ONLY, False):
            runtimes.of(one).invalidate_output()


def is_running() -> bool:
    """Whether there is one."""
    return _names is not None


def reads(obj: bpy.types.Object) -> bool:
    """Whether the bake reads an object."""
    return _names is not None and obj.name_full in _names
