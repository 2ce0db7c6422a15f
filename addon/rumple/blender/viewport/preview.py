# SPDX-License-Identifier: GPL-3.0-or-later
"""The GPU preview: wrinkles in Solid viewports, drawn on the graphics card by Blender's gpu module.

Everything runs in a viewport draw handler: in the main thread, with a drawing context. The drawings of the systems are
in preview_mesh.py, preview_field.py and preview_paths.py. The preview is off in background mode and while a render
runs.

The waves of a Wrinkle Field are drawn over Blender's own triangles. While all viewports draw them (uses_proxy()), the
handlers write no attributes for shaders. A Wrinkle Mesh and the folds of Wrinkle Paths change the shape. While all
viewports draw them, the handlers do not write the fine mesh. Blender then has the coarse mesh near the drawn surface,
for depth, outlines and clicks. A frame of a Wrinkle Field or a Wrinkle Mesh that the GPU computes from the frame before
is solved on the CPU only when its result is needed (core/frame/frame_cache.py).
"""
from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any, Callable, Iterator, Protocol

import bpy
import gpu
import numpy as np
from mathutils import Matrix

from ...core.base.wording import UserError
from .. import compat, scheduler
from ..objects import bodies, incoming_mesh, messages, modifier, runtimes, viewport_mesh, weight_paint
from . import gpu_arrays, gpu_kernels, preview_field, preview_mesh, preview_paths, studio_light
from .draw_handler import DrawHandler

# How much nearer our triangles are drawn than Blender's: a share of the distance, or of the object's size. It is larger
# than the depth differences caused by Blender's anti-aliasing, and smaller than the thickness of a lined coat at arm's
# length.
_NEARER = 1e-3
_FOLDS = 0.05  # largest distance of the drawn surface from its coarse mesh / the longest side of the mesh


class Drawing(Protocol):
    """A system's drawing of one object. It is created, updated and drawn in a draw handler."""

    has_uv: bool  # whether images can be shown

    def __init__(self, model: Any) -> None:
        """model: model of the system."""

    def update(self, obj: bpy.types.Object, runtime: runtimes.Runtime, before: runtimes.Inputs | None,
               slots: np.ndarray) -> bool:
        """Update the GPU to runtime.inputs, which are new; before: the inputs on the GPU. Returns False if there is
        nothing to draw.

        slots: (t,) material slot of every triangle of the mesh.
        """

    def shader(self) -> gpu.types.GPUShader:
        """A shader from gpu_arrays.drawing_shader()."""

    def arrays(self) -> dict[str, gpu.types.GPUTexture]:
        """The textures of its samplers."""

    def slots(self) -> list[int]:
        """The material slots with something to draw."""

    def present(self, paint: Callable[[], None], over: gpu_arrays.Overlays, block: gpu.types.GPUUniformBuf) -> None:
        """Show the drawing of paint() in the viewport, under the overlays `over` (gpu_arrays.overlays()). block: the
        transforms of object and viewer."""

    def draw(self, shader: gpu.types.GPUShader, slot: int) -> None:
        """Draw the triangles with this slot. Shader, arrays, image and block are bound."""


_DRAWINGS: dict[str, type[Drawing]] = {"MESH": preview_mesh.Drawing, "FIELD": preview_field.Drawing,
                                       "PATHS": preview_paths.Drawing}


@dataclass
class _OnGpu:
    """An object's data on the GPU."""

    model: Any  # the model that the drawing belongs to
    drawing: Drawing | None = None
    refusal: str = ""  # why it is not drawn; it is not tried again
    inputs: runtimes.Inputs | None = None  # the inputs of the data on the GPU


REFUSED = "The graphics driver refuses the GPU Preview (the console says why): the fine mesh is shown"

NOT_DRAWN = ("The GPU Preview needs one layer over the animation, without base cloth, body, own mesh, rigid parts, "
             "guides, patches that are painted smooth or rigid, a rest shape that adapts, collision with the "
             "neighbourhood, and folds that turn with the world. The fine mesh is shown")

_on_gpu: dict[int, _OnGpu] = {}  # by session key


def _clear() -> None:
    """Free all data on the GPU. Call it in the main thread."""
    _on_gpu.clear()
    gpu_arrays.forget()


