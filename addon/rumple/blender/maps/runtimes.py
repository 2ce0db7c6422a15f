# SPDX-License-Identifier: GPL-3.0-or-later
"""Runtime data of every object with Wrinkle Maps, which is not stored in the file."""
from __future__ import annotations

from dataclasses import dataclass

from ...core.systems.poses import PoseComparison
from ..objects.runtime_table import RuntimeBase, RuntimeTable


@dataclass
class Runtime(RuntimeBase):
    """One object with Wrinkle Maps."""

    comparison: PoseComparison | None = None
    shape: str = ""  # fingerprint of its inputs
    unsure: bool = False  # its mesh changed with the frame, perhaps only by shape keys: check it when playback stops
    written: tuple | None = None  # gain and strengths in the skin
    seen: tuple | None = None  # the last bones and keys, and the presence for them

    def invalidate_output(self) -> None:
        self.written = None
        super().invalidate_output()


_TABLE = RuntimeTable(Runtime)
of, known, message = _TABLE.of, _TABLE.known, _TABLE.message
forget, forget_all, forget_all_but = _TABLE.forget, _TABLE.forget_all, _TABLE.forget_all_but
invalidate_outputs, invalidate_all = _TABLE.invalidate_outputs, _TABLE.invalidate_all
