# SPDX-License-Identifier: GPL-3.0-or-later
"""The result of a solved frame. Never imports bpy."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Attribute:
    """A float or a vector for shaders and nodes, on the points or the corners of the shown mesh."""

    name: str
    vector: bool = False
    domain: str = "POINT"  # POINT or CORNER
    rest: float = 0.0  # value before the first frame
    unit: bool = False  # a direction: normalised again after interpolation between baked samples
    angle: bool = False  # radians: baked without jumps by whole turns

    @property
    def data_type(self) -> str:
        """Blender's name of the type."""
        return "FLOAT_VECTOR" if self.vector else "FLOAT"


COMMON_ATTRIBUTES = (
    Attribute("rumple_stretch_min", rest=1.0), Attribute("rumple_stretch_max", rest=1.0),
    Attribute("rumple_stretch_direction", vector=True, unit=True), Attribute("rumple_offset", vector=True))


@dataclass
class FrameResult:
    """The shown mesh of one frame. d vertices; object space, object units."""

    local_offset: np.ndarray  # (d, 3) from the linear embedding, in the frame of the deformed base triangle
    positions: np.ndarray  # (d, 3)
    attributes: dict[str, np.ndarray]  # key: name in the system's ATTRIBUTES; (d or corners,) or (..., 3)
    report: Any = None
    milliseconds: dict[str, float] = field(default_factory=dict)  # by stage: solve, show
    replayed: bool = False
    unplayed: bool = False  # its cloth should swing, but the frame was reached by a jump

    @classmethod
    def of(cls, shown: Any, **own: np.ndarray) -> "FrameResult":
        """From a native result. own: the attributes that only this system has."""
        return cls(shown.local_offset, shown.positions, dict(
            rumple_stretch_min=shown.stretch_min, rumple_stretch_max=shown.stretch_max,
            rumple_stretch_direction=shown.stretch_direction, rumple_offset=shown.offset, **own))

    @classmethod
    def at_rest(cls, positions: np.ndarray, corners: int, attributes: tuple[Attribute, ...]) -> "FrameResult":
        """The result before the first frame."""
        return cls(np.zeros_like(positions), positions,
                   {a.name: np.full((len(positions) if a.domain == "POINT" else corners, *([3] if a.vector else [])),
                                    a.rest, np.float32) for a in attributes})

    @property
    def nbytes(self) -> int:
        """Memory of the arrays."""
        return sum(values.nbytes for values in (self.local_offset, self.positions, *self.attributes.values()))

    @property
    def offset(self) -> np.ndarray:
        """(d, 3) from the unwrinkled surface."""
        return self.attributes["rumple_offset"]

    def shows_the_same(self, other: "FrameResult | PreviewFrame") -> bool:
        """Whether an output object would hold the same bits."""
        return (isinstance(other, FrameResult) and np.array_equal(self.local_offset, other.local_offset)
                and self.attributes.keys() == other.attributes.keys()
                and all(np.array_equal(values, other.attributes[name]) for name, values in self.attributes.items()))


@dataclass
class PreviewFrame:
    """A frame for a viewport that draws the wrinkles itself. The shown mesh is not computed."""

    drawing: Any = None  # native drawing data; None: the viewport solves the frame itself
    proxy_offset: np.ndarray | None = None  # (n, 3) from the coarse vertices to the drawn surface, object space
    report: Any = None
    milliseconds: dict[str, float] = field(default_factory=dict)  # by stage: solve, show
    replayed: bool = False
    unplayed: bool = False  # see FrameResult

    def shows_the_same(self, other: "FrameResult | PreviewFrame") -> bool:
        """Whether an output object would hold the same bits."""
        if not isinstance(other, PreviewFrame) or self.proxy_offset is None or other.proxy_offset is None:
            return False
        return np.array_equal(self.proxy_offset, other.proxy_offset)
