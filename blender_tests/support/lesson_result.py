# SPDX-License-Identifier: GPL-3.0-or-later
"""What a lesson leaves: settings, vertices and a picture. And, as a program, what it leaves when a script follows it:

    blender -b --factory-startup --python blender_tests/support/lesson_result.py -- EXAMPLES OUT NAME...

EXAMPLES: the folder that scripts/examples makes; OUT gets NAME.json, NAME.npy and NAME.png. The native module is
found by RUMPLE_NATIVE.
"""
from __future__ import annotations

import json
import os
import re
import sys
from pathlib import Path
from typing import Any

import bpy
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
SIZE, SAMPLES = 160, 16
OWN = ("message", "name", "bake_folder", "preset_replaced")  # what is said, and what is where the file is


def lessons() -> Any:
    """scripts/lessons_run.py."""
    if str(ROOT / "scripts") not in sys.path:
        sys.path.insert(0, str(ROOT / "scripts"))
    import lessons_run
    return lessons_run


def steps(page: str) -> str:
    """The numbered steps of a lesson."""
    return "\n".join(re.findall(r"^\d\. .*(?:\n   .*)*", page, re.M))


def named(text: str) -> set[str]:
    """What stands in bold: names in Blender's window, each part of a path."""
    bold = [words.replace("\n   ", " ") for words in re.findall(r"\*\*(.+?)\*\*", text, re.S)]
    return {part.strip() for words in bold for part in words.split(" > ")}


def example_of(page: str) -> str:
    """The name of the example that a lesson begins with."""
    return re.search(r"Open Example > (\w+)", page).group(1)


def settings(obj: bpy.types.Object) -> dict[str, Any]:
    """Everything that an artist can set, and the reference poses, by path."""
    found: dict[str, Any] = {"frame": bpy.context.scene.frame_current, "mode": obj.mode}
    for name in ("rumple", "rumple_maps"):
        _collect(getattr(obj, name), name, found)
    return found


def _collect(group: Any, path: str, found: dict[str, Any]) -> None:
    for one in group.bl_rna.properties:
        if one.identifier in (*OWN, "rna_type"):
            continue
        value, here = getattr(group, one.identifier), f"{path}.{one.identifier}"
        if one.type == "POINTER":
            if isinstance(value, bpy.types.PropertyGroup):
                _collect(value, here, found)
            else:
                found[here] = None if value is None else value.name
        elif one.type == "COLLECTION":
            for number, item in enumerate(value):
                _collect(item, f"{here}[{number}]", found)
                found[f"{here}[{number}].name"] = item.name
        else:
            found[here] = sorted(value) if isinstance(value, set) else _plain(value)


def _plain(value: Any) -> Any:
    return value if isinstance(value, (str, int, float, bool)) else [_plain(one) for one in value]


def vertices(obj: bpy.types.Object) -> np.ndarray:
    """Of the evaluated object, (n, 3) float32."""
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    found = np.empty((len(mesh.vertices), 3), np.float32)
    mesh.vertices.foreach_get("co", found.reshape(-1))
    return found


def prepare(name: str) -> None:
    """The lesson's camera, small."""
    run, render = lessons(), bpy.context.scene.render
    run.look(run.LESSONS[name], SAMPLES)
    render.resolution_x = render.resolution_y = SIZE
    render.use_persistent_data = False


def pixels(path: Path, half: int | None = None) -> np.ndarray:
    """Of a picture, (SIZE, SIZE, 3) from 0 to 1, the lowest row first. half: only that, 0 the left one."""
    image = bpy.data.images.load(str(path))
    width, height = image.size
    values = np.array(image.pixels[:], np.float32).reshape(height, width, -1)[..., :3]
    bpy.data.images.remove(image)
    if half is not None:
        values = values[:, width // 2 * half:width // 2 * (half + 1)]
    return values.reshape(SIZE, values.shape[0] // SIZE, SIZE, -1, 3).mean(axis=(1, 3))


def main() -> None:
    examples, out, *names = sys.argv[sys.argv.index("--") + 1:]
    run = lessons()
    import rumple
    rumple.register()
    for name in names:
        page = (run.PAGES / f"{name}.md").read_text(encoding="utf-8")
        example = example_of(page)
        bpy.ops.wm.read_homefile(filepath=str(Path(examples) / f"{example}.blend"))
        bpy.ops.wm.save_as_mainfile(filepath=str(Path(out) / f"{name}.blend"))
        exec(compile(run.script_of(name), f"{name}.md", "exec"), {"__name__": name})
        obj = bpy.data.objects[example]
        (Path(out) / f"{name}.json").write_text(json.dumps(settings(obj)))
        np.save(Path(out) / f"{name}.npy", vertices(obj))
        prepare(name)
        run.render(Path(out) / f"{name}.png")
        print(f"| {name}", flush=True)


if __name__ == "__main__":
    sys.path[:0] = [str(ROOT / "addon"), os.environ["RUMPLE_NATIVE"]]
    main()
