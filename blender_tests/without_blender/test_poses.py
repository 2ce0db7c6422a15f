# SPDX-License-Identifier: GPL-3.0-or-later
"""Reference poses as data: their JSON, what they refuse, and the masks of a frame."""
from __future__ import annotations

import json
import unittest
from dataclasses import replace

import numpy as np
from rumple.core.base.wording import UserError
from rumple.core.systems import poses, poses_json
from rumple.core.systems.poses import PoseComparison, PoseRig, ReferencePose, SkinWeights, TrackedBone
from support import changed_json


def face(pose_count: int = 2, bone_count: int = 4, seed: int = 0) -> PoseRig:
    """Bones of a face, all of which move in every pose."""
    random = np.random.default_rng(seed)
    neutral = random.uniform(-0.1, 0.1, (bone_count, 6)).astype(np.float32)
    made = [ReferencePose(f"pose {k}", neutral + random.uniform(0.005, 0.01, (bone_count, 6)).astype(np.float32),
                          f"pose{k}.png") for k in range(pose_count)]
    return PoseRig("Face", "head", [TrackedBone(f"bone{i}") for i in range(bone_count)], neutral, made)


def one_bone_each(bone_count: int) -> SkinWeights:
    return SkinWeights(np.arange(bone_count + 1, dtype=np.int32), np.arange(bone_count, dtype=np.int32),
                       np.ones(bone_count, np.float32))


class Json(unittest.TestCase):
    def test_reading_gives_back_every_bit(self) -> None:
        rig = face(3)
        rig.bones[1] = TrackedBone("brow.L", "TAIL", "brows")
        rig.poses[1].strength = 0.3
        rig.maps, rig.gain, rig.neutral_map = "WHOLE", 2.5, "face.png"
        read = poses_json.from_json(rig.to_json())
        np.testing.assert_array_equal(read.neutral, rig.neutral)
        for one, other in zip(read.poses, rig.poses):
            np.testing.assert_array_equal(one.bones, other.bones)
            self.assertEqual((one.name, one.map, one.strength), (other.name, other.map, other.strength))
        self.assertEqual((read.bones, read.root, read.maps, read.gain, read.neutral_map),
                         (rig.bones, rig.root, rig.maps, rig.gain, rig.neutral_map))
        self.assertEqual(read.to_json(), rig.to_json())

    def test_an_engine_that_follows_the_page_gets_the_same_influences(self) -> None:
        """docs/wrinkle_maps.md, in plain Python: nothing but the JSON and the present heads and tails."""
        rig = face(3)
        rig.bones[0].tracked, rig.bones[1].tracked = "HEAD", "TAIL"
        rig.bones[2].group = rig.bones[3].group = "brows"
        random = np.random.default_rng(1)
        now = rig.neutral + random.uniform(-0.01, 0.01, rig.neutral.shape).astype(np.float32)
        rig.poses[2].bones[0] = rig.neutral[0] + 0.05 * (rig.poses[0].bones[0] - rig.neutral[0])     # passed by
        data = json.loads(rig.to_json())
        slices = dict(head=slice(0, 3), tail=slice(3, 6), both=slice(0, 6))
        influence = np.zeros((4, 3))
        for i, bone in enumerate(data["bones"]):
            for k, pose in enumerate(data["poses"]):
                part = slices[bone["tracked"]]
                rest = np.array(bone["head"] + bone["tail"])[part]
                way = np.array(pose["bones"][i]["head"] + pose["bones"][i]["tail"])[part] - rest
                if pose["bones"][i]["moves"]:
                    influence[i, k] = min(max(sum((now[i, part] - rest) * way) / sum(way * way), 0.0), 1.0)
        influence[2:] = influence[2:].mean(0)
        self.assertFalse(data["poses"][2]["bones"][0]["moves"])
        masks = PoseComparison.build(rig, one_bone_each(4)).frame(now)
        np.testing.assert_allclose(masks.influence, influence, atol=1e-6)
        np.testing.assert_allclose(masks.pose, influence.T, atol=1e-6)

    def test_what_is_not_such_a_file_is_refused_in_words(self) -> None:
        good = json.loads(face().to_json())
        for change, word in ((dict(format="gltf"), "not a file"), (dict(version=3), "version 3"),
                             (dict(maps="colour"), "COLOUR"), (dict(gain=1000), "gain"), (dict(bones=5), "read")):
            with self.assertRaisesRegex(UserError, word):
                poses_json.from_json(json.dumps({**good, **change}))
        with self.assertRaisesRegex(UserError, "lack 'root'"):
            poses_json.from_json(json.dumps({key: value for key, value in good.items() if key != "root"}))
        good["poses"][1]["bones"].pop()
        with self.assertRaisesRegex(UserError, "pose 2, pose 1: expected 4 bones, got 3"):
            poses_json.from_json(json.dumps(good))
        with self.assertRaisesRegex(UserError, "cannot be read"):
            poses_json.from_json("{")

    def test_whatever_stands_in_it_is_read_or_refused_and_nothing_else_is_raised(self) -> None:
        # A strength of "1", a gain of null, a surrogate, deep nesting, 5,000 digits escaped as other exceptions, and a
        # map outside of the folder was taken.
        good = face().to_json()
        wrong = [None, True, "1", "x", 5, -1, 1e300, [], [1], {}, ["x"], "\ud800", "a" * 2000, "9" * 30]
        places = ("name root maps neutral_map gain bones poses version bones.0.name bones.0.tracked bones.0.group "
                  "bones.0.head bones.0.tail poses.0.name poses.0.map poses.0.strength poses.0.bones "
                  "poses.0.bones.0.tail bones.0 poses.0").split()
        changes = [(path, value) for path in places for value in wrong]
        paths = ("../x.png", "../../etc/x", "/etc/passwd", "a/b.png", "..\\x", "C:x", "..", "a\0b")
        changes += [(path, value) for path in ("poses.0.map", "neutral_map") for value in paths]
        texts = {path for path in ("name", "root", "bones.0.name", "bones.0.group", "poses.0.name", "poses.0.map",
                                   "neutral_map")}
        wanted = {(path, value) for path in texts for value in ("1", "x", "9" * 10)}
        self.assertEqual(changed_json.taken(self, good, changes), wanted | {("gain", "5"), ("poses", "[]")})
        gains = [good.replace('"gain": 1.0', f'"gain": {gain}') for gain in ("9" * 5000, "NaN", "Infinity")]
        for text in ("", "null", "[" * 200_000, '{"a":' * 200_000, *gains):
            with self.assertRaises(UserError):
                poses_json.from_json(text)


