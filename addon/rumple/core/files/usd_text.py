# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes a moving mesh as a USD stage in text (.usda), frame by frame. No bpy here.

Numbers have nine digits, so that a reader gets the same 32-bit floats (normals have five, velocities six). A stage has
all samples of an attribute together. So each varying attribute is first written to a file of its own. The stage appears
by one rename.
"""
from __future__ import annotations

import json
import os
import re
import shutil
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

import numpy as np

from . import clip_folder
from .clip_manifest import ClipFault


@dataclass
class Stage:
    """The parts of a stage that do not change with time."""

    name: str  # of the object
    start: int
    end: int
    rate: float  # frames a second
    metres: float  # per unit
    counts: np.ndarray  # (faces,) number of corners of each face
    corners: np.ndarray  # (corners,) vertices
    scheme: str = "none"  # or catmullClark
    uvs: dict[str, np.ndarray] = field(default_factory=dict)  # (corners, 2) by name, the active one first
    about: dict[str, str] = field(default_factory=dict)  # its origin


def identifier(name: str) -> str:
    """A valid name for USD."""
    plain = re.sub(r"\W", "_", name, flags=re.ASCII)
    return plain if plain and not plain[0].isdigit() else f"_{plain}"


def uv_names(layers: list[str]) -> list[str]:
    """Names of the primvars of UV layers: the first is `st`, and all are different."""
    names: list[str] = []
    for number, layer in enumerate(layers):
        name, again = "st" if number == 0 else identifier(layer), 1
        while name in names:
            name, again = f"{identifier(layer)}_{again}", again + 1
        names.append(name)
    return names


def rows(values: np.ndarray, digits: int = 9) -> str:
    """An array as text: numbers, or a tuple for each row."""
    flat = np.ascontiguousarray(values)
    if flat.ndim == 1:
        kind = "%d" if flat.dtype.kind in "iu" else f"%.{digits}g"
        return "[" + ", ".join([kind] * len(flat)) % tuple(flat.tolist()) + "]"
    one = "(" + ", ".join([f"%.{digits}g"] * flat.shape[1]) + ")"
    return "[" + ", ".join([one] * len(flat)) % tuple(flat.ravel().tolist()) + "]"


def _text(value: str) -> str:
    return json.dumps(value, ensure_ascii=False)


class StageWriter:
    """Writes a stage: call add() for every frame, then commit(), or discard(). All raise ClipFault."""

    def __init__(self, path: Path, stage: Stage) -> None:
        clip_folder.make(path.parent, 0)
        self.path, self.stage = path, stage
        self.temporary = clip_folder.temporary(path)
        self._samples: dict[str, IO[str]] = {}  # key: declaration of the attribute
        self._recent: list[tuple[int, np.ndarray]] = []  # frames whose velocities are not written yet

    def add(self, frame: int, points: np.ndarray, normals: np.ndarray | None, world: np.ndarray,
            primvars: dict[str, np.ndarray]) -> None:
        """points, normals: (n, 3) float32, object space. world: (4, 4), column vectors. primvars: (n,) or (n, 3)."""
        try:
            self._add(frame, points, normals, world, primvars)
        except OSError as error:
            raise ClipFault(clip_folder.in_words(error, self.path.parent)) from error

    def _add(self, frame: int, points: np.ndarray, normals: np.ndarray | None, world: np.ndarray,
             primvars: dict[str, np.ndarray]) -> None:
        matrix = "( " + ", ".join("(" + ", ".join(f"{x:.17g}" for x in row) + ")" for row in world.T.tolist()) + " )"
        self._sample("matrix4d xformOp:transform", frame, matrix)
        self._sample("float3[] extent", frame, rows(np.stack([points.min(0), points.max(0)])))
        self._sample("point3f[] points", frame, rows(points))
        if normals is not None:
            self._sample("normal3f[] normals", frame, rows(normals, 5))
        for name, values in primvars.items():
            kind = "float[]" if values.ndim == 1 else "vector3f[]"
            self._sample(f"{kind} primvars:{identifier(name)}", frame, rows(values))
        self._recent.append((frame, points.copy()))
        if len(self._recent) == 2:
            self._velocity(0, 0, 1)
        elif len(self._recent) == 3:
            self._velocity(1, 0, 2)
            del self._recent[0]

    def _velocity(self, of: int, first: int, last: int) -> None:
        """Write the velocity of a frame, from the frames around it."""
        (before, start), (after, end) = self._recent[first], self._recent[last]
        self._sample("vector3f[] velocities", self._recent[of][0],
                     rows((end - start) * np.float32(self.stage.rate / (after - before)), 6))

    def _sample(self, attribute: str, frame: int, value: str) -> None:
        if attribute not in self._samples:
            self._samples[attribute] = tempfile.TemporaryFile("w+", dir=self.path.parent, encoding="utf-8")
        self._samples[attribute].write(f"            {frame}: {value},\n")

    def commit(self) -> None:
        """Write the whole stage and move it into place."""
        try:
            if len(self._recent) == 2:
                self._velocity(1, 0, 1)
            with open(self.temporary, "w", encoding="utf-8", newline="\n") as file:
                self._write(file)
                file.flush()
                os.fsync(file.fileno())
            clip_folder.put(self.temporary, self.path)
        except OSError as error:
            raise ClipFault(clip_folder.in_words(error, self.path.parent)) from error
        finally:
            self.discard()

    def discard(self) -> None:
        """Never raises."""
        for file in self._samples.values():
            try:
                file.close()
            except OSError:
                pass
        self._samples.clear()
        try:
            self.temporary.unlink(missing_ok=True)
        except OSError:
            pass

    def _write(self, file: IO[str]) -> None:
        stage, name = self.stage, identifier(self.stage.name)
        about = "".join(f"        string {key} = {_text(value)}\n" for key, value in stage.about.items())
        file.write(f'#usda 1.0\n(\n    defaultPrim = "{name}"\n    customLayerData = {{\n{about}    }}\n'
                   f"    startTimeCode = {stage.start}\n    endTimeCode = {stage.end}\n"
                   f"    timeCodesPerSecond = {stage.rate:.9g}\n    framesPerSecond = {stage.rate:.9g}\n"
                   f'    metersPerUnit = {stage.metres:.9g}\n    upAxis = "Z"\n)\n\ndef Xform "{name}"\n{{\n')
        self._write_samples(file, "matrix4d xformOp:transform", "    ")
        file.write('    uniform token[] xformOpOrder = ["xformOp:transform"]\n\n'
                   f'    def Mesh "mesh"\n    {{\n        uniform token subdivisionScheme = "{stage.scheme}"\n'
                   f"        int[] faceVertexCounts = {rows(stage.counts)}\n"
                   f"        int[] faceVertexIndices = {rows(stage.corners)}\n")
        for primvar, values in zip(uv_names(list(stage.uvs)), stage.uvs.values()):
            file.write(f"        texCoord2f[] primvars:{primvar} = {rows(values)} (\n"
                       '            interpolation = "faceVarying"\n        )\n')
        for attribute in [one for one in self._samples if not one.startswith("matrix4d")]:
            self._write_samples(file, attribute, "        ")
        file.write("    }\n}\n")

    def _write_samples(self, file: IO[str], attribute: str, indent: str) -> None:
        samples = self._samples[attribute]
        samples.seek(0)
        if "primvars:" in attribute or "normals" in attribute:
            file.write(f'{indent}{attribute} (\n{indent}    interpolation = "vertex"\n{indent})\n')
        file.write(f"{indent}{attribute}.timeSamples = {{\n")
        shutil.copyfileobj(samples, file, 1 << 20)
        file.write(f"{indent}}}\n")


def stem(file: str, obj: str, source: str, start: int, end: int) -> str:
    """The name of an exported file without suffix: file, object, digest of its source, frames. obj: from
    readable_beside()."""
    return f"{clip_folder.readable(file)}-{obj}-{source[:8] or 'window'}-{start}-{end}"


def about(**entries: Any) -> dict[str, str]:
    """Entries about the origin, for Stage.about."""
    return {f"rumple_{key}": str(value) for key, value in entries.items()}
