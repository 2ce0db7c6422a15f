# SPDX-License-Identifier: GPL-3.0-or-later
"""The same scene at another frame rate, or with another density of the garment's mesh, for scripts/bench."""
from __future__ import annotations

import bpy
import numpy as np
from bench_consistency import DENSITIES, RATES

NAMES = tuple(str(rate) for rate in RATES) + DENSITIES


def play_at(rate: int, frames: np.ndarray) -> np.ndarray:
    """The open scene at another rate, by Blender's time remapping: its motion takes as many seconds as before.
    Returns the first second of the frames (k,), numbered anew."""
    render = bpy.context.scene.render
    before = round(render.fps / render.fps_base)
    if (frames[0] * rate) % before:
        raise ValueError(f"no frame at {rate} a second is at the time of frame {frames[0]} at {before}")
    first = int(frames[0]) * rate // before
    render.fps, render.fps_base, render.frame_map_old, render.frame_map_new = rate, 1.0, before, rate
    return np.arange(first, first + min(rate, (int(frames[-1]) - int(frames[0])) * rate // before) + 1)


def remodel(garment: bpy.types.Object, density: str) -> None:
    """As if the garment had been modelled with half as many vertices, or with edges half as long."""
    if density == "half":
        change = garment.modifiers.new("Density", "DECIMATE")
        change.ratio = 0.5
    else:
        change = garment.modifiers.new("Density", "SUBSURF")
        change.levels, change.use_limit_surface = 1, False  # its smooth surface is that of the garment
    with bpy.context.temp_override(object=garment, active_object=garment):
        bpy.ops.object.modifier_move_to_index(modifier=change.name, index=0)
        bpy.ops.object.modifier_apply(modifier=change.name)


def change(name: str, garment: bpy.types.Object, frames: np.ndarray) -> np.ndarray:
    """One of NAMES: changes the open scene. Returns the frames (k,) to play."""
    if name in DENSITIES:
        remodel(garment, name)
        return frames[:round(bpy.context.scene.render.fps) + 1]
    return play_at(int(name), frames)
