# SPDX-License-Identifier: GPL-3.0-or-later
"""Skeleton, skin weights and performance of the demo scene.

Weights are smooth functions of the rest position, so that the shirt and the
body under it move with one and the same field and keep their distance.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Sequence

import bpy
import numpy as np
from mathutils import Quaternion, Vector

import demo_body as body
from demo_body import Array
from interpolation import smoothstep

MAX_INFLUENCES = 4
# Metres: where the thigh begins in the middle of the body, how much lower that is for each metre to the back, over what
# length hips and thigh share; over what width the two legs do.
GROIN, GROIN_SLOPE, GROIN_WIDTH, CROTCH_WIDTH = 0.89, 0.5, 0.15, 0.06
ELBOW_HALF = 0.055  # metres; half length of the bone that shares the elbow's bend
KNEE_HALF = 0.060

# Stations of the two chains: bone, start, half width of the blend at its start.
# Heights in metres for the torso, distances from the shoulder for the arm.
TORSO_CHAIN = (
    ("hips", 0.62, 0.0), ("spine", 1.03, 0.11), ("chest", 1.20, 0.11),
    ("neck", 1.500, 0.035), ("head", 1.590, 0.035),
)
_U, _F = body.UPPER_ARM_LENGTH, body.FOREARM_LENGTH
ARM_CHAIN = (
    ("upper_arm", 0.0, 0.0), ("upper_arm_twist", 0.13, 0.085), ("elbow", _U - ELBOW_HALF, 0.080),
    ("forearm", _U + ELBOW_HALF, 0.080), ("forearm_twist", _U + 0.165, 0.05),
    ("hand", _U + _F, 0.04),
)
THIGH, SHIN = np.linalg.norm(body.KNEE - body.HIP), np.linalg.norm(body.ANKLE - body.KNEE)
LEG_CHAIN = (
    ("thigh", 0.0, 0.0), ("knee", THIGH - KNEE_HALF, 0.075), ("shin", THIGH + KNEE_HALF, 0.075),
    ("foot", THIGH + SHIN - 0.01, 0.035),
)
SIDES = {"L": 1.0, "R": -1.0}
_ACROSS = (-1.0, 0.0, 0.0)  # turns to the front, on both sides


def torso_joint(height: float) -> tuple[float, float, float]:
    """Point of the spine at a height."""
    return (0.0, float(np.interp(height, [0.9, 1.2, 1.45, 1.6], [0.02, 0.03, 0.03, 0.01])), height)


def bone_table() -> list[tuple[str, tuple, tuple, str | None]]:
    """All bones as name, head, tail, parent; parents come first."""
    bones, parent = [], None
    tops = [start for _, start, _ in TORSO_CHAIN[1:]] + [1.81]
    for (name, start, _), top in zip(TORSO_CHAIN, tops):
        bones.append((name, torso_joint(start), torso_joint(top), parent))
        parent = name
    ends = [start for _, start, _ in ARM_CHAIN[1:]] + [_U + _F + body.HAND_LENGTH]
    for side, sign in SIDES.items():
        mirror = np.array([sign, 1.0, 1.0])
        bones.append((f"clavicle.{side}", tuple(np.array([0.025, 0.0, 1.435]) * mirror),
                      tuple(body.SHOULDER * mirror), "chest"))
        parent = f"clavicle.{side}"
        for (name, start, _), end in zip(ARM_CHAIN, ends):
            head, tail = (tuple((body.SHOULDER + s * body.ARM_DIRECTION) * mirror)
                          for s in (start, end))
            bones.append((f"{name}.{side}", head, tail, parent))
            parent = f"{name}.{side}"
        stations = [start for _, start, _ in LEG_CHAIN] + [THIGH + SHIN + 0.1]
        parent = "hips"
        for (name, _, _), start, end in zip(LEG_CHAIN, stations, stations[1:]):
            bones.append((f"{name}.{side}", tuple(leg_joint(start) * mirror), tuple(leg_joint(end) * mirror), parent))
            parent = f"{name}.{side}"
    return bones


def leg_joint(distance: float) -> Array:
    """Point of the left leg's axis so many metres from the hip; beyond the ankle it goes on along the foot."""
    joints = np.array([body.HIP, body.KNEE, body.ANKLE, body.TOE])
    reached = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(joints, axis=0), axis=1))])
    return np.array([np.interp(distance, reached, joints[:, axis]) for axis in range(3)])


