# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes maps in a second Blender without a window, from a copy of the file, so that the artist can go on working.

Solving a pose and Blender's own baker each block for seconds. The second Blender also runs this file.
"""
from __future__ import annotations

import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, Generator

import bpy
import numpy as np

ADDON = Path(os.path.abspath(__file__)).parents[2]
STEP = "Rumple bakes: "  # before the name of a pose, in what it prints


class ApartBake:
    """Like bake.MapBake, but every step is short."""

    def __init__(self, plan: Any) -> None:
        """plan: the MapBake to do."""
        self.plan, self.done = plan, 0
        self.folder = Path(tempfile.mkdtemp(prefix="rumple_maps_", dir=bpy.app.tempdir))
        self._process: subprocess.Popen | None = None

    @property
    def count(self) -> int:
        return len(self.plan.poses)

    def steps(self) -> Generator[str, None, None]:
        """Yields the current state each time. Raises the exceptions of the plan."""
        yield "Saving a copy of the file"
        blend, log = self.folder / "copy.blend", self.folder / "log"
        bpy.ops.wm.save_as_mainfile(filepath=str(blend), copy=True)
        order = json.dumps(dict(object=self.plan.name, poses=self.plan.poses, folder=str(self.folder),
                                size=self.plan.size, deep=self.plan.deep,
                                scripts=not bpy.app.autoexec_fail))  # scripts that were not run here are not run there
        with open(log, "w", encoding="utf-8") as printed:
            self._process = subprocess.Popen(
                [bpy.app.binary_path, "-b", "--factory-startup", str(blend), "--python-exit-code", "1", "--python",
                 __file__, "--", order], stdout=printed, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)
        text = "Starting a second Blender"
        while self._process.poll() is None:
            steps = [line[len(STEP):] for line in log.read_text(encoding="utf-8", errors="replace").splitlines()
                     if line.startswith(STEP)]
            self.done = max(len(steps) - 1, 0)
            text = f"{steps[-1]}: baking" if steps else text
            yield text
        self._check(log)
        for number, name in enumerate(self.plan.poses):
            yield text
            self.plan.take(name, np.load(self.folder / f"{number}.npy"))

    def _check(self, log: Path) -> None:
        error = self.folder / "error"
        if error.exists():
            self.plan.refuse(error.read_text(encoding="utf-8"))
        if self._process.returncode:
            last = log.read_text(encoding="utf-8", errors="replace").strip().splitlines()[-1:]
            self.plan.refuse(f"{self.plan.name}: the second Blender, which bakes the maps, broke off: "
                             f"{''.join(last)}")

    def close(self) -> None:
        """End the second Blender if it still runs."""
        if self._process is not None and self._process.poll() is None:
            self._process.kill()
            self._process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)


# ---------------------------------------------------------------- in the second Blender
def _load_addon(scripts: bool) -> None:
    """Load this add-on from its folder, and open the file again, because a file loads the add-on's properties only
    while the add-on is enabled. scripts: whether scripts and drivers of the file run, which a rig may need."""
    spec = importlib.util.spec_from_file_location("rumple", ADDON / "__init__.py",
                                                  submodule_search_locations=[str(ADDON)])
    rumple = importlib.util.module_from_spec(spec)
    sys.modules["rumple"] = rumple
    spec.loader.exec_module(rumple)
    rumple.register()
    bpy.ops.wm.open_mainfile(filepath=bpy.data.filepath, use_scripts=scripts)


def _main(order: dict[str, Any]) -> None:
    _load_addon(order["scripts"])
    folder, obj = Path(order["folder"]), bpy.data.objects[order["object"]]
    about = obj.rumple_maps
    about.bake_folder, about.bake_size, about.bake_deep = "", order["size"], order["deep"]
    for number, name in enumerate(order["poses"]):
        about.active = about.poses.find(name)
        print(f"{STEP}{name}", flush=True)
        try:
            # as an override, because the object may be in no view layer here: in another scene, or excluded
            with bpy.context.temp_override(object=obj, active_object=obj):
                bpy.ops.rumple.maps_bake()
        except RuntimeError as error:  # bpy.ops raises this if an operator reports an error
            (folder / "error").write_text(str(error).removeprefix("Error: ").strip(), encoding="utf-8")
            return
        image = about.poses[name].image
        pixels = np.empty(len(image.pixels), np.float32)
        image.pixels.foreach_get(pixels)
        np.save(folder / f"{number}.npy", pixels)


if __name__ == "__main__":
    _main(json.loads(sys.argv[sys.argv.index("--") + 1]))
