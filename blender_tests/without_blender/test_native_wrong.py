# SPDX-License-Identifier: GPL-3.0-or-later
"""What a caller of the library gets wrong: things of another model, rows and places that are not there, numbers that
are none. Each is refused in words, before memory is touched."""
from __future__ import annotations

import unittest

import numpy as np
import rumple_native as kernels
from support.meshes import compressed, tube


class Refused(unittest.TestCase):
    def setUp(self) -> None:
        base = tube(12, 10)
        self.surface = kernels.build_surface(base.positions, base.polygon_start, base.corner_vertex,
                                             base.triangle_corner)
        self.squeezed = np.ascontiguousarray(compressed(base.positions, 0.85), np.float32)

    def test_what_was_made_for_another_model_is_refused_by_every_step(self) -> None:
        """Nobody compared whose waves, canvas, twins or state they were: memory beyond the arrays was
        read and written, and shown as values. The other model has the same mesh: sizes alone do not tell."""
        field, other = (kernels.build_wrinkle_field(self.surface) for _ in range(2))
        waves = kernels.estimate_waves_wrinkle_field(field, kernels.WrinkleFieldSettings(),
                                                     kernels.WrinkleFieldPaint(), self.squeezed)
        phase, sine = np.zeros(field.vertex_count, np.float32), kernels.WrinkleFieldProfile("SINE")
        canvas, painted = kernels.lay_out_canvas(field, self.squeezed), np.zeros_like(self.squeezed)
        dab = dict(centre=(0, 0, 0), normal=(0, 0, 1), view=(0, 0, 1), radius=10.0)
        paths, same = (kernels.build_wrinkle_paths(self.surface, level=1) for _ in range(2))
        options = kernels.WrinklePathsSettings()
        state, _ = kernels.solve_wrinkle_paths(paths, options, None, self.squeezed, 0.0)
        at = np.zeros(1, np.int32), np.full((1, 2), 0.3, np.float32)
        for call in (lambda: kernels.relax_wrinkle_field(other, kernels.WrinkleFieldSettings(), waves, 2, phase),
                     lambda: kernels.misfit_wrinkle_field(other, waves, phase),
                     lambda: kernels.evaluate_wrinkle_field(other, waves, sine, phase, *at),
                     lambda: kernels.apply_dab(other, canvas, painted, **dab),
                     lambda: kernels.apply_dab(field, canvas, painted, **dab, twins=kernels.find_twins(other)),
                     lambda: kernels.draw_rest_wrinkles(other, canvas, painted),
                     lambda: kernels.wrinkle_path_stretches(same, self.squeezed, state),
                     lambda: kernels.wrinkle_path_ellipses(same, self.squeezed, state)):
            with self.assertRaisesRegex(ValueError, "^(waves|canvas|twins|state): it was made for another model$"):
                call()

    def test_places_and_rows_beyond_a_model_are_refused_by_every_step(self) -> None:
        """A phase of another length, a triangle that is not there, fewer rows than are read: each was a crash, or
        foreign memory."""
        field, paths = kernels.build_wrinkle_field(self.surface), kernels.build_wrinkle_paths(self.surface, level=1)
        options, sine = kernels.WrinklePathsSettings(), kernels.WrinkleFieldProfile("SINE")
        waves = kernels.estimate_waves_wrinkle_field(field, kernels.WrinkleFieldSettings(),
                                                     kernels.WrinkleFieldPaint(), self.squeezed)
        drawing = kernels.draw_wrinkle_paths(paths, options, self.squeezed, kernels.solve_wrinkle_paths(
            paths, options, None, self.squeezed, 0.0)[0])
        canvas, inside = kernels.lay_out_canvas(field, self.squeezed), np.full((1, 2), 0.3, np.float32)
        few, neutral = np.zeros((3, 3), np.float32), np.zeros((2, 6), np.float32)
        maps, larger = (kernels.build_wrinkle_maps(
            ["a", "b"], ["BOTH"] * 2, np.full(2, -1, np.int32), neutral,
            [(f"pose {k}", neutral + np.float32(k + 1)) for k in range(count)], np.zeros(2, np.int32),
            np.zeros(0, np.int32), np.zeros(0, np.float32)) for count in (1, 2))
        shown = kernels.build_wrinkle_mesh(self.surface, level=1).shown
        influences = kernels.evaluate_wrinkle_maps(maps, neutral)
        calls = [lambda: kernels.apply_dab(field, canvas, few, centre=(0, 0, 0), normal=(0, 0, 1), view=(0, 0, 1),
                                           radius=10.0),
                 lambda: kernels.draw_rest_wrinkles(field, canvas, few),
                 lambda: kernels.presence_of_wrinkle_maps(larger, influences),
                 lambda: kernels.masks_of_wrinkle_maps(larger, influences),
                 lambda: shown.carry_points(np.zeros((1, 1), np.float32), 1),
                 lambda: shown.carry_corners(np.zeros((1, 1), np.float32), 1)]
        for length in (1, field.vertex_count - 1, field.vertex_count + 1, 200_000):
            calls.append(lambda length=length: kernels.misfit_wrinkle_field(field, waves, np.zeros(length, np.float32)))
        for place in (-1, paths.triangle_count, 50_000_000):
            which = np.array([place], np.int32)
            calls += [lambda which=which: kernels.drawn_wrinkle_paths(paths, options, drawing, which, inside),
                      lambda which=which: kernels.evaluate_wrinkle_field(
                          field, waves, sine, np.zeros(field.vertex_count, np.float32), which, inside)]
        none = np.full(field.vertex_count, np.nan, np.float32)  # int(x) of it was a place in the table of the profile
        with self.assertRaisesRegex(ValueError, "^phase: vertex 0 is not finite"):
            kernels.evaluate_wrinkle_field(field, waves, sine, none, np.zeros(1, np.int32), inside)
        calls.append(lambda: kernels.drawn_wrinkle_paths(paths, options, drawing, np.zeros(9, np.int32), inside))
        for number, call in enumerate(calls):
            with self.assertRaisesRegex(ValueError, r"^[\w ]+: expected .* got", msg=str(number)):
                call()

    def test_a_stored_number_that_is_none_is_named(self) -> None:
        """KeyError, TypeError and RuntimeError said neither what was wrong nor where."""
        paths = kernels.build_wrinkle_paths(self.surface, level=1)
        stored = kernels.solve_wrinkle_paths(paths, kernels.WrinklePathsSettings(), None, self.squeezed, 0.0)[0].arrays
        kernels.WrinklePathsState(paths, stored)
        for name, wrong in (("time", "x"), ("time", None), ("time", [1.0, 2.0]), ("next_id", "x"),
                            ("next_id", float("inf")), ("next_id", None)):
            with self.assertRaisesRegex(ValueError, f"state: expected a number {name}, got ", msg=str(wrong)):
                kernels.WrinklePathsState(paths, {**stored, name: wrong})
            with self.assertRaisesRegex(ValueError, f"state: expected a number {name}, got 'none'"):
                kernels.WrinklePathsState(paths, {key: value for key, value in stored.items() if key != name})
        with self.assertRaisesRegex(ValueError, "next_id: .* is out of range"):
            kernels.WrinklePathsState(paths, {**stored, "next_id": 2**70})

    def test_ids_of_paths_do_not_run_over(self) -> None:
        """The number of the next path had no upper bound: it became negative, and the state was refused afterwards."""
        model, settings = kernels.build_wrinkle_paths(self.surface, level=1), kernels.WrinklePathsSettings()
        settings.threshold, settings.width, settings.persistent = 1.05, 0.05, False
        stored = kernels.solve_wrinkle_paths(model, settings, None, self.squeezed, 0.0)[0].arrays
        self.assertGreater(len(stored["path_id"]), 2)
        with self.assertRaisesRegex(ValueError, "^next_id: expected 0 to 1.07374e[+]09, got 2.14748e[+]09"):
            kernels.WrinklePathsState(model, {**stored, "next_id": 2**31 - 1})
        last = kernels.WrinklePathsState(model, {**stored, "next_id": 2**30 - 1})
        after = kernels.solve_wrinkle_paths(model, settings, None, self.squeezed, 1.0, last)[0].arrays
        self.assertEqual((list(after["path_id"]), after["next_id"]), ([2**30 - 1], 2**30))
        kernels.WrinklePathsState(model, after)

    def test_a_painted_factor_is_refused_where_it_is_handed_over(self) -> None:
        """The paint was taken, and every frame was refused for it."""
        zero = np.zeros(len(self.squeezed), np.float32)
        with self.assertRaisesRegex(ValueError, "^width: number 0: expected 0.1 to 1, got 0"):
            kernels.WrinklePathsPaint(kernels.build_wrinkle_paths(self.surface, level=1), {"width": zero})
        with self.assertRaisesRegex(ValueError, "^wavelength: number 0: expected 0.001 to 1000, got 0"):
            kernels.estimate_waves_wrinkle_field(
                kernels.build_wrinkle_field(self.surface), kernels.WrinkleFieldSettings(),
                kernels.WrinkleFieldPaint({"wavelength": zero}), self.squeezed)

    def test_layers_of_another_mesh_are_not_shown_on_the_dense_one(self) -> None:
        """Only the number of vertices was compared."""
        dense = tube(48, 60)
        surface = kernels.build_surface(dense.positions, dense.polygon_start, dense.corner_vertex,
                                        dense.triangle_corner)
        coarse = kernels.build_coarse(surface, 0.1)
        layers = kernels.build_wrinkle_layers(coarse.surface, levels=1)
        kernels.build_wrinkle_transfer(surface, coarse, layers, 0)
        again = kernels.build_wrinkle_layers(kernels.build_coarse(surface, 0.1).surface, levels=1)
        with self.assertRaisesRegex(ValueError, "^layers: they were built over another mesh"):
            kernels.build_wrinkle_transfer(surface, coarse, again, 0)

    def test_a_fold_far_longer_than_wide_has_the_most_pieces_and_not_one(self) -> None:
        """More pieces than an int can count are any number when they are cast: it became one piece."""
        model, settings = kernels.build_wrinkle_paths(self.surface, level=1), kernels.WrinklePathsSettings()
        settings.threshold, settings.width = 1.05, 0.05
        state, _ = kernels.solve_wrinkle_paths(model, settings, None, self.squeezed, 0.0)
        points = []
        for settings.width in (0.05, 1e-2, 1e-4, 1e-10, 1e-20, 1e-37):
            curves = kernels.wrinkle_path_curves(model, settings, self.squeezed, state)
            self.assertTrue(np.isfinite(curves.positions).all())
            points.append(len(curves.positions))
        self.assertEqual(points, sorted(points))
        self.assertGreater(points[2], 5 * points[0])

    def test_a_setting_of_no_size_is_named_by_the_solver(self) -> None:
        """Such a setting of a damaged file was said with the signature of a C++ function."""
        model = kernels.build_wrinkle_paths(self.surface, level=0)
        for width in (0.0, -1.0, float("nan")):
            settings = kernels.WrinklePathsSettings()
            settings.width = width
            with self.assertRaisesRegex(ValueError, "^width: expected a value above 0"):
                kernels.solve_wrinkle_paths(model, settings, None, self.squeezed, 0.0)
        with self.assertRaisesRegex(ValueError, "profile: expected one of .*, got 99"):
            settings.profile = 99
        for level in (-1, 9, 100):  # 4**100 vertices were "about -9223372036854775808"
            with self.assertRaisesRegex(ValueError, f"^level: expected 0 to 8, got {level}"):
                kernels.build_wrinkle_mesh(self.surface, level=level)


if __name__ == "__main__":
    unittest.main()
