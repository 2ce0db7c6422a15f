# SPDX-License-Identifier: GPL-3.0-or-later
"""The layer between Python and librumple: it says what is wrong, copies nothing, and agrees with the header."""
from __future__ import annotations

import copy
import ctypes
import gc
import inspect
import pickle
import re
import subprocess
import sys
import unittest
from pathlib import Path
from typing import Any

import numpy as np
import rumple_native as kernels
from support.meshes import compressed, tube
from rumple import native
from rumple.native import c
from rumple.native.library import lib
from rumple.native.struct import CHECKED

ROOT = Path(__file__).resolve().parents[2]
SETTINGS = {  # those of Python: the header of C++ and its struct
    "WrinkleMeshSettings": ("systems/wrinkle_mesh/wrinkle_mesh.h", "Settings"),
    "WrinkleFieldSettings": ("systems/wrinkle_field/wrinkle_field.h", "Settings"),
    "WrinklePathsSettings": ("systems/wrinkle_paths/wrinkle_paths.h", "Settings"),
    "BaseClothSettings": ("surface/cloth/base_cloth.h", "Settings"),
    "BaseClothSwing": ("surface/cloth/swing.h", "Swing"),
    "ForceField": ("surface/cloth/force_fields.h", "Field"),
}


def in_cpp(header: str, struct: str) -> dict[str, Any]:
    """Numbers and truth values that a struct of C++ begins with, by name."""
    text = re.sub(r"//[^\n]*", "", (ROOT / "native" / header).read_text())
    body = re.search(rf"struct {struct} (?:: \w+ )?\{{(.*?)\n\}};", text, re.S)[1]
    found = {}
    for kind, name, value in re.findall(r"\b(float|int|bool|std::uint32_t)\s+(\w+)\s*=\s*([^;]+);", body):
        found[name] = {"true": True, "false": False}.get(value.strip()) if kind == "bool" else eval(
            re.sub(r"(?<=[\d.])f\b", "", value))
    return found