class Checks(unittest.TestCase):
    def refused(self, rig: PoseRig, word: str) -> None:
        with self.assertRaisesRegex(UserError, word):
            PoseComparison.build(rig, one_bone_each(len(rig.bones)))

    def test_names_must_be_given_once(self) -> None:
        rig = face()
        self.refused(replace(rig, bones=[TrackedBone("a"), TrackedBone("b"), TrackedBone("a"), TrackedBone("c")]),
                     "Face: two bones are called a")
        rig.poses[1].name = rig.poses[0].name
        self.refused(rig, "two poses are called pose 0")
        rig.poses[1].name = ""
        self.refused(rig, "pose 2 has no name")
        rig.poses[1].name = "ü" * 25
        self.refused(rig, "longer than 48 bytes")

    def test_values_out_of_range_are_named(self) -> None:
        rig = face()
        self.refused(replace(rig, gain=0.0), "gain: expected 0.1 to 100, got 0")
        rig.bones[1].tracked = "MIDDLE"
        self.refused(rig, "bone bone1: tracked: expected one of HEAD, TAIL, BOTH, got MIDDLE")
        rig.bones[1].tracked = "BOTH"
        rig.poses[0].strength = 2.0
        self.refused(rig, "strength of pose pose 0")
        self.refused(face(17), "17 reference poses")

    def test_equal_poses_are_refused_by_name(self) -> None:
        rig = face()
        rig.poses[1].bones = rig.poses[0].bones.copy()
        self.refused(rig, "Face: pose pose 1: every bone stands as in pose pose 0")
        rig.poses[1].bones = rig.neutral.copy()
        self.refused(rig, "Face: pose pose 1: no bone moves")

    def test_weights_that_do_not_sum_to_one_are_counted(self) -> None:
        weights = one_bone_each(4)
        weights.weight[1:3] = 2.0, 0.0
        warnings = PoseComparison.build(face(), weights).warnings
        self.assertEqual(len(warnings), 2)
        self.assertIn("weights of 1 vertices do not sum to 1", warnings[0])
        self.assertIn("1 vertices have no skin weight", warnings[1])


