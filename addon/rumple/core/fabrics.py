# SPDX-License-Identifier: GPL-3.0-or-later
"""What fabrics weigh and how stiffly they bend, and what of it the solvers take. Never imports bpy."""
from __future__ import annotations

from dataclasses import dataclass

GRAVITY = 9.81  # m/s^2


@dataclass(frozen=True)
class Fabric:
    """What a fabric hangs by: its weight and how stiffly it bends. docs/folds_on_cloth.md has the sources."""

    mass: float  # kg/m^2
    rigidity: float  # of bending, N m: the mean of warp and weft
    slack: float = 1.02  # of a garment that is usually made of it

    @property
    def bending_length(self) -> float:
        """Metres: (rigidity / weight)^(1/3), F. T. Peirce 1930. Folds are as wide as it is long, to scale."""
        return (self.rigidity / (self.mass * GRAVITY)) ** (1.0 / 3.0)

    @property
    def values(self) -> dict[str, float]:
        """The settings of the base cloth that say it, for a preset."""
        return dict(mass=self.mass, bending_length=float(f"{self.bending_length:.2g}"), slack=self.slack)

    @property
    def fold_width(self) -> float:
        """Of its folds over cotton's, in twentieths: the way back to cotton gives the former number."""
        return round(20.0 * self.bending_length / COTTON.bending_length) / 20.0


COTTON = Fabric(mass=0.2, rigidity=20e-6)  # the defaults of the settings
FABRICS = {
    "COTTON": COTTON,
    "JERSEY": Fabric(mass=0.187, rigidity=19e-6, slack=1.0),
    "SILK": Fabric(mass=0.069, rigidity=3e-6, slack=1.035),
    "WOOL": Fabric(mass=0.4, rigidity=80e-6, slack=1.025),
    "DENIM": Fabric(mass=0.324, rigidity=80e-6, slack=1.03),
    "LEATHER": Fabric(mass=0.6, rigidity=377e-6, slack=1.03),
}
