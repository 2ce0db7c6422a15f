# SPDX-License-Identifier: GPL-3.0-or-later
"""What tells one input of the solvers from another: 16 bytes of each. Never imports bpy."""
from __future__ import annotations

import hashlib
from typing import Any

import numpy as np


def digest_of(first: bytes, positions: np.ndarray, *more: np.ndarray | None) -> bytes:
    """Of one frame's input. first: digest of the settings, or other bytes that stand for what is no array."""
    digest = hashlib.blake2b(first, digest_size=16)
    digest.update(positions.data)
    for number, values in enumerate(more):
        if values is not None:
            digest.update(bytes([number]))
            digest.update(np.ascontiguousarray(values).data)
    return digest.digest()


def digest_of_settings(settings: Any, start: int, frame_rate: float) -> bytes:
    """Of a dataclass of settings, on one timeline."""
    return hashlib.blake2b(repr((settings, start, frame_rate)).encode(), digest_size=16).digest()


def digest_of_paint(paint: dict[str, np.ndarray]) -> bytes:
    """Of all that is painted, by name."""
    digest = hashlib.blake2b(digest_size=16)
    for name in sorted(paint):
        digest.update(name.encode())
        digest.update(np.ascontiguousarray(paint[name], np.float32).data)
    return digest.digest()
