# SPDX-License-Identifier: GPL-3.0-or-later
"""MakeHuman's base mesh, its default rig and its outfits, as arrays, from checkouts of the project's repositories.

Formats: http://www.makehumancommunity.org/wiki/Documentation:MHCLO_file_format and the files themselves. MakeHuman is
in decimetres, y up, and faces z; what leaves this module is in metres, z up, and faces -y. Never imports bpy.
"""
from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Iterator

import numpy as np

Array = np.ndarray
METRES = 0.1


@dataclass
class Polygons:
    """Of an OBJ file. n vertices."""

    points: Array  # (n, 3)
    corners: list[list[int]] = field(default_factory=list)  # per polygon
    uvs: list[list[tuple[float, float]]] = field(default_factory=list)  # per polygon; without any: empty
    groups: list[str] = field(default_factory=list)  # per polygon


@dataclass
class Figure:
    """The base mesh with helpers, as the targets made it, and its rig. n vertices, b bones."""

    mesh: Polygons  # decimetres, y up
    bones: dict[str, tuple[str | None, Array, Array]]  # parent, head, tail; parents first; metres, z up
    weights: Array  # (n, b) float32, rows sum to 1 where there are any


@dataclass
class Outfit:
    """m vertices. hidden: vertices of the figure that are deleted under it."""

    mesh: Polygons  # metres, z up
    weights: Array  # (m, b) float32
    hidden: set[int]


def to_blender(points: Array) -> Array:
    """Decimetres, y up, to metres, z up."""
    return METRES * np.stack([points[..., 0], -points[..., 2], points[..., 1]], axis=-1)


def words_of(path: Path) -> Iterator[list[str]]:
    """The words of each line that is no comment."""
    for line in path.read_text(encoding="utf-8").splitlines():
        words = line.split()
        if words and not words[0].startswith("#"):
            yield words


def read_obj(path: Path) -> Polygons:
    """Vertices, UVs, polygons and the group that each is in."""
    points: list[list[float]] = []
    texture: list[tuple[float, float]] = []
    out, group = Polygons(np.empty(0)), ""
    for words in words_of(path):
        if words[0] == "v":
            points.append([float(word) for word in words[1:4]])
        elif words[0] == "vt":
            texture.append((float(words[1]), float(words[2])))
        elif words[0] == "g":
            group = words[1]
        elif words[0] == "f":
            corners = [word.split("/") for word in words[1:]]
            out.corners.append([int(corner[0]) - 1 for corner in corners])
            if all(len(corner) > 1 and corner[1] for corner in corners):
                out.uvs.append([texture[int(corner[1]) - 1] for corner in corners])
            out.groups.append(group)
    out.points = np.array(points)
    return out


def read_figure(data: Path, targets: tuple[str, ...]) -> Figure:
    """data: makehuman/data of the repository. targets: names under targets/, each added wholly."""
    mesh = read_obj(data / "3dobjs" / "base.obj")
    for name in targets:
        for words in words_of(data / "targets" / f"{name}.target"):
            mesh.points[int(words[0])] += [float(word) for word in words[1:4]]
    rig = json.loads((data / "rigs" / "default.mhskel").read_text(encoding="utf-8"))
    weights_of = json.loads((data / "rigs" / "default_weights.mhw").read_text(encoding="utf-8"))["weights"]
    joints = {name: to_blender(mesh.points[vertices].mean(0)) for name, vertices in rig["joints"].items()}
    bones: dict[str, tuple[str | None, Array, Array]] = {}
    waiting = dict(rig["bones"])
    while waiting:
        ready = [name for name, bone in waiting.items() if not bone["parent"] or bone["parent"] in bones]
        if not ready:
            raise ValueError(f"default.mhskel: {sorted(waiting)} hang from no root")
        for name in ready:
            bone = waiting.pop(name)
            bones[name] = (bone["parent"], joints[bone["head"]], joints[bone["tail"]])
    weights = np.zeros((len(mesh.points), len(bones)), np.float32)
    for column, name in enumerate(bones):
        for vertex, weight in weights_of.get(name, ()):
            weights[vertex, column] = weight
    return Figure(mesh, bones, weights / np.maximum(weights.sum(1, keepdims=True), 1e-9))


def read_outfit(path: Path, figure: Figure) -> Outfit:
    """An .mhclo file, fitted to the figure: every vertex stands by three of the base mesh, weighted, and an offset."""
    mesh, references, hidden = Polygons(np.empty(0)), [], set[int]()
    scale, section = np.ones(3), ""
    for words in words_of(path):
        if words[0] == "obj_file":
            mesh = read_obj(path.parent / words[1])
        elif words[0] in ("x_scale", "y_scale", "z_scale"):
            axis = "xyz".index(words[0][0])
            ends = figure.mesh.points[[int(words[1]), int(words[2])], axis]
            scale[axis] = abs(ends[0] - ends[1]) / float(words[3])
        elif words[0] in ("verts", "delete_verts"):
            section = words[0]
        elif section == "verts" and words[0].isdigit():
            references.append([float(word) for word in words])
        elif section == "delete_verts":
            hidden |= numbers(words)
    if len(references) != len(mesh.points):
        raise ValueError(f"{path}: {len(references)} references for {len(mesh.points)} vertices")
    rows = np.array([row if len(row) == 9 else [row[0]] * 3 + [1.0] + [0.0] * 5 for row in references])
    corner, share = rows[:, :3].astype(int), rows[:, 3:6, None]
    mesh.points = to_blender((share * figure.mesh.points[corner]).sum(1) + scale * rows[:, 6:9])
    weights = np.maximum((share * figure.weights[corner]).sum(1), 0.0).astype(np.float32)
    return Outfit(mesh, weights / np.maximum(weights.sum(1, keepdims=True), 1e-9), hidden)


def numbers(words: list[str]) -> set[int]:
    """Of "3 - 5 9": 3, 4, 5, 9."""
    found: set[int] = set()
    for at, word in enumerate(words):
        if word == "-":
            found |= set(range(int(words[at - 1]), int(words[at + 1]) + 1))
        else:
            found.add(int(word))
    return found


def skin_of(figure: Figure, hidden: set[int]) -> tuple[Polygons, Array]:
    """The body without what an outfit hides, metres, z up, and the weights of its vertices."""
    faces = [corners for corners, group in zip(figure.mesh.corners, figure.mesh.groups)
             if group == "body" and not hidden.issuperset(corners)]
    kept, rows = np.unique(np.concatenate(faces), return_inverse=True)
    ends = np.cumsum([len(face) for face in faces])[:-1]
    corners = [row.tolist() for row in np.split(rows.ravel(), ends)]
    return Polygons(to_blender(figure.mesh.points[kept]), corners), figure.weights[kept]
