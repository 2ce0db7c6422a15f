# SPDX-License-Identifier: GPL-3.0-or-later
"""Solves a garment in many poses of its rig, for machine learning. core/files/pose_set.py writes the files.

The open file is changed and must not be saved: the animation of its rig is removed, and every pose is solved
independently.
"""
from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable

import bpy
import numpy as np

from ...core.files import pose_set
from ...core.files.clip_lock import Held, Lock
from ...core.files.clip_manifest import ClipFault
from ...core.files.pose_set import PoseSet
from .. import compat
from ..bake.playback import BakeError, Playback
from ..frame import clip_status
from ..objects import bodies, incoming_mesh, modifier, properties, runtimes
from . import bake, rig_poses, shown, source

Say = Callable[[str], None]


@dataclass
class Options:
    """The options of the command line. frames: of the clip; None: those of the scene."""

    count: int
    seed: int = 0
    from_clip: bool = False
    widen: float = 1.0
    resume: bool = False
    frames: tuple[int, int] | None = None


@dataclass
class Done:
    """The result. held: number of blocks that other workers have."""

    poses: int
    seconds: float
    bytes: int
    there: int
    held: int = 0


class Solver:
    """Solves poses of one garment, in any order. Call close() at the end."""

    def __init__(self, context: bpy.types.Context, obj: bpy.types.Object, files: str, options: Options) -> None:
        """Prepare the garment. Raises BakeError."""
        self.context, self.obj, self.options = context, obj, options
        scene = context.scene
        self.first, self.last = options.frames or (scene.frame_start, scene.frame_end)
        properties.group_of(obj).stateless = True
        _refuse(obj, scene)
        digest = source.of_garment(obj, files)
        self.playback = Playback(context, obj, self.first, self.first, 1)
        try:
            self.playback.solve_sample(0)
            self.rigs = rig_poses.armatures(obj)
            if not self.rigs and not options.from_clip:
                raise BakeError(f"{obj.name}: no armature moves it: give --from-clip, or add a rig")
            evaluator = runtimes.of(obj).evaluator
            self.set = PoseSet(obj.name, digest, source.made_by(), options.seed, options.count,
                               "clip" if options.from_clip else "random", [self.first, self.last],
                               evaluator.coarse_count, evaluator.vertex_count, scene.unit_settings.scale_length,
                               self._ranges(), options.widen)
            if not options.from_clip:
                self._check_ranges()
                self.playback.solve_sample(0)
                rig_poses.let_go(self.rigs)
        except BaseException:
            self.close()
            raise

    def _ranges(self) -> list[pose_set.BoneRange]:
        wanted = range(self.first, self.first + 1 if self.options.from_clip else self.last + 1)
        with self.playback.unsolved():
            return rig_poses.ranges(self.rigs, wanted, lambda frame: self.playback.visit(frame), self.options.widen)

    def _check_ranges(self) -> None:
        if all(set(one.source) == {"none"} for one in self.set.ranges):
            raise BakeError(f"{self.obj.name}: no bone of its rig has limits, or moves in the frames {self.first}-"
                            f"{self.last}: set limits of rotations, or give frames that move")

    def solve(self, pose: int) -> dict[str, Any]:
        """The arrays of one pose. Raises BakeError."""
        if self.options.from_clip:
            at = self.first + float(pose_set.shares(self.set.seed, pose, 1)[0]) * (self.last - self.first)
            frame, part = divmod(at, 1.0)
            frame, part = int(frame), float(np.float32(part))
        else:
            frame, part = self.first, 0.0
            drawn = pose_set.shares(self.set.seed, pose, 3 * len(self.set.ranges)).reshape(-1, 3)
            rig_poses.put(self.rigs, self.set.ranges, drawn)
        try:
            result, coarse = self.playback.solve_at(frame, part)
        except BakeError as error:
            raise BakeError(f"{self.obj.name}: pose {pose} cannot be solved: {error}") from error
        depsgraph = self.context.evaluated_depsgraph_get()
        return dict(number=pose, frame=frame + part, pose=rig_poses.read(self.obj, self.rigs, depsgraph),
                    coarse=coarse, fine=result.positions)

    def mesh(self) -> dict[str, np.ndarray]:
        """The constant arrays: meshes and bones at rest."""
        coarse, evaluator = incoming_mesh.of(self.obj), runtimes.of(self.obj).evaluator
        return dict(coarse_rest=compat.positions(coarse), coarse_sizes=shown.face_sizes(coarse),
                    coarse_corners=compat.corner_vertices(coarse),
                    fine_rest=np.asarray(evaluator.positions_rest, np.float32),
                    fine_sizes=np.diff(evaluator.polygon_start).astype(np.int32),
                    fine_corners=np.asarray(evaluator.corner_vertex, np.int32), bone_rest=rig_poses.at_rest(self.rigs),
                    bone_parent=rig_poses.parents(self.rigs))

    def close(self) -> None:
        self.playback.end_playback(restore_bake=False)