class Header(unittest.TestCase):
    def test_the_declarations_are_those_of_the_header(self) -> None:
        sys.path.insert(0, str(ROOT / "scripts"))
        import declarations
        for name, text in declarations.files().items():
            self.assertEqual((ROOT / "addon/rumple/native/c" / name).read_text(), text,
                             f"{name}: run scripts/declarations.py")

    def test_every_function_of_the_header_is_declared_and_exported_and_nothing_else(self) -> None:
        said = {name for file in (ROOT / "native/include/rumple").glob("*.h")
                for name in re.findall(r"\b(rumple_\w+)\(", re.sub(r"//[^\n]*", "", file.read_text()))}
        self.assertEqual(said, set(c.FUNCTIONS))
        self.assertGreater(len(said), 130)
        if sys.platform == "linux":
            table = subprocess.run(["nm", "-D", "--defined-only", str(lib.path)], capture_output=True, text=True,
                                   check=True).stdout
            self.assertEqual({line.split()[-1] for line in table.splitlines()}, said)

    def test_every_struct_is_as_large_as_the_library_says(self) -> None:
        said = {name for file in (ROOT / "native/include/rumple").glob("*.h")
                for name in re.findall(r"^typedef struct (rumple_\w+) \{", file.read_text(), re.M)}
        self.assertEqual(said, set(c.STRUCTS))
        for name, struct in c.STRUCTS.items():
            self.assertEqual(lib.rumple_struct_size(name.encode()), ctypes.sizeof(struct), name)

    def test_every_default_of_cpp_is_that_of_c_and_of_python(self) -> None:
        for name, (header, struct) in SETTINGS.items():
            settings, expected = getattr(kernels, name)(), in_cpp(header, struct)
            self.assertGreater(len(expected), 5, name)
            for field, value in expected.items():
                self.assertEqual(getattr(settings, field), np.float32(value) if isinstance(value, float) else value,
                                 f"{name}.{field}")
            members = {member for member, *_ in type(settings)._fields_}
            self.assertEqual(expected.keys() - members, set(), name)
        cloth, clearance = kernels.BaseClothSettings(), in_cpp("surface/cloth/clearance.h", "ClearanceSettings")
        for field, value in clearance.items():
            self.assertEqual(getattr(cloth, field), np.float32(value), field)
        for field, value in in_cpp("surface/strain/adaptive_reference.h", "ReferenceSettings").items():
            for name in ("WrinkleMeshSettings", "WrinkleFieldSettings", "WrinklePathsSettings"):
                self.assertEqual(getattr(getattr(kernels, name)(), field), np.float32(value), f"{name}.{field}")
        self.assertEqual(kernels.WrinkleMeshSettings().reference, "STATIC_REST")
        self.assertEqual(kernels.WrinklePathsSettings().reference, "REST")

    def test_what_python_leaves_out_is_what_c_plans(self) -> None:
        for function, plan in ((kernels.build_wrinkle_mesh, lib.rumple_wrinkle_mesh_plan_default()),
                               (kernels.build_wrinkle_paths, lib.rumple_wrinkle_paths_plan_default()),
                               (kernels.build_wrinkle_field, lib.rumple_wrinkle_field_plan_default()),
                               (kernels.build_wrinkle_layers, lib.rumple_wrinkle_layers_plan_default()),
                               (kernels.scatter_rest_wrinkles, lib.rumple_scatter_default())):
            compared = 0
            for name, parameter in inspect.signature(function).parameters.items():
                holder = plan if hasattr(plan, name) else getattr(plan, "fine", plan)
                if not hasattr(holder, name) or isinstance(parameter.default, (str, type(inspect._empty), type(None))):
                    continue
                if parameter.default is not inspect._empty:
                    self.assertEqual(getattr(holder, name), np.float32(parameter.default) if isinstance(
                        parameter.default, float) else parameter.default, f"{function.__name__}: {name}")
                    compared += 1
            self.assertGreaterEqual(compared, 2, function.__name__)

    def test_every_function_takes_nothing_and_says_what_it_lacks(self) -> None:
        refused, without_rows = 0, ("rumple_probe_formula", "rumple_wrinkle_maps_blend",
                                    "rumple_force_fields_evaluate")
        for name, (result, arguments) in c.FUNCTIONS.items():
            nothing = [0 if kind in (ctypes.c_int32, ctypes.c_uint32, ctypes.c_size_t, ctypes.c_bool, ctypes.c_float)
                       else None for kind in arguments]
            if result is CHECKED and name not in without_rows:
                with self.assertRaisesRegex(ValueError, r"^[\w.]+: expected .*, got", msg=name):
                    getattr(lib, name)(*nothing)
                refused += 1
            else:
                getattr(lib, name)(*nothing)
        self.assertGreater(refused, 80)

    def test_another_library_is_refused_in_words(self) -> None:
        kept = c.STRUCTS["rumple_pose"]
        try:
            c.STRUCTS["rumple_pose"] = c.Bodies
            with self.assertRaisesRegex(native.NativeMissing, "rumple_pose"):
                type(lib)().open()
        finally:
            c.STRUCTS["rumple_pose"] = kept


class OnATube(unittest.TestCase):
    def setUp(self) -> None:
        self.base = tube(12, 10)
        self.surface = kernels.build_surface(self.base.positions, self.base.polygon_start, self.base.corner_vertex,
                                             self.base.triangle_corner)
        self.squeezed = np.ascontiguousarray(compressed(self.base.positions, 0.85), np.float32)
        self.model = kernels.build_wrinkle_mesh(self.surface, level=1)
        self.settings, self.paint = kernels.WrinkleMeshSettings(), kernels.WrinkleMeshPaint(self.model)

    def solve(self, *positions: Any) -> Any:
        return kernels.solve_wrinkle_mesh(self.model, self.settings, self.paint, *(positions or (self.squeezed,)))


