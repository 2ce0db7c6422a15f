# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the JSON of reference poses that poses.PoseRig.to_json() writes. The text may come from anywhere, so entries
that do not have the documented types and sizes are refused with a message. Never imports bpy."""
from __future__ import annotations

import json
from typing import Any

import numpy as np

from ..base.wording import UserError
from .poses import FORMAT, FORMAT_VERSION, KEYS_VERSION, MOST_POSES, PoseRig, ReferencePose, TrackedBone, TrackedKey

MOST_TEXT = 64 << 20  # letters of a file
MOST_BONES = 10_000  # the same limit for shape keys
LONGEST_TEXT = 1024  # letters of a name; names of poses are shorter, see PoseRig.check()
FARTHEST = 1e9  # largest coordinate of a bone, object units


def from_json(text: str) -> PoseRig:
    """The rig that to_json() wrote. A muted pose has a strength of 0. Raises UserError about what is wrong, and no
    other exception."""
    data = _parsed(text)
    whole = "the reference poses"
    bones, poses = _rows(data, "bones", whole, MOST_BONES), _rows(data, "poses", whole, MOST_POSES)
    has_keys = data["version"] == KEYS_VERSION
    keys = _rows(data, "keys", whole, MOST_BONES) if has_keys else []
    rig = PoseRig(
        name=_text(data, "name", whole), root=_text(data, "root", whole), maps=_text(data, "maps", whole).upper(),
        neutral_map=_file_name(data, "neutral_map", whole), gain=_number(data, "gain", whole),
        neutral=_places(bones, "bone"),
        bones=[TrackedBone(_text(bone, "name", f"bone {number}"), _text(bone, "tracked", f"bone {number}").upper(),
                           _text(bone, "group", f"bone {number}")) for number, bone in enumerate(bones, 1)],
        keys=[TrackedKey(_text(key, "name", f"shape key {number}"), _text(key, "group", f"shape key {number}"))
              for number, key in enumerate(keys, 1)],
        neutral_keys=_values(keys, "shape key"),
        poses=[_pose(pose, f"pose {number}", len(bones), len(keys) if has_keys else None)
               for number, pose in enumerate(poses, 1)])
    rig.check()
    return rig


def _parsed(text: str) -> dict[str, Any]:
    if len(text) > MOST_TEXT:
        raise UserError(f"the file of reference poses is longer than {MOST_TEXT >> 20} MB")
    try:
        data = json.loads(text)
    except RecursionError as error:
        raise UserError("the reference poses cannot be read: they are nested too deeply") from error
    except ValueError as error:
        raise UserError(f"the reference poses cannot be read: {str(error)[:200]}") from error
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise UserError("this is not a file of reference poses")
    version = data.get("version")
    if isinstance(version, bool) or version not in (FORMAT_VERSION, KEYS_VERSION):
        raise UserError(f"reference poses of version {str(version)[:20]}; this Rumple reads {FORMAT_VERSION} and "
                        f"{KEYS_VERSION}")
    return data


def _pose(data: dict[str, Any], where: str, bone_count: int, key_count: int | None) -> ReferencePose:
    name = _text(data, "name", where)
    bones = _rows(data, "bones", where, MOST_BONES)
    keys = [] if key_count is None else _rows(data, "keys", where, MOST_BONES)
    for rows, count, kind in ((bones, bone_count, "bones"), (keys, key_count or 0, "shape keys")):
        if len(rows) != count:
            raise UserError(f"{where}, {name}: expected {count} {kind}, got {len(rows)}")
    return ReferencePose(name, _places(bones, f"{where}, bone"), _file_name(data, "map", where),
                         _number(data, "strength", where), keys=_values(keys, f"{where}, shape key"))


def _entry(data: dict[str, Any], key: str, where: str) -> Any:
    if key not in data:
        raise UserError(f"{where} lack{'' if where.endswith('s') else 's'} '{key}'")
    return data[key]


def _rows(data: dict[str, Any], key: str, where: str, most: int) -> list[dict[str, Any]]:
    rows = _entry(data, key, where)
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise UserError(f"{where} cannot be read: '{key}' is no list of entries")
    if len(rows) > most:
        raise UserError(f"{where} cannot be read: {len(rows)} {key}; there may be {most}")
    return rows


def _text(data: dict[str, Any], key: str, where: str) -> str:
    value = _entry(data, key, where)
    if not isinstance(value, str) or len(value) > LONGEST_TEXT or not _is_utf8(value):
        raise UserError(f"{where} cannot be read: '{key}' is no text of at most {LONGEST_TEXT} letters")
    return value


def _is_utf8(value: str) -> bool:
    """Whether the text can be encoded: half of a surrogate pair cannot."""
    return not any(0xD800 <= ord(letter) <= 0xDFFF for letter in value)


def _file_name(data: dict[str, Any], key: str, where: str) -> str:
    """The name of a file beside the JSON. A path is refused, because it could lead an engine anywhere."""
    value = _text(data, key, where)
    if value in (".", "..") or any(letter in value for letter in "/\\:\0"):
        raise UserError(f"{where} cannot be read: '{key}' is not the name of a file in the same folder")
    return value


def _number(data: dict[str, Any], key: str, where: str) -> float:
    value = _entry(data, key, where)
    if not _is_number(value):
        raise UserError(f"{where} cannot be read: '{key}' is no number")
    return value


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) <= FARTHEST  # not NaN either


def _places(bones: list[dict[str, Any]], where: str) -> np.ndarray:
    """(b, 6) float32 heads and tails."""
    for number, bone in enumerate(bones, 1):
        for key in ("head", "tail"):
            point = _entry(bone, key, f"{where} {number}")
            if not isinstance(point, list) or len(point) != 3 or not all(_is_number(x) for x in point):
                raise UserError(f"{where} {number} cannot be read: '{key}' is not three numbers")
    return np.array([[*bone["head"], *bone["tail"]] for bone in bones], np.float32).reshape(len(bones), 6)


def _values(keys: list[dict[str, Any]], where: str) -> np.ndarray:
    """(m,) float32 of shape keys."""
    return np.array([_number(key, "value", f"{where} {number}") for number, key in enumerate(keys, 1)], np.float32)
