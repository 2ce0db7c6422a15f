# SPDX-License-Identifier: GPL-3.0-or-later
"""Laws of the stage before every system: what lies on a base cloth is what the system makes of its positions."""
from __future__ import annotations

import unittest
from dataclasses import replace
from typing import Any
from unittest import mock

import numpy as np
from rumple import native
from rumple.core.cloth.base_cloth import BaseCloth, bend_radius
from rumple.core.frame.engine import FrameResult, Wrinkles
from rumple.core.mesh.body import Body
from rumple.core.settings.system_settings import FieldSettings, PathsSettings
from rumple.core.systems.all_systems import SYSTEMS
from support.frames import solve_frame
from support.meshes import rotated, tube

FRAMES = range(1, 9)
CLOTH = dict(base_cloth="HANG", room=0.02, thickness=0.002)
FIELD = FieldSettings(output="GEOMETRY", wavelength=0.05, detail=4)
SHADED = replace(FIELD, output="SHADING")
PATHS = PathsSettings(width=0.02, detail=2, threshold=1.1, reference="STATIC_REST", smoothing=0.0)
KINDS = {"FIELD": FIELD, "SHADED": SHADED, "PATHS": PATHS, "DRAPED": replace(FIELD, drape=1.0),
         "DRAPED PATHS": replace(PATHS, drape=1.0)}
WEIGHTLESS = dict(gravity=0.0, slack=1.0)
# Only cloth has no folds along lines that bend: without that, the laws below hold to the bit.
ALONG_ANY_LINE = mock.patch("rumple.core.cloth.base_cloth.LEAST_BEND", 0.0)


def on_cloth(settings: Any, **values: Any) -> Any:
    return replace(settings, **{**CLOTH, **values})


def bent(positions: np.ndarray, squeeze: float) -> np.ndarray:
    """A tube along z that is squeezed, and squeezed more on one side."""
    share = squeeze + (1.0 - squeeze) * 4.0 * (positions[:, :1] + 0.05)
    return np.ascontiguousarray(np.c_[positions[:, :2], positions[:, 2:] * share], np.float32)


