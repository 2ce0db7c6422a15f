# SPDX-License-Identifier: GPL-3.0-or-later
"""What is drawn in viewports by Blender's gpu module."""