class Arrays(OnATube):
    def test_what_is_wrong_with_an_array_is_said(self) -> None:
        good = self.squeezed
        shifted = np.frombuffer(b"\0" + good.tobytes(), np.float32, good.size, 1).reshape(-1, 3)  # between two floats
        for wrong, words in ((good.astype(np.float64), "float32 .* got float64"), (good[:, :2], r"\(n, 3\), got .*2\)"),
                             (good[::2], "not contiguous"), (shifted, "not aligned"),
                             (good.ravel(), r"\(n, 3\)"), (None, "NoneType"),
                             (good.tolist(), "list"), (good[:5], "expected .* got 5"),
                             (good.astype(">f4"), "got >f4")):
            with self.assertRaisesRegex(ValueError, f"positions: .*{words}"):
                self.solve(wrong)

    def test_what_is_not_finite_is_named(self) -> None:
        spoiled = self.squeezed.copy()
        spoiled[17, 1] = np.inf
        with self.assertRaisesRegex(ValueError, "positions: vertex 17 is not finite"):
            self.solve(spoiled)

    def test_nothing_that_is_right_is_copied(self) -> None:
        seen = []
        real = lib.rumple_wrinkle_mesh_pose_build
        try:
            lib.__dict__["rumple_wrinkle_mesh_pose_build"] = lambda *a: (seen.append(a[1].positions), real(*a))
            self.solve()
        finally:
            lib.__dict__["rumple_wrinkle_mesh_pose_build"] = real
        self.assertEqual(seen, [self.squeezed.ctypes.data])

    def test_a_result_is_a_view_that_cannot_be_written_and_keeps_what_it_is_of(self) -> None:
        state, _ = self.solve()
        frame = kernels.show_wrinkle_mesh(self.model, self.settings, self.squeezed, state)
        positions, again, values = frame.positions, frame.positions, frame.positions.copy()
        self.assertEqual(positions.ctypes.data, again.ctypes.data)
        with self.assertRaises(ValueError):
            positions[0, 0] = 1.0
        del frame, state, again
        gc.collect()
        for _ in range(20):  # others take the memory that was freed
            self.solve()
        np.testing.assert_array_equal(positions, values)

    def test_a_stored_state_that_does_not_fit_is_named(self) -> None:
        state, _ = self.solve()
        spoiled = state.offset.copy()
        spoiled[3, 2] = np.nan
        for offset, lengths, words in ((state.offset[:5], state.solved_length, "offset: expected .* got 5"),
                                       (state.offset, state.solved_length[:7], "solved_length: expected .* got 7"),
                                       (spoiled, state.solved_length, "offset: vertex 3 is not finite")):
            with self.assertRaisesRegex(ValueError, words):
                kernels.WrinkleMeshState(self.model, offset, lengths)
        field = kernels.build_wrinkle_field(self.surface)
        good, _ = kernels.solve_wrinkle_field(field, kernels.WrinkleFieldSettings(), kernels.WrinkleFieldPaint(),
                                              self.squeezed)
        with self.assertRaisesRegex(ValueError, "phase: expected .* got 2"):
            kernels.WrinkleFieldState(field, good.phase[:2], good.direction, good.solved_offset)
        with self.assertRaisesRegex(ValueError, "direction: vertex 0 is not finite"):
            kernels.WrinkleFieldState(field, good.phase, good.direction * np.float32(np.inf), good.solved_offset)

    def test_wrong_counts_are_refused_by_every_system(self) -> None:
        few, field = self.squeezed[:7], kernels.build_wrinkle_field(self.surface)
        paths, cloth = kernels.build_wrinkle_paths(self.surface, level=1), kernels.build_base_cloth(self.surface)
        layers = kernels.build_wrinkle_layers(self.surface, 1)
        options = kernels.WrinklePathsSettings()
        state, _ = kernels.solve_wrinkle_paths(paths, options, None, self.squeezed, 0.0)
        for call in (lambda: field.weld_pose(few), lambda: kernels.lay_out_canvas(field, few),
                     lambda: kernels.solve_base_cloth(cloth, kernels.BaseClothSettings(), None, few),
                     lambda: kernels.solve_wrinkle_layers(layers, [self.settings] * 2, None, few),
                     lambda: kernels.solve_wrinkle_layers(layers, [self.settings], None, self.squeezed),
                     lambda: kernels.solve_wrinkle_paths(paths, options, None, few, 0.0),
                     lambda: kernels.show_wrinkle_paths(paths, options, few, state),
                     lambda: kernels.wrinkle_path_stretches(paths, few, state),
                     lambda: kernels.wrinkle_path_ellipses(paths, few, state),
                     lambda: kernels.ride_wrinkle_paths(paths, options, self.squeezed, state, few),
                     lambda: kernels.label_clip(paths, options, np.arange(2.0), few),
                     lambda: self.model.shown.carry_points(few, 132),
                     lambda: self.model.shown.carry_points(few, 7)):
            with self.assertRaisesRegex(ValueError, "expected"):
                call()

    def test_paint_that_does_not_fit_is_named(self) -> None:
        with self.assertRaisesRegex(ValueError, "radius: expected 132 values, got 3"):
            kernels.WrinkleMeshPaint(self.model, dict(radius=np.ones(3, np.float32)))
        with self.assertRaisesRegex(ValueError, "paint: expected one of .*, got colour"):
            kernels.WrinkleMeshPaint(self.model, dict(colour=np.ones(132, np.float32)))


