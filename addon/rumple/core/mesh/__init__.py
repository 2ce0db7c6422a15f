# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes: the coarse mesh at rest, its healed copy, rigid parts, bodies, the shown mesh and the result of a frame."""
