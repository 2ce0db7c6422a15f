# SPDX-License-Identifier: GPL-3.0-or-later
"""The base cloth and its layers: the first click, the same picture whatever was looked at, body, paint, bake."""
from __future__ import annotations

import math
import os
import tempfile
import unittest
from typing import Any, Callable, Iterable
from unittest import mock

import bpy
import numpy as np
import rendered
import shots
import sleeve
import solved_apart
from mathutils import Vector
from mathutils.bvhtree import BVHTree
from rumple.blender import handlers, live, modifier, registry, structure

DEEPER = 1e-4  # metres that shown cloth may stand deeper inside the body than the bare garment
FRAMES = (1, 6, 13, 20)


# ---------------------------------------------------------------- scenes
def hang(obj: bpy.types.Object, level: int = 1, **values: Any) -> bpy.types.Object:
    """Cloth in layers by one click, with some settings. It becomes the active object."""
    settings = obj.rumple.mesh
    settings.base_cloth, settings.layers = "HANG", "CLOTH"
    settings.density, settings.level, settings.display_steps = "LEVEL", level, 0
    for name, value in values.items():
        setattr(settings, name, value)
    sleeve.make_active(obj)
    bpy.ops.object.rumple_add(method="MESH")
    bpy.context.view_layer.update()
    return obj


def garment(**values: Any) -> bpy.types.Object:
    """A sleeve of cloth, over nothing."""
    obj = sleeve.scene(wrinkles=False)
    obj.data.flip_normals()
    return hang(obj, **values)


def dressed(radius: float = 0.8, **values: Any) -> tuple[bpy.types.Object, bpy.types.Object]:
    """A sleeve of cloth and the body under it, that the first click finds."""
    obj = sleeve.scene(wrinkles=False)
    obj.data.flip_normals()
    body = sleeve.under(obj, radius=radius)
    hang(obj, **values)
    assert obj.rumple.body == body
    return obj, body


def forget(obj: bpy.types.Object) -> None:
    sleeve.make_active(obj)
    bpy.ops.object.rumple_clear_frames()


def pictures(obj: bpy.types.Object, frames: Iterable[float]) -> dict[float, np.ndarray]:
    """What is shown at these times, one after the other."""
    found = {}
    for frame in frames:
        whole = math.floor(frame)
        sleeve.at(whole, frame - whole)
        found[frame] = sleeve.shown(obj)
    return found


def played(obj: bpy.types.Object, last: int = sleeve.LAST) -> dict[float, np.ndarray]:
    return pictures(obj, range(1, last + 1))


def off_animation(obj: bpy.types.Object) -> float:
    """Farthest way of the base cloth from the animated mesh, metres."""
    entry = registry.runtime(obj)
    cloth = entry.fine.state_of(entry.inputs.frame).cloth
    return float(np.linalg.norm(cloth.positions - entry.inputs.positions, axis=1).max())


def final(obj: bpy.types.Object, frame: float) -> bool:
    return registry.runtime(obj).fine.history.get(frame).final


def difference(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.linalg.norm(one - other, axis=1).max())


