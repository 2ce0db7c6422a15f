# SPDX-License-Identifier: GPL-3.0-or-later
"""What is asked for of a frame, and what it is solved from. Never imports bpy."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .body import Body
from .cloth import ClothFrame
from .digests import digest_of
from .settings import SystemSettings
from .surroundings import Surroundings


@dataclass(frozen=True, eq=False)
class FrameRequest:
    """A frame that is asked for. n vertices of the base, as it is solved."""

    frame: float
    positions: np.ndarray  # (n, 3) float32, deformed base, object space
    settings: SystemSettings
    paint: dict[str, np.ndarray]  # values per vertex of the artist's mesh, by name
    start: int  # first frame of the clip; it needs no frame before it
    world_from_object: np.ndarray | None  # (3, 3)
    frame_rate: float  # frames a second
    following: tuple[float, np.ndarray] | None  # the next frame and its positions, where they are known
    for_preview: bool  # a PreviewFrame is enough
    body: Body | None  # what cloth stays outside of
    surroundings: Surroundings  # what cloth that swings meets
    in_viewport: bool  # the result of the mesh that viewports show


@dataclass(frozen=True)
class FrameInput:
    """When and where a frame is solved: what of a request is read."""

    frame: float
    seconds: float
    world_from_object: np.ndarray | None  # (3, 3) float32, where the system reads it
    animated: np.ndarray  # (n, 3) what the shown mesh is embedded in
    labels: np.ndarray | None = None  # (t,) uint8, cut for the whole clip: see Wrinkles.analyze_clip()
    next_seconds: float = 0.0  # of the frame to come ...
    next_positions: np.ndarray | None = None  # ... where it is known
    body: Body | None = None  # what cloth stays outside of
    cloth: ClothFrame | None = None  # the base cloth that a system is solved over; None: over the animated mesh
    surroundings: Surroundings = Surroundings()  # where the system reads them
    in_viewport: bool = False  # the mesh that viewports show is asked for: Wrinkles.in_viewport

    def in_time(self) -> tuple[float, np.ndarray | None, np.ndarray | None, float]:
        """As native poses take it."""
        return self.seconds, self.labels, self.next_positions, self.next_seconds

    def digest(self, settings_digest: bytes, swings: bool) -> bytes:
        """What tells it from another. swings: cloth meets the surroundings."""
        return digest_of(settings_digest, self.animated, self.world_from_object, self.labels, self.next_positions,
                         *(self.body.arrays() if self.body else ()),
                         *([self.surroundings.array()] if swings else ()),
                         None if self.next_positions is None else np.array(self.next_seconds))
