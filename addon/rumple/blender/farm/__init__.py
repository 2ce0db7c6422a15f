# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes without a window, for render queues: `scripts/rumple`, or `blender --command rumple`. See docs/farm.md."""
