# SPDX-License-Identifier: GPL-3.0-or-later
"""Translates error messages of the library for artists: which element is wrong, why, and what to do."""
from __future__ import annotations

import re


class UserError(ValueError):
    """Bad input. The message is a sentence for the artist that names the object and the first bad element."""


# Message of the library -> message in the panel, because artists do not know the names of arrays.
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
    (r"positions_rest: (vertex \d+) is (\S+) away from the origin.*",
     r"\1 is \2 away from the origin at rest: move the mesh to the origin, or scale it down"),
    (r"positions: the frame is so far from the rest shape.*",
     "this frame is so far from the rest shape, or a setting so extreme, that no fold can be computed: look at what "
     "moves it, and at its settings"),
    (r"world_from_object: .*",
     "its scale is zero in this frame, or not a number: give it one, or hide the object there"),
    (r"width: (folds of \S+) can start at more than (\d+) .*",
     r"\1 can start at more than \2 places of this mesh, and a frame would take minutes: raise the Width"),
    (r"(radius|prestretch|bending|inside|drape|folds|detail|follow|room|mask|wavelength|smooth|rigid): number \d+: "
     r"expected (\S+) to (\S+), got (\S+)",
     r"what is painted as \1 holds \4, where \2 to \3 is possible: paint it again, or take it away in the panel "
     r"Paint"),
    (r"(stretch|shear|compression|folded|smoothing|tube_radius): expected .*",  # not in the panel, scaled to metres
     "its size in metres is too small or too large for cloth: look at the object's scale and the scene's unit"),
    (r"(\w+): expected (?:a value above )?(\S+) to (\S+), got (\S+)",
     r"\1 is \4 in units of the object, where \2 to \3 is possible: look at the object's scale, the scene's unit and "
     r"that setting"),
    (r"(levels|segments): (\d+).* more corners than can be counted",
     r"\2 \1 make more corners than can be counted: choose fewer"),
    (r"OpenSubdiv cannot refine this mesh",
     "its faces cannot be subdivided: use Mesh > Clean Up > Degenerate Dissolve"),
    (r"paint\.(\w+): (.*)", r"what is painted as \1 cannot be taken: \2. Paint it again"),
    (r"uv: (corner \d+) is not finite", r"the UV map has no valid place at \1: unwrap the mesh there again"),
)]


def user_error(name: str, error: Exception) -> UserError:
    """The UserError for an error of the library. name: of the object."""
    text = str(error)
    for pattern, sentence in SENTENCES:
        if pattern.match(text):
            return UserError(f"{name}: {pattern.sub(sentence, text)}")
    return UserError(f"{name}: {text}")
