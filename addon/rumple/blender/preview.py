# SPDX-License-Identifier: GPL-3.0-or-later
"""The GPU preview: the Wrinkle Field drawn over the coarse mesh in Solid viewports, by Blender's gpu module.

All of it happens in a viewport draw handler: in the main thread, with a drawing context. The handlers that solve know
nothing of it; it looks at what they solved last (registry). Off in background mode and while a render runs.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Iterator

import bpy
import gpu
import numpy as np
from bpy.app.handlers import persistent
from mathutils import Matrix

from . import gpu_field, modifier, registry, shaders, structure, studio_light, versions

# How much nearer than Blender's own triangles ours lie: a share of the distance, or of the object's size. Enough for
# the differences of depth that its anti-aliasing makes, less than the thickness of a lined coat at arm's length.
_NEARER = 1e-3


@dataclass
class _OnGpu:
    """An object's field on the GPU."""

    model: Any  # the WrinkleFieldModel that the rest is made for
    refused: bool = False  # by the driver: not tried again
    inputs: registry.Inputs | None = None  # what the GPU holds
    waves: gpu_field.GpuField | None = None
    slots: np.ndarray | None = None  # material slot of every triangle
    batches: dict[int, gpu.types.GPUBatch] = field(default_factory=dict)  # by material slot


_on_gpu: dict[int, _OnGpu] = {}  # by session key
_passes: gpu_field.Passes | None = None
_render_shader: gpu.types.GPUShader | None = None
_no_image: gpu.types.GPUTexture | None = None
_handle: Any = None


def _clear() -> None:
    """Free all that is on the GPU. In the main thread."""
    global _passes, _render_shader, _no_image
    _on_gpu.clear()
    _passes = _render_shader = _no_image = None


# ---------------------------------------------------------------- what is shown
def shown_objects() -> Iterator[tuple[bpy.types.Object, registry.Runtime]]:
    """Objects whose preview is on and has a solved frame to show."""
    for obj, ours in modifier.wrinkled_objects():
        rumple = obj.rumple
        if rumple.method != "FIELD" or not rumple.field.gpu_preview or rumple.field.output != "SHADING":
            continue
        entry = registry.known(obj)
        if (entry is not None and entry.inputs is not None and entry.fine is not None and ours.show_viewport
                and not modifier.is_baked(ours) and obj.mode not in ("EDIT", "SCULPT")):
            yield obj, entry


# ---------------------------------------------------------------- drawing
def _draw() -> None:
    """The draw handler. Never raises, never waits."""
    space = bpy.context.space_data
    if structure.rendering() or space is None or space.type != "VIEW_3D":
        return
    if not registry.LOCK.acquire(blocking=False):
        return  # somebody solves: the next redraw shows it
    try:
        shown = {versions.session_key(obj): (obj, entry) for obj, entry in shown_objects()}
        for key in _on_gpu.keys() - shown.keys():
            del _on_gpu[key]
        if space.shading.type == "SOLID" and not space.shading.show_xray:
            for key, (obj, entry) in shown.items():
                if obj.visible_get(viewport=space):
                    _draw_guarded(obj, entry, key, space.shading)
    except Exception as error:
        print(f"Rumple: the GPU preview failed: {error}")
    finally:
        registry.LOCK.release()


def _draw_guarded(obj: bpy.types.Object, entry: registry.Runtime, key: int, shading: bpy.types.View3DShading) -> None:
    held = _on_gpu.get(key)
    if held is None or held.model is not entry.fine.model:
        held = _on_gpu[key] = _OnGpu(entry.fine.model)
    if held.refused:
        return
    blend, depth_test, depth_mask = gpu.state.blend_get(), gpu.state.depth_test_get(), gpu.state.depth_mask_get()
    try:
        if _update(obj, entry, held):
            _draw_object(obj, held, shading)
    except Exception as error:  # what a driver refuses, say: once in the console, and Blender's own picture stays
        held.refused = True
        print(f"Rumple: {structure.unexpected(obj, error)}")
    finally:
        gpu.state.blend_set(blend)
        gpu.state.depth_test_set(depth_test)
        gpu.state.depth_mask_set(depth_mask)
        gpu.state.face_culling_set("NONE")


