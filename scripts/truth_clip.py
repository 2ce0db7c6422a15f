# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples a scene for scripts/ground_truth: the garment's smooth fine surface and what it moves over, frame by frame.

All positions are in metres, float32. A clip starts in the armature's rest pose, blends to the pose of its first frame
and holds it, so that a simulation comes to rest before the clip itself begins. Its space moves with the speed that
the figure has at the clip's beginning: a walk from a standing start would fling a shirt's hem up by v^2 / 2g, 9 cm,
and what moves fast against the cloth's own space goes through it.
"""
from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
from interpolation import smoothstep
from mathutils import Matrix, Quaternion, Vector
from mathutils.bvhtree import BVHTree

NEAR = 0.04  # metres: a body so close counts as lying under the garment
SPEED_FRAMES = 8
DEEP = 0.008  # metres


@dataclass
class Surface:
    """A mesh that moves: faces stay, positions are one set a frame."""

    positions: np.ndarray  # (frames, n, 3) metres
    rest: np.ndarray  # (n, 3) metres, armature at rest
    starts: np.ndarray  # (m,) first corner of every face in corners
    corners: np.ndarray  # (c,) vertex indices, face after face


@dataclass
class Clip:
    """What a simulation starts from. Frame k of the arrays is the clip's first frame for k = lead."""

    garment: Surface  # smooth: subdivided after the skin
    patch: np.ndarray  # (m,) coarse polygon of every face of the garment
    coarse: Surface  # the garment as it is in the file; positions only at rest
    inner: Surface  # the garment again, subdivided once less: stands in for a missing body when it is shrunk
    bodies: list[Surface]  # what the garment collides with
    lead: int
    frames: range
    fps: float
    speed: np.ndarray  # (3,) metres a frame, of the clip's space


def skinned_by(thing: bpy.types.Object) -> bpy.types.Object | None:
    """The armature that deforms a mesh object."""
    for modifier in thing.modifiers:
        if modifier.type == "ARMATURE" and modifier.object is not None:
            return modifier.object
    return None


def find_garment(name: str | None) -> bpy.types.Object:
    """The mesh object of that name, upper or lower case alike, or the only one that is named like a shirt."""
    meshes = [o for o in bpy.data.objects if o.type == "MESH" and skinned_by(o) is not None]
    wanted = (name or "shirt").lower()
    for thing in meshes:
        if thing.name.lower() == wanted:
            return thing
    raise SystemExit(f"there is no skinned mesh named {wanted}; this file has: {', '.join(o.name for o in meshes)}")


def find_bodies(garment: bpy.types.Object) -> list[bpy.types.Object]:
    """The body: the largest other mesh on the same armature. Other garments are no obstacle, even where they lie
    under this one: they fit it so closely that a simulated shirt is stretched over the hips, and creeps up."""
    others = [o for o in bpy.data.objects
              if o.type == "MESH" and o is not garment and skinned_by(o) is skinned_by(garment)]
    if not others:
        raise SystemExit(f"there is no body: no other mesh is skinned by the armature of {garment.name}")
    return [max(others, key=lambda o: len(o.data.vertices))]


def evaluated_positions(thing: bpy.types.Object) -> np.ndarray:
    """(n, 3) float32, world space, metres, as the modifiers leave the mesh now."""
    shown = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    flat = np.empty(3 * len(shown.data.vertices), np.float32)
    shown.data.vertices.foreach_get("co", flat)
    return in_world(thing, flat.reshape(-1, 3))


def in_world(thing: bpy.types.Object, points: np.ndarray) -> np.ndarray:
    """Points (n, 3) of an object's space in world space, metres."""
    world = np.array(thing.matrix_world, np.float32)
    scale = bpy.context.scene.unit_settings.scale_length or 1.0
    return (points @ world[:3, :3].T + world[:3, 3]) * np.float32(scale)


def faces_of(mesh: bpy.types.Mesh) -> tuple[np.ndarray, np.ndarray]:
    """First corners (m,) and corners (c,) of a mesh's polygons, int32."""
    starts = np.empty(len(mesh.polygons), np.int32)
    corners = np.empty(len(mesh.loops), np.int32)
    mesh.polygons.foreach_get("loop_start", starts)
    mesh.loops.foreach_get("vertex_index", corners)
    return starts, corners