def chain_weights(chain: tuple, coordinate: Array) -> dict[str, Array]:
    """Partition of unity along a chain: smooth steps at the joints."""
    reached = [np.ones_like(coordinate)]
    reached += [smoothstep((coordinate - start) / (2.0 * half) + 0.5)
                for _, start, half in chain[1:]]
    reached.append(np.zeros_like(coordinate))
    return {name: reached[k] - reached[k + 1] for k, (name, _, _) in enumerate(chain)}


def skin_weights(points: Array) -> dict[str, Array]:
    """Weight of every bone at the rest positions; at most four each, sum 1."""
    p = points.copy()
    p[:, 0] = np.abs(p[:, 0])
    to_torso = np.minimum(body.torso_distance(p, body.BODY_TORSO), body.leg_distance(p))
    end = body.WRIST + body.HAND_LENGTH * body.ARM_DIRECTION
    to_arm = body.round_cone(p, body.SHOULDER, end, 0.051, 0.040)
    in_arm = smoothstep((to_torso - to_arm + 0.09) / 0.23)
    in_clavicle = 0.85 * smoothstep((p[:, 0] - 0.02) / 0.13) * smoothstep((p[:, 2] - 1.27) / 0.14)

    in_leg = smoothstep((GROIN - GROIN_SLOPE * p[:, 1] - p[:, 2]) / GROIN_WIDTH + 0.5)

    weights = {name: w * (1.0 - in_arm) * (1.0 - in_clavicle) * (1.0 - in_leg)
               for name, w in chain_weights(TORSO_CHAIN, points[:, 2]).items()}
    along = (p - body.SHOULDER) @ body.ARM_DIRECTION
    arm = {name: w * in_arm for name, w in chain_weights(ARM_CHAIN, along).items()}
    arm["clavicle"] = in_clavicle * (1.0 - in_arm)
    down = THIGH * share_along(p, body.HIP, body.KNEE) + SHIN * share_along(p, body.KNEE, body.ANKLE)
    leg = {name: w * in_leg * (1.0 - in_arm) for name, w in chain_weights(LEG_CHAIN, down).items()}
    for side, sign in SIDES.items():
        here = smoothstep(0.5 + sign * points[:, 0] / 0.01)
        weights.update({f"{name}.{side}": w * here for name, w in arm.items()})
        here = smoothstep(0.5 + sign * points[:, 0] / CROTCH_WIDTH)
        weights.update({f"{name}.{side}": w * here for name, w in leg.items()})
    return limited(weights)


def share_along(points: Array, start: Array, end: Array) -> Array:
    """(n,) how far along a bone the points lie, 0 to 1."""
    axis = end - start
    return np.clip((points - start) @ axis / (axis @ axis), 0.0, 1.0)


def limited(weights: dict[str, Array]) -> dict[str, Array]:
    """Keep the MAX_INFLUENCES largest weights of each point and renormalise."""
    table = np.stack(list(weights.values()), axis=1)
    smallest_kept = np.sort(table, axis=1)[:, -MAX_INFLUENCES]
    table[(table < smallest_kept[:, None]) | (table < 1e-4)] = 0.0
    table /= table.sum(axis=1, keepdims=True)
    return {name: table[:, k] for k, name in enumerate(weights)}


@dataclass(frozen=True)
class ArmPose:
    """Angles of one arm in degrees, relative to the A pose."""

    raise_side: float = 0.0  # away from the body, upwards
    swing_front: float = 0.0  # about the vertical, to the front
    twist: float = 0.0  # upper arm about its axis, inwards
    bend: float = 0.0  # elbow
    pronate: float = 0.0  # forearm about its axis, inwards
    flex: float = 0.0  # about the line through both shoulders, to the front


@dataclass(frozen=True)
class LegPose:
    """Angles of one leg in degrees."""

    thigh: float = 0.0  # to the front
    back: float = 0.0  # by which the shin leans back: the ankle is behind the knee
    toes: float = 0.0  # below the horizontal


@dataclass(frozen=True)
class Pose:
    """One key of the performance; degrees."""

    frame: int
    left: ArmPose = field(default_factory=ArmPose)
    right: ArmPose = field(default_factory=ArmPose)
    lean_side: float = 0.0  # to the figure's left
    lean_front: float = 0.0
    turn: float = 0.0  # to the figure's left
    nod: float = 0.0
    look: float = 0.0  # head about the vertical, to the figure's left
    crouch: float = 0.0  # thighs, to the front; the feet stay where they are
    left_leg: LegPose | None = None  # in place of the crouch: the lower foot stands on the ground
    right_leg: LegPose | None = None
    hop: float = 0.0  # metres above that

    @property
    def legs(self) -> tuple[LegPose, LegPose]:
        """Left and right."""
        crouching = LegPose(self.crouch, knee_bend(self.crouch)) if self.crouch else LegPose()
        return self.left_leg or crouching, self.right_leg or crouching


