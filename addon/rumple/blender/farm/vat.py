# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports the baked garment as vertex animation textures and a mesh for game engines. core/files/vat.py: the layout."""
from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix

from ...core.files import clip_folder
from ...core.files.clip_manifest import ClipFault, Manifest
from ...core.files.vat import STEPS, TOO_FAR, UV_MAP, Layout, Remap, encode_normals, in_place_of, remap_text, way_of
from .. import compat
from ..bake.playback import BakeError
from ..objects import units
from . import images, shown

KINDS = {"png": ("PNG",), "exr": ("OPEN_EXR",), "both": ("PNG", "OPEN_EXR")}


@dataclass
class _Clip:
    """A whole clip. points, normals: (frames, n, 3) float32, in the object's space at the first frame."""

    points: np.ndarray
    normals: np.ndarray
    mesh: bpy.types.Mesh  # a copy of the first frame, with the second UV map
    world: np.ndarray
    layout: Layout


def export(context: bpy.types.Context, obj: bpy.types.Object, manifest: Manifest, folder: Path,
           kind: str, in_place: bool) -> shown.Exported:
    """Export the shown clip. manifest: of this clip. kind: a key of KINDS. in_place: without the motion of the whole
    garment. Raises BakeError and ClipFault. Memory: 24 bytes for each point and frame, and 60 for each texel."""
    if not hasattr(bpy.types, "EXPORT_SCENE_OT_gltf"):
        raise BakeError(f"{obj.name}: Blender's glTF exporter is switched off: enable the add-on glTF 2.0 format")
    path = folder / f"{shown.stem(obj, manifest)}_vat"
    count = manifest.end - manifest.start + 1
    clip_folder.make(folder, 0)
    temporary = clip_folder.temporary(path)
    clip: _Clip | None = None
    try:
        clip = _read(context, obj, manifest, count)
        clip_folder.make(folder, len(KINDS[kind]) * clip.layout.width * clip.layout.height * 12)
        temporary.mkdir()
        about: dict[str, Any] = dict(shown.about(obj, manifest))
        if in_place:
            way = way_of(clip.points)
            clip.points -= way[:, None]
            about["way"] = way.astype(float).tolist()
        error = _write(temporary, obj, clip, kind, about, context.scene)
        size = sum(file.stat().st_size for file in temporary.iterdir())
        clip_folder.replace_folder(temporary, path)
    except OSError as fault:
        raise ClipFault(clip_folder.in_words(fault, folder)) from fault
    finally:
        clip_folder.discard(temporary)
        if clip is not None:
            bpy.data.meshes.remove(clip.mesh)
    note = _note(clip.layout, error * units.most_metres_per_unit(obj, context.scene))
    return shown.Exported(path, count, clip.layout.points, size, note, dict(
        width=clip.layout.width, height=clip.layout.height, error=error))


def _note(layout: Layout, metres: float) -> str:
    """A note for the report. metres: the largest error."""
    advice = " (much for a garment: take OpenEXR, or fewer frames)" if metres > TOO_FAR else ""
    return f", {layout.width} x {layout.height} texels, at most {1e3 * metres:.2g} mm off{advice}"


def _read(context: bpy.types.Context, obj: bpy.types.Object, manifest: Manifest, count: int) -> _Clip:
    clip: _Clip | None = None
    try:
        for number, frame in enumerate(shown.frames(context, obj, manifest)):
            if clip is None:
                layout = Layout.of(len(frame.points), count)
                empty = np.empty((count, layout.points, 3), np.float32)
                clip = _Clip(empty, empty.copy(), _first(obj, frame, layout), frame.world, layout)
            clip.points[number], clip.normals[number] = in_place_of(clip.world, frame.world, frame.points,
                                                                    shown.normals(frame.mesh))
    except BaseException:
        if clip is not None:
            bpy.data.meshes.remove(clip.mesh)
        raise
    assert clip is not None  # a clip has a frame
    return clip


def _first(obj: bpy.types.Object, frame: shown.Frame, layout: Layout) -> bpy.types.Mesh:
    """The shown mesh at the first frame: its faces, its UV map and, always second, the UV map of the texels."""
    sizes, corners = shown.face_sizes(frame.mesh), compat.corner_vertices(frame.mesh)
    maps = list(shown.uv_maps(frame.mesh).values()) or [np.zeros((len(corners), 2), np.float32)]
    mesh = bpy.data.meshes.new(f"{obj.name}_mesh")
    compat.fill_polygons(mesh, frame.points, np.concatenate([[0], np.cumsum(sizes)]), corners)
    for name, values in (("UVMap", maps[0]), (UV_MAP, layout.uv()[corners])):
        mesh.uv_layers.new(name=name, do_init=False)
        mesh.uv_layers[name].data.foreach_set("uv", np.ascontiguousarray(values).ravel())
    mesh.polygons.foreach_set("use_smooth", np.ones(len(sizes), bool))
    mesh.update()
    return mesh


def _write(folder: Path, obj: bpy.types.Object, clip: _Clip, kind: str, about: dict[str, Any],
           scene: bpy.types.Scene) -> float:
    """Write the textures. Returns the largest error of a position, object units."""
    name, layout = clip_folder.readable(obj.name), clip.layout
    offsets = clip.points - clip.points[0]
    remap = Remap.of(offsets)
    error = 0.0
    for image_kind in KINDS[kind]:
        deep, suffix = image_kind != "PNG", images.SUFFIXES[image_kind]
        shares = remap.encode(offsets, deep)
        error = max(error, float(np.abs(remap.decode(shares) - offsets).max()))
        images.write(folder / f"{name}_vat{suffix}", layout.picture(shares), image_kind)
        images.write(folder / f"{name}_vnrm{suffix}", layout.picture(encode_normals(clip.normals, deep)), image_kind)
    about.update(frames_a_second=scene.render.fps / scene.render.fps_base, error=error,
                 metres_a_unit=scene.unit_settings.scale_length, matrix=clip.world.tolist(), steps=STEPS)
    (folder / f"{name}-remap_info.json").write_text(remap_text(remap, layout, about), encoding="utf-8")
    _write_mesh(folder / f"{name}.glb", clip)
    return error


def _write_mesh(path: Path, clip: _Clip) -> None:
    """Write the mesh with Blender's exporter, from a separate scene, so that the artist's selection does not change."""
    scene = bpy.data.scenes.new("Rumple Export")
    obj = bpy.data.objects.new(path.stem, clip.mesh)
    window = bpy.context.window
    former = None if window is None else window.scene
    try:
        scene.collection.objects.link(obj)
        obj.matrix_world = Matrix(clip.world.tolist())
        if window is not None:
            window.scene = scene
        with bpy.context.temp_override(scene=scene, view_layer=scene.view_layers[0]):
            bpy.ops.export_scene.gltf(filepath=str(path), export_format="GLB", use_active_scene=True,
                                      export_texcoords=True, export_normals=True, export_materials="NONE",
                                      export_animations=False, export_skins=False, export_morph=False,
                                      export_yup=True)
    except RuntimeError as error:
        raise ClipFault(f"Blender's glTF exporter failed: {str(error).strip()}") from error
    finally:
        if former is not None:
            window.scene = former
        bpy.data.objects.remove(obj)
        bpy.data.scenes.remove(scene)
    if not path.is_file():
        raise ClipFault(f"the mesh {path.name} cannot be written: make room, or choose another folder")
