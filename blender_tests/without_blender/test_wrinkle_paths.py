# SPDX-License-Identifier: GPL-3.0-or-later
"""The Wrinkle Paths from Python: stored states, and whole real clips (SOURCES.md beside them says whose they are)."""
from __future__ import annotations

import os
import unittest
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Iterator

import numpy as np
import rumple_native as native
from rumple.core.mesh.base_mesh import BaseMesh
from rumple.core.systems.wrinkle_paths import crest_heights
from support.meshes import compressed, tube

DATA = Path(os.environ.get("RUMPLE_DATA", "../shared/data"))


def make_model(base: BaseMesh, level: int = 1) -> Any:
    """The native model of a BaseMesh."""
    surface = native.build_surface(base.positions, base.polygon_start, base.corner_vertex, base.triangle_corner)
    return native.build_wrinkle_paths(surface, level=level)


def play(model: Any, settings: Any, frames: Any, rate: float, state: Any = None,
         first: int = 0, labels: Any = None) -> Iterator[Any]:
    """Yields (state, report) of frames[first:]."""
    paint = native.WrinklePathsPaint(model)
    for f in range(first, len(frames)):
        cut = None if labels is None else labels[f]
        state, report = native.solve_wrinkle_paths(model, settings, paint, frames[f], f / rate, state, cut)
        yield state, report


class StoredStates(unittest.TestCase):
    def setUp(self) -> None:
        base = tube(16, 12)
        self.model = make_model(base)
        self.settings = native.WrinklePathsSettings()
        self.settings.width = 0.01
        rng = np.random.default_rng(3)
        shake = rng.uniform(-0.003, 0.003, base.positions.shape)
        self.frames = [np.ascontiguousarray(compressed(base.positions, 1 - 0.03 * min(f, 12)) + shake * min(f / 6, 1),
                                            np.float32) for f in range(20)]

    def assert_same(self, one: dict, two: dict) -> None:
        self.assertEqual(one.keys(), two.keys())
        for name in one:
            np.testing.assert_array_equal(one[name], two[name], err_msg=name)

    def test_a_stored_state_continues_as_the_one_that_was_stored(self) -> None:
        through = [state for state, _ in play(self.model, self.settings, self.frames, 30.0)]
        self.assertGreater(through[-1].path_count, 3)
        for cut in (1, 7, 14):
            stored = native.WrinklePathsState(self.model, through[cut].arrays)
            self.assert_same(stored.arrays, through[cut].arrays)
            *_, (last, _) = play(self.model, self.settings, self.frames, 30.0, stored, cut + 1)
            self.assert_same(last.arrays, through[-1].arrays)

    def test_a_state_counts_its_paths_and_what_was_handed_out_of_them(self) -> None:
        *_, (state, _) = play(self.model, self.settings, self.frames, 30.0)
        arrays = {name: values.nbytes for name, values in state.arrays.items() if isinstance(values, np.ndarray)}
        paths = sum(count for name, count in arrays.items() if name.startswith(("path_", "point_")))
        self.assertGreaterEqual(state.nbytes, sum(arrays.values()) + paths)

    def test_a_stored_state_that_was_spoiled_is_refused_with_its_name(self) -> None:
        *_, (state, _) = play(self.model, self.settings, self.frames, 30.0)
        good = state.arrays
        for name, value in (("path_start", good["path_start"] + 99), ("path_fade", good["path_fade"][:-1]),
                            ("point_at", good["point_at"].astype(np.float64)), ("labels", good["labels"][None])):
            with self.assertRaisesRegex(ValueError, name):
                native.WrinklePathsState(self.model, {**good, name: value})
        for name in good:
            if name in ("time", "next_id"):
                continue
            with self.assertRaisesRegex(ValueError, name):
                native.WrinklePathsState(self.model, {k: v for k, v in good.items() if k != name})

    def test_lists_name_pieces_that_are_there(self) -> None:
        *_, (state, _) = play(self.model, self.settings, self.frames, 30.0)
        lists = native.wrinkle_path_lists(self.model, self.settings, self.frames[-1], state)
        curves = native.wrinkle_path_curves(self.model, self.settings, self.frames[-1], state)
        self.assertEqual(lists.triangle_start.shape, (self.model.triangle_count + 1,))
        self.assertEqual(lists.triangle_start[-1], len(lists.ranges))
        self.assertTrue((lists.ranges[:, 0] < lists.ranges[:, 1]).all())
        self.assertLess(lists.ranges.max(), len(lists.ends))
        np.testing.assert_array_equal(lists.ends[:, :3], curves.positions)
        np.testing.assert_array_equal(lists.ends[:, 3], curves.width)
        np.testing.assert_array_equal(lists.ends[:, 7], curves.height)
        np.testing.assert_allclose(np.linalg.norm(lists.ends[:, 4:7], axis=1), 1.0, atol=1e-5)

    def test_around_a_vertex_the_highest_fold_counts_that_reaches_a_triangle_there(self) -> None:
        """Two folds of two pieces and of one: 0 to 3 mm, then 3 to 1; and 5 to 2. The first piece reaches triangle 0,
        both of the first fold reach triangle 1, none triangle 2, and the last one triangle 3."""
        ends = np.zeros((5, 8), np.float32)
        ends[:, -1] = (0.0, 3.0, 1.0, 5.0, 2.0)
        drawing = SimpleNamespace(ends=ends, ranges=np.array([[0, 1], [0, 2], [3, 4]], np.int32),
                                  triangle_start=np.array([0, 1, 2, 2, 3], np.int32), hem=np.ones(7, np.float32))
        drawing.lists = drawing
        corners = np.array([[0, 1, 2], [1, 2, 3], [2, 3, 4], [4, 5, 3]], np.int32)
        np.testing.assert_array_equal(crest_heights(drawing, corners), [3.0, 3.0, 3.0, 5.0, 5.0, 5.0, 0.0])
        drawing.ends = ends[:3]
        drawing.ranges, drawing.triangle_start = np.array([[1, 2]], np.int32), np.array([0, 0, 0, 0, 1], np.int32)
        np.testing.assert_array_equal(crest_heights(drawing, corners), [0.0, 0.0, 0.0, 3.0, 3.0, 3.0, 0.0])
        drawing.ranges, drawing.triangle_start = np.zeros((0, 2), np.int32), np.zeros(5, np.int32)
        self.assertFalse(crest_heights(drawing, corners).any())

    def test_choices_go_by_name(self) -> None:
        for name, choices in (("reference", ("REST", "FIRST_FRAME", "STATIC_REST")),
                              ("direction", ("OUTWARD", "INWARD", "BOTH")),
                              ("profile", ("SPLINE", "QUARTIC", "CIRCULAR_ARCS", "SINE"))):
            for choice in choices:
                setattr(self.settings, name, choice)
                self.assertEqual(getattr(self.settings, name), choice)
            with self.assertRaisesRegex(ValueError, f"{name}: expected one of .*{choices[-1]}.*, got WRONG"):
                setattr(self.settings, name, "WRONG")


