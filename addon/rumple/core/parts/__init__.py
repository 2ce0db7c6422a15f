# SPDX-License-Identifier: GPL-3.0-or-later
"""Which parts of a mesh are cloth: recognises skin, solid things, caps and whole kinds of garments by their shape."""
