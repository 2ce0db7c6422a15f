# SPDX-License-Identifier: GPL-3.0-or-later
"""Verifies a clip: solves samples again and compares them, bit for bit."""
from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import Iterator

import bpy
import numpy as np

from ...core.files import clip_file, clip_partial
from ...core.files.clip_manifest import Manifest
from ...core.mesh.frame_result import FrameResult
from ..bake import clip
from ..bake.playback import BakeError, Playback
from ..objects import modifier
from . import pieces


@dataclass
class Verified:
    """The result of a verification. frame: the first one that differs; None: all are equal."""

    compared: int
    frame: float | None = None
    farthest: float = 0.0  # largest distance of points in this frame, object units
    damaged: bool = False  # the clip's data does not have its checksum

    def in_words(self, name: str) -> str:
        if self.frame is None:
            return f"{name}: {self.compared} samples were solved again, all bits are those of the clip"
        if self.damaged:
            return f"{name}: frame {self.frame:g} of the clip is damaged"
        return (f"{name}: frame {self.frame:g} is the first that differs from the clip, by at most {self.farthest:.3g} "
                "object units: it was baked from another file, or by another Blender or Rumple")


def verify(context: bpy.types.Context, obj: bpy.types.Object, most: int) -> Verified:
    """Verify the clip of an object. most: how many samples to compare, spread over the clip; 0: all. If frames depend
    on each other, they are still played from the first one. Raises BakeError and ClipFault."""
    path = clip.new_clip_path(obj)
    if not path.is_file():
        raise BakeError(f"{obj.name}: there is no clip {path}: bake first")
    manifest = clip_file.read_manifest(path)
    if manifest is None or not manifest.checksums:
        raise BakeError(f"{obj.name}: {path.name} has no checksums: bake again")
    count = manifest.sample_count
    wanted = sorted(set(np.linspace(0, count - 1, min(most or count, count)).round().astype(int).tolist()))
    playback = Playback(context, obj, manifest.start, manifest.end, manifest.samples)
    if manifest.seams and playback.is_independent:
        playback.end_playback(restore_bake=True)
        raise BakeError(f"{obj.name}: the clip was made with a pre-roll, its frames are independent now: bake again")
    try:
        return _compare(playback, obj, path, manifest, wanted)
    finally:
        playback.end_playback(restore_bake=True)


def _compare(playback: Playback, obj: bpy.types.Object, path: clip.Path, manifest: Manifest,
             wanted: list[int]) -> Verified:
    attributes = modifier.system(modifier.find(obj)).wrinkles.ATTRIBUTES
    compared = 0
    for sample, result in _solved(playback, manifest, wanted):
        baked = clip_partial.points_in(path, manifest, sample)
        frame = sum(manifest.sample_frame(sample))
        if zlib.crc32(baked.tobytes()) != manifest.checksums[sample]:
            return Verified(compared, frame, damaged=True)
        before = clip_partial.points_in(path, manifest, sample - 1) if sample else None
        points = clip_file.points_of(result, attributes, before)
        if points.shape != baked.shape:
            raise BakeError(f"{obj.name}: the clip has another number of points than the fine mesh now: bake again")
        if points.astype("<f4").tobytes() != baked.tobytes():
            return Verified(compared, frame, float(np.abs(points - baked).max()))
        compared += 1
    return Verified(compared)


def _solved(playback: Playback, manifest: Manifest, wanted: list[int]) -> Iterator[tuple[int, FrameResult]]:
    if playback.is_independent:
        for sample in wanted:
            yield sample, playback.solve_sample(sample)[0]
        return
    bounds = [manifest.start, *manifest.seams, manifest.end]
    for first, last in zip(bounds, bounds[1:] if manifest.seams else bounds[-1:]):
        number = (first - manifest.start) * manifest.samples - 1
        end = number + (last - first) * manifest.samples + (last == manifest.end)
        if manifest.seams:  # play each piece as it was baked
            pieces.keep_to(playback, manifest.start, first, last, manifest.pre_roll)
        if not any(number < sample <= end for sample in wanted):
            continue
        for is_sample, result, _coarse in playback.samples_in_order():
            number += is_sample
            if is_sample and number <= end and number in wanted:
                yield number, result
            if number >= min(wanted[-1], end):
                break
