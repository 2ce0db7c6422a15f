# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: `rumple bake`, `check`, `publish`, ... A process of Blender without a window runs one of them.

Its messages begin with "Rumple: ", because Blender writes to the same streams. Errors go to stderr.
"""
from __future__ import annotations

import argparse
import json
import math
import os
import re
import signal
import sys
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Callable, Iterator

import bpy

from ...core.files import clip_folder
from . import alembic, bake, commands, plan, poses, publish, shown, vat


class Usage(Exception):
    """The command line is not valid."""


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> Any:
        raise Usage(f"{message} ({self.prog} --help says what there is)")


def say(text: str) -> None:
    print(f"Rumple: {text}", flush=True)


def complain(text: str) -> None:
    sys.stdout.flush()
    print(f"Rumple: {text}", file=sys.stderr, flush=True)


# ---------------------------------------------------------------- arguments
def frames_of(text: str) -> tuple[int, int]:
    """First and last frame, from "1-250", "-5-20" or "12"."""
    found = re.fullmatch(r"(-?\d{1,7})(?:-(-?\d{1,7}))?", text)
    if found is None:
        raise argparse.ArgumentTypeError(f"frames are A-B, not {text}")
    first = int(found[1])
    last = first if found[2] is None else int(found[2])
    if last < first:
        raise argparse.ArgumentTypeError(f"the last frame ({last}) is before the first ({first})")
    return first, last


def joined(words: list[str]) -> list[str]:
    """Join --frames and its value by "=", because argparse takes a negative first frame for an option."""
    found: list[str] = []
    for word in words:
        if found and found[-1] == "--frames":
            found[-1] = f"--frames={word}"
        else:
            found.append(word)
    return found


def _whole(text: str) -> int:
    value = int(text)
    if value < 1:
        raise ValueError
    return value


def _piece(text: str) -> tuple[int, int]:
    found = re.fullmatch(r"(\d{1,4})/(\d{1,4})", text)
    if found is None or not 1 <= int(found[1]) <= int(found[2]):
        raise argparse.ArgumentTypeError(f"a piece is K/N, from 1/N to N/N, not {text}")
    return int(found[1]), int(found[2])


def parser() -> argparse.ArgumentParser:
    top = _Parser(prog="rumple", description="Bakes wrinkles without a window. Exit codes: 0 done, 1 something failed, "
                  "2 wrong usage, 3 nothing to do, 4 --verify found a difference, 75 another worker has it, 143 ended.")
    kinds, common = top.add_subparsers(dest="command", required=True, parser_class=_Parser), [_common()]
    _add_bake_arguments(kinds.add_parser("bake", parents=common, help="bake wrinkled objects into their clips"))
    check = kinds.add_parser("check", parents=common, help="say what this worker lacks for a file")
    check.add_argument("--to-bake", action="store_true", help="before a bake: clips that are stale or gone are notes")
    kinds.add_parser("list", parents=common, help="what can be baked, in order, and what rests on what")
    _add_publish_arguments(kinds.add_parser("publish", parents=common, help="write baked garments as USD"))
    _add_vat_arguments(kinds.add_parser("vat", parents=common,
                                        help="write baked garments as vertex animation textures"))
    _add_poses_arguments(kinds.add_parser("poses", parents=common, help="solve one garment in many poses of its rig, "
                                          "as arrays for machine learning; --out is their folder"))
    attach = kinds.add_parser("attach", parents=common, help="save the file with its whole clips shown")
    attach.add_argument("--save-as", type=Path, metavar="OTHER.blend", help="else in place")
    return top


def _common() -> _Parser:
    """The arguments of all commands."""
    common = _Parser(add_help=False)
    common.add_argument("file", type=Path, metavar="FILE.blend")
    common.add_argument("--object", action="append", default=[], metavar="NAME", help="this one; may be given again")
    common.add_argument("--frames", type=frames_of, metavar="A-B", help="else those that each object has")
    common.add_argument("--out", type=Path, metavar="DIR", help="folder of the clips, else that of each object")
    common.add_argument("--enable-autoexec", action="store_true", help="run Python drivers and scripts of the file")
    common.add_argument("--json", action="store_true", help="the result as one line")
    return common


def _add_bake_arguments(one: argparse.ArgumentParser) -> None:
    one.add_argument("--resume", action="store_true",
                     help="skip clips that are whole, go on with bakes that were ended")
    one.add_argument("--verify", type=_whole, nargs="?", const=0, metavar="COUNT",
                     help="bake nothing: solve so many samples again (all) and compare bits")
    one.add_argument("--lock-age", type=float, default=600.0, metavar="SECONDS",
                     help="a lock of another host that was not touched for so long is taken over (600)")
    one.add_argument("--checkpoint", type=float, default=bake.CHECKPOINT, metavar="SECONDS",
                     help="so often the solver's state is kept for --resume, where frames go on from one another (20)")
    cut = one.add_mutually_exclusive_group()
    cut.add_argument("--piece", type=_piece, metavar="K/N", help="bake one of N pieces of the frames: independent, "
                     "or with --pre-roll and --tolerance")
    cut.add_argument("--join", type=_whole, default=0, metavar="N", help="make the clip of its N pieces")
    one.add_argument("--pre-roll", type=_whole, default=0, metavar="FRAMES",
                     help="of pieces: so many frames are solved in front of each")
    one.add_argument("--tolerance", type=float, metavar="METRES",
                     help="of pieces with a pre-roll: so far apart two may be in the frame that both have")


def _add_publish_arguments(published: argparse.ArgumentParser) -> None:
    published.add_argument("--to", type=Path, metavar="DIR", help="folder of the files: else publish, beside the file")
    published.add_argument("--scheme", choices=("none", "catmullClark"), default="none",
                           help="how readers subdivide the mesh: none has normals")
    published.add_argument("--attributes", action="store_true", help="the wrinkles' attributes, too, as primvars")
    published.add_argument("--format", choices=("usd", "alembic"), default="usd",
                           help="alembic: by Blender's own exporter, where it has one")


def _add_vat_arguments(textures: argparse.ArgumentParser) -> None:
    textures.add_argument("--to", type=Path, metavar="DIR", help="folder of the folders: else publish, beside the file")
    textures.add_argument("--image", choices=tuple(vat.KINDS), default="png",
                          help="png has 16 bits and says its error, exr has 32-bit floats")
    textures.add_argument("--in-place", action="store_true",
                          help="take the root motion out: it goes into the JSON, for the engine to move the mesh by")


def _add_poses_arguments(drawn: argparse.ArgumentParser) -> None:
    drawn.add_argument("--count", type=_whole, required=True, metavar="N", help="poses")
    drawn.add_argument("--seed", type=int, default=0, metavar="S", help="another one draws other poses (0)")
    drawn.add_argument("--from-clip", action="store_true", help="poses of the clip, at times that are drawn; else "
                       "random ones within the limits of the joints, or the range that they have in the clip")
    drawn.add_argument("--widen", type=float, default=1.0, metavar="FACTOR",
                       help="of the range that joints have in the clip (1)")
    drawn.add_argument("--resume", action="store_true", help="go on with a set, also beside other workers")
    drawn.add_argument("--verify", type=_whole, nargs="?", const=0, metavar="COUNT",
                       help="write nothing: solve so many poses again (all) and compare bits")


# ---------------------------------------------------------------- running
def main(words: list[str]) -> int:
    """Run a command. Returns the exit code."""
    try:
        chosen = parser().parse_args(joined(words))
    except Usage as error:
        complain(str(error))
        return commands.USAGE
    except SystemExit as ended:  # --help
        return int(ended.code or 0)
    try:
        return _run(chosen)
    except commands.Refused as error:
        complain(str(error))
        return error.code


def _run(chosen: argparse.Namespace) -> int:
    commands.open_file(chosen.file, chosen.enable_autoexec)
    scene = bpy.context.scene
    garments = commands.choose(scene, chosen.object)
    if chosen.command != "poses":  # `poses` has its own frames and folder
        chosen.restore = _override(chosen, plan.garments(scene), garments)
    if getattr(chosen, "verify", None) is not None and (getattr(chosen, "piece", None) or getattr(chosen, "join", 0)):
        raise commands.Refused("--verify bakes nothing: leave --piece and --join out")
    run = {"bake": _verify if getattr(chosen, "verify", None) is not None else _bake, "check": _check, "list": _list,
           "attach": _attach, "publish": _publish, "vat": _vat, "poses": _poses}
    outcome = run[chosen.command](chosen, garments)
    if chosen.json:
        say(json.dumps(outcome.data))
    return outcome.code


def _override(chosen: argparse.Namespace, there: list[bpy.types.Object],
              garments: list[bpy.types.Object]) -> Callable[[], None]:
    """Set frames and folder from the command line. Returns a function that restores the values of the file."""
    before = [(obj.rumple, obj.rumple.bake_scene_range, tuple(obj.rumple.bake_known_range), obj.rumple.bake_start,
               obj.rumple.bake_end, obj.rumple.bake_folder) for obj in there]
    for obj in garments if chosen.frames else ():
        obj.rumple.bake_start, obj.rumple.bake_end = chosen.frames
    for obj in there if chosen.out else ():  # clips of objects under them are searched there too
        obj.rumple.bake_folder = os.path.abspath(chosen.out)

    def restore() -> None:
        for about, follows, known, start, end, folder in before:
            about.bake_scene_range = False
            about.bake_start, about.bake_end, about.bake_folder = start, end, folder
            if follows:
                about.bake_scene_range = True
                about.bake_known_range = known

    return restore


def _bake(chosen: argparse.Namespace, garments: list[bpy.types.Object]) -> commands.Outcome:
    in_pieces, tolerance = chosen.piece is not None or chosen.join > 0, chosen.tolerance
    if (tolerance is None) != (chosen.pre_roll == 0) or not in_pieces and chosen.pre_roll:
        raise commands.Refused("--pre-roll and --tolerance go together, and with --piece or --join")
    if tolerance is not None and not 0.0 <= tolerance < math.inf:
        raise commands.Refused(f"--tolerance is metres from 0 on, not {tolerance:g}")
    options = bake.Options(chosen.resume, chosen.lock_age, chosen.checkpoint, chosen.piece, chosen.join,
                           chosen.pre_roll, tolerance or 0.0)
    with _ended_by_signal():
        return commands.bake_all(garments, options, say, complain)


@contextmanager
def _ended_by_signal() -> Iterator[None]:
    numbers = {signal.SIGTERM, getattr(signal, "SIGBREAK", signal.SIGTERM)}  # Windows ends a process without SIGTERM
    former = {number: signal.signal(number, lambda _signal, _frame: bake.end_soon()) for number in numbers}
    try:
        yield
    finally:
        for number, handler in former.items():
            signal.signal(number, handler)


def _verify(chosen: argparse.Namespace, garments: list[bpy.types.Object]) -> commands.Outcome:
    return commands.verify_all(garments, chosen.verify, say, complain)


def _check(chosen: argparse.Namespace, garments: list[bpy.types.Object]) -> commands.Outcome:
    return commands.check_all(garments, chosen.to_bake, say, complain)


def _list(chosen: argparse.Namespace, garments: list[bpy.types.Object]) -> commands.Outcome:
    return commands.list_all(garments, say if not chosen.json else lambda text: None)


def _publish(chosen: argparse.Namespace, garments: list[bpy.types.Object]) -> commands.Outcome:
    if chosen.format == "alembic":
        if chosen.attributes or chosen.scheme != "none":
            raise commands.Refused("--scheme and --attributes are of USD: leave them out with --format alembic")
        return commands.export_all(garments, lambda obj, manifest: alembic.publish(
            bpy.context, obj, manifest, _folder(chosen)), say, complain)
    return commands.export_all(garments, lambda obj, manifest: publish.publish(
        bpy.context, obj, manifest, _folder(chosen), chosen.scheme, chosen.attributes), say, complain)


def _vat(chosen: argparse.Namespace, garments: list[bpy.types.Object]) -> commands.Outcome:
    return commands.export_all(garments, lambda obj, manifest: vat.export(
        bpy.context, obj, manifest, _folder(chosen), chosen.image, chosen.in_place), say, complain)


def _poses(chosen: argparse.Namespace, garments: list[bpy.types.Object]) -> commands.Outcome:
    if len(garments) != 1:
        raise commands.Refused(f"poses are of one garment: give --object, one of "
                               f"{', '.join(obj.name for obj in garments)}")
    if not math.isfinite(chosen.widen) or chosen.widen <= 0.0:
        raise commands.Refused(f"--widen is a factor above 0, not {chosen.widen:g}")
    (obj,) = garments
    name = f"{clip_folder.readable(chosen.file.stem)}-{shown.name_in_files(obj)}_poses"
    folder = (chosen.out or chosen.file.parent / "publish" / name).absolute()
    options = poses.Options(chosen.count, chosen.seed, chosen.from_clip, chosen.widen, chosen.resume, chosen.frames)
    with _ended_by_signal():
        return commands.make_poses(obj, options, folder, chosen.verify, say, complain)


def _folder(chosen: argparse.Namespace) -> Path:
    return (chosen.to or chosen.file.parent / "publish").absolute()


def _attach(chosen: argparse.Namespace, garments: list[bpy.types.Object]) -> commands.Outcome:
    return commands.attach_all(garments, chosen.save_as, chosen.restore, say, complain)


def run_and_exit(words: list[str]) -> None:
    """Run a command and end Blender; for a script that Blender runs."""
    code = main(words)
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)  # with wm.quit_blender() or sys.exit(), Blender may crash while it quits and return another code


# ---------------------------------------------------------------- blender --command rumple
_registered: list[Any] = []


def register() -> None:
    """Register the command (Blender 4.2 and later) and a property, which a queue reads when a file is submitted."""
    bpy.types.Scene.rumple_bake_order = bpy.props.StringProperty(get=plan.as_text, description="Garments of the scene "
                                                                 "in the order in which they are baked")
    if hasattr(bpy.utils, "register_cli_command"):
        _registered.append(bpy.utils.register_cli_command("rumple", main))


def unregister() -> None:
    del bpy.types.Scene.rumple_bake_order
    while _registered:
        bpy.utils.unregister_cli_command(_registered.pop())
