# SPDX-License-Identifier: GPL-3.0-or-later
"""scripts/makehuman.py reads figures and outfits: files of a few lines, worked by hand."""
from __future__ import annotations

import json
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import makehuman  # noqa: E402

BASE = "v 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 10\ng body\nf 1 2 3\ng helper\nf 1 2 4\n"
RIG = {"joints": {"foot": [0], "knee": [1, 2]},
       "bones": {"upper": {"parent": "lower", "head": "knee", "tail": "foot"},
                 "lower": {"parent": None, "head": "foot", "tail": "knee"}}}
WEIGHTS = {"weights": {"lower": [[0, 1.0], [1, 0.5]], "upper": [[1, 0.5], [2, 2.0]]}}
OUTFIT = ("obj_file o.obj\nx_scale 0 1 6.0\n# a comment\nverts 0\n0 1 2 0.5 0.25 0.25 0.1 0.2 0.3\n2\n"
          "delete_verts\n0 - 1 3\n")


class MakeHuman(unittest.TestCase):
    def setUp(self) -> None:
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        for name, text in {"3dobjs/base.obj": BASE, "rigs/default.mhskel": json.dumps(RIG),
                           "rigs/default_weights.mhw": json.dumps(WEIGHTS), "targets/wide.target": "1 2 0 0\n",
                           "o.obj": "v 0 0 0\nv 0 0 0\nvt 0.25 0.5\nf 1/1 2/1 1/1\n", "o.mhclo": OUTFIT}.items():
            path = self.folder / name
            path.parent.mkdir(exist_ok=True)
            path.write_text(text, encoding="utf-8")
        self.figure = makehuman.read_figure(self.folder, ("wide",))

    def test_bones_come_after_their_parents_at_the_means_of_their_joints(self) -> None:
        self.assertEqual(list(self.figure.bones), ["lower", "upper"])
        parent, head, tail = self.figure.bones["upper"]
        self.assertEqual(parent, "lower")
        np.testing.assert_allclose(head, (0.6, 0.0, 0.5))  # of (12, 0, 0) and (0, 10, 0), y up, decimetres
        np.testing.assert_allclose(tail, (0.0, 0.0, 0.0))
        np.testing.assert_allclose(self.figure.weights, [[1.0, 0.0], [0.5, 0.5], [0.0, 1.0], [0.0, 0.0]])

    def test_an_outfit_stands_by_three_vertices_and_a_scaled_offset(self) -> None:
        outfit = makehuman.read_outfit(self.folder / "o.mhclo", self.figure)
        np.testing.assert_allclose(outfit.mesh.points, [[0.32, -0.03, 0.27], [0.0, 0.0, 1.0]])
        np.testing.assert_allclose(outfit.weights, [[0.625, 0.375], [0.0, 1.0]])
        self.assertEqual(outfit.mesh.uvs, [[(0.25, 0.5)] * 3])
        self.assertEqual(outfit.hidden, {0, 1, 3})

    def test_the_skin_is_the_body_without_what_is_hidden_wholly(self) -> None:
        skin, weights = makehuman.skin_of(self.figure, {0, 1, 3})
        self.assertEqual(skin.corners, [[0, 1, 2]])
        np.testing.assert_allclose(skin.points, [[0.0, 0.0, 0.0], [1.2, 0.0, 0.0], [0.0, 0.0, 1.0]])
        self.assertEqual(len(weights), 3)

    def test_what_is_wrong_is_said(self) -> None:
        (self.folder / "o.obj").write_text("v 0 0 0\n", encoding="utf-8")
        with self.assertRaisesRegex(ValueError, "2 references for 1 vertices"):
            makehuman.read_outfit(self.folder / "o.mhclo", self.figure)
        loop = {**RIG, "bones": {name: {**bone, "parent": "upper"} for name, bone in RIG["bones"].items()}}
        (self.folder / "rigs/default.mhskel").write_text(json.dumps(loop), encoding="utf-8")
        with self.assertRaisesRegex(ValueError, "hang from no root"):
            makehuman.read_figure(self.folder, ())


if __name__ == "__main__":
    unittest.main()
