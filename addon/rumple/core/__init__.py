# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that Rumple computes without Blender: settings, engine, frame cache, clips. Never imports bpy."""
