# SPDX-License-Identifier: GPL-3.0-or-later
"""Reference poses of shape keys: their weights, their JSON, and the masks of a frame, without Blender."""
from __future__ import annotations

import json
import unittest

import numpy as np
from rumple.core.base.wording import UserError
from rumple.core.systems import poses_json
from rumple.core.systems.poses import PoseComparison, PoseRig, ReferencePose, SkinWeights, TrackedBone, TrackedKey
from rumple.core.systems.shape_keys import STILL, weights_of_key, with_keys
from support import changed_json

NAMES = ("brow.L", "brow.R", "jaw", "snarl")


def values(*numbers: float) -> np.ndarray:
    return np.array(numbers, np.float32)


def rig_of(bones: int = 0) -> PoseRig:
    """Two poses of four keys, and of some bones that both move."""
    random = np.random.default_rng(4)
    neutral = random.uniform(-0.1, 0.1, (bones, 6)).astype(np.float32)
    places = [neutral + random.uniform(0.005, 0.01, (bones, 6)).astype(np.float32) for _ in range(2)]
    return PoseRig("Face", "head" if bones else "", [TrackedBone(f"bone{i}") for i in range(bones)], neutral,
                   [ReferencePose("Surprise", places[0], keys=values(1, 1, 0.5, 0)),
                    ReferencePose("Anger", places[1], keys=values(-0.5, -0.5, 0, 1))],
                   keys=[TrackedKey(name) for name in NAMES], neutral_keys=values(0, 0, 0, 0))


def skin(count: int, bones: int, seed: int = 5) -> SkinWeights:
    """Of n vertices: up to two bones each, and keys that overlap."""
    random = np.random.default_rng(seed)
    counts = random.integers(0, 3, count) if bones else np.zeros(count, int)
    given = SkinWeights(np.concatenate([[0], np.cumsum(counts)]).astype(np.int32),
                        random.integers(-1, max(bones, 1), counts.sum()).astype(np.int32),
                        random.uniform(0.1, 1.0, counts.sum()).astype(np.float32))
    return with_keys(given, [np.maximum(random.uniform(-1, 1, count), 0.0).astype(np.float32) for _ in NAMES], bones)


class Weights(unittest.TestCase):
    def test_the_farthest_has_one_and_what_stays_has_none(self) -> None:
        ways = np.zeros((5, 3))
        ways[:, 2] = 0.0, 0.5e-3 * STILL, -1e-3, 2e-3, 1e-3
        weights = weights_of_key(ways)
        half = (0.5 - STILL) / (1.0 - STILL)
        np.testing.assert_allclose(weights, [0.0, 0.0, half, 1.0, half], atol=1e-7)

    def test_size_and_turn_of_the_face_change_nothing(self) -> None:
        ways = np.random.default_rng(0).normal(size=(50, 3))
        turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
        np.testing.assert_allclose(weights_of_key(1e-3 * ways @ turn), weights_of_key(ways), atol=1e-6)

    def test_a_key_without_a_shape_moves_nothing(self) -> None:
        for ways in (np.zeros((3, 3)), np.full((3, 3), np.nan), np.zeros((0, 3))):
            np.testing.assert_array_equal(weights_of_key(ways), np.zeros(len(ways)))

    def test_keys_stand_behind_the_bones_of_every_vertex(self) -> None:
        bones = SkinWeights(np.array([0, 2, 2, 3], np.int32), np.array([1, -1, 0], np.int32), values(0.25, 0.75, 1))
        both = with_keys(bones, [values(0, 0.5, 1), values(1, 0, 0.125)], 2)
        np.testing.assert_array_equal(both.start, [0, 3, 4, 7])
        np.testing.assert_array_equal(both.bone, [1, -1, 3, 2, 0, 2, 3])
        np.testing.assert_array_equal(both.weight, values(0.25, 0.75, 1, 0.5, 1, 1, 0.125))
        without = with_keys(bones, [], 2)
        np.testing.assert_array_equal(without.bone, bones.bone)
        np.testing.assert_array_equal(without.start, bones.start)