# ---------------------------------------------------------------- what is shown
def can_solve_meshes() -> bool:
    """Whether this Blender has what the preview of a Wrinkle Mesh needs: from 4 on."""
    return gpu_kernels.are_available()


def _is_wanted(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> bool:
    """Whether the preview of an object is on, and its mode and modifier allow it."""
    if obj.rumple.method not in _DRAWINGS or (obj.rumple.method == "MESH" and not can_solve_meshes()):
        return False
    group, runtime = getattr(obj.rumple, obj.rumple.method.lower()), runtimes.known(obj)
    return (group.gpu_preview and getattr(group, "output", "SHADING") == "SHADING"
            and (runtime is None or runtime.evaluator is None
                 or runtime.evaluator.is_previewed(group, bool(bodies.of(obj))))
            and nodes_mod.show_viewport and not modifier.is_baked(nodes_mod) and obj.mode == "OBJECT")


def shown_objects() -> Iterator[tuple[bpy.types.Object, runtimes.Runtime]]:
    """Objects whose preview is on, with a solved frame."""
    for obj, nodes_mod in modifier.wrinkled_objects():
        runtime = runtimes.known(obj)
        if (runtime is not None and runtime.inputs is not None and runtime.evaluator is not None
                and _is_wanted(obj, nodes_mod)):
            yield obj, runtime


def _draws_in(space: bpy.types.SpaceView3D) -> bool:
    return space.shading.type == "SOLID" and not space.shading.show_xray


def _mesh_is_read(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> bool:
    """Whether the output mesh of a Wrinkle Field is needed for more than the viewport's material: it has the offsets of
    a base cloth or a body, or nodes behind it may read its attributes."""
    if obj.rumple.method != "FIELD":
        return False
    behind = list(obj.modifiers)[list(obj.modifiers).index(nodes_mod) + 1:]
    return (obj.rumple.field.base_cloth != "OFF" or bool(bodies.of(obj))
            or any(m.type == "NODES" and m.show_viewport for m in behind))


def uses_proxy(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> bool:
    """Whether all open viewports draw the wrinkles of an object themselves, so that none needs a solved output mesh.

    Never in background mode. Call it in the main thread.
    """
    if (not handler.added or viewport_mesh.is_paused() or not _is_wanted(obj, nodes_mod)
            or _mesh_is_read(obj, nodes_mod)):
        return False
    if obj.rumple.method == "MESH" and not viewport_mesh.may_have_other_points(obj, nodes_mod):
        return False
    if obj.rumple.method == "PATHS" and obj in viewport_mesh.targets():
        return False  # something is bound to the points of the fine mesh
    on_gpu = _on_gpu.get(compat.session_key(obj))
    if on_gpu is not None and on_gpu.refusal:
        return False
    views = [area.spaces.active for window in bpy.context.window_manager.windows for area in window.screen.areas
             if area.type == "VIEW_3D"]
    return bool(views) and all(_draws_in(space) for space in views)


def refusal(obj: bpy.types.Object) -> str:
    """Why the preview of an object is on but not drawn; empty if there is no reason."""
    runtime, on_gpu = runtimes.known(obj), _on_gpu.get(compat.session_key(obj))
    if (obj.rumple.method == "MESH" and obj.rumple.mesh.gpu_preview and can_solve_meshes() and runtime is not None
            and runtime.evaluator is not None):
        if not runtime.evaluator.is_previewed(obj.rumple.mesh, bool(bodies.of(obj))):
            return NOT_DRAWN
    return on_gpu.refusal if on_gpu is not None else ""


# ---------------------------------------------------------------- drawing
def _draw() -> None:
    """The draw handler. It never waits for a solve."""
    space = bpy.context.space_data
    if scheduler.rendering() or space is None or space.type != "VIEW_3D":
        return
    if not scheduler.LOCK.acquire(blocking=False):
        return  # another thread is solving: the next redraw shows the result
    try:
        _ask_for_meshes()
        shown = {compat.session_key(obj): (obj, runtime) for obj, runtime in shown_objects()}
        for key in _on_gpu.keys() - shown.keys():
            del _on_gpu[key]
        if _draws_in(space):
            _draw_all([(obj, runtime, key) for key, (obj, runtime) in shown.items()
                       if obj.visible_get(viewport=space)], space)
    finally:
        scheduler.LOCK.release()


def _ask_for_meshes() -> None:
    """Tag objects that now need another mesh, because Blender updates nothing when a viewport's shading or the tool
    changes."""
    for obj, nodes_mod in modifier.wrinkled_objects():
        runtime = runtimes.known(obj)
        if runtime is None or runtime.inputs is None:
            continue
        _ask_for_coarse(obj, runtime)
        if obj.rumple.method not in _DRAWINGS:
            continue
        over = uses_proxy(obj, nodes_mod)
        if over != runtime.asked_for_proxy:  # only once, in case it cannot be evaluated now
            runtime.asked_for_proxy = over
            if over != runtime.inputs.for_preview:
                modifier.tag_soon([obj])


def _ask_for_coarse(obj: bpy.types.Object, runtime: runtimes.Runtime) -> None:
    wanted = weight_paint.needs_coarse(obj)
    if wanted != runtime.asked_for_coarse:  # once, as below
        runtime.asked_for_coarse = wanted
        if wanted != runtime.inputs.shows_coarse:
            modifier.tag_soon([obj])


def _draw_all(shown: list[tuple[bpy.types.Object, runtimes.Runtime, int]], space: bpy.types.SpaceView3D) -> None:
    """Draw objects, given with their session keys, in one viewport."""
    if not shown:
        return
    over = _overlays(space, shown)
    for obj, runtime, key in shown:
        _draw_guarded(obj, runtime, key, space.shading, over)


def _overlays(space: bpy.types.SpaceView3D,
              shown: list[tuple[bpy.types.Object, runtimes.Runtime, int]]) -> gpu_arrays.Overlays:
    """The overlays over the previews. If a driver cannot read them, the previews are drawn over them."""
    if space.overlay.show_overlays:
        with messages.console_errors("overlays over the GPU preview"):
            return gpu_arrays.overlays(_box(shown))
    return gpu_arrays.no_overlays()


def _box(shown: list[tuple[bpy.types.Object, runtimes.Runtime, int]]) -> tuple[int, int, int, int]:
    """The part of the viewport with the objects: left, bottom, width, height, in pixels. The whole viewport if some are
    behind the viewer."""
    _left, _bottom, width, height = gpu.state.viewport_get()
    to_screen = gpu.matrix.get_projection_matrix() @ gpu.matrix.get_model_view_matrix()
    places = []
    for obj, runtime, _key in shown:
        low, high = runtime.inputs.positions.min(axis=0), runtime.inputs.positions.max(axis=0)
        folds = _FOLDS * float((high - low).max())
        corners = np.array(list(itertools.product(*zip(low - folds, high + folds))))
        places.append(np.c_[corners, np.ones(8)] @ np.array(to_screen @ obj.matrix_world).T)
    at = np.concatenate(places)
    if at[:, 3].min() <= 0.0:
        return 0, 0, width, height
    pixels = np.clip((0.5 + 0.5 * at[:, :2] / at[:, 3:]) * (width, height), 0.0, (width, height))
    left, bottom = (int(low) for low in np.floor(pixels.min(axis=0)))
    right, top = (int(high) for high in np.ceil(pixels.max(axis=0)))
    return left, bottom, right - left, top - bottom


def _draw_guarded(obj: bpy.types.Object, runtime: runtimes.Runtime, key: int, shading: bpy.types.View3DShading,
                  over: gpu_arrays.Overlays) -> None:
    on_gpu = _on_gpu.get(key)
    if on_gpu is None or on_gpu.model is not runtime.evaluator.model:
        on_gpu = _on_gpu[key] = _OnGpu(runtime.evaluator.model)
    if on_gpu.refusal:
        return
    blend, depth_test, depth_mask = gpu.state.blend_get(), gpu.state.depth_test_get(), gpu.state.depth_mask_get()
    try:
        if _update(obj, runtime, on_gpu):
            _draw_object(obj, on_gpu, shading, over)
    except Exception as error:  # e.g. a driver's error: printed once, and Blender's own drawing stays visible
        on_gpu.refusal = str(error) if isinstance(error, UserError) else REFUSED
        modifier.tag_soon([obj])
        scheduler.redraw_panels_soon()
        print(f"Rumple: {messages.unexpected(obj, error)}")
    finally:
        gpu.state.blend_set(blend)
        gpu.state.depth_test_set(depth_test)
        gpu.state.depth_mask_set(depth_mask)
        gpu.state.face_culling_set("NONE")


def _update(obj: bpy.types.Object, runtime: runtimes.Runtime, on_gpu: _OnGpu) -> bool:
    """Update the GPU to the last solved frame. Returns False if there is nothing to draw."""
    if runtime.inputs is on_gpu.inputs:
        return True
    gpu_arrays.plain_state()
    if on_gpu.drawing is None:
        on_gpu.drawing = _DRAWINGS[obj.rumple.method](on_gpu.model)
    slots = _material_slots(obj, runtime.evaluator.coarse_triangles()[1])
    if not on_gpu.drawing.update(obj, runtime, on_gpu.inputs, slots):
        return False
    on_gpu.inputs = runtime.inputs
    return True


def _material_slots(obj: bpy.types.Object, polygons: np.ndarray) -> np.ndarray:
    """The slot of every triangle, (t,) int32. polygons: (t,) the triangles' polygons."""
    coarse = incoming_mesh.of(obj).polygons
    slots = np.zeros(len(coarse), np.int32)
    coarse.foreach_get("material_index", slots)
    return slots[polygons] if len(polygons) and polygons.max() < len(slots) else np.zeros(len(polygons), np.int32)


def _draw_object(obj: bpy.types.Object, on_gpu: _OnGpu, shading: bpy.types.View3DShading,
                 over: gpu_arrays.Overlays) -> None:
    drawing = on_gpu.drawing
    gpu.state.blend_set("NONE")
    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.state.depth_mask_set(True)
    gpu.state.face_culling_set("BACK" if shading.show_backface_culling else "NONE")
    view, projection = gpu.matrix.get_model_view_matrix(), gpu.matrix.get_projection_matrix()
    lights = studio_light.lights(shading, view)
    finishes, blocks = {}, {}
    for slot in drawing.slots():
        finishes[slot] = finish = studio_light.finish(obj, slot, shading)
        finish.image = finish.image if drawing.has_uv else None
        blocks[slot] = gpu.types.GPUUniformBuf(_block(obj, view, projection, lights, finish))

    def paint() -> None:
        shader = drawing.shader()
        shader.bind()
        for name, texture in drawing.arrays().items():
            shader.uniform_sampler(name, texture)
        for slot, finish in finishes.items():
            image = gpu_arrays.blank() if finish.image is None else gpu.texture.from_image(finish.image)
            shader.uniform_sampler("image", image)
            shader.uniform_block("preview", blocks[slot])
            drawing.draw(shader, slot)

    drawing.present(paint, over, next(iter(blocks.values())))


def _block(obj: bpy.types.Object, view: Matrix, projection: Matrix, lights: studio_light.Lights,
           finish: studio_light.Finish) -> gpu.types.Buffer:
    """The struct of shaders/preview/preview_block.glsl."""
    model_view = view @ obj.matrix_world
    to_object = model_view.inverted_safe()
    is_perspective = projection[3][3] == 0.0
    viewer = (*to_object.translation, 1.0) if is_perspective else (*to_object.col[2][:3], 0.0)
    nearer = _NEARER if is_perspective else _NEARER * max(obj.dimensions)
    left, bottom, _width, _height = gpu.state.viewport_get()
    numbers = np.concatenate([np.array(rows, np.float32).ravel() for rows in (
        model_view.transposed(), projection.transposed(), to_object.to_3x3().to_4x4(), viewer,  # columns one by one
        (*finish.color, 1.0), lights.direction, lights.diffuse, lights.specular, lights.ambient,
        (finish.metallic, finish.roughness, lights.has_specular, finish.image is not None, nearer, left, bottom, 0.0))])
    return gpu.types.Buffer("FLOAT", numbers.size, numbers)


# ---------------------------------------------------------------- registration
handler = DrawHandler("the GPU preview", _draw, _clear)
register, unregister = handler.add, handler.remove
