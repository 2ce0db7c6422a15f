# SPDX-License-Identifier: GPL-3.0-or-later
"""What the base cloth is worn over and pulled by: body, gravity, paint, other garments, played and baked."""
from __future__ import annotations

import math
import unittest

import bpy
import numpy as np
from mathutils import kdtree
from rumple.blender import compat, handlers
from rumple.blender.objects import modifier, properties, runtimes
from rumple.blender.ui import panels
from support import cloth_scenes, sleeve
from support.cloth_scenes import (Cloth, DEEPER, bared, depth, depths, difference, dressed, final, forget, garment,
                                  hang, off_animation, pictures, played)

# Frames in which the arm bends so slowly that the sleeve does not face itself: which of two equally near sides of it
# bounds a fold is a matter of rounding.
GENTLE = 60


class OverABody(Cloth):

    def test_no_vertex_is_deeper_inside_than_the_bare_sleeve(self) -> None:
        for radius in (0.8, 0.95):
            obj, body = dressed(radius, level=2)
            found = depths(obj, body, range(1, 21))
            self.check_no_deeper(found, depths(bared(obj), body, found), radius)

    def test_without_a_body_it_would_be(self) -> None:
        obj, body = dressed()
        obj.rumple.body = None
        sleeve.play(1, 10)
        self.assertGreater(depth(body, sleeve.shown(obj)), 20 * DEEPER)

    def test_without_a_base_cloth_folds_stay_outside_and_what_was_inside_comes_out(self) -> None:
        obj = garment(level=2)
        body = sleeve.under(obj, radius=1.04)  # it stands out of the sleeve
        obj.rumple.body, obj.rumple.mesh.base_cloth = body, "OFF"
        seen = played(obj, 12)
        for frame in (1, 8, 12):
            sleeve.at(frame)
            self.assertLess(depth(body, seen[frame]), 5e-4, f"frame {frame}")
        self.assertGreater(off_animation(obj), 1e-3)
        forget(obj)
        self.same(seen, pictures(obj, (12, 8)) and played(obj, 12))
        obj.rumple.body = None
        self.assertGreater(depth(body, pictures(obj, (8,))[8]), 3e-3)

    def test_a_body_elsewhere_is_said_in_the_status(self) -> None:
        for elsewhere in (False, True):
            obj, body = dressed()
            for vertex in body.data.vertices if elsewhere else ():
                vertex.co.y += 3.0
            sleeve.play(1, 2)
            lines = "; ".join(line for line, _icon in panels.status_lines(obj))
            self.assertEqual("its body does not lie under it" in lines, elsewhere, lines)

    def test_which_way_the_faces_of_garment_and_body_look_does_not_count(self) -> None:
        obj, _body = dressed()
        right = played(obj, 6)
        for flips_garment, flips_body in ((True, False), (False, True), (True, True)):
            obj = sleeve.scene(wrinkles=False)
            body = sleeve.under(obj)
            for one in (obj,) * flips_garment + (body,) * flips_body:
                one.data.flip_normals()
            hang(obj)
            self.assertEqual(obj.rumple.body, body)
            for frame, positions in played(obj, 6).items():  # a turned face has its points in another order
                tree = kdtree.KDTree(len(positions))
                for number, place in enumerate(positions):
                    tree.insert(place, number)
                tree.balance()
                # Not the largest: which way a fold goes may hang on a rounding.
                self.assertLess(np.mean([tree.find(place)[2] for place in right[frame]]), 1e-3, f"frame {frame}")

    def test_a_body_that_turns_bad_leaves_the_last_picture_and_says_so(self) -> None:
        obj, body = dressed()
        seen = played(obj, 8)[8]
        held = sleeve.picture(obj)
        right = body.data.vertices[7].co.y
        body.data.vertices[7].co.y = math.nan
        sleeve.at(9)
        self.assertRegex(obj.rumple.message, "^Sleeve: vertex .* of its body Human has no valid position")
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
        obj = garment()
        sleeve.bend_until(GENTLE)
        right = played(obj, 8)
        obj = sleeve.scene(wrinkles=False)
        sleeve.bend_until(GENTLE)
        bpy.context.scene.unit_settings.scale_length = 0.01
        for part in (obj, bpy.data.objects["Arm"]):
            part.scale = (100.0, 100.0, 100.0)
        hang(obj)
        for frame, positions in played(obj, 8).items():
            # Not the largest: which way a fold goes may hang on a rounding.
            self.assertLess(float(np.abs(positions - right[frame]).mean()), 3e-4, f"frame {frame}")


