# SPDX-License-Identifier: GPL-3.0-or-later
"""The GPU preview: the Wrinkle Field drawn over the coarse mesh in Solid viewports, by Blender's gpu module.

show() takes what there is to see and touches no GPU, so that any handler may call it. All drawing happens in a
viewport draw handler, in the main thread, with a context. Off in background mode and while a render runs.
"""
from __future__ import annotations

import traceback
from dataclasses import dataclass, field
from typing import Any, Callable

import bpy
import gpu
import numpy as np
from bpy.app.handlers import persistent
from mathutils import Matrix

from .. import native
from . import gpu_field, shaders, structure, studio_light, versions

# How much nearer than Blender's own triangles ours lie: a share of the distance, or of the object's size. Enough for
# the differences of depth that its anti-aliasing makes, less than the thickness of a lined coat at arm's length.
_NEARER = 1e-3


@dataclass(frozen=True)
class Source:
    """What there is to see of an object at a frame."""

    model: Any  # WrinkleFieldModel, built with the uv of the mesh
    settings: Any  # WrinkleFieldSettings
    paint: Any  # WrinkleFieldPaint
    profile: Any  # WrinkleFieldProfile
    chosen: Any  # compares equal where settings, paint and profile are the same
    frame: float
    positions: np.ndarray  # (n, 3) float32, deformed base, object space
    state: Callable[[], Any]  # the WrinkleFieldState of this frame: asked for where frames do not follow one another


@dataclass
class _Shown:
    """An object in the preview."""

    name: str
    source: Source
    seen: Source | None = None  # what the GPU holds
    waves: gpu_field.GpuField | None = None
    slots: np.ndarray | None = None  # material slot of every triangle
    batches: dict[int, gpu.types.GPUBatch] = field(default_factory=dict)  # by material slot


_shown: dict[int, _Shown] = {}  # by session key
_passes: gpu_field.Passes | None = None
_render_shader: gpu.types.GPUShader | None = None
_no_image: gpu.types.GPUTexture | None = None
_handle: Any = None


# ---------------------------------------------------------------- what is shown
def show(obj: bpy.types.Object, source: Source) -> None:
    """Show an object so from the next redraw on. Cheap; may be called from any handler."""
    if bpy.app.background:
        return
    key = versions.session_key(obj)
    if key in _shown and _shown[key].name == obj.name:
        _shown[key].source = source
    else:
        _shown[key] = _Shown(obj.name, source)


def hide(obj: bpy.types.Object) -> None:
    """Show it no more. In the main thread: it frees textures."""
    _shown.pop(versions.session_key(obj), None)


def is_shown(obj: bpy.types.Object) -> bool:
    return versions.session_key(obj) in _shown


def clear() -> None:
    """Hide everything and free all that is on the GPU. In the main thread."""
    global _passes, _render_shader, _no_image
    _shown.clear()
    _passes = _render_shader = _no_image = None


# ---------------------------------------------------------------- drawing
def _draw() -> None:
    """The draw handler. Never raises."""
    if not _shown or structure.rendering():
        return
    space = bpy.context.space_data
    if space is None or space.type != "VIEW_3D" or space.shading.type != "SOLID" or space.shading.show_xray:
        return
    for key, entry in list(_shown.items()):
        obj = bpy.data.objects.get(entry.name)
        if obj is None or versions.session_key(obj) != key:
            del _shown[key]  # deleted, renamed or another version of itself after undo: whoever showed it does so again
        elif obj.mode not in ("EDIT", "SCULPT") and obj.visible_get(viewport=space):
            try:
                _update(obj, entry)
                _draw_object(obj, entry, space.shading)
            except Exception:  # a driver's refusal, say: once in the console, and Blender's own picture stays
                traceback.print_exc()
                del _shown[key]
            finally:
                _restore_state()


def _restore_state() -> None:
    """What Blender expects of a draw handler."""
    gpu.state.blend_set("NONE")
    gpu.state.depth_test_set("NONE")
    gpu.state.depth_mask_set(False)


def _update(obj: bpy.types.Object, entry: _Shown) -> None:
    """Bring the GPU from what it holds to what there is to see: the four stages but the last."""
    source, seen = entry.source, entry.seen
    if source is seen:
        return
    gpu_field.plain_state()
    if entry.waves is None or source.model is not seen.model:
        entry.waves, seen, entry.slots = gpu_field.GpuField(_the_passes(), source.model), None, None
    if seen is None or source.chosen != seen.chosen:
        entry.waves.set_wishes(source.settings, _wishes(source), source.profile)
        seen = None
    goes_on = seen is not None and source.frame == seen.frame + 1.0
    if not goes_on:
        state = source.state()
        entry.waves.begin(state.phase, state.direction)
    entry.waves.pose(*source.model.weld_pose(source.positions))
    entry.waves.crush()
    entry.waves.relax(source.settings.rounds if goes_on else 0)
    entry.waves.unfold()
    _collect_batches(obj, entry)
    entry.seen = source


def _wishes(source: Source) -> Any:
    return native.load().wishes_wrinkle_field(source.model, source.settings, source.paint)


def _draw_object(obj: bpy.types.Object, entry: _Shown, shading: bpy.types.View3DShading) -> None:
    shader = _the_render_shader()
    gpu.state.blend_set("NONE")
    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.state.depth_mask_set(True)
    gpu.state.face_culling_set("BACK" if shading.show_backface_culling else "NONE")
    shader.bind()
    for name, texture in entry.waves.arrays().items():
        shader.uniform_sampler(name, texture)
    view, projection = gpu.matrix.get_model_view_matrix(), gpu.matrix.get_projection_matrix()
    lights = studio_light.lights(shading, view)
    for slot, batch in entry.batches.items():
        finish = studio_light.finish(obj, slot, shading)
        image = gpu.texture.from_image(finish.image) if finish.image is not None and len(entry.source.model.uv) else None
        shader.uniform_sampler("image", _the_blank() if image is None else image)
        block = gpu.types.GPUUniformBuf(_block(obj, view, projection, lights, finish, image is not None))
        shader.uniform_block("preview", block)
        batch.draw(shader)
    gpu.state.face_culling_set("NONE")


