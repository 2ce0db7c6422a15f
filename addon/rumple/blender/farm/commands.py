# SPDX-License-Identifier: GPL-3.0-or-later
"""The work of the commands on an open file. If one garment fails, the error is reported and the others continue."""
from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable

import bpy

from ...core.files import attached_files, pose_set
from ...core.files.clip_folder import in_words, megabytes
from ...core.files.clip_lock import Held
from ...core.files.clip_manifest import ClipFault, Manifest
from ..bake import clip
from ..bake.playback import BakeError
from ..objects import clip_place, modifier, units
from . import bake, check, pieces, plan, poses, shown, source, verify
from .shown import Exported

Say = Callable[[str], None]
DONE, FAILED, USAGE, NOTHING, DIFFERS = 0, 1, 2, 3, 4
HELD = 75  # EX_TEMPFAIL: another worker has it, try again later
ENDED = 143  # exit code of shells for SIGTERM


class Refused(Exception):
    """Raised if a command cannot do anything. code: exit code of the process."""

    def __init__(self, text: str, code: int = USAGE) -> None:
        super().__init__(text)
        self.code = code


@dataclass
class Outcome:
    """The result of a command. code: exit code of the process. data: the result for programs."""

    code: int
    data: dict[str, Any]


# ---------------------------------------------------------------- the file
def open_file(file: Path, run_scripts: bool) -> None:
    """Open a blend file. Raises Refused."""
    if not file.is_file():
        raise Refused(f"there is no file {file}")
    try:
        bpy.ops.wm.open_mainfile(filepath=str(file.absolute()), load_ui=False, use_scripts=run_scripts)
    except RuntimeError as error:
        raise Refused(f"{file} cannot be opened: {str(error).strip()}") from error


def choose(scene: bpy.types.Scene, names: list[str]) -> list[bpy.types.Object]:
    """The garments with these names, or all, in the order of the bake. Raises Refused."""
    found = plan.garments(scene)
    there = ", ".join(sorted(obj.name for obj in found)) or "none"
    for name in names:
        if name not in [obj.name for obj in found]:
            why = "is linked: it is baked in its own file, or as a library override" if _is_linked(name) else \
                "is no wrinkled object of this scene"
            raise Refused(f"{name!r} {why}; there is: {there}")
    if not found:
        raise Refused(f"{Path(bpy.data.filepath).name} has no wrinkled objects that can be baked: there is nothing to "
                      "do", NOTHING)
    return [obj for obj in found if not names or obj.name in names]


def _is_linked(name: str) -> bool:
    return any(obj.name == name and obj.library is not None for obj, _ in modifier.wrinkled_objects())


# ---------------------------------------------------------------- bake
def bake_all(garments: list[bpy.types.Object], options: bake.Options, say: Say, complain: Say) -> Outcome:
    """Bake garments one after another, each after the objects that it depends on."""
    files, started = source.of_files(), time.perf_counter()
    results: dict[str, dict[str, Any]] = {}
    if check.scripts_not_run():
        complain(check.scripts_not_run())
    for obj in garments:
        name = obj.name
        failed = [other for other in plan.needs(obj) if results.get(other, {}).get("code", DONE)]
        if failed:
            code = results[failed[0]]["code"]
            results[name] = dict(code=code, error=f"it rests on {failed[0]}, which was not baked")
        else:
            results[name] = _bake_one(obj, files, options, say)
        if results[name]["code"]:
            failed_or_not = "FAILED" if results[name]["code"] == FAILED else "not baked"
            complain(f"{name} {failed_or_not}: {results[name]['error']}")
        if results[name]["code"] == ENDED:
            break
    codes = [result["code"] for result in results.values()]
    code = next((code for code in (ENDED, FAILED, HELD) if code in codes), DONE)
    say(f"{codes.count(DONE)} of {len(codes)} baked in {time.perf_counter() - started:.1f} s")
    return Outcome(code, dict(file=bpy.data.filepath, made_by=source.made_by(), garments=results))


def _bake_one(obj: bpy.types.Object, files: str, options: bake.Options, say: Say) -> dict[str, Any]:
    try:
        live = bake.show_needed(obj, files)
        if live:
            say(f"{obj.name}: it rests on {', '.join(live)}, of which there is no clip of this file: solved with it")
        if options.piece is not None:
            done = pieces.bake_piece(bpy.context, obj, files, options, say)
        elif options.join:
            done = pieces.join(obj, files, options, say)
        else:
            done = bake.bake(bpy.context, obj, files, options, say)
    except Exception as error:
        return _failed(obj, error)
    say(done.in_words(obj.name))
    return dict(code=DONE, clip=str(done.path), samples=done.samples, seconds=round(done.seconds, 3), bytes=done.bytes,
                resumed=done.resumed, passed=done.passed, was_whole=done.was_whole, checksum=done.checksum)


