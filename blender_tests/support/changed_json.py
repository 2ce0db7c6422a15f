# SPDX-License-Identifier: GPL-3.0-or-later
"""The JSON of a pose rig with one value changed: read, or refused in a sentence."""
from __future__ import annotations

import json
import unittest
from typing import Any, Iterable

from rumple.core.base.wording import UserError
from rumple.core.systems import poses_json


def taken(case: unittest.TestCase, good: str, changes: Iterable[tuple[str, Any]]) -> set[tuple[str, str]]:
    """Of some changes (path, value) those that are read, with the first letters of the value. A path's keys and
    numbers are divided by dots."""
    out = set()
    for path, value in changes:
        data = json.loads(good)
        *way, last = [int(part) if part.isdigit() else part for part in path.split(".")]
        owner = data
        for part in way:
            owner = owner[part]
        owner[last] = value
        try:
            poses_json.from_json(json.dumps(data))
            out.add((path, str(value)[:10]))
        except UserError as error:
            case.assertRegex(str(error), r"^\S.{5,300}$")
    return out
