# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist can set: ranges, units and tooltips, presets, fabrics, and where the user guide describes it."""