def _refuse(obj: bpy.types.Object, scene: bpy.types.Scene) -> None:
    """Raise BakeError for garments that are not solved, or that depend on more than the pose."""
    if not modifier.find(obj).show_viewport:
        raise BakeError(f"{obj.name}: its modifier {modifier.find(obj).name} is off in the viewport, so nothing is "
                        "solved: switch it on")
    over = [other.name for other in (*bodies.of(obj), modifier.depends_on_wrinkled(obj))
            if other is not None and modifier.find(other) is not None]
    if over:
        raise BakeError(f"{obj.name}: it rests on {over[0]}, which is wrinkled itself: a pose alone does not say where "
                        "that one is. Take its body instead")
    if not clip_status.is_independent(obj, scene):
        raise BakeError(f"{obj.name}: a simulation above the wrinkles needs the frames before, and poses have "
                        "none: switch it off, or apply it")


# ---------------------------------------------------------------- all of them
def make(solver: Solver, folder: Path, say: Say) -> Done:
    """Make every missing block that no other worker has. Raises BakeError, ClipFault and bake.Ended."""
    wanted, started = solver.set, time.perf_counter()
    pose_set.begin(folder, wanted, solver.mesh(), solver.options.resume)
    done = Done(0, 0.0, 0, 0)
    for block in range(wanted.blocks):
        path = folder / wanted.block_name(block)
        if path.exists() and pose_set.read_block(folder, wanted, block) is not None:
            continue
        try:
            lock = Lock(path)
        except Held:
            done.held += 1
            continue
        try:
            # else another worker made it before we got the lock
            if not path.exists() or pose_set.read_block(folder, wanted, block) is None:
                arrays = _block(solver, block, lock)
                lock.check()
                pose_set.write_arrays(path, arrays)
                done.poses += len(arrays["number"])
                done.seconds = time.perf_counter() - started
                say(f"{solver.obj.name}: {wanted.poses_of(block)[-1] + 1} of {wanted.count} poses, "
                    f"{1e3 * done.seconds / done.poses:.0f} ms a pose")
        except Held:
            done.held += 1
        finally:
            lock.release()
    files = [folder / wanted.block_name(block) for block in range(wanted.blocks)]
    done.there = sum(file.exists() for file in files)
    done.bytes = sum(file.stat().st_size for file in files if file.exists())
    return done


def _block(solver: Solver, block: int, lock: Lock) -> dict[str, np.ndarray]:
    poses = solver.set.poses_of(block)
    arrays: dict[str, np.ndarray] = pose_set.empty_block(solver.set, len(poses))
    for row, pose in enumerate(poses):
        if bake.is_end_wanted():
            raise bake.Ended
        lock.touch()
        for name, value in solver.solve(pose).items():
            arrays[name][row] = value
    return arrays


def first_different(solver: Solver, folder: Path, most: int) -> tuple[int, int | None]:
    """(number of compared poses, the first pose that differs). most: how many to compare, spread over the set; 0: all.
    Raises BakeError and ClipFault."""
    wanted = solver.set
    count = min(most or wanted.count, wanted.count)
    compared, block, arrays = 0, -1, None
    for pose in sorted(set(np.linspace(0, wanted.count - 1, count).round().astype(int).tolist())):
        if pose // pose_set.BLOCK != block:
            block = pose // pose_set.BLOCK
            arrays = pose_set.read_block(folder, wanted, block)
        if arrays is None:
            raise ClipFault(f"{wanted.block_name(block)} is missing or damaged: give --resume")
        row = pose % pose_set.BLOCK
        solved = pose_set.empty_block(wanted, 1)
        for name, value in solver.solve(pose).items():
            solved[name][0] = value
        if any(solved[name][0].tobytes() != arrays[name][row].tobytes() for name in arrays):
            return compared, pose
        compared += 1
    return compared, None