class Handles(OnATube):
    def test_a_state_of_another_model_is_refused(self) -> None:
        other = kernels.build_wrinkle_mesh(self.surface, level=1)
        state, _ = self.solve()
        with self.assertRaisesRegex(ValueError, "state: it was made for another model"):
            kernels.solve_wrinkle_mesh(other, self.settings, None, self.squeezed, state)
        with self.assertRaisesRegex(ValueError, "paint: it was made for another model"):
            kernels.solve_wrinkle_mesh(other, self.settings, self.paint, self.squeezed)

    def test_one_kind_of_handle_is_not_taken_for_another(self) -> None:
        state, _ = self.solve()
        for wrong in (self.surface, state, 7, "model"):
            with self.assertRaises(ctypes.ArgumentError):
                kernels.solve_wrinkle_mesh(wrong, self.settings, self.paint, self.squeezed)
        with self.assertRaisesRegex(ValueError, "model: expected a pointer, got NULL"):
            kernels.solve_wrinkle_mesh(None, self.settings, self.paint, self.squeezed)

    def test_a_handle_is_not_copied_for_it_is_freed_once(self) -> None:
        state, _ = self.solve()
        for copied in (copy.copy, copy.deepcopy, pickle.dumps):
            with self.assertRaisesRegex(TypeError, "WrinkleMeshState cannot be copied"):
                copied(state)

    def test_a_plan_or_a_pose_that_is_missing_is_named_by_every_system(self) -> None:
        surface = self.surface
        for name, model, settings in (
                ("wrinkle_mesh", self.model, self.settings),
                ("wrinkle_field", kernels.build_wrinkle_field(surface), kernels.WrinkleFieldSettings()),
                ("wrinkle_paths", kernels.build_wrinkle_paths(surface, level=0), kernels.WrinklePathsSettings())):
            place = ctypes.byref(type(model).POINTER())
            with self.assertRaisesRegex(ValueError, "plan: expected a pointer, got NULL"):
                getattr(lib, f"rumple_{name}_build")(surface, None, place)
            state = ctypes.byref(getattr(kernels, type(settings).__name__.replace("Settings", "State")).POINTER())
            written = (None, None) if name == "wrinkle_field" else (None,)  # report, waves
            pose = ctypes.byref(getattr(kernels, type(settings).__name__.replace("Settings", "Pose")).POINTER())
            with self.assertRaisesRegex(ValueError, "frame: expected a pointer, got NULL"):
                getattr(lib, f"rumple_{name}_pose_build")(model, None, pose)
            with self.assertRaisesRegex(ValueError, "pose: expected a pointer, got NULL"):
                getattr(lib, f"rumple_{name}_solve")(model, settings, None, None, None, *written, state)
            with self.assertRaisesRegex(ValueError, "settings: expected a pointer, got NULL"):
                made = getattr(kernels, type(settings).__name__.replace("Settings", "Pose")).of(model, self.squeezed)
                getattr(lib, f"rumple_{name}_solve")(model, None, None, made, None, *written, state)

    def test_what_was_refused_frees_nothing(self) -> None:
        for _ in range(3):
            with self.assertRaises(ValueError):
                kernels.build_surface(self.base.positions[:2], self.base.polygon_start, self.base.corner_vertex,
                                      self.base.triangle_corner)
            with self.assertRaises(ValueError):
                kernels.Collider(self.base.positions, np.zeros((0, 3), np.int32))
        gc.collect()

    def test_threads_solve_at_the_same_time_and_each_hears_of_its_own_fault(self) -> None:
        from concurrent.futures import ThreadPoolExecutor
        expected = self.solve()[0].offset
        spoiled = [self.squeezed.copy() for _ in range(8)]
        for number, positions in enumerate(spoiled):
            positions[number] = np.nan

        def work(number: int) -> str:
            np.testing.assert_array_equal(self.solve()[0].offset, expected)
            try:
                self.solve(spoiled[number])
            except ValueError as error:
                return str(error)
            return ""

        with ThreadPoolExecutor(4) as pool:
            for number, said in enumerate(pool.map(work, range(8))):
                self.assertEqual(said, f"positions: vertex {number} is not finite")


