# SPDX-License-Identifier: GPL-3.0-or-later
"""The small face of support/face.py with shape keys: two brows, a jaw, a frown of both brows, and a head's width."""
from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from rumple.core.systems.shape_keys import weights_of_key
from support import face, sleeve

UP = dict(brow_L=0.01, brow_R=0.01, jaw=-0.02, frown=-0.006)  # metres along z, where a key moves most


def ways() -> dict[str, np.ndarray]:
    """(n, 3) of every key."""
    places = [vertex.co for vertex in face.sheet().vertices]
    shares = np.array([face.share(co.x, co.z) for co in places])
    found = {}
    for name, share in zip(("brow.L", "brow.R", "jaw"), shares.T):
        found[name] = np.outer(share, (0.0, 0.0, UP[name.replace(".", "_")]))
    found["frown"] = np.outer(shares[:, 0] + shares[:, 1], (0.0, 0.0, UP["frown"]))
    found["width"] = np.array([(0.1 * co.x, 0.0, 0.0) for co in places])
    return found


def add_keys(obj: bpy.types.Object, names: Any = ("brow.L", "brow.R", "jaw", "frown", "width")) -> None:
    obj.shape_key_add(name="Basis")
    rest = np.array([vertex.co for vertex in obj.data.vertices], np.float32)
    for name in names:
        block = obj.shape_key_add(name=name, from_mix=False)
        block.slider_min = -1.0
        block.data.foreach_set("co", (rest + ways()[name]).astype(np.float32).ravel())


def scene(maps: bool = True) -> bpy.types.Object:
    """A face with shape keys and no armature, in an empty file."""
    sleeve.empty_file()
    with sleeve.context():
        obj = bpy.data.objects.new("Face", face.sheet())
        bpy.context.scene.collection.objects.link(obj)
        add_keys(obj)
        sleeve.make_active(obj)
        if maps:
            bpy.ops.object.rumple_add(method="MAPS")
    return obj


def set_keys(obj: bpy.types.Object, **values: float) -> None:
    """brow_L=1, jaw=0.5. The others go to 0."""
    for block in list(obj.data.shape_keys.key_blocks)[1:]:
        block.value = values.get(block.name.replace(".", "_"), 0.0)
    with sleeve.context():
        bpy.context.view_layer.update()


def add_pose(name: str) -> None:
    with sleeve.context():
        assert bpy.ops.rumple.pose_add(name=name) == {"FINISHED"}


def two_poses(obj: bpy.types.Object) -> Any:
    """Surprise: both brows and the jaw. Anger: the frown."""
    set_keys(obj, brow_L=1.0, brow_R=1.0, jaw=0.5)
    add_pose("Surprise")
    set_keys(obj, frown=1.0)
    add_pose("Anger")
    set_keys(obj)
    return obj.rumple_maps


def weights(name: str) -> np.ndarray:
    """(n,) of a key."""
    return weights_of_key(ways()[name])


class TwoPoses:
    """A test of a face with two reference poses of shape keys: mix it into a TestCase."""

    def setUp(self) -> None:
        self.obj = scene()
        self.keys = self.obj.data.shape_keys.key_blocks
        self.settings = two_poses(self.obj)
