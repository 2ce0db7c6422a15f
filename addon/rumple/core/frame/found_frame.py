# SPDX-License-Identifier: GPL-3.0-or-later
"""FoundFrame: a frame that was looked up in the frame cache. Never imports bpy."""
from __future__ import annotations

from dataclasses import dataclass

from .frame_cache import CachedFrame
from .frame_input import FrameInput, FrameRequest


@dataclass(frozen=True, eq=False)
class FoundFrame:
    """What is known of a frame before it is solved."""

    request: FrameRequest
    frame_input: FrameInput
    settings_digest: bytes
    input_digest: bytes
    before: CachedFrame | None  # the frame that it is solved from
    final: bool
    may_wait: bool  # it is solved later, when somebody asks for its state
    cached: CachedFrame | None  # the stored frame, which is replayed
    seconds: float  # spent on looking it up

    @property
    def must_be_solved(self) -> bool:
        """Whether its result takes a solve. Otherwise it is quickly made."""
        if self.cached is None:
            return not self.may_wait
        return self.cached.waits and not self.request.for_preview