class Frames(unittest.TestCase):
    def test_mute_and_solo(self) -> None:
        rig = face(3)
        self.assertEqual(poses.strengths(rig.poses), [1.0, 1.0, 1.0])
        rig.poses[0].muted, rig.poses[1].strength = True, 0.5
        self.assertEqual(poses.strengths(rig.poses), [0.0, 0.5, 1.0])
        rig.poses[1].solo = True
        self.assertEqual(poses.strengths(rig.poses), [0.0, 0.5, 0.0])
        masks = PoseComparison.build(rig, one_bone_each(4)).frame(rig.poses[1].bones)
        np.testing.assert_array_equal(masks.pose[1], np.full(4, 0.5, np.float32))
        self.assertEqual(masks.presence[1], 1.0)     # the bar still says that the pose is there
        self.assertFalse(masks.pose[[0, 2]].any())

    def test_packed_masks_hold_every_pose_once(self) -> None:
        for count in range(1, 17):
            rig = face(count, 20)
            masks = PoseComparison.build(rig, one_bone_each(20)).frame(rig.poses[-1].bones)
            packed = poses.packed(masks.pose)
            self.assertEqual(len(packed), (count + 2) // 3)
            together = np.concatenate(packed, 1)
            np.testing.assert_array_equal(together[:, :count], masks.pose.T)
            self.assertFalse(together[:, count:].any())
            self.assertTrue((masks.pose[-1] == 1.0).all())

    def test_what_the_nodes_compute_with_gives_the_same_masks(self) -> None:
        """blender/nodes/maps_mask_tree.py in NumPy: slopes, shares, the table of weights in rows of four, lifts."""
        random = np.random.default_rng(3)
        for bones, groups, entries in ((5, "", 1), (12, "ab", 9), (30, "abc", 23)):
            rig = face(4, bones, bones)
            for number, bone in enumerate(rig.bones):
                bone.tracked = poses.TRACKED[number % 3]
                bone.group = groups[number % len(groups)] if groups and number % 2 else ""
            rig.poses[1].bones[:2] = rig.neutral[:2]
            counts = random.integers(0, entries + 1, 40)
            weights = SkinWeights(np.concatenate([[0], np.cumsum(counts)]).astype(np.int32),
                                  random.integers(-1, bones, counts.sum()).astype(np.int32),
                                  random.uniform(0.1, 1.0, counts.sum()).astype(np.float32))
            comparison = PoseComparison.build(rig, weights)
            now = rig.neutral + random.uniform(-0.01, 0.01, rig.neutral.shape).astype(np.float32)
            influence = np.clip((comparison.slopes() * (now - rig.neutral)).sum(2), 0.0, 1.0)
            number = rig.group_numbers()
            group = [np.flatnonzero(number == number[i]) if number[i] >= 0 else [i] for i in range(bones)]
            influence = comparison.shares() * np.stack([influence[:, members].sum(1) for members in group], 1)
            table = comparison.table()
            self.assertEqual(table.bone.shape[1], poses.ROW)
            strength = [1.0, 0.5, 0.0, 1.0]
            weight = table.weight[:, :, None] * comparison.lifts(3.0, strength).T[table.vertex][:, None]
            rows = (weight * influence.T[table.bone]).sum(1)
            summed = rows[:40] + sum(np.where(more[:, None] < 0, 0.0, rows[more]) for more in table.more)
            masks = np.minimum(summed.T, 1.0)
            expected = comparison.frame(now, 3.0, strength)
            np.testing.assert_allclose(influence.T, expected.influence, atol=1e-5)
            np.testing.assert_allclose(masks, expected.pose, atol=1e-5)
            self.assertGreater(masks.max(), 0.05)

    def test_what_moves_as_a_whole_stays_in_root_space(self) -> None:
        rig = face()
        turn = np.array([[0, -2, 0, 3], [2, 0, 0, 4], [0, 0, 2, 5], [0, 0, 0, 1]], np.float32)
        moved = (rig.neutral.reshape(-1, 3) @ turn[:3, :3].T + turn[:3, 3]).reshape(-1, 6)
        np.testing.assert_allclose(poses.bones_in_root_space("Face", turn, moved), rig.neutral, atol=1e-6)
        with self.assertRaisesRegex(UserError, "Face: root: its matrix has no inverse"):
            poses.bones_in_root_space("Face", np.zeros((4, 4)), moved)

    def test_a_bone_that_is_not_finite_is_named(self) -> None:
        rig = face()
        now = rig.neutral.copy()
        now[2, 4] = np.nan
        with self.assertRaisesRegex(UserError, "Face: the present pose: the tail of bone bone2 is not finite"):
            PoseComparison.build(rig, one_bone_each(4)).frame(now)


if __name__ == "__main__":
    unittest.main()
