# SPDX-License-Identifier: GPL-3.0-or-later
"""The base cloth by itself: how it hangs where the shape at rest, a hold or the unit of length decides it. Under waves
and paths on a dense garment it is solved on a coarse mesh."""
from __future__ import annotations

import unittest
from dataclasses import replace
from typing import Any, Iterator
from unittest import mock

import numpy as np
from rumple.core.cloth.base_cloth import HANGING, BaseCloth, ClothInput, suggested_follow
from rumple.core.cloth.carried_cloth import CarriedCloth
from rumple.core.cloth.drape import Drape
from rumple.core.cloth.on_cloth import cloth_of
from rumple.core.frame.engine import Wrinkles
from rumple.core.mesh.base_mesh import BaseMesh
from rumple.core.mesh.body import Body
from rumple.core.settings.cloth_settings import ClothSettings
from rumple.core.settings.system_settings import FieldSettings, PathsSettings
from rumple.core.systems.all_systems import SYSTEMS
from support.frames import solve_frame
from support.meshes import rotated, thick_tube, tube


class Legs(unittest.TestCase):
    def test_a_leg_that_is_drawn_up_rides_up(self) -> None:
        """Nothing is painted. The hold of borders grows with the cube of what is suggested, up to that of a waistband:
        legs held an eighth as firmly did not move."""
        for radius in (0.05, 0.06, 0.07):
            base = tube(24, 30, radius, length=1.0)
            height = base.positions[:, 2]
            drawn = base.positions.copy()
            drawn[:, 2] += 0.04 * np.clip(2.5 * (height - 0.6), 0.0, 1.0)
            cloth = BaseCloth(base.surface(True), base.diagonal(), 1.0)
            way = cloth.solve(ClothSettings(base_cloth="HANG"), {}, ClothInput(drawn)).positions - drawn
            self.assertGreater(way[height == 0.0, 2].min(), 0.028, radius)
            self.assertLess(np.abs(way[height > 0.99]).max(), 1e-3, radius)


class WideTube(unittest.TestCase):
    """A tube that lies, held at one end: along it, and around the wider one, cloth turns by its weight."""

    LYING = np.array(((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)))

    def hung(self, unit_scale: float = 1.0, base_cloth: str = "HANG") -> np.ndarray:
        """(n, 3) metres."""
        mesh = tube(16, 10, 0.1 / unit_scale, 0.5 / unit_scale)
        settings = ClothSettings(base_cloth=base_cloth, room=0.2, slide_room=0.2)
        follow = (mesh.positions[:, 2] == mesh.positions[:, 2].min()).astype(np.float32)
        cloth = BaseCloth(mesh.surface(True), 1.0 / unit_scale, unit_scale)
        given = ClothInput(mesh.positions, self.LYING)
        return cloth.solve(settings, {"follow": follow}, given).positions * unit_scale

    def test_hanging_it_turns_more_than_cloth_that_is_firm_everywhere(self) -> None:
        turned = self.hung()
        with mock.patch.dict(HANGING, flat_share=1.0):
            self.assertGreater(np.linalg.norm(turned - self.hung(), axis=1).max(), 2e-3)

    def test_in_centimetres_it_is_as_in_metres(self) -> None:
        np.testing.assert_allclose(self.hung(0.01), self.hung(), atol=2e-4)

    def test_what_swings_is_firm_everywhere(self) -> None:
        swinging = self.hung(base_cloth="SWING")
        with mock.patch.dict(HANGING, flat_share=1.0):
            np.testing.assert_array_equal(self.hung(base_cloth="SWING"), swinging)


HANG: dict[str, Any] = dict(base_cloth="HANG", wavelength=0.05)
FIELD = FieldSettings(**HANG)
PATHS = PathsSettings(base_cloth="HANG", width=0.02, detail=1)
WEIGHTLESS: dict[str, Any] = dict(gravity=0.0, slack=1.0)
RADIUS, LENGTH = 0.1, 0.5
FRAMES = range(1, 25)
# Edges of 10 and 11 mm. The first was subdivided, so it is solved as it was modelled; the second on an even mesh.
DENSE = {"subdivided": (56, 46), "even": (62, 51)}
KINDS = {**{f"field, {name}": (FIELD, faces) for name, faces in DENSE.items()},
         "draped field": (replace(FIELD, drape=1.0), DENSE["even"]), "paths": (PATHS, DENSE["even"])}


