# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo's report: what every frame measured, as a table on the screen and JSON beside the pictures."""
from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

COLUMNS = (  # key, heading, unit, factor for the screen, format
    ("frame", "frame", "", 1, "{:.0f}"),
    ("edge_error_before_rms", "edge rms", "% before", 100, "{:.1f}"),
    ("edge_error_after_rms", "", "% after", 100, "{:.1f}"),
    ("edge_error_before_max", "edge max", "% before", 100, "{:.0f}"),
    ("edge_error_after_max", "", "% after", 100, "{:.0f}"),
    ("compressed_area_before", "area/rest", "before", 1, "{:.3f}"),
    ("compressed_area_after", "", "after", 1, "{:.3f}"),
    ("attachment_violation", "beyond r", "of r", 1, "{:.0e}"),
    ("largest_offset", "offset", "mm", 1e3, "{:.1f}"),
    ("offset_change", "change", "mm", 1e3, "{:.1f}"),
    ("solve_ms", "solve", "ms", 1, "{:.1f}"),
    ("show_ms", "show", "ms", 1, "{:.1f}"),
    ("blender_ms", "frame_set", "ms", 1, "{:.0f}"),
)
MEASURES = ("edge_error_before_rms", "edge_error_before_max", "edge_error_after_rms", "edge_error_after_max",
            "compressed_area_before", "compressed_area_after", "attachment_violation")


class Report:
    """Collects rows; lengths in metres, times in milliseconds. scale: metres per object unit."""

    def __init__(self, about: dict[str, Any], scale: float) -> None:
        self.about, self.scale = about, scale
        self.rows: list[dict[str, float]] = []
        self._offsets: np.ndarray | None = None

    def add(self, frame: int, picture: Any, measures: Any, blender_ms: float) -> None:
        """One frame. measures: of the Wrinkle Mesh; the other systems have none."""
        row = {"frame": frame}
        if measures is not None:
            row.update({name: float(getattr(measures, name)) for name in MEASURES})
        offsets = picture.local_offset * self.scale
        change = offsets - self._offsets if self._offsets is not None else np.zeros(3)
        row.update(largest_offset=_longest(offsets), offset_change=_longest(change), blender_ms=blender_ms,
                   **{f"{stage}_ms": value for stage, value in picture.milliseconds.items()})
        self._offsets = offsets
        self.rows.append(row)

    def table(self) -> list[str]:
        """Lines for the screen: headings, at most 24 rows evenly chosen, and the whole clip's mean and worst."""
        step = max(1, len(self.rows) // 24)
        columns = [column for column in COLUMNS if column[0] in self.rows[0]]
        body = [[form.format(row[key] * factor) for key, _, _, factor, form in columns] for row in self.rows[::step]]
        for name, pick in (("mean", np.mean), ("worst", np.max)):
            body.append([name] + [form.format(pick([row[key] for row in self.rows]) * factor)
                                  for key, _, _, factor, form in columns[1:]])
        lines = [[c[1] for c in columns], [c[2] for c in columns], *body]
        widths = [max(len(line[i]) for line in lines) for i in range(len(columns))]
        return ["  ".join(cell.rjust(width) for cell, width in zip(line, widths)) for line in lines]

    def write(self, path: Path) -> None:
        """As JSON."""
        path.write_text(json.dumps({**self.about, "frames": self.rows}, indent=1) + "\n", encoding="utf-8")


def _longest(vectors: np.ndarray) -> float:
    return float(np.linalg.norm(vectors, axis=-1).max())
