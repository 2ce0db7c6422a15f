# SPDX-License-Identifier: GPL-3.0-or-later
"""Weight and bending stiffness of fabrics, and the settings that follow from them. Never imports bpy."""
from __future__ import annotations

from dataclasses import dataclass

GRAVITY = 9.81  # m/s^2


@dataclass(frozen=True)
class Fabric:
    """The properties of a fabric that shape its folds. Sources: docs/folds_on_cloth.md."""

    mass: float  # kg/m^2
    rigidity: float  # bending rigidity, N m: the mean of warp and weft
    slack: float | None = None  # usual slack of a garment made of this fabric; None: that of its cut

    @property
    def bending_length(self) -> float:
        """Metres: (rigidity / weight)^(1/3), F. T. Peirce 1930. The width of folds is proportional to it."""
        return (self.rigidity / (self.mass * GRAVITY)) ** (1.0 / 3.0)

    @property
    def values(self) -> dict[str, float]:
        """The settings of the base cloth for this fabric, for a preset."""
        slack = {} if self.slack is None else dict(slack=self.slack)
        return dict(mass=self.mass, bending_length=float(f"{self.bending_length:.2g}"), **slack)

    @property
    def fold_width(self) -> float:
        """Width of its folds relative to cotton. It is rounded to twentieths, so that a change to this fabric and back
        to cotton restores the former value exactly."""
        return round(20.0 * self.bending_length / COTTON.bending_length) / 20.0


COTTON = Fabric(mass=0.2, rigidity=20e-6)  # the defaults of the settings
FABRICS = {
    "COTTON": COTTON,
    "JERSEY": Fabric(mass=0.187, rigidity=19e-6, slack=1.0),
    "SILK": Fabric(mass=0.069, rigidity=3e-6, slack=1.05),
    "WOOL": Fabric(mass=0.4, rigidity=80e-6, slack=1.04),
    "SUIT": Fabric(mass=0.45, rigidity=240e-6, slack=1.02),
    "DENIM": Fabric(mass=0.324, rigidity=80e-6, slack=1.05),
    "STRETCH": Fabric(mass=0.204, rigidity=56e-6, slack=0.95),
    "LEATHER": Fabric(mass=0.6, rigidity=377e-6, slack=1.06),
}
