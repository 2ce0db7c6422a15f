# SPDX-License-Identifier: GPL-3.0-or-later
"""Small readers of PNG, OpenEXR and binary glTF, after their specifications: not Blender's, which wrote the files."""
from __future__ import annotations

import json
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np


def read_png(path: Path) -> np.ndarray:
    """(height, width, 3) uint16, the upper row first: of RGB with 16 bits, not interlaced."""
    data, position, packed = path.read_bytes(), 8, b""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    while position < len(data):
        size, kind = struct.unpack_from(">I4s", data, position)
        body = data[position + 8:position + 8 + size]
        assert zlib.crc32(kind + body) == struct.unpack_from(">I", data, position + 8 + size)[0]
        if kind == b"IHDR":
            width, height, *form = struct.unpack(">IIBBBBB", body)
            assert form == [16, 2, 0, 0, 0], form
        if kind == b"IDAT":
            packed += body
        position += 12 + size
    assert kind == b"IEND"
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + 6 * width)
    above, shown = np.zeros(6 * width, np.uint8), np.empty((height, 6 * width), np.uint8)
    for number, row in enumerate(rows):
        above = shown[number] = _unfiltered(int(row[0]), row[1:], above)
    return shown.view(">u2").reshape(height, width, 3).astype(np.uint16)


def _unfiltered(kind: int, row: np.ndarray, above: np.ndarray) -> np.ndarray:
    if kind in (0, 2):
        return row + above if kind else row
    if kind == 1:
        return row.reshape(-1, 6).cumsum(0, dtype=np.uint8).ravel()
    done, left, corner = row.reshape(-1, 6).astype(int), np.zeros(6, int), np.zeros(6, int)
    upper = above.reshape(-1, 6).astype(int)
    for texel, up in enumerate(upper):
        if kind == 3:
            guess = (left + up) // 2
        else:
            far = [np.abs(up - corner), np.abs(left - corner), np.abs(left + up - 2 * corner)]
            guess = np.where((far[0] <= far[1]) & (far[0] <= far[2]), left, np.where(far[1] <= far[2], up, corner))
        left = done[texel] = (done[texel] + guess) % 256
        corner = up
    return done.astype(np.uint8).ravel()


def read_exr(path: Path) -> np.ndarray:
    """(height, width, 3) float32, the upper row first: of scan lines in 32-bit floats, ZIP."""
    data = path.read_bytes()
    assert struct.unpack_from("<II", data) == (20000630, 2)
    position, header = 8, {}
    while data[position]:
        end = data.index(b"\0", position)
        middle = data.index(b"\0", end + 1)
        size = struct.unpack_from("<I", data, middle + 1)[0]
        header[data[position:end].decode()] = data[middle + 5:middle + 5 + size]
        position = middle + 5 + size
    assert header["compression"] == b"\x03"
    names, place = [], 0
    while header["channels"][place]:
        end = header["channels"].index(b"\0", place)
        names.append(header["channels"][place:end].decode())
        assert struct.unpack_from("<I", header["channels"], end + 1)[0] == 2  # 32-bit floats
        place = end + 17
    left, top, right, bottom = struct.unpack("<4i", header["dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    shown = np.empty((height, len(names), width), np.float32)
    for offset in struct.unpack_from(f"<{-(-height // 16)}Q", data, position + 1):
        first, size = struct.unpack_from("<iI", data, offset)
        count = min(16, height - (first - top))
        shown[first - top:first - top + count] = np.frombuffer(
            _unzipped(data[offset + 8:offset + 8 + size], 4 * count * len(names) * width), "<f4").reshape(
                count, len(names), width)
    return shown[:, [names.index(one) for one in "RGB"]].transpose(0, 2, 1)


def _unzipped(block: bytes, size: int) -> bytes:
    if len(block) == size:
        return block
    values = np.frombuffer(zlib.decompress(block), np.uint8).astype(np.int64)
    values[1:] -= 128
    values = values.cumsum().astype(np.uint8)
    half = (len(values) + 1) // 2
    whole = np.empty(len(values), np.uint8)
    whole[::2], whole[1::2] = values[:half], values[half:]
    return whole.tobytes()


def read_glb(path: Path) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """(the document, arrays of the first primitive by attribute, and its `indices`)."""
    data = path.read_bytes()
    magic, version, length, size = struct.unpack_from("<4sIII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    document, start = json.loads(data[20:20 + size]), 28 + size
    primitive = document["meshes"][0]["primitives"][0]
    return document, {name: _accessor(document, data, start, number)
                      for name, number in {**primitive["attributes"], "indices": primitive["indices"]}.items()}


def _accessor(document: dict[str, Any], data: bytes, start: int, number: int) -> np.ndarray:
    found = document["accessors"][number]
    view = document["bufferViews"][found["bufferView"]]
    kind = {5121: "u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}[found["componentType"]]
    width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[found["type"]]
    offset = start + view.get("byteOffset", 0) + found.get("byteOffset", 0)
    return np.frombuffer(data, kind, found["count"] * width, offset).reshape(-1, width)
