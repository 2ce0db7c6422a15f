# SPDX-License-Identifier: GPL-3.0-or-later
"""Training sets: the same bits from the same seed, in any order and after any end; poses within the joints' limits."""
from __future__ import annotations

import errno
import json
import math
import tempfile
import unittest
from pathlib import Path
from unittest import mock
from typing import Any

import bpy
import numpy as np
from rumple.blender.farm import bake, commands, poses, source
from rumple.core.files import clip_folder, pose_set
from rumple.core.files.clip_manifest import ClipFault
from support import farm_case, farm_scene

NAME = farm_scene.FREE
FIRST = "c5d2a8bdb13445e4"  # of SHAKE-128 of "rumple poses 0 0"


class Drawn(unittest.TestCase):

    def test_numbers_depend_on_seed_and_pose_alone(self) -> None:
        """The first values are those of openssl dgst -shake128 -xoflen 8."""
        one = pose_set.shares(0, 0, 300)
        self.assertTrue(((0.0 <= one) & (one < 1.0)).all())
        self.assertTrue(np.array_equal(one[:9], pose_set.shares(0, 0, 9)))
        self.assertAlmostEqual(one.mean(), 0.5, delta=0.06)
        for other in (pose_set.shares(1, 0, 300), pose_set.shares(0, 1, 300)):
            self.assertLess(abs(np.corrcoef(one, other)[0, 1]), 0.2)
        self.assertEqual(one[0], (int.from_bytes(bytes.fromhex(FIRST), "little") >> 11) / 2**53)

    def test_a_wider_range_keeps_its_middle_and_ends_at_half_a_turn(self) -> None:
        np.testing.assert_allclose(pose_set.widened(0.0, 1.0, 2.0), (-0.5, 1.5))
        np.testing.assert_allclose(pose_set.widened(-1.0, 2.0, 100.0), (0.5 - math.pi, 0.5 + math.pi))


class Begun(unittest.TestCase):

    def test_a_manifest_that_cannot_be_put_in_place_leaves_no_other_file(self) -> None:
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        wanted = pose_set.PoseSet("Coat", "", "", 0, 1, "clip", [1, 1], 3, 3, 1.0)
        refused = mock.patch.object(clip_folder, "put", side_effect=OSError(errno.ENOSPC, ""))
        with refused, mock.patch.object(pose_set, "write_arrays"), self.assertRaises(ClipFault):
            pose_set.begin(Path(place.name), wanted, {}, resume=False)
        self.assertEqual(list(Path(place.name).iterdir()), [])


class SetCase(farm_case.Case):

    def setUp(self) -> None:
        super().setUp()
        small = mock.patch.object(pose_set, "BLOCK", 4)
        small.start()
        self.addCleanup(small.stop)
        self.set = self.folder / "set"

    def make(self, *words: str, folder: Path | None = None) -> int:
        return self.run_command("poses", "--object", NAME, "--out", str(folder or self.set), *words)

    def blocks(self, folder: Path | None = None) -> dict[str, np.ndarray]:
        """All of a set, one behind the other."""
        found = [np.load(path) for path in sorted((folder or self.set).glob("block-*.npz"))]
        return {name: np.concatenate([block[name] for block in found]) for name in found[0].files}

    def about(self) -> dict:
        return json.loads((self.set / "manifest.json").read_text())


