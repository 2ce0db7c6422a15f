# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's force fields: native/include/rumple/force_fields.h; docs/base_cloth.md has the formulas."""
from __future__ import annotations

from typing import Any, NamedTuple, Sequence

import numpy as np

from . import c
from .arrays import FLOAT, address, given, new
from .library import lib
from .struct import Choice, Vector


class ForceField(c.ForceField):
    """A force field. Lengths are in world units."""

    __slots__ = ()
    kind: Any = Choice(c.FORCE_FIELD_KIND)
    shape: Any = Choice(c.FORCE_FIELD_SHAPE)
    falloff: Any = Choice(c.FORCE_FIELD_FALLOFF)
    side: Any = Choice(c.FORCE_FIELD_SIDE)
    location: Any = Vector("three floats, world space")
    axis: Any = Vector("three floats: Z of the object, of any length")

    def __new__(cls) -> "ForceField":
        return cls.from_buffer_copy(lib.rumple_force_field_default())


class FieldEffects(NamedTuple):
    """The effects of force fields at points, world space, in the units of their strengths."""

    air: np.ndarray  # (p, 3) float32: velocity of the air
    push: np.ndarray  # (p, 3) float32: force
    resist: np.ndarray  # (p, 2) float32, >= 0: coefficients of linear and of quadratic drag


def evaluate_force_fields(fields: Sequence[ForceField], frame: int, positions: np.ndarray) -> FieldEffects:
    """The sum of all fields. frame: seed of the noise that changes from frame to frame. positions: (p, 3) float32,
    world space."""
    place, count = given(positions, "positions", FLOAT, 3)
    out = FieldEffects(new(FLOAT, count, 3), new(FLOAT, count, 3), new(FLOAT, count, 2))
    together = (c.ForceField * len(fields)).from_buffer_copy(b"".join(bytes(field) for field in fields) or b"")
    lib.rumple_force_fields_evaluate(together, len(fields), frame, place, count,
                                     *(number for array in out for number in (address(array), count)))
    return out


__all__ = ["FieldEffects", "ForceField", "evaluate_force_fields"]
