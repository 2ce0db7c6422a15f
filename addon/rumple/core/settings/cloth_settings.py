# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings of the base cloth, which are the same for every system. Never imports bpy."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .setting import setting

BASE_CLOTHS = (
    ("OFF", "Off", "The animated mesh is the cloth, kept out of the body: for simulated garments, skin and tight "
     "clothes"),
    ("HANG", "Hang", "The coarse mesh itself becomes cloth around its animation: it sags, pulls taut and rests on the "
     "body. No inertia, nothing to wait for"),
    ("SWING", "Swing", "As Hang, with inertia and wind: it lags behind, sways and settles. Play it through from the "
     "first frame, or bake"),
)
UPS = tuple((axis, axis, f"The {axis} axis of the garment's own mesh points up at rest")
            for axis in ("X", "Y", "Z", "-X", "-Y", "-Z"))


def nearest_up(direction: np.ndarray) -> str:
    """The axis of an object that is nearest to a direction, as the setting names it."""
    axis = int(np.abs(direction).argmax())
    return ("-" if direction[axis] < 0.0 else "") + "XYZ"[axis]


def direction_of(up: str) -> np.ndarray:
    """(3,) unit vector of an axis, as the setting names it."""
    direction = np.zeros(3)
    direction["XYZ".index(up[-1])] = -1.0 if up[0] == "-" else 1.0
    return direction


@dataclass
class ClothSettings:
    """The base cloth (section 4.3 of the Wrinkle Meshes' paper)."""

    base_cloth: str = setting("OFF", "Base Cloth", "What the wrinkles lie on", choices=BASE_CLOTHS,
                              affects="MESH")
    slack: float = setting(1.02, "Slack", "How much wider the cloth is cut than the garment is modelled. Above 1 it "
                           "has folds at rest too; below 1 it is tight", low=0.8, high=1.5)
    gravity: float = setting(1.0, "Gravity", "Share of the earth's gravity, towards -Z of the world. 0 for cloth that "
                             "does not sag", low=0.0, high=10.0)
    room: float = setting(0.03, "Room", "How far the cloth may leave its animated place", low=0.0, high=10.0,
                          unit="LENGTH")
    slide_room: float = setting(0.15, "Slide", "How far the cloth may slide along the body, where that is more than "
                                "Room. More: it hangs lower, and goes where it is pulled", low=0.0, high=10.0,
                                unit="LENGTH")
    free_room: float = setting(0.25, "Free Room", "How far the cloth may leave its animated place where it hangs free "
                               "of the body, as a skirt does: where Hangs Free is painted", low=0.0, high=10.0,
                               unit="LENGTH")
    friction: float = setting(0.3, "Friction", "How firmly the cloth stays in its place on the body where it is "
                              "pressed on. 0: it slides freely. Cotton on skin 0.3 to 0.6", low=0.0, high=10.0,
                              soft=2.0)
    up: str = setting("Z", "Up At Rest", "Axis of the garment's own mesh that points up at rest: where nothing is "
                      "painted, the highest opening is pinned", choices=UPS)
    bending_length: float = setting(0.022, "Bending Length", "How stiffly the fabric bends for its weight, as textile "
                                    "laboratories measure it (ASTM D1388): silk 16 mm, cotton 22, denim 29, leather "
                                    "40. Longer: the cloth keeps its shape and stands off", low=0.005, high=1.0,
                                    soft=0.1, unit="LENGTH")
    thickness: float = setting(0.003, "Thickness", "How far the cloth stays off the body", low=0.0, high=1.0,
                               unit="LENGTH")
    # Only for swinging cloth
    mass: float = setting(0.2, "Mass", "Kilograms of a square metre: silk 0.07, cotton 0.2, denim 0.32, leather 0.6. "
                          "Heavier cloth moves less in wind and air", low=0.01, high=10.0, soft=1.0)
    swing_damping: float = setting(10.0, "Swing Damping", "How fast swaying dies away, per second. 0: only what "
                                   "the solver loses", low=0.0, high=1000.0, soft=50.0)
    substeps: int = setting(2, "Substeps", "Time steps of the solver in a thirtieth of a second, whatever the frame "
                            "rate. More: livelier and slower", low=1, high=20)
    locomotion: float = setting(0.2, "Locomotion", "Share of the motion of the garment as a whole that its inertia "
                                "feels. 1: as it is. 0: walks, turns and stops do not move the cloth on the body",
                                low=0.0, high=1.0, unit="FACTOR")
    drag: float = setting(1.0, "Wind Drag", "How much wind and still air push the cloth. 1: a sheet across the wind",
                          low=0.0, high=10.0, soft=3.0)

    @property
    def draped(self) -> bool:
        """Whether the base cloth itself gets wide folds: see Draped. The Wrinkle Mesh has them as a layer instead."""
        return False

    @property
    def swings(self: Any) -> bool:  # `stateless` is defined by the system's settings
        """Whether the base cloth depends on time. Independent frames have no time, so their cloth hangs."""
        return self.base_cloth == "SWING" and not self.stateless


@dataclass
class Draped:
    """The setting for wide folds under a Wrinkle Field or Wrinkle Paths."""

    drape: float = setting(0.0, "Drape", "Wide folds of the base cloth itself. They take cloth up: there are fewer "
                           "fine ones on them", low=0.0, high=2.0, soft=1.0, unit="FACTOR")

    # self: the settings of a system that has a base cloth.
    @property
    def draped(self: Any) -> bool:
        """Whether the base cloth itself gets wide folds."""
        return self.base_cloth != "OFF" and self.drape > 0.0
