# SPDX-License-Identifier: GPL-3.0-or-later
"""The baked garment, as all its modifiers show it, out of Blender: USD."""
from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from ...core import clip_file, usd_text
from ...core.clip_manifest import ClipFault, Manifest
from .. import compat
from ..bake.playback import BakeError
from ..frame import clip_status
from ..objects import modifier
from . import bake, source


@dataclass
class Published:
    """One garment."""

    path: Path
    frames: int
    vertices: int
    bytes: int


def publish(context: bpy.types.Context, obj: bpy.types.Object, files: str, folder: Path, scheme: str,
            with_attributes: bool) -> Published:
    """Raises BakeError and ClipFault."""
    manifest = _shown_clip(obj, files)
    path = folder / usd_text.file_name(Path(bpy.data.filepath).stem, obj.name, manifest.source, manifest.start,
                                       manifest.end)
    attributes = modifier.system(modifier.find(obj)).wrinkles.ATTRIBUTES if with_attributes else ()
    writer: usd_text.StageWriter | None = None
    try:
        for frame in range(manifest.start, manifest.end + 1):
            context.scene.frame_set(frame)
            evaluated = obj.evaluated_get(context.evaluated_depsgraph_get())
            text = clip_status.cannot_play(obj, modifier.output_object(modifier.find(obj)), float(frame))
            if text:
                raise BakeError(text)
            mesh = evaluated.data
            points = compat.positions(mesh)
            if not len(points):
                raise BakeError(f"{obj.name}: nothing of it is shown at frame {frame}: see its other modifiers")
            if writer is None:
                writer = usd_text.StageWriter(path, _stage(context.scene, obj, mesh, manifest, scheme))
                vertices = len(points)
            if (len(points), len(mesh.loops)) != (vertices, len(writer.stage.corners)):
                raise BakeError(f"{obj.name}: another modifier changes its number of points at frame {frame}: switch "
                                "it off, or let it come later in the pipeline")
            values = {attribute.name: np.squeeze(compat.read_attribute(mesh.attributes[attribute.name]))
                      for attribute in attributes if attribute.domain == "POINT" and attribute.name in mesh.attributes}
            writer.add(frame, points, None if scheme != "none" else _normals(mesh), np.array(evaluated.matrix_world),
                       values)
        writer.commit()
    except BaseException:
        if writer is not None:
            writer.discard()
        raise
    return Published(path, manifest.end - manifest.start + 1, vertices, path.stat().st_size)


def _shown_clip(obj: bpy.types.Object, files: str) -> Manifest:
    """The clip at its place, now shown; else the one that the file shows. Raises BakeError."""
    manifest = bake.whole_clip(obj, source.of_garment(obj, files), any_frames=True)
    if manifest is not None:
        bake.show(obj, manifest)
        return manifest
    clip = clip_status.clip_path(obj) if modifier.is_baked(modifier.find(obj)) else None
    try:
        manifest = clip_file.read_manifest(clip) if clip is not None else None
    except ClipFault as error:
        raise BakeError(f"{obj.name}: the baked clip {clip.name} cannot be shown: {error}") from error
    if manifest is None:
        raise BakeError(f"{obj.name}: there is no whole clip of this file: bake first")
    return manifest


def _stage(scene: bpy.types.Scene, obj: bpy.types.Object, mesh: bpy.types.Mesh, manifest: Manifest,
           scheme: str) -> usd_text.Stage:
    counts = np.empty(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("loop_total", counts)
    layers = sorted(mesh.uv_layers, key=lambda layer: not layer.active_render)
    uvs = {}
    for layer in layers:
        values = np.empty(2 * len(mesh.loops), np.float32)
        layer.data.foreach_get("uv", values)
        uvs[layer.name] = values.reshape(-1, 2)
    about = usd_text.about(file=Path(bpy.data.filepath).name, object=obj.name, source=manifest.source,
                           frames=f"{manifest.start}-{manifest.end}", made_by=source.made_by())
    return usd_text.Stage(obj.name, manifest.start, manifest.end, scene.render.fps / scene.render.fps_base,
                          scene.unit_settings.scale_length, counts, compat.corner_vertices(mesh).copy(), scheme, uvs,
                          about)


def _normals(mesh: bpy.types.Mesh) -> np.ndarray | None:
    """Of smooth meshes."""
    smooth = np.empty(len(mesh.polygons), bool)
    mesh.polygons.foreach_get("use_smooth", smooth)
    if not smooth.all():
        return None
    values = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("normal", values)
    return values.reshape(-1, 3)
