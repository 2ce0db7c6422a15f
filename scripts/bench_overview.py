# SPDX-License-Identifier: GPL-3.0-or-later
"""The table at the head of docs/bench.md, written from the tables of scenes below it: run it after they change."""
from __future__ import annotations

import re
from pathlib import Path

PAGE = Path(__file__).resolve().parents[1] / "docs" / "bench.md"
CONTENDERS = ("Rumple, Wrinkle Mesh", "Cloth at full resolution", "Cloth, then Subdivision", "Tension map, displaced")
SIMULATED = "Cloth at full resolution"
# Column of a scene's table -> of the overview. The band is given as a share of the full simulation's.
BAND = "55 to 110"
MEASURES = {"ms": "ms a frame", "area kept": "area kept", BAND: "folds of 55 to 110 mm, of the simulation's",
            "frame to frame": "frame to frame, mm", "in the body, %": "in the body, %", "crossings": "crossings"}
BEGIN, END = "<!-- scripts/bench_overview.py -->\n", "<!-- end -->\n"


def scenes(page: str) -> dict[str, list[dict[str, str]]]:
    """Heading of a scene, without its frames -> cells of each contender by the name of their column."""
    found = {}
    for section in page.split("\n## ")[1:]:
        rows = [[cell.strip() for cell in line.strip("|").split(" | ")]
                for line in section.splitlines() if line.startswith("|")]
        by_name = {row[0]: dict(zip(rows[0], row)) for row in rows}
        if all(name in by_name for name in CONTENDERS):
            scene = re.sub(r",? ?frames \d+ to \d+", "", section.splitlines()[0]).replace(" ()", "")
            found[scene] = [by_name[name] for name in CONTENDERS]
    return found


def cell(contenders: list[dict[str, str]], measure: str) -> str:
    """A measure of all contenders."""
    values = [row[measure] for row in contenders]
    if measure == BAND:
        values = [f"{float(value) / float(values[CONTENDERS.index(SIMULATED)]):.2f}" for value in values]
    return " / ".join(values)


def overview(page: str) -> str:
    """Of a page's scenes: a row for each."""
    rows = [["scene", *MEASURES.values()], ["---"] * (1 + len(MEASURES))]
    rows += [[scene, *(cell(contenders, measure) for measure in MEASURES)]
             for scene, contenders in scenes(page).items()]
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


def renewed(page: str) -> str:
    """The page with its overview written anew."""
    before, rest = page.split(BEGIN)
    return before + BEGIN + overview(page) + END + rest.split(END, 1)[1]


if __name__ == "__main__":
    PAGE.write_text(renewed(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
