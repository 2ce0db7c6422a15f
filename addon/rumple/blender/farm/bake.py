# SPDX-License-Identifier: GPL-3.0-or-later
"""The bake of one garment by a worker: locked, and resumed where a former one was ended."""
from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

import bpy

from ...core import clip_file, clip_folder
from ...core.checkpoint import CannotGoOn, Checkpoint
from ...core.clip_lock import Held, Lock
from ...core.clip_manifest import ClipFault, Manifest
from ...core.clip_partial import PartialWriter
from ...core.frame_result import Attribute
from ..bake import clip
from ..bake.playback import BakeError
from ..frame import clip_status, path_curves
from ..objects import messages, modifier, runtimes
from . import plan, source

Say = Callable[[str], None]
CHECKPOINT = 20.0  # seconds of a bake between two states that are kept
_end_wanted = False


class Ended(Exception):
    """From outside: what is baked so far is kept."""


def end_soon() -> None:
    """For the handler of a signal. Behind the sample that is being solved: Blender ends the process on the spot where
    SystemExit leaves one of its own handlers."""
    global _end_wanted
    _end_wanted = True


def is_end_wanted() -> bool:
    """Whether a signal came."""
    return _end_wanted


@dataclass
class Options:
    """As the command line has them."""

    resume: bool = False
    oldest_lock: float = 600.0
    checkpoint: float = CHECKPOINT
    piece: tuple[int, int] | None = None  # number, of how many
    join: int = 0  # so many pieces
    pre_roll: int = 0  # frames in front of each piece
    tolerance: float = 0.0  # metres, where two pieces meet


class FarmBake(clip.ClipBake):
    """A ClipBake that another one can go on with."""

    behind_a_jump = False  # its frames are final only where they were played from the clip's first one

    def __init__(self, context: bpy.types.Context, obj: bpy.types.Object, digest: str, resume: bool,
                 checkpoint: float = CHECKPOINT) -> None:
        """checkpoint: seconds between two of them."""
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
        """bake() has it, before it looks at what is there."""

    def _make_writer(self, path: Path, manifest: Manifest, attributes: tuple[Attribute, ...]) -> PartialWriter:
        manifest.source = self._digest
        self.partial = PartialWriter(path, manifest, attributes, self._resume, source.made_by())
        self.resumed = self.partial.kept
        return self.partial

    def _usable(self) -> int:
        """How many of the samples that are kept a bake may go on behind: all of them where frames are independent, else
        those up to a state."""
        if self.curves.wanted:
            return 0
        if self.playback.is_independent:
            return self.partial.kept
        state = self.partial.checkpoint
        return state.sample + 1 if state is not None and self._has_states else 0

    def _pass_over(self, kept: int) -> None:
        """Go on behind the first samples, if the last of them is what is solved here and now."""
        about = self.partial.manifest
        last = about.checksums[kept - 1], about.poses[kept - 1]
        if not self.playback.is_independent and not self._take_state():
            return
        self.partial.pass_over(kept - 1)
        self.partial.add(*self.playback.solve_sample(kept - 1))
        if (about.checksums[kept - 1], about.poses[kept - 1]) != last:  # so none of them is trusted
            self.partial.cut(0)
            self.partial.pass_over(0)
            self.resumed = 0
            return
        self.passed = self.done = kept
        count = self.playback.sample_count
        self.playback.count = count
        self.samples = ((True, *self.playback.solve_sample(sample)) for sample in range(kept, count))

    # --- states
    def _take_state(self) -> bool:
        """Whether the frame of the state that is kept has the same pose here, and goes on from it now."""
        state = self.partial.checkpoint
        assert state is not None
        if self.playback.analyzes:
            for _ in self.playback.analyze():
                pass
        self.playback.solve_sample(state.sample)  # by a jump: that makes all that the state belongs to
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
        """The whole frame that it is, or is behind."""
        return float(self.playback.start + sample // self.playback.samples)

    def step(self) -> bool:
        more = super().step()
        if more and time.monotonic() - self._kept_at >= self._every:
            self._keep_state()
        return more

    def _keep_state(self) -> None:
        """What lives on behind the last whole frame, for a bake that resumes."""
        self._kept_at = time.monotonic()
        sample = self.partial.done - 1
        if not self._has_states or sample < 0:
            return
        evaluator = runtimes.of(self.obj).evaluator
        solved = None if evaluator is None else evaluator.frame_cache.get(self._frame(sample))
        if solved is not None and (solved.final or self.behind_a_jump):
            self.partial.save(Checkpoint.of(sample - sample % self.playback.samples, solved))

    def stop(self) -> None:
        """Ended from outside: what is baked so far is left for a bake that resumes. Never raises."""
        with messages.console_errors(self.name):
            self._keep_state()
        self.partial.keep()
        self.writer = None
        self.cancel()


# ---------------------------------------------------------------- clips that are there
def whole_clip(obj: bpy.types.Object, digest: str, any_frames: bool = False) -> Manifest | None:
    """The clip at an object's place, if it is whole and of the same: file, settings, frames. Else None."""
    about = obj.rumple
    return whole_at(clip.new_clip_path(obj), obj, digest,
                    None if any_frames else (about.bake_start, about.bake_end, about.bake_samples))


def whole_at(path: Path, obj: bpy.types.Object, digest: str, frames: tuple[int, int, int] | None) -> Manifest | None:
    """The clip at a path. frames: first, last, samples of each; None: any."""
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
    """Let an object play the clip at its place."""
    path = clip.new_clip_path(obj)
    if manifest.curves:
        curves = path_curves.clip_path(path)
        path_curves.play(obj, clip_file.read_manifest(curves), clip.stored_path(curves))
    clip.attach(obj, manifest, path)


def show_needed(obj: bpy.types.Object, files: str, all_frames: bool = True) -> list[str]:
    """Let what an object rests on play its clips, as where all are baked one after another. The names of those that
    have none, and are solved live. all_frames: they have to cover those that the object is baked for: BakeError."""
    live = []
    for name in _all_needed(obj):
        other = bpy.data.objects[name]
        manifest = whole_clip(other, source.of_garment(other, files), any_frames=True)
        plays, path = modifier.plays_clip(modifier.find(other)), clip.new_clip_path(other)
        if manifest is None:
            live.append(name)
        elif all_frames and (manifest.start > obj.rumple.bake_start or manifest.end < obj.rumple.bake_end):
            raise BakeError(f"it rests on {name}, whose clip has frames {manifest.start} to {manifest.end} only: bake "
                            "that one for all frames of this one")
        elif not plays or clip_status.clip_path(other) != path:
            show(other, manifest)
    return live


def _all_needed(obj: bpy.types.Object) -> list[str]:
    """What it rests on, each behind what that rests on."""
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
    """What became of one garment."""

    path: Path
    samples: int
    seconds: float
    bytes: int
    resumed: int = 0  # samples of an ended bake that were used
    passed: int = 0  # of these, not solved again
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
    """The clip of one garment. Raises BakeError, or ClipFault (Held: another worker has it)."""
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
    """To its end. started: by time.perf_counter()."""
    try:
        _step_through(running, lock, say)
        lock.check()
    except (BakeError, Held):  # Held: another worker has begun meanwhile
        running.cancel()
        raise
    except BaseException:  # ended from outside, or a disk that fails for a moment: what is baked so far is kept
        running.stop()
        raise
    try:
        path = running.finish()
    except BaseException:  # a bake that resumes has it to put in place only
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
