# SPDX-License-Identifier: GPL-3.0-or-later
"""Messages about an object. They are stored with its runtime, shown in the panel, and printed once."""
from __future__ import annotations

import traceback
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Callable, Iterator

import bpy

from ...core.base.wording import UserError
from ...native import NativeMissing
from .. import scheduler


@dataclass
class Messages:
    """The panel's messages about an object."""

    message: str = ""  # an error in this frame
    refusal: str = ""  # an error in the meshes and settings: it stays until they change
    unplayed: str = ""  # a warning that this frame was reached by a jump, if this is visible
    unplayed_in_renders: str = ""  # the last one that a render has printed
    left_out: str = ""  # a warning that a body is not used
    no_room: str = ""  # a warning that paths of this frame are not shown
    notes: list[str] = field(default_factory=list)


def set_frame_error(runtime: Messages, text: str) -> None:
    """Set the error of the current frame. A new one is printed once."""
    _tell(text, runtime.message)
    runtime.message = text


def set_build_error(runtime: Messages, text: str) -> None:
    """Set the error of the structure. It is empty when the structure is valid again."""
    _tell(text, runtime.refusal)
    runtime.refusal = text


def note_unplayed(runtime: Messages, text: str, rendering: bool) -> None:
    """Set the warning about a frame that was reached by a jump. In renders a new one is printed."""
    if text != runtime.unplayed:
        scheduler.redraw_panels_soon()
    runtime.unplayed = text
    if rendering:
        _print_new(text, runtime.unplayed_in_renders)
        runtime.unplayed_in_renders = text


def note_left_out(runtime: Messages, text: str) -> None:
    """Set the warning about a body that is not used. A new one is printed once."""
    _tell(text, runtime.left_out)
    runtime.left_out = text


def note_no_room(runtime: Messages, text: str) -> None:
    """Set the warning about paths that are not shown in this frame. A new one is printed once."""
    _tell(text, runtime.no_room)
    runtime.no_room = text


def _tell(text: str, former: str) -> None:
    _print_new(text, former)
    if text != former:
        scheduler.redraw_panels_soon()


def _print_new(text: str, former: str) -> None:
    if text and text != former:
        print(f"Rumple: {text}")


@contextmanager
def frame_errors(obj: bpy.types.Object, runtime: Messages) -> Iterator[None]:
    """Turn exceptions into the error of this frame, because handlers must not raise. The last valid frame stays
    visible."""
    with _errors(obj, runtime, set_frame_error):
        yield


@contextmanager
def build_errors(obj: bpy.types.Object, runtime: Messages) -> Iterator[None]:
    """Turn exceptions into the error of the structure. The last valid mesh stays."""
    with _errors(obj, runtime, set_build_error):
        yield


@contextmanager
def _errors(obj: bpy.types.Object, runtime: Messages, tell: Callable[[Messages, str], None]) -> Iterator[None]:
    try:
        yield
    except Exception as error:  # a message in the panel, never a traceback
        tell(runtime, of_error(obj, error))


def of_error(obj: bpy.types.Object, error: Exception) -> str:
    """The message about an exception."""
    if isinstance(error, (UserError, NativeMissing)):
        return str(error)
    if isinstance(error, MemoryError):
        return f"{obj.name}: there is not enough memory: choose longer folds, or lower Memory Limit"
    return unexpected(obj, error)


@contextmanager
def console_errors(what: str) -> Iterator[None]:
    """Print each exception of work that belongs to no object once. The following work continues."""
    try:
        yield
    except Exception as error:
        text = _in_one_line(what, error)
        if text not in _said:
            _said.add(text)
            print(f"Rumple: {text}")


_said: set[str] = set()


def unexpected(obj: bpy.types.Object | str, error: Exception) -> str:
    """One line about a bug in Rumple, with the place in the code for a report. obj: its name if the object may be
    gone."""
    return _in_one_line(obj if isinstance(obj, str) else obj.name, error)


def _in_one_line(what: str, error: Exception) -> str:
    place = traceback.extract_tb(error.__traceback__)[-1]
    file = place.filename.replace("\\", "/").rsplit("/", 1)[-1]
    return f"{what}: unexpected {type(error).__name__} in {file}:{place.lineno}: {error}"
