# SPDX-License-Identifier: GPL-3.0-or-later
"""A Blender without the add-on that opens a file of ours: what it sees.

Tests call look(); this same file is what the other Blender runs.
"""
from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np

FILE, SEEN, STILL, SAVED = "scene.blend", "seen.npz", "still.png", "resaved.blend"
POSITION = "position"


class InAFolder:
    """A test with a folder for the file that the other Blender opens: mix it into a TestCase."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def save(self) -> None:
        bpy.ops.wm.save_as_mainfile(filepath=str(self.folder / FILE))


def look(folder: Path, name: str, times: tuple[float, ...], render: int = 0,
         attributes: tuple[str, ...] = ()) -> dict[float, dict[str, np.ndarray]]:
    """Positions and attributes of the object `name` of FILE at these times, as the other Blender has them.

    It leaves SAVED in the folder, the file as it saves it, and STILL where a frame to render is given.
    """
    wanted = json.dumps(dict(object=name, times=times, render=render, attributes=attributes, folder=str(folder)))
    done = subprocess.run([bpy.app.binary_path, "-b", "--factory-startup", str(folder / FILE),
                           "--python-exit-code", "1", "--python", __file__, "--", wanted],
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=300,
                          env={key: value for key, value in os.environ.items() if key != "RUMPLE_NATIVE"})
    if done.returncode != 0 or "Traceback" in done.stdout:
        raise AssertionError(done.stdout)
    with np.load(folder / SEEN) as seen:
        return {time: {what: seen[f"{index} {what}"] for what in (POSITION, *attributes)}
                for index, time in enumerate(times)}


def read(mesh: bpy.types.Mesh, what: str) -> np.ndarray:
    """Values of an attribute, (n, 1) or (n, 3); in 3.4 positions are none."""
    if what == POSITION:
        data, prop, width = mesh.vertices, "co", 3
    else:
        data = mesh.attributes[what].data
        prop, width = ("value", 1) if mesh.attributes[what].data_type == "FLOAT" else ("vector", 3)
    flat = np.empty(len(data) * width, np.float32)
    data.foreach_get(prop, flat)
    return flat.reshape(-1, width)


def main() -> None:
    wanted = json.loads(sys.argv[sys.argv.index("--") + 1])
    assert not any(name.split(".")[0] in ("rumple", "rumple_native") for name in sys.modules)
    assert not hasattr(bpy.types.Object, "rumple")
    scene, folder, seen = bpy.context.scene, Path(wanted["folder"]), {}
    for index, time in enumerate(wanted["times"]):
        scene.frame_set(int(time), subframe=time - int(time))
        mesh = bpy.data.objects[wanted["object"]].evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        for what in (POSITION, *wanted["attributes"]):
            seen[f"{index} {what}"] = read(mesh, what)
    np.savez(folder / SEEN, **seen)
    if wanted["render"]:
        scene.frame_set(wanted["render"])
        scene.render.filepath = str(folder / STILL)
        bpy.ops.render.render(write_still=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / SAVED), copy=True)


if __name__ == "__main__":
    main()