class Cloth(unittest.TestCase):

    def same(self, one: dict[float, np.ndarray], other: dict[float, np.ndarray]) -> None:
        for frame in one.keys() & other.keys():
            np.testing.assert_array_equal(one[frame], other[frame], f"frame {frame}")

    def saved(self) -> str:
        """The file, in a folder that goes with the test."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        path = os.path.join(folder.name, "scene.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        return path


# ---------------------------------------------------------------- the first click
class FirstClick(Cloth):

    def setUp(self) -> None:
        self.obj = sleeve.scene(wrinkles=False)
        self.unset()

    def unset(self) -> None:
        for name in ("base_cloth", "layers"):
            self.obj.rumple.mesh.property_unset(name)

    def click(self) -> tuple[str, str]:
        sleeve.make_active(self.obj)
        bpy.ops.object.rumple_add(method="MESH")
        sleeve.at(3)
        self.assertEqual(self.obj.rumple.message, "")
        self.assertTrue(np.isfinite(sleeve.shown(self.obj)).all())
        return self.obj.rumple.mesh.base_cloth, self.obj.rumple.mesh.layers

    def test_a_sleeve_becomes_cloth_in_layers(self) -> None:
        self.assertEqual(self.click(), ("HANG", "CLOTH"))
        report = sleeve.picture(self.obj).report
        self.assertIsNotNone(report.cloth)
        self.assertEqual(len(report.layers), registry.runtime(self.obj).fine.level + 1)

    def test_one_that_is_skinned_by_its_parent_too(self) -> None:
        self.obj.modifiers.clear()
        self.obj.parent, self.obj.parent_type = bpy.data.objects["Arm"], "ARMATURE"
        self.assertEqual(self.click(), ("HANG", "CLOTH"))

    def stays(self) -> None:
        self.assertEqual(self.click(), ("OFF", "ONE"))

    def test_a_sheet_stays(self) -> None:
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=6, y_subdivisions=6, size=0.4)
        self.obj = sleeve.skinned(bpy.context.object.data, bpy.data.objects["Arm"], "Sheet")
        self.unset()
        self.stays()

    def close(self, *rings: int) -> None:
        """Put a lid on some ends."""
        corners = [vertex.co.copy() for vertex in self.obj.data.vertices]
        quads = [tuple(polygon.vertices) for polygon in self.obj.data.polygons]
        lids = [tuple(range(ring * sleeve.AROUND, (ring + 1) * sleeve.AROUND)) for ring in rings]
        mesh = bpy.data.meshes.new("Closed")
        mesh.from_pydata(corners, [], quads + [lid[::-1] if lid[0] else lid for lid in lids])
        self.obj = sleeve.skinned(mesh, bpy.data.objects["Arm"], "Closed")
        self.unset()

    def test_a_head_with_one_opening_stays(self) -> None:
        self.close(0)
        self.stays()

    def test_a_body_without_an_opening_stays(self) -> None:
        self.close(0, sleeve.ALONG - 1)
        self.stays()

    def test_a_simulated_garment_stays(self) -> None:
        self.obj.modifiers.new("Cloth", "CLOTH")
        self.stays()

    def test_a_simulation_in_absolute_shape_keys_stays(self) -> None:
        self.obj.shape_key_add(name="Basis")
        self.obj.shape_key_add(name="Later")
        self.obj.data.shape_keys.use_relative = False
        self.stays()

    def test_without_an_armature_it_stays(self) -> None:
        self.obj.modifiers.clear()
        self.stays()

    def test_what_was_chosen_before_stays(self) -> None:
        for name, value, expected in (("base_cloth", "OFF", ("OFF", "ONE")), ("layers", "ONE", ("OFF", "ONE")),
                                      ("base_cloth", "HANG", ("HANG", "ONE")), ("layers", "CLOTH", ("OFF", "CLOTH"))):
            self.setUp()
            setattr(self.obj.rumple.mesh, name, value)
            self.assertEqual(self.click(), expected, f"{name} {value}")

    def test_lengths_that_were_set_before_stay(self) -> None:
        settings = self.obj.rumple.mesh
        settings.wavelength, settings.room, settings.thickness, settings.gravity = 0.06, 0.011, 0.007, 0.5
        self.assertEqual(self.click(), ("HANG", "CLOTH"))
        np.testing.assert_allclose((settings.wavelength, settings.room, settings.thickness, settings.gravity),
                                   (0.06, 0.011, 0.007, 0.5), rtol=1e-6)

    def test_removed_and_added_again_it_is_as_it_was(self) -> None:
        settings = self.obj.rumple.mesh
        for chosen in ("OFF", "HANG"):
            self.click()
            settings.base_cloth, settings.slack, settings.room = chosen, 1.03, 0.02
            bpy.ops.object.rumple_remove()
            self.assertEqual(self.click(), (chosen, "CLOTH"))
            np.testing.assert_allclose((settings.slack, settings.room), (1.03, 0.02), rtol=1e-6)
            bpy.ops.object.rumple_remove()


# ---------------------------------------------------------------- the same picture, whatever was looked at
class ToTheBit(Cloth):

    def setUp(self) -> None:
        self.obj, self.body = dressed()

    def test_played_twice_scrubbed_and_played_again(self) -> None:
        first = played(self.obj)
        self.assertGreater(difference(first[20], first[1]), 0.1)
        self.same(first, played(self.obj))
        self.same(first, pictures(self.obj, (17, 2, 20, 9, 1, 12)))
        forget(self.obj)
        pictures(self.obj, (17, 2, 20, 9, 3))
        self.same(first, played(self.obj))

    def test_saved_and_opened(self) -> None:
        first = played(self.obj)
        sleeve.at(15)
        bpy.ops.wm.open_mainfile(filepath=self.saved())
        obj = bpy.data.objects["Sleeve"]
        self.same(first, played(obj))
        self.assertEqual(obj.rumple.message, "")

    def test_the_picture_of_a_jump_is_replaced_when_it_is_played_through(self) -> None:
        first = played(self.obj)
        forget(self.obj)
        jumped = pictures(self.obj, (18,))[18]
        self.assertFalse(final(self.obj, 18.0))
        self.assertGreater(difference(jumped, first[18]), 1e-5)
        np.testing.assert_array_equal(pictures(self.obj, (18,))[18], jumped)
        self.same(first, played(self.obj))
        self.assertTrue(final(self.obj, 18.0))

    def test_between_two_frames(self) -> None:
        played(self.obj)
        times = (12.5, 3.25, 19.75)
        first = pictures(self.obj, times)
        self.assertGreater(difference(first[12.5], pictures(self.obj, (12,))[12]), 1e-3)
        self.same(first, pictures(self.obj, reversed(times)))
        forget(self.obj)
        found = {}
        for frame in range(1, 21):
            found.update(pictures(self.obj, (frame, *(time for time in times if int(time) == frame))))
        self.same(first, found)

    def rendered(self, render: Callable[[], object]) -> dict[float, np.ndarray]:
        """Positions by time, as they are shown to renders."""
        found, show = {}, live._show

        def spy(held, entry, picture, in_viewport) -> bool:
            if not in_viewport:
                found[entry.inputs.frame] = picture.positions
            return show(held, entry, picture, in_viewport)

        with mock.patch.object(live, "_show", spy):
            render()
        return found

    def stage(self) -> None:
        scene = bpy.context.scene
        scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        scene.collection.objects.link(scene.camera)
        scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 1, False
        scene.render.resolution_x = scene.render.resolution_y = shots.SIZE

    def test_renders_have_the_played_frames(self) -> None:
        first = {frame: sleeve.picture(self.obj).positions for frame in range(1, 6) if sleeve.at(frame) is None}
        self.stage()
        forget(self.obj)
        sleeve.at(20)
        self.body.hide_render = self.body.hide_viewport = True
        found = self.rendered(lambda: shots.clip(1, 5))
        self.assertEqual(found.keys(), first.keys())
        self.same(first, found)

    def test_motion_blur_has_the_moments_between(self) -> None:
        self.stage()
        shots.blur(0.5)
        found = self.rendered(lambda: shots.clip(1, 4))
        self.assertGreater(sum(time != int(time) for time in found), 3)
        self.same(found, self.rendered(lambda: shots.clip(1, 4)))
        sleeve.play(1, 4)
        for time in (3.75, 4.0, 4.25):
            sleeve.at(int(time), time - int(time))
            np.testing.assert_array_equal(sleeve.picture(self.obj).positions, found[time], str(time))


class Rendered(Cloth):

    def test_pixels_are_those_of_the_cloth_solved_apart(self) -> None:
        obj = shots.stage("CYCLES")
        obj.rumple.mesh.base_cloth, obj.rumple.mesh.layers = "HANG", "CLOTH"
        found = shots.clip(1, 4)
        for frame, picture in zip(found, solved_apart.expected(obj, range(1, 5))):
            self.assertLessEqual(solved_apart.unlike(found[frame], picture), rendered.STRAY, f"frame {frame}")
        obj.rumple.mesh.base_cloth = "OFF"
        self.assertGreater(solved_apart.unlike(found[4], shots.still(4)), 10 * rendered.STRAY)
        self.assertEqual(obj.rumple.message, "")


# ---------------------------------------------------------------- body and gravity
def depth(body: bpy.types.Object, positions: np.ndarray) -> float:
    """How deep the deepest of some positions is inside the body, metres; 0 where all are outside."""
    mesh = sleeve.evaluated(body).data
    tree = BVHTree.FromPolygons([vertex.co.copy() for vertex in mesh.vertices],
                                [tuple(polygon.vertices) for polygon in mesh.polygons])
    deepest = 0.0
    for position in map(Vector, positions):
        nearest, normal = tree.find_nearest(position)[:2]
        deepest = max(deepest, (nearest - position).dot(normal))
    return deepest


class OverABody(Cloth):

    def test_no_vertex_is_deeper_inside_than_the_bare_sleeve(self) -> None:
        for radius in (0.8, 0.95):
            obj, body = dressed(radius, level=2)
            found = {frame: depth(body, seen) for frame, seen in
                     ((frame, pictures(obj, (frame,))[frame]) for frame in range(1, 21))}
            settings = obj.rumple.mesh
            settings.base_cloth, settings.layers, settings.radius = "OFF", "ONE", 0.0
            for frame in found:
                sleeve.at(frame)
                self.assertLess(found[frame], DEEPER + depth(body, sleeve.shown(obj)), f"{radius}, frame {frame}")

    def test_without_a_body_it_would_be(self) -> None:
        obj, body = dressed()
        obj.rumple.body = None
        sleeve.play(1, 6)
        self.assertGreater(depth(body, sleeve.shown(obj)), 20 * DEEPER)

    def test_a_body_that_turns_bad_leaves_the_last_picture_and_says_so(self) -> None:
        obj, body = dressed()
        seen = played(obj, 8)[8]
        held = sleeve.picture(obj)
        right = body.data.vertices[7].co.y
        body.data.vertices[7].co.y = math.nan
        sleeve.at(9)
        self.assertRegex(obj.rumple.message, "^Sleeve: vertex .* of its body Human is not finite")
        self.assertIs(sleeve.picture(obj), held)
        self.assertTrue(np.isfinite(sleeve.shown(obj)).all())
        body.data.vertices[7].co.y = right
        sleeve.at(9)
        self.assertEqual(obj.rumple.message, "")
        np.testing.assert_array_equal(pictures(obj, (8,))[8], seen)


class Gravity(Cloth):

    def height(self, obj: bpy.types.Object) -> float:
        """Mean z in the world of the played cloth, metres."""
        played(obj, 6)
        return float((sleeve.shown(obj) @ np.array(sleeve.evaluated(obj).matrix_world)[:3, :3].T)[:, 2].mean())

    def test_it_sags_down_in_the_world_whichever_side_is_up(self) -> None:
        flat = self.height(garment(gravity=0.0))
        obj = garment(gravity=1.0)
        self.assertLess(self.height(obj), flat - 2e-3)
        upright = sleeve.shown(obj)
        obj.rotation_euler.x = math.pi
        bpy.context.view_layer.update()
        self.assertLess(self.height(obj), flat - 2e-3)
        self.assertGreater(sleeve.shown(obj)[:, 2].mean(), upright[:, 2].mean() + 4e-3)  # in the object: up

    def test_without_gravity_and_slack_cloth_at_rest_is_the_bare_surface(self) -> None:
        obj = garment(gravity=0.0, slack=1.0)
        sleeve.at(1)
        seen, settings = sleeve.shown(obj), obj.rumple.mesh
        settings.base_cloth, settings.radius = "OFF", 0.0
        sleeve.at(1)
        np.testing.assert_allclose(seen, sleeve.shown(obj), atol=1e-6)

    def test_a_scene_in_centimetres_hangs_as_one_in_metres(self) -> None:
        right = played(garment(), 8)
        obj = sleeve.scene(wrinkles=False)
        obj.data.flip_normals()
        bpy.context.scene.unit_settings.scale_length = 0.01
        for part in (obj, bpy.data.objects["Arm"]):
            part.scale = (100.0, 100.0, 100.0)
        hang(obj)
        for frame, positions in played(obj, 8).items():
            np.testing.assert_allclose(positions, right[frame], atol=2e-4, err_msg=str(frame))


# ---------------------------------------------------------------- paint and settings
class Painted(Cloth):

    def setUp(self) -> None:
        self.obj = garment()

    def paint(self, word: str, value: float) -> None:
        """All over."""
        sleeve.make_active(self.obj)
        bpy.ops.object.rumple_paint(group=word)
        self.obj.vertex_groups.active.add(range(len(self.obj.data.vertices)), value, "REPLACE")

    def test_follow_starts_from_what_is_suggested_and_nothing_moves(self) -> None:
        first = played(self.obj)
        bpy.ops.object.rumple_paint(group="follow")
        group = self.obj.vertex_groups["Rumple Follow"]
        suggested = registry.runtime(self.obj).fine.suggested_follow(np.eye(3, dtype=np.float32))
        weights = [group.weight(vertex.index) for vertex in self.obj.data.vertices]
        np.testing.assert_allclose(weights, suggested, atol=0.026)
        self.assertGreater(np.ptp(weights), 0.5)
        for frame, positions in played(self.obj).items():
            self.assertLess(difference(positions, first[frame]), 1e-3, f"frame {frame}")

    def test_all_of_follow_keeps_the_cloth_at_the_animation(self) -> None:
        played(self.obj)
        self.assertGreater(off_animation(self.obj), 5e-3)
        self.paint("follow", 1.0)
        worst = {}
        for frame in range(1, 21):
            sleeve.at(frame)
            worst[frame] = off_animation(self.obj)
        self.assertLess(max(worst.values()), 2e-4, str(worst))

    def test_no_room_keeps_it_there_too(self) -> None:
        self.paint("room", 0.0)
        for frame in range(1, 21):
            sleeve.at(frame)
            self.assertLess(off_animation(self.obj), 1e-6)

    def test_no_room_leaves_the_layers_and_they_fold_as_without_a_base_cloth(self) -> None:
        self.obj.rumple.mesh.slack = 1.0
        self.paint("room", 0.0)
        found = played(self.obj)
        self.obj.rumple.mesh.base_cloth = "OFF"
        for frame, positions in played(self.obj).items():
            self.assertLess(difference(positions, found[frame]), 1e-6, f"frame {frame}")

    def test_a_new_group_of_a_layer_changes_nothing_and_zero_takes_the_layer_away(self) -> None:
        self.obj.rumple.mesh.level = 2
        sleeve.at(1)
        names = ("drape", "folds", "detail")
        first = played(self.obj)[20]
        for name in names:
            bpy.ops.object.rumple_paint(group=name)
        np.testing.assert_array_equal(played(self.obj)[20], first)
        for name in names:
            self.paint(name, 0.0)
            painted = played(self.obj)[20]
            self.paint(name, 1.0)
            setattr(self.obj.rumple.mesh, name, 0.0)
            self.assertLess(difference(painted, played(self.obj)[20]), 1e-6, name)
            setattr(self.obj.rumple.mesh, name, 1.0)
            self.assertGreater(difference(painted, first), 5e-4, name)

    def test_without_any_layer_the_cloth_is_smooth(self) -> None:
        settings = self.obj.rumple.mesh
        bare = lambda: float(np.linalg.norm(sleeve.attribute(self.obj, "rumple_offset"), axis=1).max())  # noqa: E731
        played(self.obj)
        folded = bare()
        for name in ("drape", "folds", "detail"):
            setattr(settings, name, 0.0)
        settings.gravity, settings.slack = 0.0, 1.0
        self.paint("room", 0.0)
        played(self.obj)
        self.assertLess(bare(), 1e-6)
        self.assertGreater(folded, 5e-3)


class Changes(Cloth):

    def test_each_setting_updates_the_picture_and_the_way_back_is_exact(self) -> None:
        obj, settings = garment(), None
        settings = obj.rumple.mesh
        first = played(obj, 10)
        for name, value in (("slack", 1.08), ("gravity", 3.0), ("room", 0.004), ("drape", 0.1), ("folds", 0.1),
                            ("detail", 0.2), ("layers", "ONE"), ("base_cloth", "OFF")):
            former = getattr(settings, name)
            setattr(settings, name, value)
            bpy.context.view_layer.update()
            self.assertEqual(obj.rumple.message, "")
            other = sleeve.shown(obj)
            self.assertTrue(len(other) != len(first[10]) or difference(other, first[10]) > 2e-4, name)
            setattr(settings, name, former)
            self.same(first, played(obj, 10))

    def test_animated_slack_plays_and_repeats(self) -> None:
        obj = garment()
        still = played(obj)
        for frame, value in ((1, 1.01), (20, 1.2)):
            obj.rumple.mesh.slack = value
            obj.keyframe_insert("rumple.mesh.slack", frame=frame)
        first = played(obj)
        self.assertGreater(difference(first[20], still[20]), 1e-3)
        self.same(first, pictures(obj, (20, 3, 12, 1)))
        forget(obj)
        self.same(first, played(obj))


# ---------------------------------------------------------------- bake
class Baked(Cloth):

    def bake(self, obj: bpy.types.Object) -> None:
        self.saved()
        sleeve.make_active(obj)
        self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})

    def test_a_clip_is_what_was_played_and_needs_no_handlers(self) -> None:
        obj, _body = dressed()
        live_ones = played(obj)
        self.bake(obj)
        handlers.unregister()
        try:
            for frame, positions in pictures(obj, (20, 1, 9, 14)).items():
                np.testing.assert_allclose(positions, live_ones[frame], atol=1e-6)
        finally:
            handlers.register()

    def test_a_garment_over_a_baked_one_sees_it(self) -> None:
        outer, inner = Over.two(self)
        first = pictures(outer, range(1, 11))
        self.bake(inner)
        forget(outer)
        for frame, positions in pictures(outer, range(1, 11)).items():
            self.assertLess(difference(positions, first[frame]), 1e-3, f"frame {frame}")
        self.assertEqual(outer.rumple.message, "")
        inner.rumple.mesh.gravity = 4.0
        self.bake(inner)
        changed = pictures(outer, range(1, 11))
        self.assertGreater(difference(changed[10], first[10]), 1e-3)


class Over(Cloth):
    """A garment over another one, that is worn over a body."""

    def two(self, **values: Any) -> tuple[bpy.types.Object, bpy.types.Object]:
        """The outer and the inner garment. By the names the outer one would come first."""
        outer, body = dressed(0.7)
        inner = sleeve.under(outer, "Undershirt", 0.85)
        hang(inner, room=0.02)
        inner.rumple.body, inner.rumple.body_collection = body, None
        outer.rumple.body = inner
        hang_on = dict(room=0.03, **values)
        for name, value in hang_on.items():
            setattr(outer.rumple.mesh, name, value)
        bpy.context.view_layer.update()
        return outer, inner

    def setUp(self) -> None:
        self.outer, self.inner = self.two()

    def test_the_outer_one_changes_with_the_inner_one_in_the_same_frame(self) -> None:
        first = played(self.outer, 6)[6]
        for name, value in (("gravity", 0.0), ("slack", 1.1), ("layers", "ONE"), ("base_cloth", "OFF")):
            former = getattr(self.inner.rumple.mesh, name)
            setattr(self.inner.rumple.mesh, name, value)
            bpy.context.view_layer.update()
            self.assertGreater(difference(sleeve.shown(self.outer), first), 1e-5, name)
            self.assertEqual((self.outer.rumple.message, self.inner.rumple.message), ("", ""))
            setattr(self.inner.rumple.mesh, name, former)
            np.testing.assert_array_equal(played(self.outer, 6)[6], first)

    def test_it_lies_outside_of_the_inner_ones_folds(self) -> None:
        for frame in range(1, 9):
            sleeve.at(frame)
            self.assertLess(depth(self.inner, sleeve.shown(self.outer)), 1e-3, f"frame {frame}")

    def test_deleting_the_inner_one_leaves_no_error(self) -> None:
        for delete in (lambda: bpy.data.objects.remove(self.inner), bpy.ops.object.delete,
                       bpy.ops.object.rumple_remove, lambda: self.inner.modifiers.remove(modifier.find(self.inner))):
            self.setUp()
            played(self.outer, 4)
            sleeve.make_active(self.inner)
            delete()
            self.assertEqual(len(pictures(self.outer, (5, 6))), 2)
            self.assertEqual(self.outer.rumple.message, "")
            self.assertTrue(final(self.outer, 6.0))

    def test_a_circle_is_refused_in_words_and_the_other_one_hangs_on(self) -> None:
        self.inner.rumple.body = self.outer
        played(self.outer, 4)
        said = sorted(bool(obj.rumple.message) for obj in (self.outer, self.inner))
        self.assertEqual(said, [False, True])
        self.inner.rumple.body = None
        played(self.outer, 4)
        self.assertEqual((self.outer.rumple.message, self.inner.rumple.message), ("", ""))


# ---------------------------------------------------------------- files, copies, undo
class Kept(Cloth):

    def test_undo_and_redo_of_the_first_click(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        for name in ("base_cloth", "layers"):
            obj.rumple.mesh.property_unset(name)
        bpy.ops.ed.undo_push(message="before")
        bpy.ops.object.rumple_add(method="MESH")
        bpy.ops.ed.undo_push(message="added")
        right = played(obj, 5)
        bpy.ops.ed.undo()
        obj = bpy.data.objects["Sleeve"]
        self.assertIsNone(modifier.find(obj))
        self.assertFalse(obj.rumple.mesh.is_property_set("base_cloth"))
        bpy.ops.ed.redo()
        obj = bpy.data.objects["Sleeve"]
        self.assertEqual(obj.rumple.mesh.base_cloth, "HANG")
        self.same(right, played(obj, 5))
        self.assertEqual(obj.rumple.message, "")

    def test_a_duplicate_has_its_own(self) -> None:
        obj, _body = dressed()
        bpy.ops.object.duplicate()
        copy = bpy.context.object
        structure.settle_all()
        first = played(obj, 6)
        self.same(first, played(copy, 6))
        copy.rumple.mesh.gravity = 4.0
        self.assertGreater(difference(played(copy, 6)[6], first[6]), 1e-3)
        self.same(first, played(obj, 6))

    def test_appended_and_linked(self) -> None:
        right = played(garment(), 5)
        path = self.saved()
        for link in (False, True):
            sleeve.empty_file()
            with bpy.data.libraries.load(path, link=link) as (_, wanted):
                wanted.objects = ["Sleeve"]
            obj, = wanted.objects
            bpy.context.scene.collection.objects.link(obj)
            structure.settle_all()
            self.same(right, played(obj, 5))
            self.assertEqual(obj.rumple.message, "")
        sleeve.empty_file()


# ---------------------------------------------------------------- other fine meshes
class OneLayer(Cloth):
    """What layers cannot do is solved as one fine mesh over the cloth."""

    def check(self, obj: bpy.types.Object, **values: Any) -> None:
        for name, value in values.items():
            setattr(obj.rumple.mesh, name, value)
        structure.settle_all()
        first = played(obj, 8)
        self.assertEqual(obj.rumple.message, "")
        report = sleeve.picture(obj).report
        self.assertEqual(len(report.layers), 1)
        self.assertGreater(report.cloth.offset_mean, 1e-3)
        self.assertTrue(all(np.isfinite(positions).all() for positions in first.values()))
        np.testing.assert_allclose(first[8], sleeve.picture(obj).positions, atol=2e-6)
        self.same(first, played(obj, 8))
        obj.rumple.mesh.base_cloth = "OFF"
        self.assertGreater(difference(played(obj, 8)[8], first[8]), 5e-3)

    def test_a_regular_split(self) -> None:
        self.check(garment(), source="REGULAR", segments=2)

    def test_edges_of_some_length(self) -> None:
        self.check(garment(), source="EDGE_LENGTH", edge_length=0.02)

    def test_an_own_mesh(self) -> None:
        obj, _body = dressed()
        own = bpy.data.objects.new("Own", sleeve.tube("Own"))
        own.data.flip_normals()
        bpy.context.scene.collection.objects.link(own)
        obj.rumple.own_mesh = own
        self.check(obj, source="OBJECT")

    def test_a_rest_shape_that_adapts(self) -> None:
        self.check(garment(), rest_shape="ADAPTIVE")


if __name__ == "__main__":
    unittest.main()
