# SPDX-License-Identifier: GPL-3.0-or-later
"""What belongs to one wrinkled object: properties, modifier, meshes, what it is worn over, and what is kept of it."""