_REST_LEFT = ArmPose(raise_side=-19, swing_front=8, twist=8, bend=22, pronate=5)
_REST_RIGHT = ArmPose(raise_side=-19, swing_front=6, twist=8, bend=26, pronate=5)
PERFORMANCE = (
    Pose(1, _REST_LEFT, _REST_RIGHT),
    Pose(20, ArmPose(38, 28, -5, 30, -10), ArmPose(-18, 2, 5, 18, 5),
         lean_side=-5, turn=-8, nod=2, look=12, crouch=8),
    Pose(36, ArmPose(46, 30, -62, 102, -25), ArmPose(-16, 0, 4, 30, 10),
         lean_side=-8, lean_front=2, turn=-14, nod=-2, look=20),
    Pose(48, ArmPose(20, 52, 5, 102, 45), ArmPose(-16, 12, 8, 52, 20),
         lean_side=4, lean_front=14, turn=12, nod=2, look=-6, crouch=52),
    Pose(60, ArmPose(-8, 34, 14, 66, 30), ArmPose(-18, 10, 8, 40, 12),
         lean_side=3, lean_front=6, turn=9, nod=4, look=-4, crouch=20),
    Pose(72, _REST_LEFT, _REST_RIGHT),
)


def turn_about(axis: Array | tuple, degrees: float) -> Quaternion:
    """Rotation about an axis in armature space."""
    return Quaternion(Vector(axis), np.radians(degrees))


def arm_turns(pose: ArmPose, side: str) -> dict[str, Quaternion]:
    """Rotation of each bone of an arm, in armature space at rest.

    A mirrored rotation has its axis mirrored as an axial vector.
    """
    axial = np.array([1.0, -1.0, -1.0]) if side == "R" else np.ones(3)
    along = body.ARM_DIRECTION * axial
    hinge = np.cross(body.ARM_DIRECTION, [0.0, -1.0, 0.0]) * axial
    up, front = np.array([0.0, -1.0, 0.0]) * axial, np.array([0.0, 0.0, -1.0]) * axial
    swing = (turn_about(_ACROSS, pose.flex) @ turn_about(front, 0.85 * pose.swing_front)
             @ turn_about(up, 0.75 * pose.raise_side))
    return {
        f"clavicle.{side}": (turn_about(front, 0.15 * pose.swing_front)
                             @ turn_about(up, 0.25 * pose.raise_side)),
        f"upper_arm.{side}": swing @ turn_about(along, 0.4 * pose.twist),
        f"upper_arm_twist.{side}": turn_about(along, 0.6 * pose.twist),
        f"elbow.{side}": turn_about(hinge, 0.5 * pose.bend),
        f"forearm.{side}": turn_about(hinge, 0.5 * pose.bend),
        f"forearm_twist.{side}": turn_about(along, 0.6 * pose.pronate),
        f"hand.{side}": turn_about(along, 0.4 * pose.pronate),
    }


def pose_turns(pose: Pose) -> dict[str, Quaternion]:
    """Rotation of every moving bone, in armature space at rest."""
    turns = {}
    for bone, share in (("spine", 0.5), ("chest", 0.5)):
        turns[bone] = (turn_about((0, 0, 1), share * pose.turn)
                       @ turn_about((0, 1, 0), share * pose.lean_side)
                       @ turn_about((1, 0, 0), share * pose.lean_front))
    for bone, share in (("neck", 0.4), ("head", 0.6)):
        turns[bone] = (turn_about((0, 0, 1), share * pose.look)
                       @ turn_about((1, 0, 0), share * pose.nod))
    for leg, side in zip(pose.legs, SIDES):
        turns.update(leg_turns(leg, side))
    return {**turns, **arm_turns(pose.left, "L"), **arm_turns(pose.right, "R")}


def knee_bend(crouch: float) -> float:
    """Degrees by which the shin leans back: the ankle stays about below the hip."""
    return float(np.degrees(np.arcsin(THIGH * np.sin(np.radians(crouch)) / SHIN)))


def leg_turns(leg: LegPose, side: str) -> dict[str, Quaternion]:
    """Rotation of each bone of a leg, in armature space at rest."""
    half = turn_about(_ACROSS, -0.5 * (leg.thigh + leg.back))
    return {f"thigh.{side}": turn_about(_ACROSS, leg.thigh), f"knee.{side}": half, f"shin.{side}": half,
            f"foot.{side}": turn_about(_ACROSS, leg.back - leg.toes)}