class Structs(unittest.TestCase):
    def test_a_setting_that_is_not_there_is_refused(self) -> None:
        settings = kernels.WrinkleMeshSettings()
        with self.assertRaises(AttributeError):
            settings.radios = 1.0
        with self.assertRaises(TypeError):
            settings.radius = "wide"
        with self.assertRaisesRegex(ValueError, "collision: expected one of NONE, PLANE, NEIGHBOURHOOD, got BALL"):
            settings.collision = "BALL"
        with self.assertRaisesRegex(ValueError, "reference: expected one of REST, .*, got 1"):
            settings.reference = 1

    def test_a_number_that_does_not_fit_is_refused(self) -> None:
        settings = kernels.WrinkleMeshSettings()
        for name, value in (("iterations", 2**31), ("seed", -1), ("seed", 2**32), ("threads", -2**40)):
            with self.assertRaisesRegex(ValueError, f"{name}: {value} is out of range"):
                setattr(settings, name, value)
        settings.seed = 2**32 - 1
        self.assertEqual(settings.seed, 2**32 - 1)

    def test_settings_of_two_objects_are_two(self) -> None:
        one, two = kernels.BaseClothSettings(), kernels.BaseClothSettings()
        one.gravity = (1, 2, 3.5)
        self.assertEqual(one.gravity, (1.0, 2.0, 3.5))
        self.assertEqual(two.gravity, (0.0, 0.0, float(np.float32(-9.81))))
        with self.assertRaisesRegex(ValueError, "gravity: expected three floats, got 2"):
            one.gravity = (1, 2)

    def test_choices_and_settings_inside_settings_read_back(self) -> None:
        settings = kernels.WrinklePathsSettings()
        settings.direction, settings.profile, settings.reference, settings.window = "BOTH", "SINE", "FIRST_FRAME", 0.5
        self.assertEqual((settings.direction, settings.profile, settings.reference, settings.window),
                         ("BOTH", "SINE", "FIRST_FRAME", 0.5))
        self.assertEqual((settings.rest.reference, settings.rest.window), (1, 0.5))


if __name__ == "__main__":
    unittest.main()