def build(base: BaseMesh, settings: Any) -> Wrinkles:
    return SYSTEMS["PATHS" if isinstance(settings, PathsSettings) else "FIELD"].wrinkles.build(base, settings)


def squeezed(base: BaseMesh, frame: int) -> np.ndarray:
    """Pushed together, and more so on one side."""
    share = 1.0 - 0.04 * frame * (1.0 + base.positions[:, :1] / RADIUS)
    return np.ascontiguousarray(base.positions * np.concatenate([np.ones((len(share), 2)), share], 1), np.float32)


def cloth_at(fine: Wrinkles, frame: int, positions: np.ndarray, settings: Any, **more: Any) -> Any:
    """The base cloth of a frame, solved or stored."""
    solve_frame(fine, float(frame), positions, settings, more.pop("paint", {}), start=1, **more)
    return cloth_of(fine.state_of(float(frame)))


def played(fine: Wrinkles, settings: Any, frames: int = 4, **more: Any) -> Any:
    """The base cloth of the last of some frames."""
    return [cloth_at(fine, frame, squeezed(fine.base, frame), settings, **more) for frame in range(1, frames + 1)][-1]


def on_all_vertices(base: BaseMesh, settings: Any) -> Wrinkles:
    fine = build(base, settings)
    fine.find_cloth_mesh = None
    return fine


