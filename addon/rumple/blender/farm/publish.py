# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports the baked garment as USD."""
from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np

from ...core.files import usd_text
from ...core.files.clip_manifest import Manifest
from .. import compat
from ..objects import modifier
from . import shown


def publish(context: bpy.types.Context, obj: bpy.types.Object, manifest: Manifest, folder: Path, scheme: str,
            with_attributes: bool) -> shown.Exported:
    """Export the shown clip. manifest: of this clip. Raises BakeError and ClipFault."""
    path = folder / f"{shown.stem(obj, manifest)}.usda"
    attributes = modifier.system(modifier.find(obj)).wrinkles.ATTRIBUTES if with_attributes else ()
    writer: usd_text.StageWriter | None = None
    try:
        for frame in shown.frames(context, obj, manifest):
            mesh = frame.mesh
            if writer is None:
                writer = usd_text.StageWriter(path, _stage(context.scene, obj, mesh, manifest, scheme))
                vertices = len(frame.points)
            values = {attribute.name: np.squeeze(compat.read_attribute(mesh.attributes[attribute.name]))
                      for attribute in attributes if attribute.domain == "POINT" and attribute.name in mesh.attributes}
            writer.add(frame.number, frame.points, _normals(mesh) if scheme == "none" else None, frame.world, values)
        writer.commit()
    except BaseException:
        if writer is not None:
            writer.discard()
        raise
    return shown.Exported(path, manifest.end - manifest.start + 1, vertices, path.stat().st_size)


def _stage(scene: bpy.types.Scene, obj: bpy.types.Object, mesh: bpy.types.Mesh, manifest: Manifest,
           scheme: str) -> usd_text.Stage:
    return usd_text.Stage(obj.name, manifest.start, manifest.end, scene.render.fps / scene.render.fps_base,
                          scene.unit_settings.scale_length, shown.face_sizes(mesh), compat.corner_vertices(mesh).copy(),
                          scheme, shown.uv_maps(mesh), usd_text.about(**shown.about(obj, manifest)))


def _normals(mesh: bpy.types.Mesh) -> np.ndarray | None:
    """The normals of a smooth mesh; None for other meshes."""
    smooth = np.empty(len(mesh.polygons), bool)
    mesh.polygons.foreach_get("use_smooth", smooth)
    return shown.normals(mesh) if smooth.all() else None
