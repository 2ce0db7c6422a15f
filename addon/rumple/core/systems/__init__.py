# SPDX-License-Identifier: GPL-3.0-or-later
"""The systems: Wrinkle Mesh, Field with its brush, Paths with their curves, and the reference poses of Wrinkle Maps."""
