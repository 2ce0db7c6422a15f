# SPDX-License-Identifier: GPL-3.0-or-later
"""The clips of the gallery: which file, which garments, which frames, and what stands side by side.

    scripts/gallery_clips.py [NAME,...]      names of those that can be rendered here, a line each

Never imports bpy.
"""
from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
DATA, OUTFITS = ROOT.parent / "shared" / "data", ROOT / "out" / "outfits"


MADE = ("", "skirt", "sit", "twist", "elbow", "jeans", "cape", "painted")  # by scripts


@dataclass(frozen=True)
class Column:
    """One of the pictures that stand side by side."""

    label: str
    method: str = ""  # of the wrinkles; none: bare
    preset: str = ""  # a fabric
    settings: tuple[tuple[str, Any], ...] = ()  # of the system: name, value
    paint: bool = False  # what is painted, in place of the folds


BARE, CLOTH = Column("As it was animated"), Column("Wrinkle Mesh, one click", "MESH")


@dataclass(frozen=True)
class Clip:
    """A scene, played through."""

    file: str  # of the folder; none: the demo's; skirt: of the lessons; others of scripts/gallery_scenes.py
    garments: tuple[str, ...]  # what is wrinkled, what is worn under others first
    frames: tuple[int, int]
    columns: tuple[Column, ...] = (BARE, CLOTH)
    looks_at: tuple[str, ...] = ()  # objects in the middle of the picture; none: the garments
    view: tuple[float, float, float] = (0.55, -1.0, 0.2)  # from the middle to the camera
    distance: float = 3.0  # metres
    raised: float = 0.0  # metres: how far above that middle the camera looks
    size: tuple[int, int] = (400, 500)  # pixels of a column
    folder: Path = DATA
    bone: str = ""  # of the demo's skeleton, in the middle of the picture
    dyed: bool = False  # each column has the colour and the gloss of its fabric
    is_skin: bool = False  # no cloth, and nothing stands on a floor
    rate: int = 12  # frames a second that are rendered, at least: a browser loads every one of them

    @property
    def path(self) -> Path | None:
        """Where the scene is; None for what is made by scripts."""
        return None if self.file in MADE else self.folder / f"{self.file}.blend"


FABRICS = tuple(Column(preset.capitalize(), "MESH", preset) for preset in ("SILK", "COTTON", "DENIM", "LEATHER"))
WIDE_SKIRT = (("wavelength", 0.14), ("slack", 1.08), ("bending_length", 0.03), ("locomotion", 1.0),
              ("swing_damping", 2.0))
HANG, SWING = (Column(label, "MESH", settings=(("base_cloth", value), *WIDE_SKIRT))
               for label, value in (("Hang: no time passes", "HANG"), ("Swing", "SWING")))
FRONT, WALKING = (0.32, -1.0, 0.08), (0.5, -1.0, 0.15)
CLIPS = {
    "dressed": Clip("", ("Trousers", "Shirt"), (1, 72), distance=4.4, view=FRONT, looks_at=("Mannequin",)),
    "close": Clip("", ("Trousers", "Shirt"), (1, 72), distance=2.3, view=(0.75, -1.0, 0.15), looks_at=("Shirt",)),
    "walk": Clip("S1_walk_shirt", ("trousers", "shirt"), (30, 120), distance=4.6, view=WALKING, raised=0.08),
    "jump": Clip("S2_squat_trousers", ("trousers", "sweater"), (15, 95), distance=5.2, view=WALKING, raised=0.14),
    "suit": Clip("male_elegantsuit01", ("male_elegantsuit01",), (2, 40),
                 (BARE, Column("Wrinkle Mesh, suit", "MESH", "SUIT")), distance=3.6, view=FRONT, raised=0.3,
                 looks_at=("Body",), folder=OUTFITS),
    "sit": Clip("sit", ("Trousers", "Shirt"), (5, 64), distance=4.6, view=(0.9, -1.0, 0.15), looks_at=("Mannequin",),
                size=(380, 480)),
    "twist": Clip("twist", ("Shirt",), (1, 78), distance=2.9, view=FRONT, size=(380, 420)),
    "elbow": Clip("elbow", ("Shirt",), (1, 60), (BARE, Column("Wrinkle Mesh, wool", "MESH", "WOOL")), distance=1.35,
                  view=(1.0, -0.6, 0.1), bone="elbow.L", size=(400, 400)),
    "jeans": Clip("jeans", ("Jeans",), (1, 72), (BARE, Column("Wrinkle Mesh, denim", "MESH", "DENIM")), distance=2.7,
                  view=(0.45, -1.0, 0.15), size=(400, 468)),
    "cape": Clip("cape", ("Trousers", "Shirt", "Cape"), (13, 74), (BARE, Column("Wrinkle Mesh, Swing", "MESH")),
                 distance=4.6, view=(1.0, 0.3, 0.15), looks_at=("Mannequin",), size=(400, 424), rate=24),
    "painted": Clip("painted", ("Shirt",), (1, 70), (
        Column("What the brush leaves", "FIELD", paint=True), Column("Wrinkle Field, while the hand moves", "FIELD")),
        distance=1.9, view=(0.25, -1.0, 0.12), raised=0.02, size=(380, 420), rate=6),
    "face": Clip("S4_face_expressions", ("Head",), (1, 126), (BARE, Column("Wrinkle Maps", "MAPS")), distance=0.48,
                 view=(0.1, -1.0, 0.05), raised=0.0, size=(320, 330), is_skin=True),
    "skirt": Clip("skirt", ("Skirt",), (1, 60), (Column("As it was animated"), HANG, SWING), distance=3.2,
                  view=FRONT, looks_at=("Skirt",), size=(320, 400)),
    "systems": Clip("", ("Shirt",), (1, 72), (
        CLOTH, Column("Wrinkle Field", "FIELD"), Column("Wrinkle Paths", "PATHS")), distance=3.4,
        view=FRONT, raised=0.03, size=(320, 400)),
    "fabrics": Clip("S1_walk_shirt", ("shirt",), (40, 110), FABRICS, distance=2.5, raised=0.04, size=(280, 360),
                    dyed=True),
}


def possible() -> list[str]:
    """The clips whose files are there."""
    return [name for name, clip in CLIPS.items() if clip.path is None or clip.path.is_file()]


if __name__ == "__main__":
    wanted = sys.argv[1].split(",") if len(sys.argv) > 1 else list(CLIPS)
    print("".join(f"{name}\n" for name in possible() if name in wanted), end="")
