# SPDX-License-Identifier: GPL-3.0-or-later
"""The base class of tests that look at a GPU preview in a Solid viewport."""
from __future__ import annotations

from types import ModuleType, SimpleNamespace
from typing import Iterator

import bpy
import numpy as np
import rumple_native as native
from rumple.blender import handlers
from rumple.blender.objects import runtimes
from rumple.blender.viewport import preview
from rumple.core.mesh.frame_result import FrameResult
from support import gpu_waves, sleeve
from support.frames import solve_frame
from support.window_case import WindowCase


class PreviewCase(WindowCase):
    method = "FIELD"

    def setUp(self) -> None:
        """One sample a pixel: the same picture at every redraw."""
        system = bpy.context.preferences.system
        self.addCleanup(setattr, system, "viewport_aa", system.viewport_aa)
        system.viewport_aa = "OFF"

    def view(self) -> Iterator[float]:
        """The biggest area as a clean Solid viewport: self.area."""
        self.area = max(bpy.context.window_manager.windows[0].screen.areas, key=lambda a: a.width * a.height)
        self.area.type = "VIEW_3D"
        yield 0.2
        self.clear_view(self.area.spaces.active)
        yield 0.1

    def make(self, **settings: object) -> Iterator[float]:
        """The sleeve, bent, with wrinkles and their preview on; self.obj and self.area."""
        self.obj = sleeve.scene(wrinkles=False)
        group = getattr(self.obj.rumple, self.method.lower())
        for name, value in {"gpu_preview": True, **settings}.items():
            setattr(group, name, value)
        with sleeve.context():
            bpy.ops.object.rumple_add(method=self.method)
        sleeve.at(sleeve.LAST)
        yield from self.view()
        self.look()
        yield 0.3

    def look(self) -> None:
        """At the sleeve's bend, from below."""
        region = self.area.spaces.active.region_3d
        region.view_rotation, region.view_location, region.view_distance = (1, 0, 0, 0), (0.25, 0.12, 0.0), 0.8
        region.view_perspective = "PERSP"

    def shot(self) -> Iterator[float]:
        """Leaves what the viewport shows in self.seen, (height, width) float, its inside without the header."""
        bpy.context.window_manager.windows[0].cursor_warp(2, 2)  # the pointer would be in the picture
        self.area.tag_redraw()
        yield 0.3
        region = next(region for region in self.area.regions if region.type == "WINDOW")
        screen = self.pixels().astype(float).mean(2)
        bottom = screen.shape[0] - region.y
        self.seen = screen[bottom - region.height + 100:bottom - 10, region.x + 60:region.x + region.width - 60]

    def show_overlays(self, on: bool) -> None:
        """The armature's bones in front of all, and the outline of the selected sleeve. Nothing of it otherwise."""
        for obj in bpy.data.objects:
            obj.select_set(on and obj == self.obj, view_layer=bpy.context.view_layer)
        bpy.data.objects["Arm"].show_in_front = True
        overlay = self.area.spaces.active.overlay
        overlay.show_bones = overlay.show_outline_selected = on

    def runtime(self) -> runtimes.Runtime:
        return runtimes.of(self.obj)

    def settled(self, uses_proxy: bool = True) -> Iterator[float]:
        """Waits until the viewport has the mesh that it should have."""
        self.area.tag_redraw()
        yield from self.until(lambda: self.runtime().inputs is not None
                              and self.runtime().inputs.for_preview == uses_proxy)
        self.assertEqual(self.runtime().inputs.for_preview, uses_proxy)
        yield 0.1

    def held(self) -> preview._OnGpu:
        (held,) = preview._on_gpu.values()
        return held

    def drawn_at(self, frame: int) -> Iterator[float]:
        """The scene there, and on the GPU."""
        sleeve.at(frame)
        self.area.tag_redraw()
        yield from self.until_drawn(frame)

    def until_drawn(self, frame: float) -> Iterator[float]:
        """Until the GPU holds what was solved last, of this frame."""
        yield from self.until(lambda: preview._on_gpu and self.held().inputs is not None
                              and self.held().inputs is runtimes.of(self.obj).inputs
                              and self.held().inputs.frame == frame)

    def watch(self, of: object, name: str, calls: list[int]) -> None:
        """Until the test ends every call of a function leaves a number in `calls`."""
        function = getattr(of, name)

        def called(*arguments: object, **named: object) -> object:
            calls.append(len(calls))
            return function(*arguments, **named)

        self.addCleanup(setattr, of, name, function)
        setattr(of, name, called)

    def engines_fullness(self, atol: float) -> np.ndarray:
        """(w,) of the waves that the GPU holds, which must be those of the engine. Of a Wrinkle Field."""
        fine, inputs = runtimes.of(self.obj).evaluator, runtimes.of(self.obj).inputs
        expected = native.estimate_waves_wrinkle_field(
            fine.model, fine._native_settings(inputs.settings), fine._paint,
            fine.solved_over(inputs.frame, inputs.positions), fine.wrinkles_of(inputs.frame)).fullness
        fullness = gpu_waves.estimated(self.held().drawing.waves)[1][:, 2]
        np.testing.assert_allclose(fullness**2, expected**2, atol=atol, err_msg=str(inputs.frame))
        return fullness

    def in_renders(self) -> FrameResult:
        """The frame that the GPU holds, as renders show it."""
        runtime, scene = runtimes.of(self.obj), bpy.context.scene
        inputs = runtime.inputs
        found = solve_frame(runtime.evaluator, inputs.frame, inputs.positions, inputs.settings, inputs.paint,
                            start=scene.frame_start, frame_rate=inputs.frame_rate,
                            world_from_object=inputs.world_from_object)
        assert isinstance(found, FrameResult)
        return found

    def opened_again(self, blend: str, fine: np.ndarray) -> Iterator[float]:
        """A saved file, first without the add-on, where it must show this fine mesh, then with it: self.obj."""
        handlers.unregister()
        try:
            with sleeve.context():
                bpy.ops.wm.open_mainfile(filepath=blend)
            yield 0.3
            np.testing.assert_array_equal(sleeve.shown(bpy.data.objects["Sleeve"]), fine)
        finally:
            handlers.register()
        with sleeve.context():
            bpy.ops.wm.open_mainfile(filepath=blend)
        self.obj = bpy.data.objects["Sleeve"]

    def refuse(self, drawer: ModuleType) -> list[int]:
        """Until the test ends a driver that compiles nothing of a gpu module. Counts how often it was asked."""
        tried: list[int] = []

        def refuse() -> None:
            tried.append(1)
            raise RuntimeError("a driver that does not like it")

        self.addCleanup(setattr, drawer, "_compile", drawer._compile)
        preview._clear()
        drawer._compile = refuse
        return tried

    def area_of_view(self) -> object:
        """A context override with self.area."""
        return sleeve.context(area=self.area, region=next(r for r in self.area.regions if r.type == "WINDOW"))


def showing_normals() -> SimpleNamespace:
    """A viewport's shading whose picture is the normal: three lights that wrap all round, along the axes, red, green
    and blue."""
    lights = [SimpleNamespace(use=True, direction=axis, diffuse_color=axis, specular_color=(0, 0, 0), smooth=1.0)
              for axis in np.eye(3).tolist()]
    return SimpleNamespace(light="STUDIO", color_type="SINGLE", single_color=(1.0, 1.0, 1.0),
                           show_specular_highlight=False, show_backface_culling=False, use_world_space_lighting=False,
                           selected_studio_light=SimpleNamespace(solid_lights=lights, light_ambient=(0.0, 0.0, 0.0)))


def smooth(picture: np.ndarray) -> np.ndarray:
    """The picture without what changes within a few pixels."""
    return sum(np.roll(picture, (i, j), (0, 1)) for i in range(-8, 9) for j in range(-8, 9)) / 17**2
