# SPDX-License-Identifier: GPL-3.0-or-later
"""The garments that the demo is made of: closed but for their openings, faces outward, clear of the body."""
from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import unittest
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
if str(SCRIPTS) not in sys.path:
    sys.path.insert(0, str(SCRIPTS))
import demo_body  # noqa: E402
import demo_shirt  # noqa: E402
import demo_trousers  # noqa: E402
from rumple.core.mesh.base_mesh import BaseMesh  # noqa: E402
from rumple.core.mesh.body import Body  # noqa: E402
from rumple.core.settings.system_settings import MeshSettings  # noqa: E402
from rumple.core.systems.wrinkle_mesh import WrinkleMesh, cloth_defaults  # noqa: E402
from support.frames import solve_frame  # noqa: E402


class Script(unittest.TestCase):

    def test_a_report_of_an_older_run_is_no_success(self) -> None:
        """Where Blender did not even start, the demo ended well."""
        with tempfile.TemporaryDirectory() as folder:
            scripts, out = Path(folder, "scripts"), Path(folder, "out")
            for made in (scripts, out):
                made.mkdir()
            for name in ("demo", "lib.sh"):
                shutil.copy(SCRIPTS / name, scripts)
            for name in ("install", "build"):
                (scripts / name).symlink_to("/bin/true")
            (out / "report.json").write_text("{}")
            done = subprocess.run([str(scripts / "demo"), "--out", str(out), "--blender", "false"], capture_output=True)
            self.assertEqual(done.returncode, 1, done)
            self.assertIn(b"no report was made", done.stderr)


class Garment:
    """What holds for each of them."""

    openings: int

    @classmethod
    def build(cls) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Points, quads, UVs."""
        raise NotImplementedError

    @classmethod
    def setUpClass(cls) -> None:
        cls.points, cls.quads, cls.uvs = cls.build()

    def test_two_faces_at_an_edge_that_run_along_it_in_opposite_ways(self) -> None:
        uses = Counter((int(quad[k]), int(quad[(k + 1) % 4])) for quad in self.quads for k in range(4))
        self.assertEqual(max(uses.values()), 1)
        self.assertTrue((np.bincount(self.quads.ravel()) > 0).all())

    def test_its_openings(self) -> None:
        uses = {(int(quad[k]), int(quad[(k + 1) % 4])) for quad in self.quads for k in range(4)}
        onwards = {b: a for a, b in uses if (b, a) not in uses}
        loops = 0
        while onwards:
            loops += 1
            at = next(iter(onwards))
            while at in onwards:
                at = onwards.pop(at)
        self.assertEqual(loops, self.openings)

    def test_faces_look_outwards(self) -> None:
        a, b, c, d = (self.points[self.quads[:, k]] for k in range(4))
        normals = np.cross(c - a, d - b)
        middles = (a + b + c + d) / 4.0
        away = demo_body.distance_gradient(middles, demo_body.body_distance)
        self.assertGreater((np.einsum("ij,ij->i", normals, away) > 0.0).mean(), 0.97)

    def test_it_lies_outside_the_body(self) -> None:
        self.assertGreater(demo_body.body_distance(self.points).min(), 0.004)

    def test_each_side_is_that_of_the_mirror(self) -> None:
        mirrored = {tuple(np.round(p * (-1.0, 1.0, 1.0), 4) + 0.0) for p in self.points}
        same = {tuple(np.round(p, 4) + 0.0) for p in self.points}
        self.assertLess(len(same - mirrored), 0.02 * len(same))

    def test_the_texture_is_within_the_image(self) -> None:
        self.assertTrue((self.uvs >= 0.0).all() and (self.uvs <= 1.0).all())


class Shirt(Garment, unittest.TestCase):
    openings = 4

    @classmethod
    def build(cls) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        shirt = demo_shirt.build_shirt()
        return shirt.points, shirt.quads, shirt.uvs


class Trousers(Garment, unittest.TestCase):
    openings = 3

    @classmethod
    def build(cls) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        trousers = demo_trousers.build_trousers()
        return trousers.points, trousers.quads, trousers.uvs


def fans(quads: np.ndarray) -> np.ndarray:
    """(2 m, 3) of (m, 4), int32."""
    return np.ascontiguousarray(np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]), np.int32)


def face_normals(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    return normals / np.linalg.norm(normals, axis=1)[:, None]


class AtRest(unittest.TestCase):
    """There was a knob on the front of the trousers, in a fold that no simulation has."""

    def shown(self, slack: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """One click on the standing figure: points without and with layers, triangles."""
        points, quads, _ = Trousers.build()
        corners = np.arange(4 * len(quads), dtype=np.int32).reshape(-1, 4)
        base = BaseMesh("Trousers", np.ascontiguousarray(points, np.float32), np.append(corners[:, 0], corners.size)
                        .astype(np.int32), quads.ravel().astype(np.int32), fans(corners))
        skin, skin_quads = demo_body.build_body(0.012)
        body = Body(np.ascontiguousarray(skin, np.float32), fans(skin_quads))
        settings = MeshSettings(**{**cloth_defaults(base, 1.0, np.eye(3)), "slack": slack})
        fine = WrinkleMesh.build(base, settings)
        without, folded = (solve_frame(
            fine, 1.0, base.positions, replace(settings, **dict.fromkeys(("drape", "folds", "detail"), share)), {},
            start=1, body=body, world_from_object=np.eye(3, dtype=np.float32)).positions.copy() for share in (0.0, 1.0))
        return without, folded, fans(fine.shown.corner_vertex.reshape(-1, 4))

    def turned(self, slack: float) -> tuple[float, float]:
        """Degrees by which layers turn the surface, root of the mean of squares: of the hips, of the legs."""
        without, folded, triangles = self.shown(slack)
        cosine = np.einsum("ij,ij->i", face_normals(without, triangles), face_normals(folded, triangles))
        squares = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))**2
        height = without[triangles].mean(1)[:, 2]
        hips, legs = (height > 0.80) & (height < 1.0), (height > 0.1) & (height < 0.7)
        return float(np.sqrt(squares[hips].mean())), float(np.sqrt(squares[legs].mean()))

    def test_trousers_that_are_cut_wider_hang_and_have_no_ripples(self) -> None:
        hips, legs = self.turned(1.02)
        self.assertLess(hips, 2.2)
        self.assertLess(legs, 2.2)

    def test_legs_that_are_cut_far_wider_fold(self) -> None:
        self.assertGreater(self.turned(1.15)[1], 4.0)


if __name__ == "__main__":
    unittest.main()