def _failed(obj: bpy.types.Object, error: Exception) -> dict[str, Any]:
    """The result of a garment that failed. It handles any exception, so that the others continue."""
    if isinstance(error, bake.Ended):
        return dict(code=ENDED, error="ended by SIGTERM; what is solved so far is kept for --resume")
    if isinstance(error, (BakeError, ClipFault)):  # many messages begin with the object's name
        return dict(code=HELD if isinstance(error, Held) else FAILED, error=str(error).removeprefix(f"{obj.name}: "))
    if isinstance(error, OSError):
        return dict(code=FAILED, error=in_words(error, Path(
            error.filename or obj.rumple.bake_folder or clip_place.FOLDER)))
    return dict(code=FAILED, error=f"{type(error).__name__}: {error}")


# ---------------------------------------------------------------- the others
def verify_all(garments: list[bpy.types.Object], most: int, say: Say, complain: Say) -> Outcome:
    """Verify clips. most: samples of each clip; 0: all."""
    files = source.of_files()
    results: dict[str, dict[str, Any]] = {}
    for obj in garments:
        try:
            bake.show_needed(obj, files, all_frames=False)
            found = verify.verify(bpy.context, obj, most)
        except Exception as error:
            results[obj.name] = _failed(obj, error)
            complain(f"{obj.name} FAILED: {results[obj.name]['error']}")
            continue
        results[obj.name] = dict(code=DONE if found.frame is None else DIFFERS, compared=found.compared,
                                 frame=found.frame, farthest=found.farthest, damaged=found.damaged)
        (say if found.frame is None else complain)(found.in_words(obj.name))
    codes = [result["code"] for result in results.values()]
    return Outcome(FAILED if FAILED in codes else max(codes), dict(file=bpy.data.filepath, garments=results))


def check_all(garments: list[bpy.types.Object], to_bake: bool, say: Say, complain: Say) -> Outcome:
    """Check what this worker lacks. to_bake: for a bake, which repairs clips. Warnings do not count as failures."""
    findings = check.findings(garments, to_bake)
    for finding in findings:
        (complain if finding.lacks else say)(("" if finding.lacks else "note: ") + finding.text)
    lacks = sum(finding.lacks for finding in findings)
    if not lacks:
        say(f"nothing is lacking for {len(garments)} wrinkled objects: {source.made_by()}")
    return Outcome(FAILED if lacks else DONE, dict(file=bpy.data.filepath, made_by=source.made_by(), findings=[
        dict(kind=finding.kind, lacks=finding.lacks, text=finding.text) for finding in findings]))


def list_all(garments: list[bpy.types.Object], say: Say) -> Outcome:
    """List the garments, in the order of the bake."""
    rows = []
    for obj in garments:
        start, end = units.bake_range(obj, bpy.context.scene)
        rows.append(dict(name=obj.name, needs=plan.needs(obj), start=start, end=end, samples=obj.rumple.bake_samples,
                         bytes=plan.bytes_of(obj), cut=pieces.kind(obj)))
        rests = f", rests on {', '.join(rows[-1]['needs'])}" if rows[-1]["needs"] else ""
        say(f"{obj.name}: frames {start}-{end}, about {megabytes(rows[-1]['bytes'])} MB{rests}")
    return Outcome(DONE, dict(file=bpy.data.filepath, garments=rows))


def export_all(garments: list[bpy.types.Object], export: Callable[[bpy.types.Object, Manifest], Exported], say: Say,
               complain: Say) -> Outcome:
    """Export every garment with a complete clip. export: raises BakeError and ClipFault."""
    files = source.of_files()
    results: dict[str, dict[str, Any]] = {}
    for obj in garments:
        started = time.perf_counter()
        try:
            bake.show_needed(obj, files, all_frames=False)
            done = export(obj, shown.whole_clip(obj, files))
        except Exception as error:
            results[obj.name] = _failed(obj, error)
            complain(f"{obj.name} FAILED: {results[obj.name]['error']}")
            continue
        seconds = time.perf_counter() - started
        results[obj.name] = dict(code=DONE, file=str(done.path), frames=done.frames, vertices=done.vertices,
                                 bytes=done.bytes, seconds=round(seconds, 3), **done.more)
        say(f"{obj.name}: {done.frames} frames of {done.vertices} points in {seconds:.1f} s, "
            f"{megabytes(done.bytes)} MB{done.note}: {done.path}")
    codes = [result["code"] for result in results.values()]
    return Outcome(FAILED if FAILED in codes else DONE, dict(file=bpy.data.filepath, garments=results))


