# SPDX-License-Identifier: GPL-3.0-or-later
"""All functions and classes of the native library. load() of this package returns this module.

Arrays are C-contiguous float32 or int32. Lengths are in the units of the positions. Arrays in results are read-only
views of the library's memory, and keep it alive. Bad input raises ValueError with the name of the argument and the
first bad element.
"""
from __future__ import annotations

from . import c
from .base_cloth import *
from .coarse_mesh import *
from .force_fields import *
from .stopping import *
from .surface import *
from .wrinkle_field import *
from .wrinkle_field_brush import *
from .wrinkle_field_steps import *
from .wrinkle_layers import *
from .wrinkle_maps import *
from .wrinkle_mesh import *
from .wrinkle_paths import *
from .wrinkle_paths_drawing import *

__version__ = c.VERSION