class Json(unittest.TestCase):
    def test_reading_gives_back_every_bit(self) -> None:
        for bones in (0, 3):
            rig = rig_of(bones)
            rig.keys[1].group = "brows"
            rig.neutral_keys = values(0.1, 0, 0, 1 / 3)
            read = poses_json.from_json(rig.to_json())
            self.assertEqual(read.keys, rig.keys)
            np.testing.assert_array_equal(read.neutral_keys, rig.neutral_keys)
            for one, other in zip(read.poses, rig.poses):
                np.testing.assert_array_equal(one.keys, other.keys)
                np.testing.assert_array_equal(one.bones, other.bones)
            self.assertEqual(read.to_json(), rig.to_json())

    def test_files_of_bones_alone_are_what_they_were(self) -> None:
        """An engine that reads version 1 knows no keys."""
        rig = rig_of(3)
        self.assertEqual(json.loads(rig.to_json())["version"], 2)
        rig.keys, rig.neutral_keys = [], values()
        for pose in rig.poses:
            pose.keys = values()
        text = rig.to_json()
        self.assertEqual(json.loads(text)["version"], 1)
        self.assertNotIn("keys", text)
        self.assertEqual(poses_json.from_json(text).keys, [])

    def test_an_engine_that_follows_the_page_gets_the_same_influences(self) -> None:
        rig = rig_of(0)
        rig.neutral_keys = values(0.2, 0, 0, 0)
        rig.keys[0].group = rig.keys[1].group = "brows"
        now = values(0.6, 0.25, 3.0, -1.0)
        data = json.loads(rig.to_json())
        influence = np.zeros((4, 2))
        for i, key in enumerate(data["keys"]):
            for k, pose in enumerate(data["poses"]):
                way = pose["keys"][i]["value"] - key["value"]
                if pose["keys"][i]["moves"]:
                    influence[i, k] = min(max((float(now[i]) - key["value"]) / way, 0.0), 1.0)
        influence[:2] = influence[:2].mean(0)
        comparison = PoseComparison.build(rig, skin(40, 0))
        np.testing.assert_allclose(comparison.frame(rig.neutral, keys=now).influence, influence, atol=1e-6)
        self.assertFalse(data["poses"][1]["keys"][2]["moves"])

    def test_whatever_stands_in_its_keys_is_read_or_refused(self) -> None:
        good = rig_of(1).to_json()
        wrong = [None, True, "1", 5, 1e300, [], {}, ["x"], [{}], "\ud800", "a" * 2000]
        places = "keys keys.0 keys.0.name keys.0.group keys.0.value poses.0.keys poses.0.keys.1 poses.0.keys.0.value"
        taken = changed_json.taken(self, good, [(path, value) for path in places.split() for value in wrong])
        self.assertEqual(taken, {("keys.0.name", "1"), ("keys.0.group", "1"), ("keys.0.value", "5"),
                                 ("poses.0.keys.0.value", "5")})


class Frames(unittest.TestCase):
    def test_one_brow_leaves_the_other_alone(self) -> None:
        comparison = PoseComparison.build(rig_of(), with_keys(
            SkinWeights(np.zeros(4, np.int32), np.zeros(0, np.int32), values()),
            [values(1, 0, 0), values(0, 1, 0), values(0, 0, 1), values(0.5, 0.5, 0)], 0))
        nobody = np.zeros((0, 6), np.float32)
        raised = comparison.frame(nobody, keys=values(1, 0, 0, 0))
        np.testing.assert_array_equal(raised.pose, [[1, 0, 0], [0, 0, 0]])
        np.testing.assert_array_equal(comparison.frame(nobody, keys=values(0, 0, 0, 0)).pose, np.zeros((2, 3)))

    def test_what_the_nodes_compute_with_gives_the_same_masks(self) -> None:
        """blender/nodes/maps_mask_tree.py in NumPy, of bones and keys together."""
        random = np.random.default_rng(6)
        for bones in (0, 3):
            rig = rig_of(bones)
            rig.keys[0].group = rig.keys[1].group = "brows"
            comparison = PoseComparison.build(rig, skin(60, bones))
            keys = random.uniform(-0.5, 1.2, 4).astype(np.float32)
            now = rig.neutral + random.uniform(-0.01, 0.01, rig.neutral.shape).astype(np.float32)
            places = np.concatenate([now, np.pad(keys[:, None], ((0, 0), (0, 5)))])
            influence = np.clip((comparison.slopes() * (places - comparison.neutral())).sum(2), 0.0, 1.0)
            number = rig.group_numbers()
            group = [np.flatnonzero(number == g) if g >= 0 else [i] for i, g in enumerate(number)]
            influence = comparison.shares() * np.stack([influence[:, members].sum(1) for members in group], 1)
            table = comparison.table()
            for gain in (0.5, 1.0, 3.0):
                weight = table.weight[:, :, None] * comparison.lifts(gain, [1.0, 0.5]).T[table.vertex][:, None]
                rows = (weight * influence.T[table.bone]).sum(1)
                summed = rows[:60] + sum(np.where(more[:, None] < 0, 0.0, rows[more]) for more in table.more)
                expected = comparison.frame(now, gain, [1.0, 0.5], keys)
                np.testing.assert_allclose(influence.T, expected.influence, atol=1e-5)
                np.testing.assert_allclose(np.minimum(summed.T, 1.0), expected.pose, atol=1e-5)
            self.assertGreater(comparison.model.reach.max(), 1.0)

    def test_faces_without_bones_lack_no_skin_weights(self) -> None:
        none = SkinWeights(np.zeros(3, np.int32), np.zeros(0, np.int32), values())
        keys = [values(1, 0)] * 4
        self.assertEqual(PoseComparison.build(rig_of(0), with_keys(none, keys, 0)).warnings, [])
        self.assertIn("1 vertices have no skin weight", PoseComparison.build(rig_of(1), with_keys(none, keys, 1)
                                                                             ).warnings[0])

    def test_equal_poses_and_repeated_keys_are_refused_by_name(self) -> None:
        rig = rig_of()
        rig.poses[1].keys = rig.poses[0].keys
        with self.assertRaisesRegex(UserError, "Face: pose Anger: every bone and shape key stands as in pose Surprise"):
            PoseComparison.build(rig, SkinWeights.none())
        rig.poses[1].keys = rig.neutral_keys
        with self.assertRaisesRegex(UserError, "Face: pose Anger: no bone and no shape key moves"):
            PoseComparison.build(rig, SkinWeights.none())
        rig.keys[1].name = "brow.L"
        with self.assertRaisesRegex(UserError, "two shape keys are called brow.L"):
            rig.check()


if __name__ == "__main__":
    unittest.main()