class Sets(SetCase):

    def test_the_manifest_says_what_the_arrays_are(self) -> None:
        """Numbers and frames were said to be float32, and are not."""
        self.assertEqual(self.make("--count", "2"), 0, self.err)
        self.assertEqual(self.about()["numbers"], {name: str(array.dtype) for name, array in self.blocks().items()})

    def test_the_same_seed_has_the_same_bytes_and_another_one_other_poses(self) -> None:
        self.assertEqual(self.make("--count", "6", "--seed", "5"), 0, self.err)
        self.assertEqual(sorted(path.name for path in self.set.iterdir()),
                         ["block-00000.npz", "block-00001.npz", "manifest.json", "mesh.npz"])
        again, other = self.folder / "again", self.folder / "other"
        self.assertEqual(self.make("--count", "6", "--seed", "5", folder=again), 0)
        self.assertEqual(self.read_all(again), self.read_all(self.set))
        self.assertEqual(self.make("--count", "6", "--seed", "6", folder=other), 0)
        one, two = self.blocks(), self.blocks(other)
        self.assertGreater(np.abs(one["coarse"] - two["coarse"]).max(1).max(1).min(), 0.01)  # every pose is another
        self.assertGreater(np.abs(np.diff(one["coarse"], axis=0)).max(2).max(1).min(), 0.01)

    def test_arrays_are_what_the_manifest_says_and_fine_points_are_solved(self) -> None:
        self.assertEqual(self.make("--count", "5"), 0, self.err)
        about, found, mesh = self.about(), self.blocks(), np.load(self.set / "mesh.npz")
        self.assertEqual((about["object"], about["count"], about["kind"], about["block"]), (NAME, 5, "random", 4))
        self.assertIn("none", about["history"])
        self.assertEqual(list(found["number"]), [0, 1, 2, 3, 4])
        for name, shape in about["arrays"].items():
            self.assertEqual(found[name].shape, (5, *shape[1:]))
            self.assertTrue(np.isfinite(found[name]).all())
        self.assertEqual(len(mesh["fine_rest"]), about["fine"])
        self.assertEqual(mesh["fine_sizes"].sum(), len(mesh["fine_corners"]))
        self.assertEqual(mesh["coarse_sizes"].sum(), len(mesh["coarse_corners"]))
        size = np.ptp(mesh["fine_rest"], axis=0).max()
        for pose in range(5):  # the fine mesh lies where the coarse one does
            for end in (np.min, np.max):
                self.assertLess(np.abs(end(found["fine"][pose], 0) - end(found["coarse"][pose], 0)).max(), 0.2 * size)

    def test_bone_matrices_are_those_that_move_the_coarse_points(self) -> None:
        """Points that one bone alone moves lie where its matrix puts them."""
        self.assertEqual(self.make("--count", "3"), 0, self.err)
        about, found, mesh = self.about(), self.blocks(), np.load(self.set / "mesh.npz")
        obj = bpy.data.objects[NAME]
        checked = 0
        for number, bone in enumerate(about["ranges"]):
            group = obj.vertex_groups.get(bone["bone"])
            only = [] if group is None else [vertex.index for vertex in obj.data.vertices
                                             if [(one.group, one.weight) for one in vertex.groups
                                                 if one.weight] == [(group.index, 1.0)]]
            if not only:
                continue
            rig = bpy.data.objects[bone["armature"]]
            rest = np.linalg.inv(mesh["bone_rest"][number]) @ np.linalg.inv(np.array(rig.matrix_world)) @ np.array(
                obj.matrix_world)
            points = np.c_[mesh["coarse_rest"][only], np.ones(len(only))] @ rest.T
            for pose in range(3):
                moved = (points @ found["pose"][pose, number].T)[:, :3]
                np.testing.assert_allclose(found["coarse"][pose][only], moved, atol=1e-5)
                checked += len(only)
        self.assertGreater(checked, 10)

    def test_ended_and_resumed_it_has_the_bytes_of_one_go(self) -> None:
        self.assertEqual(self.make("--count", "9"), 0, self.err)
        whole, resumed = self.read_all(self.set), self.folder / "resumed"
        with mock.patch.object(bake, "is_end_wanted", side_effect=[False] * 6 + [True]):
            self.assertEqual(self.make("--count", "9", folder=resumed), commands.ENDED)
        self.assertEqual(sorted(self.read_all(resumed)), ["block-00000.npz", "manifest.json", "mesh.npz"])
        damaged = resumed / "block-00000.npz"
        damaged.write_bytes(damaged.read_bytes()[:-999])
        self.assertEqual(self.make("--count", "9", folder=resumed), 1)
        self.assertIn("give --resume", self.err)
        self.assertEqual(self.make("--count", "9", "--resume", folder=resumed), 0)
        self.assertEqual(self.read_all(resumed), whole)
        (self.set / "block-00001.npz").unlink()  # from the middle: no pose needs those before it
        self.assertEqual(self.make("--count", "9", "--resume"), 0)
        self.assertEqual(self.read_all(self.set), whole)

    def test_a_pose_alone_has_the_bits_that_it_has_in_the_set(self) -> None:
        for words in ((), ("--from-clip",)):
            folder = self.folder / f"set{len(words)}"
            self.assertEqual(self.make("--count", "9", *words, folder=folder), 0, self.err)
            found = self.blocks(folder)
            for pose in (7, 2):
                commands.open_file(self.blend, False)
                solver = poses.Solver(bpy.context, bpy.data.objects[NAME], source.of_files(),
                                      poses.Options(9, from_clip=bool(words)))
                alone = solver.solve(pose)
                solver.close()
                for name in ("coarse", "fine", "pose"):
                    self.assertEqual(alone[name].tobytes(), found[name][pose].tobytes(), (name, pose, words))

    def test_verify_finds_a_pose_that_differs(self) -> None:
        self.assertEqual(self.make("--count", "6"), 0, self.err)
        self.assertEqual(self.make("--count", "6", "--verify"), 0, self.err)
        self.assertIn("6 poses were solved again", self.out)
        path = self.set / "block-00001.npz"
        arrays = dict(np.load(path))
        arrays["fine"][1, 17, 2] = np.nextafter(arrays["fine"][1, 17, 2], np.float32(9.0))
        pose_set.write_arrays(path, arrays)
        self.assertEqual(self.make("--count", "6", "--verify"), commands.DIFFERS)
        self.assertIn("pose 5 is the first that differs", self.err)

    def test_limits_of_joints_hold_and_what_has_none_has_the_range_of_the_clip(self) -> None:
        commands.open_file(self.blend, False)
        rig = bpy.data.objects["Arm"]
        upper, lower = rig.pose.bones[0], rig.pose.bones[1]
        limit = lower.constraints.new("LIMIT_ROTATION")
        limit.owner_space, limit.use_limit_x, limit.min_x, limit.max_x = "LOCAL", True, 0.1, 0.4
        upper.use_ik_limit_z, upper.ik_min_z, upper.ik_max_z = True, -0.2, 0.3
        upper.lock_ik_y = True
        farm_scene.save(self.blend)
        self.assertEqual(self.make("--count", "12", "--widen", "2"), 0, self.err)
        ranges = {one["bone"]: one for one in self.about()["ranges"]}
        one = ranges["lower"]
        np.testing.assert_allclose((one["least"][0], one["most"][0]), (0.1, 0.4), atol=1e-6)
        self.assertEqual((one["source"][0], ranges["upper"]["source"][1:]), ("constraint", ["ik", "ik"]))
        self.assertEqual((ranges["upper"]["least"][1], ranges["upper"]["most"][1]), (0.0, 0.0))
        self.assertIn("clip", {source_ for other in ranges.values() for source_ in other["source"]})
        pose, mesh = self.blocks()["pose"], np.load(self.set / "mesh.npz")
        number = list(ranges).index("lower")
        parent = mesh["bone_parent"][number]
        local = np.linalg.inv(np.linalg.inv(mesh["bone_rest"][parent]) @ mesh["bone_rest"][number]) @ np.linalg.inv(
            pose[:, parent]) @ pose[:, number]
        angles = np.arctan2(local[:, 2, 1], local[:, 2, 2])  # x of Euler XYZ
        self.assertTrue(((angles > 0.1 - 1e-4) & (angles < 0.4 + 1e-4)).all(), angles)
        self.assertGreater(np.ptp(angles), 0.1)

    def test_poses_of_the_clip_are_those_of_its_frames(self) -> None:
        self.assertEqual(self.make("--count", "5", "--from-clip", "--frames", "2-4"), 0, self.err)
        found, obj = self.blocks(), bpy.data.objects[NAME]
        self.assertTrue(((found["frame"] >= 2.0) & (found["frame"] <= 4.0)).all())
        self.assertEqual(len(np.unique(found["frame"])), 5)
        commands.open_file(self.blend, False)
        obj = bpy.data.objects[NAME]
        next(m for m in obj.modifiers if m.type == "NODES").show_viewport = False
        for frame, coarse in zip(found["frame"], found["coarse"]):
            bpy.context.scene.frame_set(int(frame), subframe=frame % 1.0)
            mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
            shown = np.array([vertex.co for vertex in mesh.vertices])
            np.testing.assert_allclose(coarse, shown, atol=1e-5)

    def test_two_workers_share_the_blocks(self) -> None:
        self.assertEqual(self.make("--count", "9"), 0, self.err)
        whole = self.read_all(self.set)
        (self.set / "block-00001.npz").unlink()
        held = mock.patch.object(poses, "Lock", side_effect=poses.Held("another has it"))
        with held:
            self.assertEqual(self.make("--count", "9", "--resume"), commands.HELD)
        self.assertIn("2 of 3 blocks, ", self.out)
        self.assertIn("other workers have 1 of them", self.out)
        self.assertEqual(self.make("--count", "9", "--resume"), 0)
        self.assertEqual(self.read_all(self.set), whole)