class OnCloth(unittest.TestCase):

    def setUp(self) -> None:
        self.base = tube(14, 10)
        self.clip = {f: bent(self.base.positions, 1.0 - 0.06 * min(f - 1, 9 - f)) for f in FRAMES}

    def build(self, settings: Any) -> Wrinkles:
        method = "PATHS" if isinstance(settings, PathsSettings) else "FIELD"
        return SYSTEMS[method].wrinkles.build(self.base, settings)

    def solve(self, fine: Wrinkles, frame: int, settings: Any, positions: np.ndarray | None = None,
              paint: dict | None = None, **options: Any) -> FrameResult:
        options = {"world_from_object": np.eye(3, dtype=np.float32), **options}
        return solve_frame(fine, float(frame), self.clip[frame] if positions is None else positions, settings,
                           paint or {}, start=1, **options)

    def same(self, one: FrameResult, other: FrameResult, offsets: bool = True) -> None:
        np.testing.assert_array_equal(one.positions, other.positions)
        if offsets:
            np.testing.assert_array_equal(one.local_offset, other.local_offset)
        for name, values in one.attributes.items():
            np.testing.assert_array_equal(values, other.attributes[name], name)

    # --- settings
    def test_what_is_hidden_in_a_body_is_two_centimetres_deep_on_a_person_and_to_scale_on_others(self) -> None:
        surface = self.build(FIELD).surface
        for metres, unit_scale, expected in ((1.0, 1.0, 0.02), (1.0, 0.01, 2.0), (0.2, 1.0, 0.01), (6.0, 0.1, 0.4)):
            cloth = BaseCloth(surface, metres / unit_scale, unit_scale)
            np.testing.assert_allclose(cloth.hidden_depth(), expected, rtol=1e-6)

    def test_only_cloth_has_no_folds_along_lines_that_bend_on_less_than_four_wavelengths(self) -> None:
        for settings, wavelength in ((FIELD, 0.05), (PATHS, 0.04)):
            fine = self.build(settings)
            self.assertEqual(fine._native_settings(settings).bend_radius, 0.0)
            self.assertAlmostEqual(fine._native_settings(on_cloth(settings)).bend_radius, 4.0 * wavelength, places=6)
        self.assertAlmostEqual(bend_radius(on_cloth(FIELD), 0.05, 0.01), 20.0)  # centimetres

    # --- drape
    def test_a_drape_folds_what_waves_and_paths_lie_on_and_nothing_without_a_base_cloth(self) -> None:
        for settings in (FIELD, PATHS):
            draped = replace(settings, drape=1.0)
            plain, fine = self.build(settings), self.build(draped)
            for frame in range(1, 6):
                self.solve(plain, frame, on_cloth(settings, gravity=0.0))
                self.solve(fine, frame, on_cloth(draped, gravity=0.0))
            over = [wrinkles.solved_over(5.0, self.clip[5]) for wrinkles in (plain, fine)]
            self.assertGreater(np.linalg.norm(over[1] - over[0], axis=1).max(), 2e-3)
            self.same(self.solve(self.build(settings), 5, settings), self.solve(self.build(draped), 5, draped))

    # --- off
    def test_without_a_base_cloth_it_is_what_the_kernel_makes_of_the_animation(self) -> None:
        """Gravity's direction, what is painted for the cloth and a body far away change no bit."""
        far = Body(4.0 * np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], np.int32))
        turned = np.ascontiguousarray(rotated(np.eye(3), 50.0) - rotated(np.zeros((1, 3)), 50.0))
        paint = {name: np.full(len(self.base.positions), 0.5, np.float32) for name in ("follow", "room")}
        for name, settings in KINDS.items():
            fine, other = self.build(settings), self.build(settings)
            for frame in FRAMES:
                plain = self.solve(fine, frame, settings)
                self.same(plain, self.solve(other, frame, settings, paint=paint, body=far, world_from_object=turned))
            state = fine.state_of(8.0)
            if isinstance(settings, PathsSettings):
                shown = native.load().show_wrinkle_paths(fine.model, fine._native_settings(settings), self.clip[8],
                                                         state)
            else:
                shown = native.load().show_wrinkle_field(
                    fine.model, fine._native_settings(settings), native.load().WrinkleFieldProfile("SINE"),
                    fine._paint, self.clip[8], state)
            np.testing.assert_array_equal(shown.local_offset, plain.local_offset, name)

    # --- on
    @ALONG_ANY_LINE
    def test_it_is_what_the_system_makes_of_the_cloths_positions(self) -> None:
        for name, settings in KINDS.items():
            fine, apart, moved = self.build(settings), self.build(settings), 0.0
            for frame in FRAMES:
                picture = self.solve(fine, frame, on_cloth(settings))
                cloth = fine.solved_over(float(frame), self.clip[frame])
                moved = max(moved, float(np.abs(cloth - self.clip[frame]).max()))
                expected = self.solve(apart, frame, settings, cloth)
                if name not in ("FIELD", "DRAPED"):  # whose waves are bounded: see below
                    self.same(picture, expected, offsets=False)
                if name != "SHADED":
                    self.assertFalse(np.array_equal(picture.local_offset, expected.local_offset))
            self.assertGreater(moved, 3e-3, name)

    @ALONG_ANY_LINE
    def test_waves_go_no_farther_inwards_than_the_cloth_is_off_what_is_under_it(self) -> None:
        field = replace(FIELD, attachment="PN")  # there the gap is between the corners', on a smooth surface less
        fine, apart = self.build(field), self.build(field)
        worn = self.clip[5] * np.array((0.97, 0.97, 1.0), np.float32)
        body = Body(worn, np.ascontiguousarray(self.base.corner_vertex[self.base.triangle_corner]))
        shown = self.solve(fine, 5, on_cloth(field), body=body)
        unbounded = self.solve(apart, 5, field, fine.solved_over(5.0, self.clip[5]))
        weights = np.c_[1.0 - fine.barycentric.sum(1), fine.barycentric]
        gap = (weights * fine.state_of(5.0).cloth.gap[fine.triangle_vertex]).sum(axis=1)
        height, free = heights(shown), heights(unbounded)
        self.assertGreaterEqual(float((height + gap).min()), -1e-6)
        self.assertGreater(int((free < -gap - 1e-3).sum()), 10)
        np.testing.assert_allclose(height, np.maximum(free, -gap), atol=1e-6)

    def test_a_limb_that_is_elsewhere_at_rest_is_not_under_the_cloth(self) -> None:
        """An arm that is animated into the flank of a shirt: it is not dressed in the shirt."""
        settings = on_cloth(FIELD, gravity=0.0)
        triangles = np.ascontiguousarray(self.base.corner_vertex[self.base.triangle_corner])
        limb = Body(self.clip[5] * np.array((1.03, 1.03, 1.0), np.float32), triangles)
        away = limb.positions + np.array((1.0, 0.0, 0.0), np.float32)
        cloth = {}
        for name, rest in (("none", None), ("here", self.base.positions), ("away", away),
                           ("unknown", np.full_like(away, np.nan))):
            fine = self.build(FIELD)
            self.solve(fine, 5, settings, body=replace(limb, rest=rest))
            cloth[name] = fine.state_of(5.0).cloth.positions
        alone = self.build(FIELD)
        self.solve(alone, 5, settings)
        for name in ("here", "unknown"):
            np.testing.assert_array_equal(cloth[name], cloth["none"])
        apart = [np.linalg.norm(cloth[name] - alone.state_of(5.0).cloth.positions, axis=1).max() for name in cloth]
        self.assertGreater(apart[0], 3e-3)
        self.assertLess(apart[2], 1e-4)

    def test_what_is_shown_is_embedded_in_the_animated_mesh(self) -> None:
        """Each shown vertex is as far from its place on the animated triangle as its stored offset is long."""
        for name, settings in KINDS.items():
            fine = self.build(settings)
            picture = self.solve(fine, 5, on_cloth(settings))
            corners = self.clip[5][fine.triangle_vertex]
            weights = np.c_[1.0 - fine.barycentric.sum(1), fine.barycentric]
            way = picture.positions - np.einsum("dk,dki->di", weights, corners)
            np.testing.assert_allclose(np.linalg.norm(picture.local_offset, axis=1), np.linalg.norm(way, axis=1),
                                       atol=1e-6, err_msg=name)
            self.assertGreater(float(np.linalg.norm(way, axis=1).mean()), 1e-3, name)

    @ALONG_ANY_LINE
    def test_curves_and_proxies_ride_on_the_animated_mesh(self) -> None:
        fine, apart = self.build(PATHS), self.build(PATHS)
        for frame in FRAMES:
            sketch = self.solve(fine, frame, on_cloth(PATHS), for_preview=True)
            cloth = fine.solved_over(float(frame), self.clip[frame])
            expected = self.solve(apart, frame, PATHS, cloth, for_preview=True)
            np.testing.assert_allclose(sketch.proxy_offset + self.clip[frame], expected.proxy_offset + cloth, atol=1e-6)
        self.solve(fine, 5, on_cloth(PATHS))
        curves = fine.curves(5.0, self.clip[5], on_cloth(PATHS))
        over = apart.curves(5.0, fine.solved_over(5.0, self.clip[5]), PATHS)
        self.assertGreater(len(curves.id), 0)
        np.testing.assert_array_equal(curves.positions, over.positions)
        p0, p1, p2 = (self.clip[5][curves.corners[:, k]] for k in range(3))
        on_triangle = p0 + curves.weights[:, :1] * (p1 - p0) + curves.weights[:, 1:] * (p2 - p0)
        np.testing.assert_allclose(np.linalg.norm(curves.local_offset, axis=1),
                                   np.linalg.norm(curves.positions - on_triangle, axis=1), atol=1e-6)

    def test_at_rest_without_weight_and_slack_there_is_no_fold(self) -> None:
        for name, settings in KINDS.items():
            picture = self.solve(self.build(settings), 1, on_cloth(settings, **WEIGHTLESS), self.base.positions)
            folded = picture.attributes["rumple_height" if isinstance(settings, PathsSettings) else "rumple_amplitude"]
            self.assertLess(float(np.abs(folded).max()), 2e-6 if isinstance(settings, PathsSettings) else 2e-4, name)
            self.assertLess(float(np.abs(picture.positions - fine_at_rest(self, settings)).max()), 2e-4, name)

    def test_waves_stand_where_the_cloth_is_compressed_and_nowhere_else(self) -> None:
        fine, settings = self.build(SHADED), on_cloth(SHADED)
        self.solve(fine, 5, settings)
        cloth = fine.solved_over(5.0, self.clip[5])
        waves = native.load().shown_waves_wrinkle_field(
            fine.model, fine._native_settings(settings), native.load().WrinkleFieldProfile("SINE"), fine._paint, cloth,
            fine.wrinkles_of(5.0))
        amplitude = self.solve(fine, 5, settings).attributes["rumple_amplitude"]
        np.testing.assert_allclose(amplitude, waves.height, atol=1e-9)
        self.assertGreater(float((waves.height > 0.0).mean()), 0.05)
        self.assertFalse((waves.height[waves.compression >= 1.0] > 0.0).any())

    def test_rigid_motion_carries_everything_along(self) -> None:
        turn = np.ascontiguousarray(rotated(np.eye(3), 70.0) - rotated(np.zeros((1, 3)), 70.0), np.float32)
        for name, settings in KINDS.items():
            here, there = (self.build(settings) for _ in range(2))
            for frame in FRAMES:
                one = self.solve(here, frame, on_cloth(settings))
                # The object is turned, and the garment in it back: the world, and its gravity, stay where they are.
                other = self.solve(there, frame, on_cloth(settings), rotated(self.clip[frame], 70.0),
                                   world_from_object=turn)
                np.testing.assert_allclose(other.positions, rotated(one.positions, 70.0), atol=5e-4, err_msg=name)

    def test_however_a_frame_was_reached_it_is_the_same_when_played_through(self) -> None:
        for name, settings in KINDS.items():
            settings = on_cloth(settings)
            fine, other = self.build(settings), self.build(settings)
            played = [self.solve(fine, f, settings) for f in FRAMES]
            for frame in (6, 3, 8):
                picture = self.solve(fine, frame, settings)
                self.assertTrue(picture.replayed)
                self.same(picture, played[frame - 1])
            self.solve(other, 6, settings)
            self.assertEqual(other.frame_cache.frames(), [(6.0, False)])
            for frame in (7, 2, 8):
                self.solve(other, frame, settings)
            for frame in FRAMES:
                self.same(self.solve(other, frame, settings), played[frame - 1])
            alone = replace(settings, stateless=True)
            forward = [self.solve(fine, f, alone) for f in FRAMES]
            for frame in reversed(FRAMES):
                self.same(self.solve(other, frame, alone), forward[frame - 1])

    def test_what_lies_on_the_cloth_does_not_solve_it_again_and_the_bits_are_those_of_a_fresh_solve(self) -> None:
        """A brush and a slider ask for one frame again and again: only what it is made of counts."""
        count = len(self.base.positions)
        half = np.full(count, 0.5, np.float32)
        inner = np.ascontiguousarray(self.base.corner_vertex[self.base.triangle_corner])
        worn = Body(self.clip[5] * np.array((0.97, 0.97, 1.0), np.float32), inner)
        other = Body(self.clip[5] * np.array((0.96, 0.96, 1.0), np.float32), inner)
        turned = np.ascontiguousarray(rotated(np.eye(3), 50.0) - rotated(np.zeros((1, 3)), 50.0))
        field, cloth = on_cloth(FIELD), {"mask": half, "room": half}
        # What is asked for, one after the other, and whether the cloth has to be solved for it.
        asked: list[tuple[Any, dict, int, dict[str, Any], bool]] = [
            (field, {}, 5, {}, True), (field, {"mask": half}, 5, {}, False),
            (replace(field, strength=0.5), {}, 5, {}, False),
            (field, cloth, 5, {}, True), (field, {**cloth, "mask": 0.5 * half}, 5, {}, False),
            (field, {**cloth, "room": 0.5 * half}, 5, {}, True), (field, {"follow": half}, 5, {}, True),
            (field, {}, 6, {}, True), (replace(field, room=0.01), {}, 5, {}, True),
            (field, {}, 5, dict(body=worn), True), (field, {"mask": half}, 5, dict(body=worn), False),
            (field, {}, 5, dict(body=other), True), (field, {}, 5, dict(world_from_object=turned), True),
            (replace(field, drape=0.5), {}, 5, {}, True), (replace(field, drape=0.6), {}, 5, {}, True),
            (replace(field, base_cloth="SWING"), {}, 5, {}, True),
            (replace(field, base_cloth="SWING"), {}, 5, dict(frame_rate=30.0), True),
            (replace(field, base_cloth="SWING", stateless=True), {}, 5, {}, True),
            (replace(field, base_cloth="SWING", stateless=True), {}, 5, dict(frame_rate=30.0), True)]
        fine = self.build(FIELD)
        for number, (settings, paint, frame, more, anew) in enumerate(asked):
            fine.frame_cache.clear()  # as another paint or setting does
            with mock.patch.object(BaseCloth, "solve", autospec=True, side_effect=BaseCloth.solve) as solved:
                shown = self.solve(fine, frame, settings, paint=paint, **more)
            self.assertEqual(solved.call_count, int(anew), number)
            self.same(shown, self.solve(self.build(FIELD), frame, settings, paint=paint, **more))

    def test_the_status_and_the_surface_that_others_lie_on_are_those_of_the_cloth(self) -> None:
        for settings in KINDS.values():
            fine = self.build(settings)
            self.assertIsNone(fine.worn_surface(5.0, self.clip[5], settings))
            picture = self.solve(fine, 5, on_cloth(settings))
            self.assertTrue(any("Base cloth" in line for line in fine.status(picture)))
            self.assertEqual(len(fine.status(self.solve(self.build(settings), 5, settings))) + 1,
                             len(fine.status(picture)))

    def test_what_others_lie_on_is_the_cloth_with_the_height_of_the_folds_around(self) -> None:
        """A shirt showed the folds of the trousers under it, where these were only in the picture."""
        for name in ("FIELD", "SHADED", "PATHS"):
            settings, at_once = KINDS[name], dict(fade=0.0, growth_limit=100.0) if name == "PATHS" else {}
            fine, flat, hung = self.build(settings), self.build(settings), on_cloth(settings, **at_once)
            no_folds = replace(hung, **{"height" if at_once else "strength": 0.0})
            for frame in range(1, 6):
                shown = self.solve(fine, frame, hung)
                self.solve(flat, frame, no_folds)
            cloth = fine.solved_over(5.0, self.clip[5])
            worn = fine.worn_surface(5.0, self.clip[5], hung)
            np.testing.assert_array_equal(flat.worn_surface(5.0, self.clip[5], no_folds).positions, cloth)
            if name == "SHADED":
                np.testing.assert_array_equal(worn.positions, cloth)
                continue
            radius, around = np.linalg.norm(shown.positions[:, :2], axis=1), fine.model.shown.triangle_vertex
            of_cloth, of_worn = (np.linalg.norm(one[around][..., :2], axis=2).max(axis=1)
                                 for one in (cloth, worn.positions))
            self.assertGreater((radius - of_cloth).max(), 1e-3, f"{name} has no folds")
            self.assertLess((radius - of_worn).max(), 2e-4, name)

    def test_folds_without_a_cloth_count_for_others_too(self) -> None:
        """Folds of leggings, without base cloth and body, came through the skirt over them."""
        for name in ("FIELD", "SHADED", "PATHS"):
            at_once = dict(fade=0.0, growth_limit=100.0) if name == "PATHS" else {}
            settings = replace(KINDS[name], **at_once)
            fine = self.build(settings)
            for frame in range(1, 6):
                shown = self.solve(fine, frame, settings)
            worn = fine.worn_surface(5.0, self.clip[5], settings)
            if name == "SHADED":
                self.assertIsNone(worn)  # the animated mesh
                continue
            radius, around = np.linalg.norm(shown.positions[:, :2], axis=1), fine.model.shown.triangle_vertex
            bare, of_worn = (np.linalg.norm(one[around][..., :2], axis=2).max(axis=1)
                             for one in (fine.solved_over(5.0, self.clip[5]), worn.positions))
            self.assertGreater((radius - bare).max(), 1e-3, f"{name} has no folds")
            self.assertLess((radius - of_worn).max(), 2e-4, name)

    def test_the_smooth_cloth_stays_off_a_body_that_it_would_cut_through(self) -> None:
        """The body has ridges half-way between the rings of the cloth, whose vertices know nothing of them."""
        body = tube(96, 20)  # a ring at every ring of the cloth, and one between them
        ridge = np.arange(len(body.positions)) // 96 % 2 == 1
        body.positions[:, :2] *= np.where(ridge, 0.0503, 0.046)[:, None] / 0.05
        worn = Body(body.positions, np.ascontiguousarray(body.corner_vertex[body.triangle_corner]))
        settings = on_cloth(replace(FIELD, strength=0.0), gravity=0.0)
        least = {}
        for covered in (True, False):
            fine = self.build(settings)
            with mock.patch.object(fine, "_keeps_off_bodies", lambda: not covered):
                shown = self.solve(fine, 1, settings, self.base.positions, body=worn).positions
            on_ridge = (np.abs(shown[:, 2] % 0.03 - 0.015) < 1e-3) & (shown[:, 2] > 0.04) & (shown[:, 2] < 0.26)
            least[covered] = float(np.linalg.norm(shown[on_ridge, :2], axis=1).min())
        self.assertLess(least[False], 0.0503)
        self.assertGreater(least[True], 0.0503 + 1e-3)

    def test_waves_do_not_go_into_a_body_between_the_vertices(self) -> None:
        """The waves were only as deep as the cloth had room at its vertices, and a thigh came through jeans as specks.
        The body is a tube with a rib between two columns of vertices, and as much room at these as the waves need."""
        body, column = tube(140, 20), np.pi / 14.0
        angle = np.arctan2(body.positions[:, 1], body.positions[:, 0])
        on_rib = np.abs(angle - column) < 0.5 * column
        body.positions[:, :2] *= np.where(on_rib, 0.047, 0.036)[:, None] / 0.05
        worn = Body(body.positions, np.ascontiguousarray(body.corner_vertex[body.triangle_corner]))
        settings = on_cloth(FIELD, gravity=0.0)
        fine = self.build(settings)
        shown = [self.solve(fine, frame, settings, body=worn).positions for frame in range(1, 6)][-1]
        beside = np.abs(np.arctan2(shown[:, 1], shown[:, 0]) - column)
        radius = np.linalg.norm(shown[:, :2], axis=1)
        self.assertGreater(radius[beside < 0.2 * column].min(), 0.047)
        self.assertLess(radius[beside > 3.0 * column].min(), 0.042)


def heights(picture: FrameResult) -> np.ndarray:
    """(d,) of the waves over the cloth of a tube along z, positive outwards."""
    outwards = (picture.offset[:, :2] * picture.positions[:, :2]).sum(axis=1)
    return np.copysign(np.linalg.norm(picture.offset, axis=1), outwards)


def fine_at_rest(case: OnCloth, settings: Any) -> np.ndarray:
    """What is shown of the rest pose without a base cloth."""
    return case.solve(case.build(settings), 1, settings, case.base.positions).positions


if __name__ == "__main__":
    unittest.main()
