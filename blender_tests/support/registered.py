# SPDX-License-Identifier: GPL-3.0-or-later
"""What the add-on has registered with Blender."""
from __future__ import annotations

from typing import Any, Iterator


def own_classes(base: type) -> Iterator[Any]:
    """The add-on's registered classes of a kind: bpy.types.Operator, Panel, PropertyGroup, ..."""
    for cls in base.__subclasses__():
        yield from own_classes(cls)
        if cls.__module__.startswith("rumple.") and getattr(cls, "is_registered", False):
            yield cls


def own_properties(cls: Any) -> Iterator[Any]:
    """What a class adds to its base."""
    base = cls.bl_rna.base
    inherited = set() if base is None else {prop.identifier for prop in base.properties}
    for prop in cls.bl_rna.properties:
        if prop.identifier not in inherited | {"rna_type"}:
            yield prop
