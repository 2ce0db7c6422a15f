# SPDX-License-Identifier: GPL-3.0-or-later
"""The frames of a garment without Blender."""
from __future__ import annotations

from typing import Any

import numpy as np
from rumple.core.frame.engine import FrameResult, PreviewFrame, Wrinkles
from rumple.core.frame.frame_input import FrameRequest


def solve_frame(wrinkles: Wrinkles, frame: float, positions: np.ndarray, settings: Any, paint: dict[str, np.ndarray],
                *, start: int, **others: Any) -> FrameResult | PreviewFrame:
    """The result of a frame, replayed or solved. The arguments are those of FrameRequest; start: its first frame."""
    return wrinkles.finish_frame(wrinkles.find_frame(FrameRequest(frame, positions, settings, paint, start, **others)))
