# SPDX-License-Identifier: GPL-3.0-or-later
"""The bake of one garment by a worker, with a lock. It can resume an interrupted bake."""
from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

import bpy

from ...core.files import clip_file, clip_folder
from ...core.files.checkpoint import CannotGoOn, Checkpoint
from ...core.files.clip_lock import Held, Lock
from ...core.files.clip_manifest import ClipFault, Manifest
from ...core.files.clip_partial import PartialWriter
from ...core.mesh.frame_result import Attribute
from ..bake import clip
from ..bake.playback import BakeError
from ..frame import clip_status, path_curves
from ..objects import messages, modifier, runtimes, units
from . import plan, source

Say = Callable[[str], None]
CHECKPOINT = 20.0  # seconds between two checkpoints
_end_wanted = False


class Ended(Exception):
    """Raised if the bake is stopped from outside. Its samples so far are kept."""


def end_soon() -> None:
    """Stop after the current sample; for a signal handler. It does not raise SystemExit, because Blender ends the
    process immediately if SystemExit leaves one of Blender's handlers."""
    global _end_wanted
    _end_wanted = True


def is_end_wanted() -> bool:
    """Whether a signal has asked to stop."""
    return _end_wanted


@dataclass
class Options:
    """The options of the command line."""

    resume: bool = False
    oldest_lock: float = 600.0
    checkpoint: float = CHECKPOINT
    piece: tuple[int, int] | None = None  # number of the piece, number of pieces
    join: int = 0  # number of pieces to join
    pre_roll: int = 0  # frames before each piece
    tolerance: float = 0.0  # metres, largest difference where two pieces meet