def _update(obj: bpy.types.Object, entry: registry.Runtime, held: _OnGpu) -> bool:
    """Bring the GPU from what it holds to the frame that was solved last: all stages but the last.

    Where the engine solves a frame from the one before, the GPU does so by itself; after a jump, after a change at the
    same frame and up to the clip's first frame it takes over the engine's state. False where there is none.
    """
    inputs, fine = entry.inputs, entry.fine
    if inputs is held.inputs:
        return True
    gpu_field.plain_state()
    if held.waves is None:
        held.waves = gpu_field.GpuField(_the_passes(), held.model)
    before = held.inputs
    if before is None or before.settings != inputs.settings or before.paint is not inputs.paint:
        held.waves.set_wishes(*fine.wishes(inputs.settings))
    goes_on = (before is not None and before.paint is inputs.paint and not inputs.settings.stateless
               and inputs.frame == before.frame + 1.0 > bpy.context.scene.frame_start)
    if not goes_on:
        state = fine.state_of(inputs.frame)
        if state is None:
            return False
        held.waves.begin(state.phase, state.direction, state.solved_offset)
    elif before.settings != inputs.settings:
        held.waves.wake()
    state = fine.state_of(inputs.frame) if inputs.settings.adapts else None
    held.waves.pose(*held.model.weld_pose(inputs.positions),
                    fine.reference_stretches(state, inputs.positions) if state is not None else None)
    held.waves.crush()
    held.waves.relax(inputs.settings.rounds if goes_on else 0)
    held.waves.unfold()
    _collect_batches(obj, held)
    held.inputs = inputs
    return True


def _draw_object(obj: bpy.types.Object, held: _OnGpu, shading: bpy.types.View3DShading) -> None:
    shader = _the_render_shader()
    gpu.state.blend_set("NONE")
    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.state.depth_mask_set(True)
    gpu.state.face_culling_set("BACK" if shading.show_backface_culling else "NONE")
    shader.bind()
    for name, texture in held.waves.arrays().items():
        shader.uniform_sampler(name, texture)
    view, projection = gpu.matrix.get_model_view_matrix(), gpu.matrix.get_projection_matrix()
    lights = studio_light.lights(shading, view)
    for slot, batch in held.batches.items():
        finish = studio_light.finish(obj, slot, shading)
        has_image = finish.image is not None and len(held.model.uv) > 0
        shader.uniform_sampler("image", gpu.texture.from_image(finish.image) if has_image else _the_blank())
        block = gpu.types.GPUUniformBuf(_block(obj, view, projection, lights, finish, has_image))
        shader.uniform_block("preview", block)
        batch.draw(shader)


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


def _collect_batches(obj: bpy.types.Object, held: _OnGpu) -> None:
    """A batch of separate triangles for every material slot that is used, when these changed."""
    model = held.model
    triangles = model.triangles
    slots = np.zeros(len(triangles), np.int32)
    if not obj.data.loop_triangles:
        obj.data.calc_loop_triangles()  # Blender forgets them when the mesh is touched
    if len(obj.data.loop_triangles) == len(slots):
        obj.data.loop_triangles.foreach_get("material_index", slots)
    if held.slots is not None and np.array_equal(slots, held.slots):
        return
    held.slots = slots
    corners = np.arange(3 * len(triangles), dtype=np.int32).reshape(-1, 3)
    uv = model.uv if len(model.uv) else np.zeros((corners.size, 2), np.float32)
    fan = model.uv_fan if len(model.uv_fan) else np.zeros(corners.size, np.int32)
    layout = gpu.types.GPUVertFormat()
    layout.attr_add(id="triangle", comp_type="I32", len=3, fetch_mode="INT")
    layout.attr_add(id="corner", comp_type="I32", len=1, fetch_mode="INT")
    layout.attr_add(id="fan", comp_type="I32", len=1, fetch_mode="INT")
    layout.attr_add(id="uv", comp_type="F32", len=2, fetch_mode="FLOAT")
    held.batches = {}
    for slot in np.unique(slots):
        chosen = corners[slots == slot].ravel()
        buffer = gpu.types.GPUVertBuf(layout, len(chosen))
        for name, values in (("triangle", triangles[chosen // 3]), ("corner", chosen % 3), ("fan", fan[chosen]),
                             ("uv", uv[chosen])):
            buffer.attr_fill(name, np.ascontiguousarray(values))
        held.batches[int(slot)] = gpu.types.GPUBatch(type="TRIS", buf=buffer)


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
    textures = ("positions", "normals", "waves", "phases", "u_slopes", "v_slopes", "profile", "image")
    for slot, name in enumerate(textures):
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
    _clear()


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
    _clear()
