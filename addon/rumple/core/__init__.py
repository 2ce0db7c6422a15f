# SPDX-License-Identifier: GPL-3.0-or-later
"""What Rumple does, without Blender: settings, engine, history. Never imports bpy."""
