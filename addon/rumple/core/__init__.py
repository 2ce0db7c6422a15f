# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that Rumple computes without Blender: settings, engine, frame cache, clips. Never imports bpy.

The folders, each of which imports only those before it: base, settings, mesh, parts, paint, cloth, frame, systems,
files."""