class Clip:
    """A garment of a real scene: its posed positions in every frame, and its model.

    withheld: the model knows no rest pose; it is made of the first frame's positions.
    """

    def __init__(self, scene: str, garment: str, level: int, withheld: bool = False) -> None:
        data = np.load(DATA / f"{scene}.npz")
        prefix = "" if str(data["primary"]) == garment else f"{garment}__"
        rest = np.ascontiguousarray(data[prefix + "rest"], np.float32)
        begin, size = data[prefix + "poly_start"], data[prefix + "poly_size"]
        start = np.append(begin, begin[-1] + size[-1]).astype(np.int32)
        fans = [(a, a + i, a + i + 1) for a, n in zip(begin, size) for i in range(1, n - 1)]
        self.rate = float(data["fps"])
        if prefix + "frames" in data:
            self.frames = np.ascontiguousarray(data[prefix + "frames"], np.float32)
        else:   # as SOURCES.md says
            bones = data["bone_matrices"] @ np.linalg.inv(data["bone_rest"])
            points = np.concatenate([rest, np.ones((len(rest), 1))], 1)
            posed = [np.einsum("vk,vkij,vj->vi", data[prefix + "weights"], b[data[prefix + "joints"]], points)
                     for b in bones]
            self.frames = np.ascontiguousarray(np.array(posed)[:, :, :3], np.float32)
        surface = native.build_surface(self.frames[0] if withheld else rest, start,
                                       np.ascontiguousarray(data[prefix + "poly_verts"], np.int32),
                                       np.array(fans, np.int32))
        self.model = native.build_wrinkle_paths(surface, level=level)
        shown = self.model.shown
        edges = np.sort(np.stack([shown.corner_vertex.reshape(-1, 4),
                                  np.roll(shown.corner_vertex.reshape(-1, 4), -1, 1)], -1).reshape(-1, 2), 1)
        lone, count = np.unique(edges, axis=0, return_counts=True)
        self.border = np.unique(lone[count == 1])
        quad = shown.positions_rest[shown.corner_vertex.reshape(-1, 4)]
        areas = 0.5 * np.linalg.norm(np.cross(quad[:, 2] - quad[:, 0], quad[:, 3] - quad[:, 1]), axis=1)
        self.area = np.bincount(shown.corner_vertex, np.repeat(areas / 4.0, 4))

    def height(self, settings: Any, frame: np.ndarray, state: Any) -> np.ndarray:
        """Of every shown vertex, metres."""
        return native.show_wrinkle_paths(self.model, settings, np.ascontiguousarray(frame, np.float32), state).height

    def folded(self, settings: Any, frame: np.ndarray, state: Any) -> float:
        """Area that stands out by more than a millimetre, square metres."""
        return float(self.area[np.abs(self.height(settings, frame, state)) > 1e-3].sum())

    def hold(self, settings: Any, state: Any, frame: int, seconds: float, noise: float = 0.0) -> Iterator[Any]:
        """Yields (state, report) of a pose that is held, with normal noise in metres."""
        rng, paint = np.random.default_rng(1), native.WrinklePathsPaint(self.model)
        for _ in range(round(seconds * self.rate)):
            pose = self.frames[frame] + rng.normal(0.0, noise, self.frames[frame].shape)
            state, report = native.solve_wrinkle_paths(self.model, settings, paint,
                                                       np.ascontiguousarray(pose, np.float32),
                                                       state.time + 1.0 / self.rate, state)
            yield state, report

    def slower(self, factor: int) -> np.ndarray:
        """The frames with so many steps from each to the next."""
        time = np.arange((len(self.frames) - 1) * factor + 1) / factor
        before = np.minimum(time.astype(int), len(self.frames) - 2)
        share = (time - before)[:, None, None]
        mixed = self.frames[before] * (1.0 - share) + self.frames[before + 1] * share
        return np.ascontiguousarray(mixed, np.float32)


