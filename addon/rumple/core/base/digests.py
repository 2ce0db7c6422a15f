# SPDX-License-Identifier: GPL-3.0-or-later
"""Digests of the solvers' inputs, 16 bytes each: equal inputs have equal digests. Never imports bpy."""
from __future__ import annotations

import hashlib
from typing import Any

import numpy as np


def digest_of(first: bytes, positions: np.ndarray, *more: np.ndarray | None) -> bytes:
    """Digest of one frame's input. first: digest of the settings, or other bytes for inputs that are not arrays."""
    digest = hashlib.blake2b(first, digest_size=16)
    digest.update(positions.data)
    for number, values in enumerate(more):
        if values is not None:
            digest.update(bytes([number]))
            digest.update(np.ascontiguousarray(values).data)
    return digest.digest()


def digest_of_settings(settings: Any, start: int, frame_rate: float) -> bytes:
    """Digest of a settings dataclass, with the first frame and the frame rate."""
    return hashlib.blake2b(repr((settings, start, frame_rate)).encode(), digest_size=16).digest()


def digest_of_paint(paint: dict[str, np.ndarray]) -> bytes:
    """Digest of all painted values, sorted by name."""
    digest = hashlib.blake2b(digest_size=16)
    for name in sorted(paint):
        digest.update(name.encode())
        digest.update(np.ascontiguousarray(paint[name], np.float32).data)
    return digest.digest()