class FarmBake(clip.ClipBake):
    """A ClipBake that can be resumed."""

    behind_a_jump = False  # frames are only final if they were played from the clip's first frame
    WRITER = PartialWriter

    def __init__(self, context: bpy.types.Context, obj: bpy.types.Object, digest: str, resume: bool,
                 checkpoint: float = CHECKPOINT) -> None:
        """checkpoint: seconds between two checkpoints."""
        self._digest, self._resume, self._every = digest, resume, checkpoint
        self.passed = 0  # samples that are not solved again
        super().__init__(context, obj)
        self._kept_at = time.monotonic()
        self._has_states = (not self.playback.is_independent and not self.curves.wanted
                            and clip_status.stands_alone(obj))
        try:
            with self._faults():
                kept = self._usable()
                if kept > 1:
                    self._pass_over(kept)
        except BakeError:
            self.cancel()
            raise

    def _take_lock(self, path: Path) -> None:
        """Nothing: bake() has taken the lock before it looks for existing clips."""

    def _make_writer(self, path: Path, manifest: Manifest, attributes: tuple[Attribute, ...]) -> PartialWriter:
        manifest.source = self._digest
        self.partial = self.WRITER(path, manifest, attributes, self._resume, source.made_by())
        self.resumed = self.partial.kept
        return self.partial

    def _usable(self) -> int:
        """How many kept samples a bake may continue after: all if frames are independent, otherwise those up to a
        checkpoint."""
        if self.curves.wanted:
            return 0
        if self.playback.is_independent:
            return self.partial.kept
        state = self.partial.checkpoint
        return state.sample + 1 if state is not None and self._has_states else 0

    def _pass_over(self, kept: int) -> None:
        """Continue after the first `kept` samples, if the last of them is equal when it is solved again here."""
        about = self.partial.manifest
        last = about.checksums[kept - 1], about.poses[kept - 1]
        if not self.playback.is_independent and not self._take_state():
            return
        self.partial.pass_over(kept - 1)
        self.partial.add(*self.playback.solve_sample(kept - 1))
        if (about.checksums[kept - 1], about.poses[kept - 1]) != last:  # then none of them is used
            self.partial.cut(0)
            self.partial.pass_over(0)
            self.resumed = 0
            return
        self.passed = self.done = kept
        count = self.playback.sample_count
        self.playback.count = count
        self.samples = ((True, *self.playback.solve_sample(sample)) for sample in range(kept, count))

    # --- checkpoints
    def _take_state(self) -> bool:
        """Continue from the kept checkpoint. Returns False if its frame has another pose here."""
        state = self.partial.checkpoint
        assert state is not None
        if self.playback.analyzes:
            for _ in self.playback.analyze():
                pass
        self.playback.solve_sample(state.sample)  # a jump to its frame builds everything that the state needs
        runtime, frame = runtimes.of(self.obj), self._frame(state.sample)
        solved = runtime.evaluator.frame_cache.get(frame)
        try:
            if solved is None or solved.input_digest != state.input_digest:
                return False
            restored = state.restored(runtime.evaluator)
        except CannotGoOn:
            return False
        runtime.evaluator.frame_cache.clear()
        runtime.evaluator.frame_cache.put(frame, restored)
        runtime.invalidate_output()
        return True

    def _frame(self, sample: int) -> float:
        """The whole frame of a sample, or the one before it."""
        return float(self.playback.start + sample // self.playback.samples)

    def step(self) -> bool:
        more = super().step()
        if more and time.monotonic() - self._kept_at >= self._every:
            self._keep_state()
        return more

    def _keep_state(self) -> None:
        """Write a checkpoint after the last whole frame."""
        self._kept_at = time.monotonic()
        sample = self.partial.done - 1
        if not self._has_states or sample < 0:
            return
        evaluator = runtimes.of(self.obj).evaluator
        solved = None if evaluator is None else evaluator.frame_cache.get(self._frame(sample))
        if solved is not None and (solved.final or self.behind_a_jump):
            self.partial.save(Checkpoint.of(sample - sample % self.playback.samples, solved))

    def stop(self) -> None:
        """Stop from outside, and keep the samples for a later bake. Never raises."""
        with messages.console_errors(self.name):
            self._keep_state()
        self.partial.keep()
        self.writer = None
        self.cancel()


# ---------------------------------------------------------------- existing clips
def whole_clip(obj: bpy.types.Object, digest: str, any_frames: bool = False) -> Manifest | None:
    """The clip at an object's place, if it is complete and has the same file, settings and frames. Otherwise None."""
    frames = *units.bake_range(obj, bpy.context.scene), obj.rumple.bake_samples
    return whole_at(clip.new_clip_path(obj), obj, digest, None if any_frames else frames)


def whole_at(path: Path, obj: bpy.types.Object, digest: str, frames: tuple[int, int, int] | None) -> Manifest | None:
    """The clip at a path, if it is complete. frames: first, last, samples per frame; None: any."""
    try:
        manifest = clip_file.read_manifest(path) if path.is_file() else None
        if manifest is None or manifest.source != digest or manifest.object != obj.name or not manifest.checksums:
            return None
        if frames not in (None, (manifest.start, manifest.end, manifest.samples)):
            return None
        if not all(clip_file.sample_is_whole(path, manifest, sample) for sample in range(manifest.sample_count)):
            return None
        if manifest.curves:
            curves = clip_file.read_manifest(path_curves.clip_path(path))
            if curves is None or clip_file.checksum(curves) != manifest.curves:
                return None
    except (ClipFault, OSError):
        return None
    return manifest if clip_status.is_baked_from(manifest.inputs, obj, bpy.context.scene) else None


def show(obj: bpy.types.Object, manifest: Manifest) -> None:
    """Make an object play the clip at its place."""
    path = clip.new_clip_path(obj)
    if manifest.curves:
        curves = path_curves.clip_path(path)
        path_curves.play(obj, clip_file.read_manifest(curves), clip.stored_path(curves))
    clip.attach(obj, manifest, path)


def show_needed(obj: bpy.types.Object, files: str, all_frames: bool = True) -> list[str]:
    """Make the objects under a garment play their clips, as in a bake of all objects. Returns the names of those
    without a clip, which are solved live. all_frames: raise BakeError if a clip does not cover the frames of the
    bake."""
    live = []
    start, end = units.bake_range(obj, bpy.context.scene)
    for name in _all_needed(obj):
        other = bpy.data.objects[name]
        manifest = whole_clip(other, source.of_garment(other, files), any_frames=True)
        plays, path = modifier.plays_clip(modifier.find(other)), clip.new_clip_path(other)
        if manifest is None:
            live.append(name)
        elif all_frames and (manifest.start > start or manifest.end < end):
            raise BakeError(f"it rests on {name}, whose clip has frames {manifest.start} to {manifest.end} only: bake "
                            "that one for all frames of this one")
        elif not plays or clip_status.clip_path(other) != path:
            show(other, manifest)
    return live


def _all_needed(obj: bpy.types.Object) -> list[str]:
    """The objects that it depends on, each after the objects that it depends on itself."""
    todo, found = plan.needs(obj), set()
    while todo:
        name = todo.pop()
        if name not in found:
            found.add(name)
            todo += plan.needs(bpy.data.objects[name])
    return [other.name for other in plan.garments(bpy.context.scene) if other.name in found and other != obj]


# ---------------------------------------------------------------- one garment
@dataclass
class Baked:
    """The result of the bake of one garment."""

    path: Path
    samples: int
    seconds: float
    bytes: int
    resumed: int = 0  # used samples of an interrupted bake
    passed: int = 0  # those that were not solved again
    was_whole: bool = False
    note: str = ""
    checksum: int = 0

    def in_words(self, name: str) -> str:
        if self.was_whole:
            return f"{name}: is whole already: {self.path}"
        solved = max(self.samples - self.passed, 1)
        resumed = f", {self.resumed} resumed" if self.resumed else ""
        return (f"{name}: {self.samples} samples{resumed} in {self.seconds:.1f} s, {1e3 * self.seconds / solved:.1f} "
                f"ms a sample, {clip_folder.megabytes(self.bytes)} MB: {self.path}{self.note}")


def bake(context: bpy.types.Context, obj: bpy.types.Object, files: str, options: Options, say: Say) -> Baked:
    """Bake the clip of one garment. Raises BakeError, or ClipFault (Held: another worker has it)."""
    path, started = clip.new_clip_path(obj), time.perf_counter()
    lock = Lock(path, options.oldest_lock)
    try:
        digest = source.of_garment(obj, files)
        manifest = whole_clip(obj, digest) if options.resume else None
        if manifest is not None and not manifest.seams:
            show(obj, manifest)
            return Baked(path, manifest.sample_count, 0.0, path.stat().st_size, was_whole=True,
                         checksum=clip_file.checksum(manifest))
        return run(FarmBake(context, obj, digest, options.resume, options.checkpoint), lock, say, started)
    finally:
        lock.release()


def run(running: FarmBake, lock: Lock, say: Say, started: float) -> Baked:
    """Run a bake to its end. started: time.perf_counter() at the start."""
    try:
        _step_through(running, lock, say)
        lock.check()
    except (BakeError, Held):  # Held: another worker has taken over
        running.cancel()
        raise
    except BaseException:  # stopped from outside, or a temporary error of the disk: the samples are kept
        running.stop()
        raise
    try:
        path = running.finish()
    except BaseException:  # a later bake only needs to move it to its place
        running.stop()
        raise
    about = running.partial.manifest
    return Baked(path, about.sample_count, time.perf_counter() - started, path.stat().st_size, running.resumed,
                 running.passed, note=running.note, checksum=clip_file.checksum(about))


def _step_through(running: FarmBake, lock: Lock, say: Say) -> None:
    name, count, said = running.name, running.playback.count, time.perf_counter()
    if running.resumed:
        again = running.resumed - running.passed
        say(f"{name}: goes on with {running.resumed} samples of a bake that was ended"
            + (f"; {again} are solved again: each frame goes on from the one before it" if again else ""))
    while running.step():
        lock.touch()
        if _end_wanted:
            raise Ended
        if time.perf_counter() - said > 1.0 or running.done == count:
            said = time.perf_counter()
            say(f"{name}: {running.done} of {count} frames, {100 * running.done // count} %")
