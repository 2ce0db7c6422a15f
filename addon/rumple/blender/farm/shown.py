# SPDX-License-Identifier: GPL-3.0-or-later
"""The frames of a baked garment after all its modifiers, for exporters."""
from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Iterator

import bpy
import numpy as np

from ...core.files import clip_file, clip_folder, usd_text
from ...core.files.clip_manifest import ClipFault, Manifest
from .. import compat
from ..bake.playback import BakeError
from ..frame import clip_status
from ..objects import modifier
from . import bake, source


@dataclass
class Exported:
    """The export of one garment: a file or a folder of files."""

    path: Path
    frames: int
    vertices: int
    bytes: int
    note: str = ""
    more: dict[str, Any] = field(default_factory=dict)  # further results for programs


@dataclass
class Frame:
    """One frame. points: (n, 3) float32, object space. world: (4, 4), for column vectors. mesh: only valid until the
    next frame."""

    number: int
    mesh: bpy.types.Mesh
    points: np.ndarray
    world: np.ndarray


def whole_clip(obj: bpy.types.Object, files: str) -> Manifest:
    """The clip at the object's place, which is then shown; otherwise the clip that the file shows. Raises BakeError."""
    manifest = bake.whole_clip(obj, source.of_garment(obj, files), any_frames=True)
    if manifest is not None:
        bake.show(obj, manifest)
        return manifest
    return clip_shown(obj)


def clip_shown(obj: bpy.types.Object) -> Manifest:
    """The clip that the file shows. Raises BakeError."""
    clip = clip_status.clip_path(obj) if modifier.is_baked(modifier.find(obj)) else None
    try:
        manifest = clip_file.read_manifest(clip) if clip is not None else None
    except ClipFault as error:
        raise BakeError(f"{obj.name}: the baked clip {clip.name} cannot be shown: {error}") from error
    if manifest is None:
        raise BakeError(f"{obj.name}: there is no whole clip of this file: bake first")
    return manifest


def frames(context: bpy.types.Context, obj: bpy.types.Object, manifest: Manifest) -> Iterator[Frame]:
    """Every whole frame of the clip, all with the same points. Raises BakeError."""
    counts: tuple[int, int] | None = None
    for number in range(manifest.start, manifest.end + 1):
        context.scene.frame_set(number)
        evaluated = obj.evaluated_get(context.evaluated_depsgraph_get())
        if not evaluated.is_evaluated:
            raise BakeError(f"{obj.name}: nothing of it is shown at frame {number}, it is hidden: show it")
        text = clip_status.cannot_play(obj, modifier.output_object(modifier.find(obj)), float(number))
        if text:
            raise BakeError(text)
        mesh = evaluated.data
        points = compat.positions(mesh)
        if not len(points):
            raise BakeError(f"{obj.name}: nothing of it is shown at frame {number}: see its other modifiers")
        if counts not in (None, (len(points), len(mesh.loops))):
            raise BakeError(f"{obj.name}: another modifier changes its number of points at frame {number}: switch "
                            "it off, or let it come later in the pipeline")
        counts = len(points), len(mesh.loops)
        yield Frame(number, mesh, points, np.array(evaluated.matrix_world))


def stem(obj: bpy.types.Object, manifest: Manifest) -> str:
    """The name of exported files without suffix: file, object, digest of the source, frames."""
    file = Path(bpy.data.filepath).stem
    return usd_text.stem(file, name_in_files(obj), manifest.source, manifest.start, manifest.end)


def name_in_files(obj: bpy.types.Object) -> str:
    """A name for file names that no other garment of this file has."""
    others = [other.name for other, _nodes_mod in modifier.wrinkled_objects() if other != obj]
    return clip_folder.readable_beside(obj.name, others, obj.library.filepath if obj.library is not None else "")


def about(obj: bpy.types.Object, manifest: Manifest) -> dict[str, str]:
    """The origin of an export."""
    return dict(file=Path(bpy.data.filepath).name, object=obj.name, source=manifest.source,
                frames=f"{manifest.start}-{manifest.end}", made_by=source.made_by())


def face_sizes(mesh: bpy.types.Mesh) -> np.ndarray:
    """Corners of each face, (faces,) int32."""
    return compat.indices(mesh.polygons, "loop_total")


def normals(mesh: bpy.types.Mesh) -> np.ndarray:
    """Normals of the points, (n, 3) float32."""
    values = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("normal", values)
    return values.reshape(-1, 3)


def uv_maps(mesh: bpy.types.Mesh) -> dict[str, np.ndarray]:
    """(corners, 2) float32 by name, the one for renders first."""
    layers = sorted(mesh.uv_layers, key=lambda layer: not layer.active_render)
    return {layer.name: compat.uv_values(layer) for layer in layers}
