# SPDX-License-Identifier: GPL-3.0-or-later
"""A setting is stated once: what Python says of it (core/settings/system_settings.py) is what the library says."""
from __future__ import annotations

import unittest
from dataclasses import fields
from typing import Any

import numpy as np
from rumple.core.settings.system_settings import FieldSettings, MeshSettings, PathsSettings
from rumple.native import kernels
from support.meshes import tube

PAIRS = {MeshSettings: "WrinkleMeshSettings", FieldSettings: "WrinkleFieldSettings",
         PathsSettings: "WrinklePathsSettings"}
# Settings of the same name with another default, and why.
OTHERS = {
    ("MeshSettings", "slack"): "of the base cloth; the library's is of one layer and says when the base pulls taut",
    ("FieldSettings", "rounds"): "one for each frame that plays; the library's suits single frames",
}


def shared(settings: type) -> dict[str, Any]:
    """The fields that the native settings have, too, by name."""
    there = {name for name, *_ in type(getattr(kernels, PAIRS[settings])())._fields_}
    return {f.name: f for f in fields(settings) if f.name in there}


class Stated(unittest.TestCase):
    def test_a_default_of_python_is_that_of_the_library(self) -> None:
        differing = set()
        for settings, name in PAIRS.items():
            options, there = getattr(kernels, name)(), shared(settings)
            self.assertGreater(len(there), 7, name)
            for field in there.values():
                expected = np.float32(field.default) if isinstance(field.default, float) else field.default
                if getattr(options, field.name) != expected:
                    differing.add((settings.__name__, field.name))
        self.assertEqual(differing, set(OTHERS))

    def test_the_library_takes_both_ends_of_every_range(self) -> None:
        base = tube(4, 2)
        positions, taken = base.positions, 0
        mesh = kernels.build_wrinkle_mesh(base.surface(True), level=0)
        paths = kernels.build_wrinkle_paths(base.surface(True), level=0)
        field = kernels.build_wrinkle_field(base.surface(True))
        state, _ = kernels.solve_wrinkle_paths(paths, kernels.WrinklePathsSettings(), None, positions, 0.0)
        check = {
            MeshSettings: lambda o: kernels.solve_wrinkle_mesh(mesh, o, None, positions),
            FieldSettings: lambda o: kernels.wave_parameters_wrinkle_field(field, o, kernels.WrinkleFieldPaint({})),
            PathsSettings: lambda o: kernels.show_wrinkle_paths(paths, o, positions, state)}
        for settings, name in PAIRS.items():
            for field_ in shared(settings).values():
                ends = field_.metadata["low"], field_.metadata["high"]
                for value in (end for end in ends if end is not None and not isinstance(field_.default, str)):
                    options = getattr(kernels, name)()
                    setattr(options, field_.name, type(field_.default)(value))
                    with self.subTest(settings=name, field=field_.name, value=value):
                        check[settings](options)
                        taken += 1
            options = getattr(kernels, name)()
            options.threads = -1  # else the call checks nothing
            with self.assertRaisesRegex(ValueError, "threads"):
                check[settings](options)
        self.assertGreater(taken, 30)


if __name__ == "__main__":
    unittest.main()
