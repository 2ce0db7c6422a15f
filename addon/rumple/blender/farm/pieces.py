# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes clips in pieces, each with its own lock and checkpoints, and joins them."""
from __future__ import annotations

import hashlib
import time
from pathlib import Path

import bpy

from ...core.files import clip_file, clip_pieces
from ...core.files.clip_lock import Lock
from ...core.files.clip_manifest import ClipFault, Manifest
from ...core.files.clip_pieces import Piece, PieceWriter
from ...core.mesh.frame_result import Attribute
from ..bake import clip
from ..bake.playback import BakeError, Playback
from ..frame import clip_status, path_curves
from ..objects import modifier, properties, units
from . import bake, source
from .bake import Baked, Options, Say


def kind(obj: bpy.types.Object) -> str:
    """How a clip may be cut, if the objects under the garment have clips: "independent", "pre-roll", or empty: not."""
    if clip_status.is_simulated_in_front(obj) or path_curves.of(obj):
        return ""
    if properties.settings_of(obj, bpy.context.scene).stateless:
        return "independent"
    return "" if any(a.angle for a in _attributes(obj)) else "pre-roll"


def _attributes(obj: bpy.types.Object) -> tuple[Attribute, ...]:
    return modifier.system(modifier.find(obj)).wrinkles.ATTRIBUTES


def pre_roll_of(obj: bpy.types.Object, asked: int) -> int:
    """Number of frames that are solved before each piece; 0 if frames are independent. Raises BakeError."""
    name = obj.name
    if path_curves.of(obj):
        raise BakeError(f"{name}: its curves are baked beside it: bake it whole, not in pieces")
    if not clip_status.stands_alone(obj):
        raise BakeError(f"{name}: more lives from frame to frame than its own wrinkles (cloth, soft body or simulation "
                        "nodes above them, or something wrinkled under it without a clip): bake it whole, not "
                        "in pieces")
    if clip_status.is_independent(obj, bpy.context.scene):
        return 0
    if not asked:
        raise BakeError(f"{name}: its frames go on from one another: bake it whole, or give --pre-roll FRAMES and "
                        "--tolerance METRES")
    if any(a.angle for a in _attributes(obj)):
        raise BakeError(f"{name}: its waves cannot be compared in metres: bake it whole, or switch Independent Frames "
                        "on")
    return asked


def keep_to(playback: Playback, start: int, first: int, last: int, pre_roll: int) -> None:
    """Make a playback solve one piece of a clip that begins at `start`. Frames before the first frame of the whole
    clip's playback are never solved."""
    begin = min(units.first_frame(playback.obj, playback.scene), start)
    played = first == start and pre_roll > 0
    playback.keep_to(first, last, range(begin if played else max(first - pre_roll, begin), first))


def _digest(piece: Piece, pre_roll: int, digest: str) -> str:
    """Digest of the inputs of a piece. It includes the versions of Blender and Rumple, so only pieces of the same
    versions are joined."""
    return hashlib.blake2b(repr((digest, source.made_by(), piece, pre_roll)).encode(), digest_size=16).hexdigest()


class PieceBake(bake.FarmBake):
    """The bake of one piece, which is not shown."""

    WRITER = PieceWriter

    def __init__(self, context: bpy.types.Context, obj: bpy.types.Object, piece: Piece, pre_roll: int, digest: str,
                 options: Options) -> None:
        self.piece, self._pre_roll = piece, pre_roll
        self.behind_a_jump = pre_roll > 0
        super().__init__(context, obj, _digest(piece, pre_roll, digest), options.resume, options.checkpoint)

    def _place(self, obj: bpy.types.Object) -> Path:
        return self.piece.path(clip.new_clip_path(obj))

    def _make_playback(self, context: bpy.types.Context) -> Playback:
        playback = super()._make_playback(context)
        keep_to(playback, self.piece.start, self.piece.first, self.piece.last, self._pre_roll)
        return playback

    def finish(self) -> Path:
        with self._faults():
            self.partial.seal()
            self.partial.commit()
        self.note = self.playback.note()
        self.playback.end_playback(restore_bake=True)
        return self.partial.clip


def _cut(obj: bpy.types.Object, count: int) -> list[Piece]:
    try:
        return clip_pieces.pieces_of(*units.bake_range(obj, bpy.context.scene), count)
    except ClipFault as error:
        raise BakeError(f"{obj.name}: {error}") from error


def _frames(obj: bpy.types.Object, piece: Piece) -> tuple[int, int, int]:
    return piece.first, piece.last, obj.rumple.bake_samples