def _block(obj: bpy.types.Object, view: Matrix, projection: Matrix, lights: studio_light.Lights,
           finish: studio_light.Finish, has_image: bool) -> gpu.types.Buffer:
    """The struct of shaders/preview/preview_block.glsl."""
    model_view = view @ obj.matrix_world
    to_object = model_view.inverted_safe()
    is_perspective = projection[3][3] == 0.0
    viewer = (*to_object.translation, 1.0) if is_perspective else (*to_object.col[2][:3], 0.0)
    nearer = _NEARER if is_perspective else _NEARER * max(obj.dimensions)
    numbers = np.concatenate([np.array(rows, np.float32).ravel() for rows in (
        model_view.transposed(), projection.transposed(), to_object.to_3x3().to_4x4(), viewer,  # columns one by one
        (*finish.color, 1.0), lights.direction, lights.diffuse, lights.specular, lights.ambient,
        (finish.metallic, finish.roughness, lights.has_specular, has_image, nearer, 0.0, 0.0, 0.0))])
    return gpu.types.Buffer("FLOAT", numbers.size, numbers)


def _collect_batches(obj: bpy.types.Object, entry: _Shown) -> None:
    """A batch of separate triangles for every material slot that is used, when these changed."""
    model = entry.source.model
    triangles = model.triangles
    slots = np.zeros(len(triangles), np.int32)
    if len(obj.data.loop_triangles) == len(slots):
        obj.data.loop_triangles.foreach_get("material_index", slots)
    if entry.slots is not None and np.array_equal(slots, entry.slots):
        return
    entry.slots = slots
    corners = np.arange(3 * len(triangles), dtype=np.int32).reshape(-1, 3)
    uv = model.uv if len(model.uv) else np.zeros((corners.size, 2), np.float32)
    fan = model.uv_fan if len(model.uv_fan) else np.zeros(corners.size, np.int32)
    layout = gpu.types.GPUVertFormat()
    layout.attr_add(id="triangle", comp_type="I32", len=3, fetch_mode="INT")
    layout.attr_add(id="corner", comp_type="I32", len=1, fetch_mode="INT")
    layout.attr_add(id="fan", comp_type="I32", len=1, fetch_mode="INT")
    layout.attr_add(id="uv", comp_type="F32", len=2, fetch_mode="FLOAT")
    entry.batches = {}
    for slot in np.unique(slots):
        chosen = corners[slots == slot].ravel()
        buffer = gpu.types.GPUVertBuf(layout, len(chosen))
        for name, values in (("triangle", triangles[chosen // 3]), ("corner", chosen % 3), ("fan", fan[chosen]),
                             ("uv", uv[chosen])):
            buffer.attr_fill(name, np.ascontiguousarray(values))
        entry.batches[int(slot)] = gpu.types.GPUBatch(type="TRIS", buf=buffer)


# ---------------------------------------------------------------- shaders, compiled when first needed
def _the_passes() -> gpu_field.Passes:
    global _passes
    if _passes is None:
        _passes = gpu_field.Passes()
    return _passes


def _the_blank() -> gpu.types.GPUTexture:
    global _no_image
    if _no_image is None:
        _no_image = gpu_field.upload(np.ones((1, 4), np.float32))
    return _no_image


def _the_render_shader() -> gpu.types.GPUShader:
    global _render_shader
    if _render_shader is None:
        _render_shader = _compile()
    return _render_shader


def _compile() -> gpu.types.GPUShader:
    between = gpu.types.GPUStageInterfaceInfo("rumple_preview")
    for name in ("phase", "weight", "normal", "place", "u_slope", "v_slope"):
        between.smooth("VEC3", name)
    between.smooth("VEC2", "image_uv")
    for name in ("vector_a", "vector_b", "vector_c"):
        between.flat("VEC3", name)
    info = gpu.types.GPUShaderCreateInfo()
    info.typedef_source(shaders.text("preview/preview_block"))
    info.uniform_buf(0, "Preview", "preview")
    for slot, name in enumerate(("positions", "normals", "waves", "phases", "u_slopes", "v_slopes", "profile", "image")):
        info.sampler(slot, "FLOAT_2D", name)
    for slot, (kind, name) in enumerate((("IVEC3", "triangle"), ("INT", "corner"), ("INT", "fan"), ("VEC2", "uv"))):
        info.vertex_in(slot, kind, name)
    info.vertex_out(between)
    info.fragment_out(0, "VEC4", "out_color")
    info.vertex_source(shaders.source("preview/texels", "preview/render_vertex"))
    info.fragment_source(shaders.source(*shaders.FORMULAS, "preview/texels", "preview/studio_light",
                                        "preview/render_fragment"))
    return gpu.shader.create_from_info(info)


# ---------------------------------------------------------------- registration
@persistent
def _on_load(*_arguments: object) -> None:
    clear()


def register() -> None:
    """Nothing in background mode: there is no viewport, and the gpu module crashes 3.4 there."""
    global _handle
    if bpy.app.background:
        return
    _handle = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW")
    bpy.app.handlers.load_pre.append(_on_load)


def unregister() -> None:
    global _handle
    if _handle is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_handle, "WINDOW")
        bpy.app.handlers.load_pre.remove(_on_load)
        _handle = None
    clear()
