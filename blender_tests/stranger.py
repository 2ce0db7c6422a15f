# SPDX-License-Identifier: GPL-3.0-or-later
"""Run by a Blender without the add-on, after it has opened a file: leaves what it shows in a folder.

    blender -b --factory-startup FILE --python stranger.py -- '{"object": ..., "times": [...], ...}'

seen.npz: positions of the evaluated mesh for every time, by its index; still.png where a frame to render is
given; resaved.blend: the file as this Blender saves it.
"""
import json
import os
import sys

import bpy
import numpy as np


def positions(obj):
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    flat = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def main():
    wanted = json.loads(sys.argv[sys.argv.index("--") + 1])
    assert not any(name.split(".")[0] in ("rumple", "rumple_native") for name in sys.modules)
    assert not hasattr(bpy.types.Object, "rumple")
    scene, seen = bpy.context.scene, {}
    for index, time in enumerate(wanted["times"]):
        scene.frame_set(int(time), subframe=time - int(time))
        seen[str(index)] = positions(bpy.data.objects[wanted["object"]])
    np.savez(os.path.join(wanted["folder"], "seen.npz"), **seen)
    if wanted["render"]:
        scene.frame_set(wanted["render"])
        scene.render.filepath = os.path.join(wanted["folder"], "still.png")
        bpy.ops.render.render(write_still=True)
    bpy.ops.wm.save_as_mainfile(filepath=os.path.join(wanted["folder"], "resaved.blend"), copy=True)


main()
