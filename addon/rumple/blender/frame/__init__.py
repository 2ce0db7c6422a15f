# SPDX-License-Identifier: GPL-3.0-or-later
"""What is done for a frame, and between frames: solving, rebuilding, curves, the state of clips."""
