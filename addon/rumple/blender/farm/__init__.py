# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes without a window, for the queues of others: `scripts/rumple`, or `blender --command rumple`. docs/farm.md."""
