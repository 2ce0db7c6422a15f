# SPDX-License-Identifier: GPL-3.0-or-later
"""What the library says of an array, in the words of an artist: which element, what is wrong, what to do."""
from __future__ import annotations

import re


class UserError(ValueError):
    """Bad input, in a sentence for the artist that names the object and the first bad element."""


# What the library says -> what the panel says. Names of arrays mean nothing to an artist.
SENTENCES = [(re.compile(pattern), sentence) for pattern, sentence in (
    (r"(?:next_)?positions: (vertex \d+) is not finite",
     r"\1 has no valid position in this frame (not a number): look at the shape keys, modifiers and simulations that "
     r"move it"),
    (r"positions_rest: (vertex \d+) is not finite",
     r"\1 has no valid position at rest (not a number): delete it, or set its position"),
    (r"body positions: (vertex \d+) is not finite",
     r"\1 of its bodies has no valid position in this frame: repair that body, or choose another one"),
    (r"body positions: (vertex \d+) is (\S+) away from the origin.*",
     r"\1 of its bodies is \2 away from the origin in this frame: look at what moves that one, and at the scale of "
     r"the garment"),
    (r"polygon_start: the mesh has no faces", "its mesh has no faces: add some, or choose another object"),
    (r"positions_rest: all vertices stand at one place", "all of its vertices stand at one place: give it a shape"),
    (r"longest: edges of at most ([\d.e+-]+) need more than (\d+) vertices.*",
     r"edges of \1 need more than \2 vertices: choose a greater Longest Edge, or raise Most Vertices"),
    (r"the fine mesh would have about (\d+) vertices, more than (\d+).*",
     r"the fine mesh would have about \1 vertices, more than \2: choose fewer subdivisions, or raise Most Vertices"),
    (r"(?:next_)?positions: (vertex \d+) is (\S+) away from the origin.*",
     r"\1 is \2 away from the origin in this frame, as where a simulation explodes (the last "
     r"good frame stays): look at what moves it"),
    (r"rest_wrinkle: (vertex \d+) is not finite",
     r"the painted rest wrinkle of \1 is not a valid vector: press Clear in the panel Rest Wrinkles and paint it "
     r"again"),
    (r"rest_wrinkle: (vertex \d+) has length (.*)",
     r"the painted rest wrinkle of \1 has length \2: press Clear in the panel Rest Wrinkles and paint it again"),
    (r"paint\.(\w+): (.*)", r"what is painted as \1 cannot be taken: \2. Paint it again"),
    (r"uv: (corner \d+) is not finite", r"the UV map has no valid place at \1: unwrap the mesh there again"),
)]


def user_error(name: str, error: Exception) -> UserError:
    """What the library refused of an object."""
    text = str(error)
    for pattern, sentence in SENTENCES:
        if pattern.match(text):
            return UserError(f"{name}: {pattern.sub(sentence, text)}")
    return UserError(f"{name}: {text}")
