# SPDX-License-Identifier: GPL-3.0-or-later
"""Rumple: wrinkles for animated garments and skin.

core/ is what it does, without Blender; blender/ is what an artist sees. Nothing here imports bpy before
Blender registers the add-on, so that core/ can be used and tested in plain Python.
"""
bl_info = {     # read by Blender 3.4 to 4.1; from 4.2 on blender_manifest.toml
    "name": "Rumple",
    "author": "Rumple authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Properties > Modifiers > Wrinkles",
    "description": "Wrinkles for animated garments and skin, live in the modifier stack",
    "category": "Animation",
}


def register() -> None:
    from . import blender
    blender.register()


def unregister() -> None:
    from . import blender
    blender.unregister()