def triangles_of(starts: np.ndarray, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Fans: (t, 3) vertex indices and (t,) the face that each triangle is part of, int32."""
    sizes = np.diff(np.append(starts, len(corners)))
    face = np.repeat(np.arange(len(starts)), sizes - 2)
    number = np.arange(len(face)) - np.repeat(np.cumsum(sizes - 2) - (sizes - 2), sizes - 2)
    first = starts[face]
    fans = np.stack([corners[first], corners[first + number + 1], corners[first + number + 2]], 1)
    return fans.astype(np.int32), face.astype(np.int32)


def covered(clip: Clip) -> float:
    """Share of the coarse garment's vertices that have the body within NEAR below them, at rest."""
    body = clip.bodies[0]
    ends = np.append(body.starts, len(body.corners))
    tree = BVHTree.FromPolygons(body.rest.tolist(), [body.corners[a:b].tolist() for a, b in zip(ends[:-1], ends[1:])])
    return float(np.mean([tree.find_nearest(p, NEAR)[0] is not None for p in clip.coarse.rest.tolist()]))


def through(clip: Clip, positions: np.ndarray) -> np.ndarray:
    """(frames,) share of the cloth's vertices (frames, n, 3), those of the clip without its lead, that lie deeper than
    DEEP in the body: where this grows, a limb has come through the cloth, though its cuff is in place."""
    body = clip.bodies[0]
    triangles = triangles_of(body.starts, body.corners)[0].tolist()
    shares = []
    for cloth, skin in zip(positions, body.positions[clip.lead:]):
        tree = BVHTree.FromPolygons(skin.tolist(), triangles)
        found = [(point, *tree.find_nearest(point, NEAR)[:2]) for point in cloth.tolist()]
        shares.append(np.mean([hit is not None and (Vector(p) - hit).dot(normal) < -DEEP for p, hit, normal in found]))
    return np.array(shares)


class Poses:
    """The armature's pose between rest and the clip's first frame. Bones without a parent keep that frame's pose:
    then the figure stands where the clip begins, and nothing is dragged through the room."""

    def __init__(self, armature: bpy.types.Object, first: int) -> None:
        bpy.context.scene.frame_set(first)
        self.armature = armature
        self.bones = {bone.name: bone.matrix_basis.decompose() for bone in armature.pose.bones}

    def show(self, share: float) -> None:
        """Pose the armature: 0 rest, 1 the first frame; its action must not be linked."""
        rest = (Vector(), Quaternion(), Vector((1.0, 1.0, 1.0)))
        for bone in self.armature.pose.bones:
            place, turn, size = self.bones[bone.name]
            part = share if bone.parent is not None else 1.0
            bone.matrix_basis = Matrix.LocRotScale(
                rest[0].lerp(place, part), rest[1].slerp(turn, part), rest[2].lerp(size, part))
        bpy.context.view_layer.update()


def moving_space(surfaces: list[Surface], lead: int) -> np.ndarray:
    """Take the speed out of the clip with which it begins, that of the first surface's middle over a few frames.
    The speed (3,), metres a frame: world positions are those of the clip and the speed times the clip's frames."""
    middle = surfaces[0].positions[lead:lead + SPEED_FRAMES + 1].mean(1, dtype=np.float64)
    speed = (middle[-1] - middle[0]) / max(len(middle) - 1, 1)
    for surface in surfaces:
        clip = surface.positions[lead:]
        clip -= travelled(speed, len(clip))
    return speed


def travelled(speed: np.ndarray, frames: int) -> np.ndarray:
    """(frames, 1, 3) float32 metres from the first of some frames on."""
    return (np.arange(frames)[:, None, None] * speed).astype(np.float32)


def subdivided(garment: bpy.types.Object, levels: int) -> None:
    """Leave only what deforms the garment, then Subdivision; every face remembers its coarse polygon."""
    for modifier in garment.modifiers:
        if modifier.type != "ARMATURE":
            modifier.show_viewport = False
    attribute = garment.data.attributes.new("coarse", "INT", "FACE")
    attribute.data.foreach_set("value", np.arange(len(garment.data.polygons), dtype=np.int32))
    fine = garment.modifiers.new("Fine", "SUBSURF")
    fine.levels = levels


def surface_at_rest(thing: bpy.types.Object) -> Surface:
    """Faces and rest positions; the armature must be at rest."""
    rest = evaluated_positions(thing)
    shown = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return Surface(np.empty((0, *rest.shape), np.float32), rest, *faces_of(shown.data))


def sample(garment: bpy.types.Object, frames: range, levels: int, blend: int, settle: int) -> Clip:
    """The whole clip after `blend` frames from the rest pose to its first and `settle` frames in that."""
    scene = bpy.context.scene
    armature = skinned_by(garment)
    bodies = find_bodies(garment)
    armature.data.pose_position = "REST"
    bpy.context.view_layer.update()
    for modifier in garment.modifiers:
        modifier.show_viewport = modifier.type == "ARMATURE"
    coarse = surface_at_rest(garment)
    subdivided(garment, levels)
    inner = garment.copy()
    scene.collection.objects.link(inner)
    inner.modifiers["Fine"].levels = levels - 1
    things = [garment, inner, *bodies]
    surfaces = [surface_at_rest(thing) for thing in things]
    shown = garment.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    patch = np.empty(len(shown.polygons), np.int32)
    shown.attributes["coarse"].data.foreach_get("value", patch)
    armature.data.pose_position = "POSE"

    taken: list[list[np.ndarray]] = [[] for _ in things]
    poses = Poses(armature, frames[0])
    action, armature.animation_data.action = armature.animation_data.action, None
    for number in range(blend + settle):
        poses.show(smoothstep(number / blend))
        for row, thing in zip(taken, things):
            row.append(evaluated_positions(thing))
    armature.animation_data.action = action
    for frame in frames:
        scene.frame_set(frame)
        for row, thing in zip(taken, things):
            row.append(evaluated_positions(thing))
    for surface, row in zip(surfaces, taken):
        surface.positions = np.stack(row)
    speed = moving_space(surfaces, blend + settle)
    return Clip(surfaces[0], patch, coarse, surfaces[1], surfaces[2:], blend + settle, frames,
                scene.render.fps / scene.render.fps_base, speed)
