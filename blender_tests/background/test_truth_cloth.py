# SPDX-License-Identifier: GPL-3.0-or-later
"""The fabric of scripts/ground_truth: Blender's Cloth bends as far as the bending length says, on any mesh."""
from __future__ import annotations

import math
import unittest

import bpy
import numpy as np
from truth_cloth import Fabric, add_group, set_fabric, set_gravity

OVERHANG, HELD, ACROSS = 0.08, 0.04, 4  # metres, metres, faces
FRAMES = 150  # until the strip rests


def hang_strip(fabric: Fabric, edge: float, fps: float) -> float:
    """Degrees below the horizontal of the line from where a strip leaves an edge to its end."""
    scene = bpy.context.scene
    set_gravity(scene, fps)
    along = np.arange(round((OVERHANG + HELD) / edge) + 1) * edge - HELD
    points = [(x, y * edge, 0.0) for x in along for y in range(ACROSS + 1)]
    row = ACROSS + 1
    faces = [(k, k + row, k + row + 1, k + 1) for k in range(len(points) - row) if k % row < ACROSS]
    mesh = bpy.data.meshes.new("Strip")
    mesh.from_pydata(points, [], faces)
    strip = bpy.data.objects.new("Strip", mesh)
    scene.collection.objects.link(strip)
    cloth = strip.modifiers.new("Cloth", "CLOTH")
    set_fabric(cloth.settings, fabric, edge, fps)
    cloth.settings.pin_stiffness, cloth.settings.air_damping = 50.0, 1.0
    held = np.array(points)[:, 0] < 0.5 * edge
    cloth.settings.vertex_group_mass = add_group(strip, "Pin", held.astype(float))
    cloth.point_cache.frame_start, cloth.point_cache.frame_end = 1, FRAMES
    for frame in range(1, FRAMES + 1):
        scene.frame_set(frame)
    hung = strip.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.vertices
    places = np.array([vertex.co for vertex in hung])
    last_held = int(np.flatnonzero(held)[-1])
    down = places[-row:].mean(axis=0) - places[last_held - ACROSS:last_held + 1].mean(axis=0)
    bpy.data.objects.remove(strip)
    return math.degrees(math.atan2(-down[2], down[0]))


class Strips(unittest.TestCase):
    """A strip that hangs over an edge (F. T. Peirce 1930). With a fixed stiffness in Blender's units the same fabric
    bent as chiffon does on one mesh, and as cotton on another."""

    def test_the_bending_length_is_the_fabric_s(self) -> None:
        for length, edge, fps in ((0.022, 0.005, 30.0), (0.022, 0.008, 24.0), (0.022, 0.01, 30.0), (0.03, 0.008, 30.0)):
            bpy.ops.wm.read_homefile(use_empty=True)
            angle = math.radians(hang_strip(Fabric(bending_length=length), edge, fps))
            measured = OVERHANG * (math.cos(angle / 2.0) / (8.0 * math.tan(angle))) ** (1.0 / 3.0)
            self.assertLess(abs(measured / length - 1.0), 0.1, (length, edge, fps, math.degrees(angle)))


if __name__ == "__main__":
    unittest.main()