def ankle_shift(leg: LegPose) -> Vector:
    """Where the ankle would go if the hips stayed, metres."""
    joints = [Vector(leg_joint(start)) for _, start, _ in LEG_CHAIN]
    bones = [after - before for before, after in zip(joints, joints[1:])]
    leaning = (leg.thigh, 0.5 * (leg.thigh - leg.back), -leg.back)  # thigh, knee, shin
    return sum((turn_about(_ACROSS, angle) @ bone - bone for bone, angle in zip(bones, leaning)), Vector())


def hips_shift(pose: Pose) -> Vector:
    """Where the hips go, metres, so that the lower foot stays on the ground; both feet where they stand alike."""
    left, right = (ankle_shift(leg) for leg in pose.legs)
    if pose.legs[0] == pose.legs[1]:
        return Vector((0.0, 0.0, pose.hop)) - left
    return Vector((0.0, 0.0, pose.hop - min(left.z, right.z)))


def build_armature(collection: bpy.types.Collection) -> bpy.types.Object:
    """Armature object "Skeleton" in rest pose. Bones can only be made in edit mode."""
    data = bpy.data.armatures.new("Skeleton")
    skeleton = bpy.data.objects.new("Skeleton", data)
    collection.objects.link(skeleton)
    bpy.context.view_layer.objects.active = skeleton
    bpy.ops.object.mode_set(mode="EDIT")
    for name, head, tail, parent in bone_table():
        bone = data.edit_bones.new(name)
        bone.head, bone.tail = head, tail
        bone.parent = data.edit_bones[parent] if parent else None
    bpy.ops.object.mode_set(mode="OBJECT")
    data.display_type = "STICK"
    skeleton.hide_render = True
    return skeleton


def animate(skeleton: bpy.types.Object, performance: Sequence[Pose] = PERFORMANCE) -> None:
    """Key a performance; neighbouring quaternions stay in one hemisphere."""
    last: dict[str, Quaternion] = {}
    for pose in performance:
        for name, turn in pose_turns(pose).items():
            bone = skeleton.pose.bones[name]
            rest = bone.bone.matrix_local.to_quaternion()
            value = rest.inverted() @ turn @ rest
            value.make_compatible(last.get(name, value))
            last[name] = value
            bone.rotation_mode = "QUATERNION"
            bone.rotation_quaternion = value
            bone.keyframe_insert("rotation_quaternion", frame=pose.frame)
        hips = skeleton.pose.bones["hips"]
        hips.location = hips.bone.matrix_local.to_3x3().inverted() @ hips_shift(pose)
        hips.keyframe_insert("location", frame=pose.frame)
    stand_between(skeleton, performance)


def stand_between(skeleton: bpy.types.Object, performance: Sequence[Pose]) -> None:
    """Key the hips between poses as well: the foot of a leg that bends rises with the cosine of the angle, not in step
    with hips that go down, and would go through the ground."""
    scene, hips = bpy.context.scene, skeleton.pose.bones["hips"]
    into_bone, found = hips.bone.matrix_local.to_3x3().inverted(), {}
    for before, after in zip(performance, performance[1:]):
        for frame in range(before.frame + 1, after.frame) if before.legs != after.legs else ():
            scene.frame_set(frame)
            off = [skeleton.pose.bones[f"foot.{side}"].head - skeleton.data.bones[f"foot.{side}"].head_local
                   for side in SIDES]
            alike = all(pose.legs[0] == pose.legs[1] for pose in (before, after))
            lower = off[0] if alike else Vector((0.0, 0.0, min(one.z for one in off)))
            found[frame] = hips.location - into_bone @ lower
    for frame, location in found.items():
        hips.location = location
        hips.keyframe_insert("location", frame=frame)


def skin(target: bpy.types.Object, points: Array, skeleton: bpy.types.Object, hangs: bool = False) -> None:
    """Vertex groups from skin_weights and an Armature modifier. hangs: legs that hang free of the feet."""
    weights = skin_weights(points)
    for side in SIDES if hangs else ():
        weights[f"shin.{side}"] += weights.pop(f"foot.{side}")
    for name, column in weights.items():
        members = np.flatnonzero(column > 0.0)
        if len(members) == 0:
            continue
        group = target.vertex_groups.new(name=name)
        for index in members.tolist():
            group.add([index], float(column[index]), "REPLACE")
    modifier = target.modifiers.new("Armature", "ARMATURE")
    modifier.object = skeleton
    target.parent = skeleton
