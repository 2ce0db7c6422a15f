# SPDX-License-Identifier: GPL-3.0-or-later
"""Inside Blender: this tree's add-on, and one command of it. Started by scripts/rumple."""
from __future__ import annotations

import os
import sys
from pathlib import Path

import addon_utils

sys.path[:0] = [str(Path(__file__).resolve().parent.parent / "addon"), os.environ["RUMPLE_NATIVE"]]


def refuse(error: Exception) -> None:
    """What a worker lacks before anything else, in words."""
    print(f"Rumple: {error}", file=sys.stderr, flush=True)
    os._exit(1)


if addon_utils.enable("rumple", default_set=True, persistent=True, handle_error=refuse) is None:
    os._exit(1)
from rumple.blender.farm import command  # noqa: E402

command.run_and_exit(sys.argv[sys.argv.index("--") + 1:])