class Refused(SetCase):

    def test_in_a_sentence_and_nothing_is_left(self) -> None:
        for words, said in ((("--object", farm_scene.OUTER), "it rests on Sleeve, which is wrinkled itself"),
                            (("--object", NAME, "--frames", "1"), "no bone of its rig has limits, or moves"),
                            (("--object", "Arm"), "'Arm' is no wrinkled object of this scene"),
                            ((), "poses are of one garment: give --object"),
                            (("--object", NAME, "--widen", "nan"), "--widen is a factor above 0, not nan")):
            self.assertNotEqual(self.run_command("poses", "--count", "2", "--out", str(self.set), *words), 0)
            self.assertIn(said, self.err)
            self.assertFalse(self.set.exists(), words)

    def test_another_set_in_the_folder_is_left_alone(self) -> None:
        self.assertEqual(self.make("--count", "2"), 0, self.err)
        before = self.read_all(self.set)
        for words, said in ((("--count", "2"), "holds a set of poses: give --resume"),
                            (("--count", "2", "--seed", "1", "--resume"), r"another set of poses \(seed 0, not 1"),
                            (("--count", "3", "--resume"), r"another set of poses \(count 2, not 3")):
            self.assertEqual(self.make(*words), 1)
            self.assertRegex(self.err, said)
            self.assertEqual(self.read_all(self.set), before)
        commands.open_file(self.blend, False)
        farm_scene.save(self.blend)  # saved again it is another file
        self.assertEqual(self.make("--count", "2", "--resume"), 1)
        self.assertRegex(self.err, r"another set of poses \(source ")
        self.assertEqual(self.read_all(self.set), before)
        commands.open_file(self.blend, False)
        farm_scene.break_garment(NAME)
        farm_scene.save(self.blend)
        self.assertEqual(self.make("--count", "2", "--resume"), 1)
        self.assertIn("is off in the viewport, so nothing is solved: switch it on", self.err)
        self.assertEqual(self.read_all(self.set), before)

    def test_a_full_disk_keeps_whole_blocks_only(self) -> None:
        real = np.savez

        def savez(file: Any, **arrays: np.ndarray) -> None:
            if "number" in arrays and arrays["number"][0] >= 4:
                file.write(b"half")
                raise OSError(28, "")
            real(file, **arrays)

        with mock.patch.object(np, "savez", savez):
            self.assertEqual(self.make("--count", "6"), 1)
        self.assertIn("is full: make room", self.err)
        self.assertEqual(sorted(self.read_all(self.set)), ["block-00000.npz", "manifest.json", "mesh.npz"])
        self.set = self.folder / "file"
        self.set.write_text("")
        self.assertEqual(self.make("--count", "2"), 1)
        self.assertIn("is no folder, or leads through a file", self.err)
