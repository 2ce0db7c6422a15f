# SPDX-License-Identifier: GPL-3.0-or-later
"""The state of a frame that has a base cloth, and the report on its solve. Never imports bpy."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...native.surface import FrameState
from .base_cloth import ClothFrame

LEAST_UNDER = 0.02  # least share of vertices with the body under them: with fewer, something is wrong


@dataclass
class OnCloth:
    """The state of a frame that has a base cloth."""

    cloth: ClothFrame
    wrinkles: FrameState

    @property
    def nbytes(self) -> int:
        return self.cloth.nbytes + self.wrinkles.nbytes


State = FrameState | OnCloth  # of a frame


@dataclass
class OnClothReport:
    """How a frame that has a base cloth was solved."""

    cloth: Any  # native
    wrinkles: Any  # the system's report
    has_body: bool  # whether it was worn over a body
    is_free: bool = True  # False: there is no base cloth, and the animated mesh was only moved out of a body

    @property
    def layers(self) -> list[Any]:
        """The system's report on each layer, coarse first."""
        return self.wrinkles if isinstance(self.wrinkles, list) else [self.wrinkles]

    def lines(self, name: str, unit_scale: float) -> list[str]:
        """Lines for the artist. name: of the object; unit_scale: metres per object unit."""
        offset = 1000.0 * unit_scale * self.cloth.offset_mean
        under = 100.0 * self.cloth.body_known
        lines = [f"Base cloth: {offset:.1f} mm from the animation on average, {under:.0f} % has the body under it"
                 if self.is_free else
                 f"Body: it moves the mesh by {offset:.1f} mm on average, {under:.0f} % has the body under it"]
        if self.has_body and self.cloth.body_known < LEAST_UNDER:
            lines.append(f"{name}: its body does not lie under it: choose another body")
        return lines


def system_state(state: State | None) -> FrameState | None:
    """A system's own part of a stored state, or None."""
    return state.wrinkles if isinstance(state, OnCloth) else state


def cloth_of(state: State | None) -> ClothFrame | None:
    """The base cloth of a stored state, or None."""
    return state.cloth if isinstance(state, OnCloth) else None
