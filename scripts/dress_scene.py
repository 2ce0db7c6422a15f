# SPDX-License-Identifier: GPL-3.0-or-later
"""A dress on the demo's figure: the upper part of its shirt, and a skirt that hangs away from the legs. For a picture
of the docs. Metres, z up, the figure faces -y.
"""
from __future__ import annotations

import bpy
import demo_rig
import demo_scene
import demo_shirt
import numpy as np
from demo_body import Array
from interpolation import smoothstep

ROWS, HEM, RINGS = 4, 0.50, 18  # of the shirt that are cut away; height of the hem, metres; rings of the skirt
CHEST = 1.2  # metres: below are the shirt's hem and its cuffs
SLEEVES = 0.26  # metres from the middle: what is farther out is a sleeve
# Half width and half depth of the skirt, by the share of the way from the waist to the hem.
SKIRT = np.array([[0.0, 0.187, 0.133], [0.25, 0.205, 0.155], [1.0, 0.360, 0.340]])
LEGS = 0.75  # share of a knee's motion that the skirt of a game's character follows
BODY_SPACING = 0.012  # metres


def dress_mesh() -> tuple[Array, Array]:
    """Points (n, 3) and quads (m, 4), normals outward."""
    shirt = demo_shirt.build_shirt()
    points, quads = shirt.points, shirt.quads
    for _ in range(ROWS):
        quads = quads[~np.isin(quads, _lowest_border(points, quads)).any(axis=1)]
    used, quads = np.unique(quads, return_inverse=True)
    points, quads = points[used], quads.reshape(-1, 4)
    ring = _lowest_border(points, quads)
    middle = points[ring, 1].mean()
    angle = np.arctan2((points[ring, 1] - middle) / SKIRT[0, 2], points[ring, 0] / SKIRT[0, 1])
    rows, first = [points], len(points)
    for share in np.arange(1, RINGS + 1) / RINGS:
        wide, deep = (np.interp(share, SKIRT[:, 0], SKIRT[:, column]) for column in (1, 2))
        height = points[ring, 2] * (1.0 - share) + HEM * share
        rows.append(np.stack([wide * np.cos(angle), middle + deep * np.sin(angle), height], axis=1))
    indices = np.concatenate([ring[None], first + np.arange(RINGS * len(ring)).reshape(RINGS, -1)])
    upper, lower = indices[:-1], indices[1:]
    skirt = np.stack([upper, lower, np.roll(lower, -1, axis=1), np.roll(upper, -1, axis=1)], axis=-1)
    return np.concatenate(rows), np.concatenate([quads, skirt.reshape(-1, 4)])


def _lowest_border(points: Array, quads: Array) -> Array:
    """Vertices of the open border of the trunk, counter-clockwise seen from above."""
    sides = np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2)
    edges, uses = np.unique(np.sort(sides, axis=1), axis=0, return_counts=True)
    border = np.unique(edges[uses == 1])
    ring = border[(points[border, 2] < CHEST) & (np.abs(points[border, 0]) < SLEEVES)]
    middle = points[ring, 1].mean()
    return ring[np.argsort(np.arctan2(points[ring, 1] - middle, points[ring, 0]))]


def skirt_weights(points: Array) -> dict[str, Array]:
    """As the shirt is skinned, and below the waist to hips and thighs. Weight of every bone, (n,) each."""
    below = smoothstep((1.0 - points[:, 2]) / 0.25)
    left = smoothstep(0.5 + points[:, 0] / 0.36)
    leg = LEGS * np.clip((1.0 - points[:, 2]) / 0.35, 0.0, 1.0)
    weights = {name: weight * (1.0 - below) for name, weight in demo_rig.skin_weights(points).items()}
    for name, weight in (("hips", 1.0 - leg), ("thigh.L", leg * left), ("thigh.R", leg * (1.0 - left))):
        weights[name] = weights.get(name, 0.0) + weight * below
    return weights


def build_dress_scene() -> bpy.types.Object:
    """The figure lifts an arm and crouches, as in the demo. Returns the dress."""
    skeleton, scene = demo_scene.build_figure(BODY_SPACING), bpy.context.scene
    performance = demo_rig.PERFORMANCE
    demo_rig.animate(skeleton, performance)
    scene.frame_start, scene.frame_end = performance[0].frame, performance[-1].frame
    points, quads = dress_mesh()
    dress = demo_scene.mesh_object("Dress", points, quads, ("Shirt cloth",))
    for name, weights in skirt_weights(points).items():
        group = dress.vertex_groups.new(name=name)
        for index in np.flatnonzero(weights > 1e-4).tolist():
            group.add([index], float(weights[index]), "REPLACE")
    dress.modifiers.new("Armature", "ARMATURE").object = skeleton
    dress.parent = skeleton
    demo_scene.add_camera_and_lights()
    bpy.context.view_layer.objects.active = dress
    scene.frame_set(scene.frame_start)
    return dress
