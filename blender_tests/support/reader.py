# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds words in a picture of Blender's window, as somebody does who reads: by what their letters look like.

Blender tells a script neither where a button stands nor what is written on it. So the words are drawn with the font
of the interface, and looked for by normalised cross-correlation. A word is found where it stands alone: not within a
longer name.
"""
from __future__ import annotations

from dataclasses import dataclass

import blf
import bpy
import gpu
import numpy as np
from mathutils import Matrix

ALIKE = 0.95  # correlation of a word with its picture: 0.99 where it stands; "Wool" has 0.9 with what is in "Wrinkles"
ALONE = 5  # pixels without letters beside a word: more than a space, less than from the arrow of a panel to its name
LETTER = 0.35  # of the contrast of the word: what counts as ink


@dataclass(frozen=True)
class Box:
    """Pixels of the window; y upwards, as events have it."""

    left: int
    low: int
    right: int
    high: int

    @property
    def middle(self) -> tuple[int, int]:
        return (self.left + self.right) // 2, (self.low + self.high) // 2


def word_picture(words: str) -> np.ndarray:
    """How the interface writes them, (height, width) from 0 to 1, the top row first, cut to the ink."""
    size = bpy.context.preferences.ui_styles[0].widget.points * bpy.context.preferences.system.ui_scale
    blf.size(0, size, *([72] if bpy.app.version < (4, 0, 0) else []))
    width, height = int(blf.dimensions(0, words)[0]) + 12, int(2.5 * size)
    screen = gpu.types.GPUOffScreen(width, height)
    with screen.bind():
        frame = gpu.state.active_framebuffer_get()
        frame.clear(color=(0.0, 0.0, 0.0, 1.0))
        with gpu.matrix.push_pop(), gpu.matrix.push_pop_projection():
            gpu.matrix.load_matrix(Matrix.Identity(4))
            gpu.matrix.load_projection_matrix(Matrix(((2.0 / width, 0.0, 0.0, -1.0), (0.0, 2.0 / height, 0.0, -1.0),
                                                      (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0))))
            blf.color(0, 1.0, 1.0, 1.0, 1.0)
            blf.position(0, 4, int(0.8 * size), 0)
            blf.draw(0, words)
        buffer = frame.read_color(0, 0, width, height, 4, 0, "FLOAT")
    buffer.dimensions = width * height * 4
    screen.free()
    ink = np.array(buffer, np.float32).reshape(height, width, 4)[::-1, :, 0]
    rows, columns = np.flatnonzero(ink.max(axis=1) > 0.2), np.flatnonzero(ink.max(axis=0) > 0.2)
    return ink[rows[0]:rows[-1] + 1, columns[0]:columns[-1] + 1]


def correlation(picture: np.ndarray, word: np.ndarray) -> np.ndarray:
    """Of a word with every place of a grey picture where it fits, -1 to 1: dark letters on light count as well."""
    shape = [a + b for a, b in zip(picture.shape, word.shape)]
    fits = tuple(slice(0, a - b + 1) for a, b in zip(picture.shape, word.shape))
    flat = word - word.mean()
    product = np.fft.irfft2(np.fft.rfft2(picture, shape) * np.conj(np.fft.rfft2(flat, shape)), shape)[fits]
    sums = [_box_sums(power, word.shape) for power in (picture, picture * picture)]
    spread = np.sqrt(np.maximum(sums[1] - sums[0] ** 2 / word.size, 0.0) * (flat * flat).sum())
    return np.where(spread > 1.0, product / np.maximum(spread, 1e-9), 0.0)


def _box_sums(picture: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    sums = np.pad(picture.astype(np.float64).cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    h, w = shape
    return sums[h:, w:] - sums[:-h, w:] - sums[h:, :-w] + sums[:-h, :-w]


def find(pixels: np.ndarray, words: str, within: Box, upwards: bool = False, alone: bool = True) -> list[Box]:
    """Where the words stand in a box of the window, from above. pixels: (height, width, 3), the top row first. upwards:
    they are written so, as on the tabs of a sidebar. alone: not as a part of more words, nor close to an arrow."""
    height = len(pixels)
    top = height - within.high
    picture = pixels[top:height - within.low, within.left:within.right].astype(np.float32).mean(axis=2)
    if upwards:  # what was above is at the right then
        found = _find(np.rot90(picture, -1), word_picture(words), Box(within.low, 0, within.high, picture.shape[1]),
                      alone)
        return [Box(within.left + picture.shape[1] - box.high, box.left, within.left + picture.shape[1] - box.low,
                    box.right) for box in found]
    return _find(picture, word_picture(words), within, alone)


def _find(picture: np.ndarray, word: np.ndarray, within: Box, alone: bool) -> list[Box]:
    if picture.shape[0] < word.shape[0] or picture.shape[1] < word.shape[1]:
        return []
    alike, found = np.abs(correlation(picture, word)), []
    while alike.size and alike.max() > ALIKE:
        row, column = np.unravel_index(alike.argmax(), alike.shape)
        alike[max(0, row - 5):row + 6, max(0, column - 10):column + 11] = 0.0
        if not alone or _stands_alone(picture, row, column, word.shape):
            left, high = within.left + int(column), within.high - int(row)
            found.append(Box(left, high - word.shape[0], left + word.shape[1], high))
    return sorted(found, key=lambda box: (-box.high, box.left))


def _stands_alone(picture: np.ndarray, row: int, column: int, shape: tuple[int, int]) -> bool:
    rows = picture[row:row + shape[0]]
    inside = rows[:, column:column + shape[1]]
    ground = np.median(inside)
    contrast = np.abs(inside - ground).max()
    for beside in (rows[:, max(0, column - ALONE):max(0, column - 1)],
                   rows[:, column + shape[1] + 1:column + shape[1] + ALONE]):
        # A line over all rows is the edge of a button, not a letter.
        ink = np.abs(beside - ground) > LETTER * contrast
        if (ink.any(axis=0) & ~ink.all(axis=0)).any():
            return False
    return True
