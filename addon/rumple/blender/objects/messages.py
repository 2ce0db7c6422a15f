# SPDX-License-Identifier: GPL-3.0-or-later
"""What is said of an object: kept with its runtime, read by the panel, printed once."""
from __future__ import annotations

import traceback
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Callable, Iterator

import bpy

from ...core.engine import UserError
from ...native import NativeMissing
from .. import scheduler


@dataclass
class Messages:
    """What the panel says about an object."""

    message: str = ""  # what is wrong with this frame
    refusal: str = ""  # what is wrong with the meshes and settings: stays until they change
    unplayed: str = ""  # that this frame was reached by a jump, where it shows
    unplayed_in_renders: str = ""  # the last of these that a render has said
    left_out: str = ""  # which of its bodies does not count
    notes: list[str] = field(default_factory=list)


def set_frame_error(runtime: Messages, text: str) -> None:
    """Set the message on the current frame; a new one goes to the console once."""
    _tell(text, runtime.message)
    runtime.message = text


def set_build_error(runtime: Messages, text: str) -> None:
    """Set the message on the structure; empty when it is right again."""
    _tell(text, runtime.refusal)
    runtime.refusal = text


def note_unplayed(runtime: Messages, text: str, rendering: bool) -> None:
    """Set what is said of a frame that was reached by a jump; of renders a new one goes to the console."""
    if text != runtime.unplayed:
        scheduler.redraw_panels_soon()
    runtime.unplayed = text
    if rendering:
        _print_new(text, runtime.unplayed_in_renders)
        runtime.unplayed_in_renders = text


def note_left_out(runtime: Messages, text: str) -> None:
    """Set what is said of a body that does not count; a new one goes to the console once."""
    _tell(text, runtime.left_out)
    runtime.left_out = text


def _tell(text: str, former: str) -> None:
    _print_new(text, former)
    if text != former:
        scheduler.redraw_panels_soon()


def _print_new(text: str, former: str) -> None:
    if text and text != former:
        print(f"Rumple: {text}")


@contextmanager
def frame_errors(obj: bpy.types.Object, runtime: Messages) -> Iterator[None]:
    """Errors become the message on this frame: handlers must not throw. The last good picture stays."""
    with _errors(obj, runtime, set_frame_error):
        yield


@contextmanager
def build_errors(obj: bpy.types.Object, runtime: Messages) -> Iterator[None]:
    """Errors become the message on the structure. The last good mesh stays."""
    with _errors(obj, runtime, set_build_error):
        yield


@contextmanager
def _errors(obj: bpy.types.Object, runtime: Messages, tell: Callable[[Messages, str], None]) -> Iterator[None]:
    try:
        yield
    except Exception as error:  # a message on the panel, never a traceback
        tell(runtime, of_error(obj, error))


def of_error(obj: bpy.types.Object, error: Exception) -> str:
    """What is said of it."""
    if isinstance(error, (UserError, NativeMissing)):
        return str(error)
    if isinstance(error, MemoryError):
        return f"{obj.name}: there is not enough memory: choose longer folds, or lower Memory Limit"
    return unexpected(obj, error)


@contextmanager
def console_errors(what: str) -> Iterator[None]:
    """Errors of what belongs to no object go to the console, each once, and what comes after goes on."""
    try:
        yield
    except Exception as error:
        text = _in_one_line(what, error)
        if text not in _said:
            _said.add(text)
            print(f"Rumple: {text}")


_said: set[str] = set()


def unexpected(obj: bpy.types.Object | str, error: Exception) -> str:
    """A mistake of ours in one line, with the place for the report. obj: its name, where it may be gone."""
    return _in_one_line(obj if isinstance(obj, str) else obj.name, error)


def _in_one_line(what: str, error: Exception) -> str:
    place = traceback.extract_tb(error.__traceback__)[-1]
    file = place.filename.replace("\\", "/").rsplit("/", 1)[-1]
    return f"{what}: unexpected {type(error).__name__} in {file}:{place.lineno}: {error}"