@unittest.skipUnless(DATA.is_dir(), "the real scenes are not there")
class RealClips(unittest.TestCase):
    GARMENTS = (("S1_walk_shirt", "shirt"), ("S1_walk_shirt", "trousers"), ("S2_squat_trousers", "trousers"),
                ("S2_squat_trousers", "sweater"), ("S3_skirt_sim", "skirt"))

    def look(self, clip: Clip, settings: Any, labels: Any = None) -> tuple[int, float]:
        """The most folds of a frame, and the mean change of height a frame where there is a fold, metres."""
        most, change, before = 0, [], None
        for state, report in play(clip.model, settings, clip.frames, clip.rate, labels=labels):
            frame = round(state.time * clip.rate)
            self.assertEqual(native.wrinkle_path_fault(state), "", f"frame {frame}")
            picture = native.show_wrinkle_paths(clip.model, settings, clip.frames[frame], state)
            self.assertTrue(np.isfinite(picture.positions).all())
            self.assertLess(np.abs(picture.height).max(), 0.75 * settings.width)
            self.assertLess(np.abs(picture.height[clip.border]).max(), 1e-7, f"a fold at the hem in frame {frame}")
            folded = picture.height != 0
            if before is not None and (folded | (before != 0)).any():
                change.append(np.abs(picture.height - before)[folded | (before != 0)].mean())
            before, most = picture.height, max(most, report.paths)
        return most, float(np.mean(change))

    def test_folds_stay_on_the_surface_through_whole_clips(self) -> None:
        for scene, garment in self.GARMENTS:
            with self.subTest(garment=f"{scene} {garment}"):
                clip = Clip(scene, garment, 1)
                settings = native.WrinklePathsSettings()
                most, _ = self.look(clip, settings)
                self.assertGreater(most, 5)
                labels = native.label_clip(clip.model, settings, np.arange(len(clip.frames)) / clip.rate,
                                           clip.frames.reshape(-1, 3))
                self.assertGreater(self.look(clip, settings, labels)[0], 5)
                settings.reference = "FIRST_FRAME"
                self.assertGreater(self.look(Clip(scene, garment, 1, withheld=True), settings)[0], 5)

    def test_a_held_pose_comes_to_rest(self) -> None:
        for scene, garment in self.GARMENTS:
            clip, settings = Clip(scene, garment, 0), native.WrinklePathsSettings()
            states = [state for state, _ in play(clip.model, settings, clip.frames, clip.rate)]
            for frame in range(9, len(states), 24):
                state = [state for state, _ in clip.hold(settings, states[frame], frame, 2.0)][-1]
                for after, report in clip.hold(settings, state, frame, 0.2):
                    self.assertEqual((report.born, report.died, report.moved_most), (0, 0, 0.0), (garment, frame))
                for name in ("path_id", "path_fade", "path_start", "point_triangle_edge", "point_at"):
                    np.testing.assert_array_equal(after.arrays[name], state.arrays[name], (garment, frame))

    def test_a_held_pose_that_jitters_keeps_its_folds_as_they_are(self) -> None:
        for garment in ("trousers", "sweater"):
            clip, settings = Clip("S2_squat_trousers", garment, 2), native.WrinklePathsSettings()
            crouch = 32
            *_, (start, _) = play(clip.model, settings, clip.frames[:crouch + 1], clip.rate)
            *_, (still, _) = clip.hold(settings, start, crouch, 3.0)
            area = [clip.folded(settings, clip.frames[crouch], state)
                    for state, _ in clip.hold(settings, start, crouch, 3.0, noise=1e-3)]
            of_still = np.array(area[15:]) / clip.folded(settings, clip.frames[crouch], still)
            self.assertGreater(of_still.min(), 0.75, garment)
            self.assertLess(of_still.max(), 1.1, garment)

    def test_a_glitch_of_one_frame_leaves_nothing_behind_after_a_second(self) -> None:
        for garment in ("trousers", "sweater"):
            clip, settings = Clip("S2_squat_trousers", garment, 2), native.WrinklePathsSettings()
            stand = clip.frames[0]
            noise = np.random.default_rng(3).normal(0.0, 0.03, stand.shape).astype(np.float32)
            *_, (clean, _) = play(clip.model, settings, np.array([stand] * 46), clip.rate)
            for glitch in (clip.frames[32], stand + noise):
                frames = np.array([stand] * 15 + [glitch] + [stand] * 30)
                *_, (state, _) = play(clip.model, settings, frames, clip.rate)
                self.assertLess(abs(state.path_count - clean.path_count), 3, garment)
                self.assertLess(clip.folded(settings, stand, state), 1.1 * clip.folded(settings, stand, clean), garment)

    def test_the_same_folds_at_every_frame_rate_and_in_slow_motion(self) -> None:
        clip, settings = Clip("S2_squat_trousers", "trousers", 2), native.WrinklePathsSettings()

        def folded(rate: float, factor: int) -> np.ndarray:
            states = [state for state, _ in play(clip.model, settings, clip.slower(factor), rate)]
            return np.array([np.abs(clip.height(settings, frame, state)) > 1e-3
                             for frame, state in zip(clip.frames, states[::factor])])

        plain = folded(30.0, 1)
        for rate, factor, least in ((60.0, 2, 0.65), (120.0, 4, 0.6), (30.0, 4, 0.4)):
            other = folded(rate, factor)
            self.assertAlmostEqual((clip.area * other).sum() / (clip.area * plain).sum(), 1.0, delta=0.12)
            self.assertGreater((clip.area * (plain & other)).sum() / (clip.area * (plain | other)).sum(), least, rate)

    def test_a_noisy_clip_folds_as_the_clean_one(self) -> None:
        for scene, garment in self.GARMENTS:
            clip, settings = Clip(scene, garment, 1), native.WrinklePathsSettings()
            noise = np.random.default_rng(2).normal(0.0, 1e-3, clip.frames.shape)
            area = []
            for frames in (clip.frames, np.ascontiguousarray(clip.frames + noise, np.float32)):
                area.append(np.mean([clip.folded(settings, frame, state) for frame, (state, _) in
                                     zip(frames, play(clip.model, settings, frames, clip.rate))]))
            self.assertAlmostEqual(area[1] / area[0], 1.0, delta=0.3, msg=garment)

    def test_persistence_makes_folds_move_several_times_less(self) -> None:
        clip = Clip("S2_squat_trousers", "trousers", 2)
        settings = native.WrinklePathsSettings()
        _, kept = self.look(clip, settings)
        settings.persistent = False
        _, anew = self.look(clip, settings)
        self.assertLess(3.0 * kept, anew)

    def test_a_jump_folds_the_backs_of_the_knees(self) -> None:
        clip = Clip("S2_squat_trousers", "trousers", 2)
        settings = native.WrinklePathsSettings()
        data = np.load(DATA / "S2_squat_trousers.npz")
        names = [str(n) for n in data["bone_names"]]
        deepest = 0
        for state, _ in play(clip.model, settings, clip.frames, clip.rate):
            frame = round(state.time * clip.rate)
            curves = native.wrinkle_path_curves(clip.model, settings, clip.frames[frame], state)
            for side in "lr":
                thigh, calf, foot = (data["bone_heads"][frame, names.index(f"{bone}_{side}")]
                                     for bone in ("thigh", "calf", "foot"))
                bend = np.degrees(np.arccos(np.dot(calf - thigh, foot - calf) /
                                            np.linalg.norm(calf - thigh) / np.linalg.norm(foot - calf)))
                if bend < 80:
                    continue
                deepest += 1
                behind = (thigh + foot) / 2 - calf
                near = curves.positions[np.linalg.norm(curves.positions - calf, axis=1) < 0.17] - calf
                self.assertGreater((near @ behind > 0).sum(), 3, f"frame {frame}, side {side}")
        self.assertGreater(deepest, 10)

    def test_a_standing_chest_bears_hardly_a_fold(self) -> None:
        clip, settings = Clip("S2_squat_trousers", "sweater", 2), native.WrinklePathsSettings()
        data = np.load(DATA / "S2_squat_trousers.npz")
        names, rest = [str(n) for n in data["bone_names"]], clip.model.shown.positions_rest
        neck, pelvis = (data["bone_rest"][names.index(name), :3, 3] for name in ("neck_01", "pelvis"))
        chest = (np.abs(rest[:, 0]) < 0.07) & (rest[:, 1] < neck[1] - 0.03)   # in front, between the armpits
        chest &= (rest[:, 2] > pelvis[2] + 0.3 * (neck[2] - pelvis[2])) & (rest[:, 2] < neck[2])
        self.assertGreater(chest.sum(), 100)
        for state, _ in play(clip.model, settings, clip.frames, clip.rate):
            frame = round(state.time * clip.rate)
            height = clip.height(settings, clip.frames[frame], state)
            folded = clip.area[chest & (np.abs(height) > 1e-3)].sum() / clip.area[chest].sum()
            if frame < 8:       # it stands, arms out
                self.assertLess(folded, 0.01, frame)
            elif 72 < frame < 110:  # it has jumped and stands, arms down: 0.3, when weak folds stood as high as others
                self.assertLess(folded, 0.15, frame)

    def test_the_cut_clears_isolated_labels(self) -> None:
        clip = Clip("S2_squat_trousers", "trousers", 0)
        settings = native.WrinklePathsSettings()
        triangle_vertex = clip.model.triangle_vertex
        edges = np.sort(np.stack([triangle_vertex, np.roll(triangle_vertex, -1, 1)], -1).reshape(-1, 2), 1)
        _, edge = np.unique(edges, axis=0, return_inverse=True)
        order = np.argsort(edge, kind="stable")
        pairs = np.array([(a // 3, b // 3) for a, b in zip(order, order[1:]) if edge[a] == edge[b]])
        isolated = {}
        for raw in (False, True):
            labels = native.label_clip(clip.model, settings, np.arange(len(clip.frames)) / clip.rate,
                                       clip.frames.reshape(-1, 3), raw)
            agree = np.zeros(labels.shape, bool)
            same = labels[:, pairs[:, 0]] == labels[:, pairs[:, 1]]
            for side in (0, 1):
                for f in range(len(labels)):
                    np.logical_or.at(agree[f], pairs[:, side], same[f])
            still = labels[1:] == labels[:-1]
            agree[1:] |= still
            agree[:-1] |= still
            isolated[raw] = 1.0 - agree.mean()
        self.assertLess(5 * isolated[False], isolated[True])


if __name__ == "__main__":
    unittest.main()
