# SPDX-License-Identifier: GPL-3.0-or-later
"""The Wrinkle Field in a window: both engines draw its waves."""
from __future__ import annotations
from support import wave_shader_cases
from support.window_case import WindowCase


class Rendered(wave_shader_cases.Waves, WindowCase):
    """In a window; the background suite has the same."""