def make_poses(obj: bpy.types.Object, options: poses.Options, folder: Path, compare: int | None, say: Say,
               complain: Say) -> Outcome:
    """Make a set of poses. compare: instead, solve this many poses of an existing set again (0: all) and compare
    bits."""
    solver: poses.Solver | None = None
    try:
        solver = poses.Solver(bpy.context, obj, source.of_files(), options)
        if compare is not None:
            pose_set.begin(folder, solver.set, solver.mesh(), resume=True)
            return _compare_poses(solver, folder, compare, say, complain)
        done = poses.make(solver, folder, say)
    except bake.Ended:
        complain(f"{obj.name}: ended by SIGTERM; whole blocks are kept for --resume")
        return Outcome(ENDED, dict(code=ENDED))
    except Exception as error:
        failed = _failed(obj, error)
        complain(f"{obj.name} FAILED: {failed['error']}")
        return Outcome(failed["code"], failed)
    finally:
        if solver is not None:
            solver.close()
    whole = done.there == solver.set.blocks
    rate = f", {1e3 * done.seconds / done.poses:.1f} ms a pose" if done.poses else ""
    rest = "" if whole else f"; other workers have {done.held} of them"
    say(f"{obj.name}: {done.poses} poses of {solver.set.fine} points in {done.seconds:.1f} s{rate}, "
        f"{done.there} of {solver.set.blocks} blocks, {megabytes(done.bytes)} MB{rest}: {folder}")
    return Outcome(DONE if whole else HELD, dict(code=DONE if whole else HELD, folder=str(folder), poses=done.poses,
                                                 seconds=round(done.seconds, 3), bytes=done.bytes, blocks=done.there))


def _compare_poses(solver: poses.Solver, folder: Path, most: int, say: Say, complain: Say) -> Outcome:
    compared, pose = poses.first_different(solver, folder, most)
    if pose is None:
        say(f"{solver.obj.name}: {compared} poses were solved again, all bits are those of the set")
    else:
        complain(f"{solver.obj.name}: pose {pose} is the first that differs from the set")
    return Outcome(DONE if pose is None else DIFFERS, dict(compared=compared, pose=pose))


def attach_all(garments: list[bpy.types.Object], save_as: Path | None, restore: Callable[[], None], say: Say,
               complain: Say) -> Outcome:
    """Save the file with its complete clips shown. Garments without a clip are not changed. restore: undoes the changes
    of the command line to the file."""
    files, counts_as = source.of_files(), source.of_file(Path(bpy.data.filepath))
    folders: set[Path] = set()
    results: dict[str, dict[str, Any]] = {}
    for obj in garments:
        try:
            bake.show_needed(obj, files, all_frames=False)
            manifest = bake.whole_clip(obj, source.of_garment(obj, files), any_frames=True)
        except BakeError as error:
            raise Refused(str(error)) from error
        if manifest is None:
            results[obj.name] = dict(code=FAILED, error="there is no whole clip of this file")
            complain(f"{obj.name} FAILED: there is no whole clip of this file: bake it")
            continue
        bake.show(obj, manifest)
        results[obj.name] = dict(code=DONE, clip=str(clip.new_clip_path(obj)))
        say(f"{obj.name}: shows {clip.new_clip_path(obj)}")
        folders.add(clip.new_clip_path(obj).parent)
    restore()
    target = (save_as or Path(bpy.data.filepath)).absolute()
    try:  # Blender itself writes a temporary file and renames it
        bpy.ops.wm.save_as_mainfile(filepath=str(target), copy=save_as is not None, check_existing=False)
    except RuntimeError as error:
        raise Refused(f"{target} cannot be saved: {str(error).strip()}", FAILED) from error
    _note_attached(target, counts_as, sorted(folders), complain)
    codes = [result["code"] for result in results.values()]
    return Outcome(FAILED if FAILED in codes else DONE, dict(file=str(target), garments=results))


def _note_attached(target: Path, counts_as: bytes, folders: list[Path], complain: Say) -> None:
    """Write notes so that the clips still belong to the saved file, whose bytes have changed."""
    saved = source.content(target)
    for folder in folders:
        try:
            attached_files.write_note(folder, saved, counts_as)
        except OSError as error:
            complain(f"bake --resume will take the clips for those of another file: {in_words(error, folder)}")
