# SPDX-License-Identifier: GPL-3.0-or-later
"""Drawing in viewports with Blender's gpu module."""
