# SPDX-License-Identifier: GPL-3.0-or-later
"""FrameRequest, the arguments of a frame, and FrameInput, the part that it is solved from. Never imports bpy.

What a frame depends on is said in these places, and a new input may belong into each of them:
- FrameRequest, and Inputs with what Blender shows (blender/objects/runtimes.py): without a change nothing is solved;
- FrameInput.digest(), of a frame in the frame cache, with the digests of settings and paint (base/digests.py);
- Wrinkles._take_inputs() (engine.py): first frame and frame rate, whose frames are kept apart;
- KeptFrames.identity (files/kept_frames.py), of frames on disk: version and model;
- inputs_fingerprint() (blender/frame/clip_status.py), of a baked clip, and evaluator.sources(), of a model.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.digests import digest_of
from ..cloth.base_cloth import ClothFrame
from ..cloth.surroundings import Surroundings
from ..mesh.body import Body
from ..settings.system_settings import SystemSettings


@dataclass(frozen=True, eq=False)
class FrameRequest:
    """The request for a frame. n: vertices of the base."""

    frame: float
    positions: np.ndarray  # (n, 3) float32, deformed base, object space
    settings: SystemSettings
    paint: dict[str, np.ndarray]  # values per vertex of the artist's mesh, by name
    start: int  # first frame of the clip; it needs no frame before it
    world_from_object: np.ndarray | None = None  # (3, 3)
    frame_rate: float = 24.0  # frames a second
    for_preview: bool = False  # a PreviewFrame is enough
    body: Body | None = None  # the cloth stays outside of it
    surroundings: Surroundings = Surroundings()  # wind and force fields for swinging cloth
    in_viewport: bool = False  # the result is for the mesh of viewports, if there is one


@dataclass(frozen=True)
class FrameInput:
    """The time and place at which a frame is solved: the parts of a request that the solve reads."""

    frame: float
    seconds: float
    world_from_object: np.ndarray | None  # (3, 3) float32, where the system reads it
    animated: np.ndarray  # (n, 3) positions that the shown mesh is embedded in
    labels: np.ndarray | None = None  # (t,) uint8, computed for the whole clip: see Wrinkles.analyze_clip()
    body: Body | None = None  # what cloth stays outside of
    cloth: ClothFrame | None = None  # the base cloth that a system is solved over; None: over the animated mesh
    surroundings: Surroundings = Surroundings()  # if the system reads them
    in_viewport: bool = False  # the result is for Wrinkles.in_viewport

    def digest(self, settings_digest: bytes, swings: bool) -> bytes:
        """A digest of this input. swings: the cloth swings, so the surroundings count."""
        return digest_of(settings_digest, self.animated, self.world_from_object, self.labels,
                         *(self.body.arrays() if self.body else ()),
                         *([self.surroundings.array()] if swings else ()))
