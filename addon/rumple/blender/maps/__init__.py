# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkle Maps: properties, modifier, hidden meshes, operators, baking, panels."""