def _whole(obj: bpy.types.Object, digest: str, cut: list[Piece], pre_roll: int) -> Baked | None:
    """The clip, if it already exists and was baked in one piece or of the same pieces."""
    manifest, path = bake.whole_clip(obj, digest), clip.new_clip_path(obj)
    if manifest is None or (manifest.seams and (manifest.pre_roll, manifest.seams) != (
            pre_roll, [piece.first for piece in cut[1:]])):
        return None
    return Baked(path, manifest.sample_count, 0.0, path.stat().st_size, was_whole=True,
                 checksum=clip_file.checksum(manifest))


def bake_piece(context: bpy.types.Context, obj: bpy.types.Object, files: str, options: Options, say: Say) -> Baked:
    """Bake one piece. Raises BakeError, or ClipFault (Held: another worker has it)."""
    assert options.piece is not None
    pre_roll, started = pre_roll_of(obj, options.pre_roll), time.perf_counter()
    number, count = options.piece
    cut = _cut(obj, count)
    piece, digest = cut[number - 1], source.of_garment(obj, files)
    path = piece.path(clip.new_clip_path(obj))
    lock = Lock(path, options.oldest_lock)
    try:
        if options.resume:
            done = _whole(obj, digest, cut, pre_roll)
            if done is not None:
                return done
            there = bake.whole_at(path, obj, _digest(piece, pre_roll, digest), _frames(obj, piece))
            if there is not None:
                return Baked(path, there.sample_count, 0.0, path.stat().st_size, was_whole=True,
                             checksum=clip_file.checksum(there))
        return bake.run(PieceBake(context, obj, piece, pre_roll, digest, options), lock, say, started)
    finally:
        lock.release()


# ---------------------------------------------------------------- joining
def join(obj: bpy.types.Object, files: str, options: Options, say: Say) -> Baked:
    """Join the pieces into the clip, and remove them. Raises BakeError, or ClipFault (Held: another worker has it)."""
    pre_roll, path, started = pre_roll_of(obj, options.pre_roll), clip.new_clip_path(obj), time.perf_counter()
    cut = _cut(obj, options.join)
    lock = Lock(path, options.oldest_lock)
    try:
        digest = source.of_garment(obj, files)
        done = _whole(obj, digest, cut, pre_roll) if options.resume else None
        if done is None:
            pieces = [_there(obj, piece, path, _digest(piece, pre_roll, digest)) for piece in cut]
            _compare(obj, pieces, pre_roll, options.tolerance, say)
            lock.check()
            manifest = clip_pieces.join(path, pieces, _attributes(obj), digest, pre_roll)
            done = Baked(path, manifest.sample_count, time.perf_counter() - started, path.stat().st_size,
                         note=f", joined of {len(cut)} pieces", checksum=clip_file.checksum(manifest))
            done.passed = done.samples
        shown = clip_file.read_manifest(path)
        assert shown is not None
        bake.show(obj, shown)
        clip_pieces.remove(path)
        return done
    finally:
        lock.release()


def _there(obj: bpy.types.Object, piece: Piece, path: Path, digest: str) -> tuple[Path, Manifest]:
    file = piece.path(path)
    manifest = bake.whole_at(file, obj, digest, _frames(obj, piece))
    if manifest is None:
        raise BakeError(f"{obj.name}: there is no whole piece {piece.number} of {piece.count} of this file, by this "
                        f"Blender and Rumple: bake --piece {piece.number}/{piece.count}")
    return file, manifest


def _compare(obj: bpy.types.Object, pieces: list[tuple[Path, Manifest]], pre_roll: int, tolerance: float,
             say: Say) -> None:
    """Compare the common frames of neighbouring pieces. Raises BakeError."""
    found = clip_pieces.seams(pieces)
    metres = units.most_metres_per_unit(obj, bpy.context.scene)
    for seam in found:
        apart = metres * seam.farthest
        if not pre_roll and not seam.same:
            raise BakeError(f"{obj.name}: frame {seam.frame} is another one in piece {seam.number} than in the one "
                            f"before it, by {1e3 * apart:.3g} mm: bake both again, by the same Blender and library")
        if pre_roll and not apart <= tolerance:
            raise BakeError(f"{obj.name}: at frame {seam.frame} piece {seam.number} is {1e3 * apart:.3g} mm from the "
                            f"one before it, more than the tolerance of {1e3 * tolerance:.3g} mm: give more frames of "
                            f"pre-roll than {pre_roll}, or bake it whole")
    if pre_roll and found:
        worst = max(found, key=lambda seam: seam.farthest)
        say(f"{obj.name}: its pieces are at most {1e3 * metres * worst.farthest:.3g} mm apart, at frame "
            f"{worst.frame}, behind {pre_roll} frames of pre-roll")
