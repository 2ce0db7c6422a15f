# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group "Rumple Maps" in the engine that needs a screen."""
import maps_shots
from case import WindowCase


class MapsInEevee(WindowCase):

    def test_eevee_shows_the_native_blend(self):
        maps_shots.check(self, "EEVEE")
