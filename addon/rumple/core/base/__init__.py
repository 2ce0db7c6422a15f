# SPDX-License-Identifier: GPL-3.0-or-later
"""Arithmetic on rows of vertices, triangles and matrices, digests, calls at the same time, the wording of errors."""
