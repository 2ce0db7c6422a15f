# SPDX-License-Identifier: GPL-3.0-or-later
"""The work for a frame and between frames: solving, rebuilding, curves, the state of clips."""