# ---------------------------------------------------------------- paint
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
        suggested = runtimes.of(self.obj).evaluator.suggested_follow(
            properties.settings_of(self.obj, bpy.context.scene))
        weights = [group.weight(vertex.index) for vertex in self.obj.data.vertices]
        np.testing.assert_allclose(weights, suggested, atol=0.026)
        self.assertGreater(np.ptp(weights), 0.5)
        for frame, positions in played(self.obj).items():
            self.assertLess(difference(positions, first[frame]), 1e-4, f"frame {frame}")

    def test_all_of_follow_keeps_the_cloth_at_the_animation(self) -> None:
        played(self.obj)
        self.assertGreater(off_animation(self.obj), 5e-3)
        self.paint("follow", 1.0)
        way = {}
        for frame in range(1, 21):
            sleeve.at(frame)
            way[frame] = off_animation(self.obj)
        self.assertLess(max(way[frame] for frame in range(1, 7)), 2e-4)
        # A pin is a stiff spring: where skinning stretches and folds the sleeve hard, at the end, it gives in.
        self.assertLess(max(way.values()), 1e-3)

    def test_no_room_keeps_it_there_too(self) -> None:
        self.paint("room", 0.0)
        for frame in range(1, 21):
            sleeve.at(frame)
            self.assertLess(off_animation(self.obj), 1e-6)

    def test_a_new_group_of_a_layer_changes_nothing_and_zero_takes_the_layer_away(self) -> None:
        self.obj.rumple.mesh.level = 2
        sleeve.bend_until(GENTLE)
        sleeve.at(1)
        names = ("drape", "folds", "detail")
        first = played(self.obj)[20]
        for name in names:
            bpy.ops.object.rumple_paint(group=name)
        self.assertEqual(difference(played(self.obj)[20], first), 0.0)
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


# ---------------------------------------------------------------- other garments
class Over(Cloth):
    """A garment over another one, that is worn over a body."""

    def setUp(self) -> None:
        self.outer, self.inner = cloth_scenes.two()

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

    def test_the_outer_one_follows_in_the_frame_in_which_the_inner_one_gets_other_points(self) -> None:
        """It was solved over the bare coarse mesh there, because the inner one was solved after it."""
        fewer = self.inner.modifiers.new("Fewer", "DECIMATE")
        compat.move_modifier(self.inner, len(self.inner.modifiers) - 1, 0)
        fewer = self.inner.modifiers["Fewer"]
        for frame, ratio in ((4, 1.0), (5, 0.5)):
            fewer.ratio = ratio
            self.inner.keyframe_insert(f"{fewer.path_from_id()}.ratio", frame=frame)
        for curve in compat.keyed_curves(self.inner.animation_data):
            for key in curve.keyframe_points:
                key.interpolation = "CONSTANT"
        played(self.outer, 5)
        self.assertEqual(len(runtimes.of(self.outer).inputs.body.positions),
                         runtimes.of(self.inner).evaluator.vertex_count)

    def test_it_lies_outside_of_the_inner_ones_folds(self) -> None:
        for layers in ("CLOTH", "ONE"):
            self.inner.rumple.mesh.layers = layers
            for frame in range(1, 9):
                sleeve.at(frame)
                self.assertLess(depth(self.inner, sleeve.shown(self.outer)), 1e-3, f"{layers}, frame {frame}")

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
        outer, inner = cloth_scenes.two()
        hung, places = {}, {}

        def base_cloth() -> np.ndarray:
            runtime = runtimes.of(outer)
            return runtime.evaluator.solved_over(runtime.inputs.frame, runtime.inputs.positions)

        def apart(frame: int) -> float:
            return float(np.abs(base_cloth() - hung[frame]).mean())

        for frame in range(1, 11):
            sleeve.at(frame)
            hung[frame], places[frame] = base_cloth(), runtimes.of(outer).inputs.body.positions
        self.bake(inner)
        forget(outer)
        for frame in range(1, 11):
            sleeve.at(frame)
            np.testing.assert_allclose(runtimes.of(outer).inputs.body.positions, places[frame], atol=1e-6)
            # Its quads are cut in two by Blender now, some along the other diagonal.
            self.assertLess(apart(frame), 2e-4, f"frame {frame}")
        self.assertEqual(outer.rumple.message, "")
        inner.rumple.mesh.gravity = 8.0
        self.bake(inner)
        played(outer, 10)
        self.assertGreater(apart(10), 2e-4)  # twice what is allowed above


if __name__ == "__main__":
    unittest.main()
