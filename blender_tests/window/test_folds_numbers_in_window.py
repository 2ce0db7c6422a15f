# SPDX-License-Identifier: GPL-3.0-or-later
"""The GPU preview of the Wrinkle Paths: its numbers against C++."""
from __future__ import annotations

from types import SimpleNamespace

import gpu
import numpy as np
from mathutils import Matrix
from rumple import native
from rumple.blender.viewport import glsl, gpu_arrays, preview, preview_paths
from rumple.core.frame import engine
from rumple.core.settings.system_settings import PathsSettings
from rumple.core.systems.wrinkle_paths import WrinklePaths
from support.frames import solve_frame
from support.preview_case import showing_normals
from support.window_case import WindowCase

SIDE = 400  # pixels of the drawings into a buffer
WIDTH = 0.08  # of the folds of the sheet, which is a metre wide

PROBE = """
void main() {
    int i = THIS_TEXEL(lists);
    vec4 place = TEXEL(places, i);
    vec3 n = TEXEL(normals, i).xyz;
    FoldBlend blend = folds_at(ivec2(TEXEL(lists, i).xy), place.xyz, n, place.w);
    out_fold = vec4(blended_normal(blend, n), blend.height);
}
"""


class Sheet:
    """A curved uneven sheet that is squeezed, with its folds, without Blender."""

    def __init__(self, attachment: str = "LIMIT", flat: bool = False, count: int = 11, **settings: object) -> None:
        random = np.random.default_rng(2)
        line = np.linspace(0.0, 1.0, count)
        rest = np.array([(x, y, 0.0) for y in line for x in line])
        inner = (np.abs(rest[:, :2] - 0.5) < 0.49).all(1)
        rest[inner, :2] += random.uniform(-0.25, 0.25, (inner.sum(), 2)) / (count - 1)
        first = np.array([j * count + i for j in range(count - 1) for i in range(count - 1)], np.int32)
        quads = np.stack((first, first + 1, first + count + 1, first + count), 1)
        corner = 4 * np.arange(len(quads), dtype=np.int32)[:, None]
        triangles = np.concatenate((corner + (0, 1, 2), corner + (0, 2, 3)), 1).reshape(-1, 3).astype(np.int32)
        self.base = engine.BaseMesh("Sheet", rest.astype(np.float32), np.arange(0, quads.size + 1, 4, dtype=np.int32),
                                    quads.ravel(), triangles)
        self.settings = PathsSettings(width=WIDTH, attachment=attachment, hem_rings=1, **settings)
        self.fine = WrinklePaths.build(self.base, self.settings)
        bulge = 0.0 if flat else 0.08
        self.pose = np.column_stack((0.7 * rest[:, 0], rest[:, 1], bulge * np.sin(5.0 * rest[:, 0] + 3.0 * rest[:, 1])))
        self.pose = self.pose.astype(np.float32)
        for frame in range(1, 16):  # folds rise in some frames
            share = min(frame / 6.0, 1.0)
            pose = ((1.0 - share) * rest + share * self.pose).astype(np.float32)
            self.sketch = solve_frame(self.fine, float(frame), pose, self.settings, {}, start=1, for_preview=True)
        self.drawing = self.sketch.drawing
        self.native_settings = self.fine._native_settings(self.settings)

    def points(self, count: int, inside: bool = False) -> tuple[np.ndarray, np.ndarray]:
        """(triangle, weights of corners 1 and 2): random ones, edges and corners among them unless inside."""
        random = np.random.default_rng(5)
        triangle = random.integers(0, len(self.fine.model.triangle_vertex), count).astype(np.int32)
        weights = random.dirichlet((1.0, 1.0, 1.0), count)
        if not inside:
            weights[::5] = np.eye(3)[random.integers(0, 3, len(weights[::5]))]
            weights[1::5, 0] = 0.0
            weights /= weights.sum(1, keepdims=True)
        return triangle, np.ascontiguousarray(weights[:, 1:], np.float32)

    def twin(self, triangle: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """(n, 7) position, height and normal by C++."""
        return native.load().drawn_wrinkle_paths(self.fine.model, self.native_settings, self.drawing, triangle, weights)

    def mixed(self, values: np.ndarray, triangle: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Values of welded vertices at places."""
        corners = values[self.fine.model.triangle_vertex[triangle]]
        all_weights = np.column_stack((1.0 - weights.sum(1), weights)).astype(np.float32)
        return sum(corners[:, k] * all_weights[:, k].reshape(-1, *[1] * (corners.ndim - 2)) for k in range(3))


class Formulas(WindowCase):

    def test_heights_and_normals_are_those_of_cpp(self) -> None:
        for profile in preview_paths.PROFILES:
            for direction in ("OUTWARD", "BOTH"):
                sheet = Sheet(profile=profile, direction=direction)
                triangle, weights = sheet.points(4000)
                expected = sheet.twin(triangle, weights)
                lists = sheet.drawing.lists
                normal = sheet.mixed(sheet.drawing.normal, triangle, weights)
                normal /= np.sqrt((normal * normal).sum(1, keepdims=True))
                place = np.column_stack((sheet.mixed(sheet.drawing.flat, triangle, weights),
                                         sheet.mixed(sheet.drawing.hem, triangle, weights)))
                start = lists.triangle_start
                inputs = dict(lists=np.column_stack((start[triangle], start[triangle + 1])), places=place,
                              normals=normal, ranges=lists.ranges, ends=lists.ends.reshape(-1, 4))
                probe = gpu_arrays.Pass(
                    glsl.source(*glsl.FOLDS, "preview/texels", "preview/folds") + PROBE, tuple(inputs),
                    ("out_fold",), (("INT", "profile_kind"),))
                target = gpu_arrays.Target(len(triangle))
                gpu_arrays.plain_state()
                probe.run(target, {name: gpu_arrays.upload(values) for name, values in inputs.items()},
                          profile_kind=preview_paths.PROFILES.index(profile))
                found = target.read()
                self.assertGreater((np.abs(expected[:, 3]) > 0.1 * WIDTH).sum(), 400)
                self.assertEqual((expected[:, 3] < -1e-3 * WIDTH).any(), direction == "BOTH")
                np.testing.assert_allclose(found[:, 3], expected[:, 3], atol=1e-5 * WIDTH)
                # At a crest the gradient turns round within rounding of the place.
                off = np.abs(found[:, :3] - expected[:, 4:]).max(1)
                self.assertLess(np.percentile(off, 99), 1e-4)
                self.assertLess(off.mean(), 1e-4)

    def test_patterns_cover_a_triangle_once(self) -> None:
        for parts in (1, 2, 8, 32):
            points, cells = preview_paths.spots(parts), preview_paths.cells(parts)
            self.assertEqual((len(points), len(cells)), ((parts + 1) * (parts + 2) // 2, parts * parts))
            a, b, c = (points[cells[:, k]] for k in range(3))
            twice_area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
            np.testing.assert_array_equal(twice_area, 1)  # all as large, all the same way round: parts^2 in all
            self.assertTrue((points >= 0).all() and (points.sum(1) <= parts).all())

    def test_runs_draw_every_patch_once(self) -> None:
        for parts in (1, 8, 32):
            for count in (1, 2, 7, 600, 5000):
                drawn = [i for first, size in preview_paths.runs(3, count, parts) for i in range(first, first + size)]
                self.assertEqual(drawn, list(range(3, 3 + count)))


class SheetObject(SimpleNamespace):
    """What the drawing reads of an object of Blender's; like one, it can be a key."""

    __hash__ = object.__hash__


class Stage(WindowCase):
    """The sheet drawn into a buffer, seen from above."""

    def drawn(self, sheet: Sheet, view: Matrix = Matrix.Translation((-0.35, -0.5, 0.0))) -> None:
        """self.color (SIDE, SIDE, 4), the bottom row first, alpha 0 where nothing is; self.depth (SIDE, SIDE)."""
        drawing = preview_paths.Drawing(sheet.fine.model)
        mesh = SimpleNamespace(uv_layers=())
        obj = SheetObject(matrix_world=Matrix(), dimensions=(1.0, 1.0, 1.0), material_slots=(), data=mesh,
                          rumple=SimpleNamespace(incoming=None))
        entry = SimpleNamespace(result=sheet.sketch, evaluator=sheet.fine,
                                inputs=SimpleNamespace(settings=sheet.settings))
        self.assertTrue(drawing.update(obj, entry, None, np.zeros(len(sheet.base.triangle_corner), np.int32)))
        buffer = gpu.types.GPUOffScreen(SIDE, SIDE, format="RGBA32F")
        with buffer.bind():
            here = gpu.state.active_framebuffer_get()
            here.clear(color=(0.0, 0.0, 0.0, 0.0), depth=1.0)
            with gpu.matrix.push_pop(), gpu.matrix.push_pop_projection():
                gpu.matrix.load_matrix(view)
                gpu.matrix.load_projection_matrix(Matrix.Diagonal((1.0 / 0.6, 1.0 / 0.6, -1.0, 1.0)))
                preview._draw_object(obj, preview._OnGpu(sheet.fine.model, drawing), showing_normals(),
                                     gpu_arrays.no_overlays())
            color, depth = (here.read_color(0, 0, SIDE, SIDE, 4, 0, "FLOAT"), here.read_depth(0, 0, SIDE, SIDE))
        gpu_arrays.plain_state()
        self.color, self.depth = as_array(color, 4), as_array(depth, 1)[..., 0]
        buffer.free()

    def normals(self) -> np.ndarray:
        scale = np.float32(4.0).view(np.int32)  # the reciprocal of 4 as studio_light.glsl has it
        return self.color[..., :3] / np.int32(0x7EEF370B - scale).view(np.float32) - 1.0

    def test_pixels_have_the_normal_and_the_place_of_cpp(self) -> None:
        sheet = Sheet("LINEAR", flat=True)
        triangle, weights = sheet.points(3000, inside=True)
        expected = sheet.twin(triangle, weights)
        self.drawn(sheet)
        at = (expected[:, :2] - (0.35, 0.5)) / 0.6
        pixel = np.floor((at + 1.0) * SIDE / 2.0).astype(int)
        inside = (self.color[pixel[:, 1], pixel[:, 0], 3] > 0.5)
        self.assertGreater(inside.mean(), 0.95)
        self.assertGreater((expected[:, 3] > 0.2 * WIDTH).sum(), 300)
        off = np.abs(self.normals()[pixel[:, 1], pixel[:, 0]] - expected[:, 4:])[inside]
        self.assertLess(np.median(off), 0.01)  # a pixel is 0.003 wide, 1 / 27 of a fold
        self.assertLess(np.percentile(off, 95), 0.2)
        # z is 1 - 2 depth; and a thousandth nearer than it is.
        z = 1.0 - 2.0 * self.depth[pixel[:, 1], pixel[:, 0]] - 1e-3
        z_off = np.abs(z - expected[:, 2])[inside]
        self.assertLess(np.median(z_off), 0.01 * WIDTH)
        self.assertLess(np.percentile(z_off, 99), 0.1 * WIDTH)  # chords of triangles of 3/8 of the width

    def test_nothing_tears(self) -> None:
        """No background that has the sheet on all four sides, whatever the parts of the edges."""
        for attachment in ("LIMIT", "PN", "LINEAR"):
            sheet = Sheet(attachment, count=7)
            parts = sheet.drawing.parts
            self.assertGreater(len(np.unique(parts)), 2, attachment)
            self.assertTrue((parts[:, 1:] < parts[:, :1]).any(), attachment)  # some are cut less at an edge
            for turn in np.linspace(0.0, 0.9, 7):
                self.drawn(sheet, Matrix.Rotation(turn, 4, "X") @ Matrix.Rotation(turn, 4, "Z")
                           @ Matrix.Translation((-0.35, -0.5, 0.0)))
                covered = self.color[..., 3] > 0.5
                around = np.ones_like(covered)
                for axis in (0, 1):
                    for step in (1, -1):  # something on this side of it
                        turned = np.flip(covered, axis) if step < 0 else covered
                        so_far = np.logical_or.accumulate(turned, axis)
                        around &= np.flip(so_far, axis) if step < 0 else so_far
                self.assertGreater(covered.sum(), 0.2 * SIDE * SIDE)
                self.assertEqual((around & ~covered).sum(), 0, f"{attachment}, {turn}")


def as_array(buffer: gpu.types.Buffer, channels: int) -> np.ndarray:
    buffer.dimensions = SIDE * SIDE * channels
    return np.array(buffer, np.float32).reshape(SIDE, SIDE, channels)