class OfDenseGarments(unittest.TestCase):
    """Under a Wrinkle Field or Paths it is solved on few vertices and carried to all of them."""

    def each(self) -> Iterator[tuple[BaseMesh, Any, Wrinkles]]:
        for settings, faces in KINDS.values():
            base = tube(*faces, RADIUS, LENGTH)
            yield base, settings, build(base, settings)

    def far(self, one: np.ndarray, other: np.ndarray) -> float:
        return float(np.linalg.norm(one - other, axis=1).max())

    def test_it_is_solved_on_fewer_vertices_and_has_values_for_all(self) -> None:
        for base, settings, fine in self.each():
            cloth = played(fine, settings, 1)
            self.assertLess(3 * len(cloth.solved), len(base.positions))
            mesh = fine.cloth_mesh
            assert mesh is not None
            self.assertEqual(mesh.coarse.spacing is None, around(base) == DENSE["subdivided"][0])
            self.assertEqual(cloth.positions.shape, base.positions.shape)
            self.assertEqual((cloth.gap.shape, len(cloth.body_hint)), ((len(base.positions),), 0))
            whole = played(on_all_vertices(base, settings), settings, 1)
            self.assertGreaterEqual(cloth.gap.min(), 0.0)
            np.testing.assert_allclose(np.median(cloth.gap), np.median(whole.gap), rtol=0.2)
            self.assertEqual(cloth.nbytes - whole.nbytes, cloth.solved.nbytes + cloth.state.nbytes - whole.state.nbytes
                             + cloth.drape.nbytes - (0 if whole.drape is None else whole.drape.nbytes))

    def test_other_garments_are_solved_on_their_own_vertices(self) -> None:
        """One that is not dense; one whose coarse mesh would have more than a third of its vertices; and every one
        without a base cloth."""
        for faces in ((28, 22), (32, 25)):
            self.assertTrue(played(build(tube(*faces, RADIUS, LENGTH), FIELD), FIELD, 1).solved is None, faces)
        base, off = tube(*DENSE["even"], RADIUS, LENGTH), replace(FIELD, base_cloth="OFF")
        body = Body(base.positions + np.float32(5.0), base.triangles)
        fine = build(base, FIELD)
        self.assertTrue(played(fine, off, 1, body=body).solved is None)
        self.assertIsNotNone(played(fine, FIELD, 1, body=body).solved)

    def test_switched_off_and_on_while_it_swings(self) -> None:
        """The state of a frame is then of other vertices: the cloth starts anew."""
        swinging = replace(FIELD, base_cloth="SWING", rest_shape="ADAPTIVE")
        base, settings = tube(*DENSE["even"], RADIUS, LENGTH), (swinging, replace(swinging, base_cloth="OFF"), swinging)
        body, fine = Body(base.positions + np.float32(5.0), base.triangles), build(base, swinging)
        with mock.patch.object(BaseCloth, "solve", autospec=True, side_effect=BaseCloth.solve) as solve:
            carried = [cloth_at(fine, frame, squeezed(base, frame), settings[frame - 1], body=body).solved is not None
                       for frame in (1, 2, 3)]
        self.assertEqual(carried, [True, False, True])
        self.assertEqual([call.args[4] for call in solve.call_args_list], [None] * 3)

    def test_it_hangs_as_if_all_vertices_were_solved(self) -> None:
        for base, settings, fine in self.each():
            if not settings.drape:  # folds as wide as five edges are others on edges of 10 mm
                cloth, whole = played(fine, settings), played(on_all_vertices(base, settings), settings)
                way = np.linalg.norm(whole.positions - squeezed(base, 4), axis=1)
                apart = np.linalg.norm(cloth.positions - whole.positions, axis=1)
                self.assertGreater(way.max(), 0.02)
                self.assertLess(apart.mean(), 0.4 * way.mean())

    def test_it_has_no_edges_of_the_coarse_triangles(self) -> None:
        """Along the tube it bends hardly more from vertex to vertex than with all vertices solved."""
        for base, settings, fine in self.each():
            bent = []
            for one in (fine, on_all_vertices(base, settings)):
                rings = played(one, replace(settings, drape=0.0), 2).positions.reshape(-1, around(base), 3)
                bent.append(np.quantile(np.linalg.norm(rings[2:] - 2.0 * rings[1:-1] + rings[:-2], axis=-1), 0.99))
            self.assertLess(bent[0], 1.2 * bent[1])

    def test_what_alternates_from_vertex_to_vertex_of_an_even_mesh_is_smoothed(self) -> None:
        """Irregular triangles are compressed in patches, and paths drew a bump on each of them. What is pinned stays,
        and so does a displacement that is the same everywhere."""
        base, random = tube(*DENSE["even"], RADIUS, LENGTH), np.random.default_rng(3)
        fine, solved, solve = build(base, FIELD), list[Any](), BaseCloth.solve

        def solve_and_keep(*args: Any) -> Any:
            frame = solve(*args)
            solved.append(frame.positions)
            return frame

        with mock.patch.object(BaseCloth, "solve", solve_and_keep):
            cloth = cloth_at(fine, 1, squeezed(base, 2), FIELD)
        draped, mesh = fine.draped_cloth(coarse=True), fine.cloth_mesh
        assert mesh is not None
        carried = CarriedCloth(fine.solved_surface, mesh.coarse, draped.drape)
        animated = mesh.coarse.positions(squeezed(base, 2))
        np.testing.assert_array_equal(cloth.solved, carried.smoothed(solved[0], animated, draped.cloth.follow))
        self.assertGreater(self.far(cloth.solved, solved[0]), 1e-4)

        free, moved = np.zeros(len(animated), np.float32), animated + np.float32(0.01)
        self.assertLess(self.far(carried.smoothed(moved, animated, free), moved), 1e-7)
        shaken = (animated + 1e-3 * random.standard_normal(animated.shape)).astype(np.float32)
        self.assertLess((carried.smoothed(shaken, animated, free) - animated).std(), 0.5e-3)
        np.testing.assert_allclose(carried.smoothed(shaken, animated, free + 1.0), shaken, atol=1e-7)
        subdivided = build(tube(*DENSE["subdivided"], RADIUS, LENGTH), FIELD)
        with mock.patch.object(BaseCloth, "solve", solve_and_keep):
            cloth = cloth_at(subdivided, 1, squeezed(subdivided.base, 2), FIELD)
        np.testing.assert_array_equal(cloth.solved, solved[-1], "as it was modelled, it is even")

    def test_at_rest_without_weight_it_stays_where_it_was_modelled(self) -> None:
        for base, settings, fine in self.each():
            cloth = cloth_at(fine, 1, base.positions, replace(settings, drape=0.0, **WEIGHTLESS))
            self.assertLess(self.far(cloth.positions, base.positions), 1e-3)
            held = replace(settings, drape=0.0, room=0.0, **WEIGHTLESS)
            np.testing.assert_allclose(cloth_at(fine, 2, base.positions, held).positions, base.positions, atol=1e-6)

    def test_rigid_motion_carries_it_along(self) -> None:
        turn = np.ascontiguousarray(rotated(np.eye(3), 70.0) - rotated(np.zeros((1, 3)), 70.0), np.float32)
        for base, settings, fine in self.each():
            plain = replace(settings, drape=0.0)
            here = cloth_at(fine, 1, squeezed(base, 2), plain).positions
            there = cloth_at(build(base, plain), 1, rotated(squeezed(base, 2), 70.0), plain, world_from_object=turn)
            np.testing.assert_allclose(there.positions, rotated(here, 70.0), atol=1e-5)

    def test_a_held_pose_comes_to_rest_and_stays_to_the_bit(self) -> None:
        for base, settings, fine in self.each():
            frames = [cloth_at(fine, frame, squeezed(base, min(frame, 3)), settings).positions for frame in FRAMES]
            self.assertGreater(self.far(frames[2], frames[1]), 1e-3)
            np.testing.assert_array_equal(frames[-1], frames[-2])

    def test_a_drape_goes_on_from_the_frame_before(self) -> None:
        base, settings = tube(*DENSE["even"], RADIUS, LENGTH), replace(FIELD, drape=1.0)
        fine = build(base, settings)
        with mock.patch.object(Drape, "solve", autospec=True, side_effect=Drape.solve) as solve:
            frames = [cloth_at(fine, frame, squeezed(base, frame), settings).drape for frame in (1, 2, 3)]
        self.assertEqual([call.kwargs["before"] for call in solve.call_args_list], [None, *frames[:2]])

    def test_however_a_frame_was_reached_it_is_the_same(self) -> None:
        for base, settings, fine in self.each():
            through = [cloth_at(fine, frame, squeezed(base, frame), settings).positions for frame in range(1, 5)]
            other = build(base, settings)
            for frame in (4, 2, 1, 2, 3, 4):
                cloth = cloth_at(other, frame, squeezed(base, frame), settings)
            np.testing.assert_array_equal(cloth.positions, through[-1])
            alone = replace(settings, stateless=True)
            forward, back = ([cloth_at(one, frame, squeezed(base, frame), alone).positions for frame in order]
                             for one, order in ((fine, (1, 2, 3)), (other, (3, 2, 1))))
            np.testing.assert_array_equal(forward, back[::-1])

    def test_a_loose_vertex_stays_as_animated_and_changes_nothing(self) -> None:
        for base, settings, fine in self.each():
            more = replace(base, positions=np.ascontiguousarray(np.r_[[[0.5, 0.0, 0.0]], base.positions], np.float32),
                           corner_vertex=base.corner_vertex + np.int32(1))
            cloth, other = played(fine, settings, 2), played(build(more, settings), settings, 2)
            np.testing.assert_array_equal(other.positions[0], squeezed(more, 2)[0])
            np.testing.assert_allclose(other.positions[1:], cloth.positions, atol=2e-3)
            np.testing.assert_allclose(other.gap[1:], cloth.gap, atol=2e-3)

    def test_it_stays_off_a_body_and_knows_how_far(self) -> None:
        """The body is a tube in it. The gap is the height above the cloth's inner surface, never above the body."""
        inner = tube(40, 31, 0.97 * RADIUS, LENGTH)
        body = Body(inner.positions, inner.triangles)
        for base, settings, fine in self.each():
            cloth = played(fine, settings, 3, body=body)
            middle = np.abs(cloth.positions[:, 2] - cloth.positions[:, 2].mean()) < 0.3 * np.ptp(cloth.positions[:, 2])
            height = np.linalg.norm(cloth.positions[:, :2], axis=1) - 0.97 * RADIUS
            self.assertGreater(height[middle].min(), settings.thickness - 1e-3)
            self.assertTrue((cloth.gap[middle] < height[middle]).all())
            self.assertTrue(((cloth.body_hint >= 0) & (cloth.body_hint < len(body.triangles))).all())

    def test_the_inner_side_moves_with_the_outer_one_and_stays_off_a_body(self) -> None:
        """Also of a garment that is not dense."""
        thickness, inner = 0.004, tube(40, 31, 0.97 * RADIUS, LENGTH)
        for settings, faces in ((FIELD, DENSE["even"]), (PATHS, DENSE["even"]), (FIELD, (28, 22))):
            base, dense = thick_tube(*faces, RADIUS, LENGTH, thickness), faces == DENSE["even"]
            fine = build(base, settings)
            for frame in range(1, 4):
                body = Body(squeezed(inner, frame), inner.triangles)
                cloth = cloth_at(fine, frame, squeezed(base, frame), settings, body=body)
            self.assertIn("Thickness of 4.0 mm: the inner side moves with the outer one", fine.status(
                solve_frame(fine, 3.0, squeezed(base, 3), settings, {}, start=1, body=body)))
            outside, inside = np.split(cloth.positions, 2)
            self.assertLess((8 if dense else 4) * len(cloth.solved), len(base.positions))
            self.assertGreater(self.far(outside, squeezed(base, 3)[:len(outside)]), 0.01)
            apart = np.linalg.norm(outside - inside, axis=1) / thickness
            most = 0.95 if dense else 0.6  # triangles of 5 cm shear where it is squeezed most
            self.assertTrue((np.abs(np.quantile(apart, (0.05, 0.5, most)) - 1.0) < 0.1).all())
            middle = np.abs(inside[:, 2] - inside[:, 2].mean()) < 0.3 * np.ptp(inside[:, 2])
            in_body = np.linalg.norm(inside[middle, :2], axis=1) <= 0.97 * RADIUS
            self.assertLessEqual(in_body.mean(), 0.0 if dense else 0.25)  # 0.93 if both sides are solved
            follow = suggested_follow(tube(*faces, RADIUS, LENGTH).surface(True), settings.up)
            np.testing.assert_array_equal(fine.suggested_follow(settings)[:len(follow)], follow)  # it has a collar

    def test_paint_counts_and_what_is_suggested_is_what_counts_without(self) -> None:
        for base, settings, fine in self.each():
            firm = {"follow": np.ones(len(base.positions), np.float32)}
            plain = replace(settings, drape=0.0)
            self.assertLess(self.far(played(fine, plain, paint=firm).positions, squeezed(base, 4)), 5e-3)
            free = played(fine, plain).positions
            self.assertGreater(self.far(free, squeezed(base, 4)), 0.02)
            suggested = {"follow": fine.suggested_follow(plain)}
            np.testing.assert_array_equal(played(fine, plain, paint=suggested).positions, free)

    def test_what_is_kept_smooth_has_no_drape(self) -> None:
        base, settings = tube(*DENSE["even"], RADIUS, LENGTH), replace(FIELD, drape=1.0)
        smooth = {"smooth": np.ones(len(base.positions), np.float32)}
        draped, kept, plain = (played(build(base, settings), one, paint=paint) for one, paint in (
            (settings, {}), (settings, smooth), (replace(settings, drape=0.0), {})))
        self.assertGreater(self.far(draped.positions, plain.positions), 2e-3)
        np.testing.assert_allclose(kept.positions, plain.positions, atol=1e-5)

    def test_its_drape_is_as_wide_as_that_of_the_garment_with_fewer_vertices(self) -> None:
        """Folds are five edges wide: on the garment's own edges of 11 mm they were as narrow as waves. The vertices are
        on the smooth surface of the folds, which is lower than their crests by up to a quarter."""
        heights = []
        for faces in ((28, 23), DENSE["subdivided"]):
            base = tube(*faces, RADIUS, LENGTH)
            fine, weightless = build(base, FIELD), replace(FIELD, **WEIGHTLESS)
            draped, plain = (played(fine, replace(weightless, drape=height)).positions for height in (1.0, 0.0))
            way = (draped - plain).reshape(faces[1] + 1, faces[0], 3)[::faces[1] // 23, ::faces[0] // 28]
            heights.append(np.sqrt((way ** 2).sum(axis=-1).mean()))
        self.assertLess(heights[1], heights[0])
        self.assertGreater(heights[1], 0.7 * heights[0])


def around(base: BaseMesh) -> int:
    """Vertices of a ring of a tube."""
    return int(np.count_nonzero(base.positions[:, 2] == 0.0))


if __name__ == "__main__":
    unittest.main()
