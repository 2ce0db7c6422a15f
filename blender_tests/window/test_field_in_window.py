# SPDX-License-Identifier: GPL-3.0-or-later
"""The Wrinkle Field in a window: both engines draw its waves."""
from __future__ import annotations

import waves_rendered
from case import WindowCase


class Rendered(waves_rendered.Waves, WindowCase):
    """In a window; the background suite has the same."""
