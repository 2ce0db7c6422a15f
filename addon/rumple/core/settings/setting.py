# SPDX-License-Identifier: GPL-3.0-or-later
"""setting(): declares one value that an artist can set. Never imports bpy."""
from __future__ import annotations

from dataclasses import field
from typing import Any


def setting(default: Any, name: str, tip: str, *, low: float | None = None, high: float | None = None,
            soft: float | None = None, unit: str = "NONE", choices: tuple = (), affects: str = "SOLVE") -> Any:
    """A dataclass field that knows its name, tooltip, range and unit: LENGTH (metres), SECONDS, FACTOR or NONE.

    affects: what must be made again after a change. MESH: the shown mesh; SOLVE: the stored frames; PAINT: the values
    that are read from the coarse mesh.
    """
    return field(default=default, metadata=dict(name=name, tip=tip, low=low, high=high, soft=soft, unit=unit,
                                                choices=choices, affects=affects))
