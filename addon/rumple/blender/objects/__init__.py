# SPDX-License-Identifier: GPL-3.0-or-later
"""The data of one wrinkled object: properties, modifier, meshes, bodies under the garment, and state between frames."""
