# SPDX-License-Identifier: GPL-3.0-or-later
"""What the figure of the demo does in scenes of the gallery. Frames count from 1, 24 a second; angles in degrees."""
from __future__ import annotations

import math

from demo_rig import ArmPose, LegPose, Pose, knee_bend
from interpolation import smoothstep

HANGING = ArmPose(raise_side=-19, swing_front=8, twist=8, bend=22, pronate=5)
FRAMES_PER_SECOND = 24.0

# Sit down and get up.
SIT_FRAMES = (1, 84)
SEATED = LegPose(thigh=83.0)
SIT_HELD = (34, 54)  # frames
_DOWN, _UP = (6.0, SIT_HELD[0]), (SIT_HELD[1], 80.0)

# Run.
RUN_FRAMES = (1, 84)
STRIDE = 2.1  # metres, of two steps
RUN_SPEED, RUN_START = 3.0, 20.0  # metres a second; frames until that is reached


def sit() -> list[Pose]:
    """Down on a seat, rest there, and up again; the feet stay where they are."""
    poses = []
    for frame in range(SIT_FRAMES[0], SIT_FRAMES[1] + 1, 2):
        down = smoothstep((frame - _DOWN[0]) / (_DOWN[1] - _DOWN[0])) - smoothstep((frame - _UP[0]) / (_UP[1] - _UP[0]))
        bent = math.sin(math.pi * down)
        leg = LegPose(SEATED.thigh * down, 16.0 * bent + SEATED.back * down)
        arm = ArmPose(-19 + 3 * down, 8, 8 + 14 * down, 22 + 22 * down, 5 + 20 * down, 22 * down + 16 * bent)
        poses.append(Pose(frame, arm, arm, lean_front=34 * bent + 2 * down, nod=-14 * bent, left_leg=leg,
                          right_leg=leg))
    return poses


def twist() -> list[Pose]:
    """The torso turns to one side and to the other, the arms go along."""
    def pose(frame: int, turn: float) -> Pose:
        out = abs(turn) / 44.0
        left, right = (ArmPose(-19 + 34 * out, 8 + 22 * out + side * turn / 5, 8, 22 + 44 * out, 5)
                       for side in (-1.0, 1.0))
        return Pose(frame, left, right, turn=turn, look=0.35 * turn, crouch=6 * out)
    return [pose(frame, turn) for frame, turn in ((1, 0), (20, 44), (28, 44), (52, -44), (60, -44), (78, 0))]


def shift_weight() -> list[Pose]:
    """Knees that bend, the weight on one leg and on the other."""
    def pose(frame: int, left: float, right: float) -> Pose:
        arms = [ArmPose(-4, 14, 8, 34, 5, 0.3 * thigh) for thigh in (right, left)]
        legs = [LegPose(thigh, knee_bend(thigh)) for thigh in (left, right)]
        return Pose(frame, *arms, lean_side=0.2 * (left - right), lean_front=0.125 * (left + right),
                    turn=0.25 * (left - right), left_leg=legs[0], right_leg=legs[1])
    return [pose(frame, *thighs) for frame, thighs in ((1, (2, 2)), (16, (50, 28)), (22, (50, 28)), (36, (16, 16)),
                                                       (52, (28, 50)), (58, (28, 50)), (72, (2, 2)))]


def bend_elbow() -> list[Pose]:
    """The left forearm goes up and comes down again; the upper arm rises a little."""
    up = ArmPose(10, 30, 0, 118, 10, 18)
    return [Pose(1, ArmPose(6, 26, 0, 12, 0), HANGING), Pose(26, up, HANGING, turn=-4), Pose(36, up, HANGING, turn=-4),
            Pose(60, ArmPose(6, 26, 0, 12, 0), HANGING)]


def run_speed(frame: float) -> float:
    """Share of RUN_SPEED."""
    return smoothstep((frame - 1.0) / RUN_START)


def run_distance(frame: float) -> float:
    """Metres of ground that have gone by."""
    started = min(frame - 1.0, RUN_START) / RUN_START
    # The integral of smoothstep() over the first frames, and full speed behind them.
    seconds = (RUN_START * (started**3 - 0.5 * started**4) + max(frame - 1.0 - RUN_START, 0.0)) / FRAMES_PER_SECOND
    return RUN_SPEED * seconds


def run() -> list[Pose]:
    """From a stand into a run, in place."""
    return [run_pose(frame) for frame in range(RUN_FRAMES[0], RUN_FRAMES[1] + 1)]


def run_pose(frame: int) -> Pose:
    phase, speed = 2.0 * math.pi * run_distance(frame) / STRIDE, run_speed(frame)
    legs = [run_leg(phase + side, speed) for side in (0.0, math.pi)]
    swing = 34.0 * speed * math.cos(phase)
    arms = [ArmPose(-19, 10, 8, 22 + 58 * speed, 5, way * swing + 8 * speed) for way in (-1.0, 1.0)]
    # Both feet leave the ground twice a stride.
    return Pose(frame, *arms, lean_front=9 * speed, turn=7 * speed * math.cos(phase), nod=-5 * speed,
                look=-4 * speed * math.cos(phase), left_leg=legs[0], right_leg=legs[1],
                hop=0.045 * speed * math.sin(phase)**2)


def run_leg(phase: float, speed: float) -> LegPose:
    """phase: 0 where the thigh is farthest in front; the leg is on the ground in the first half."""
    thigh = speed * (12.0 + 30.0 * math.cos(phase))
    folded = max(-math.sin(phase), 0.0) ** 1.3  # under the body, on its way to the front
    bend = speed * (22.0 + 64.0 * folded)
    return LegPose(thigh, bend - thigh, speed * (30.0 * max(-math.cos(phase), 0.0) + 22.0 * folded))
