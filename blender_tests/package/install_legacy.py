# SPDX-License-Identifier: GPL-3.0-or-later
"""Inside Blender: installs and enables a legacy zip as the preferences do, and saves that."""
import sys

import bpy

bpy.ops.preferences.addon_install(filepath=sys.argv[-1])
bpy.ops.preferences.addon_enable(module="rumple")
bpy.ops.wm.save_userpref()
