# SPDX-License-Identifier: GPL-3.0-or-later
"""Where bodies are while their garment is as at rest: known for skin that follows the same armature."""
from __future__ import annotations

import unittest
from unittest import mock

import bpy
import numpy as np
from rumple.blender import compat
from rumple.blender.objects import bodies, bodies_at_rest
from support import sleeve
from support.worn_sleeve import Worn, outward, placed, solved_body

NOT_TURNED, AS_LARGE = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)


class AtRest(Worn):

    def longer(self) -> None:
        """Most of the body is bare: it is three times as long as the sleeve."""
        for vertex in self.body.data.vertices:
            vertex.co.x *= 3.0

    def test_it_is_known_where_skin_is_bare_and_follows_the_same_armature(self) -> None:
        self.longer()
        placed(self.body, (0.02, 0.0, 0.0), NOT_TURNED, AS_LARGE)
        self.obj.rumple.body = self.body
        sleeve.at(12)
        rest = compat.positions(self.body.data) + np.array((0.02, 0.0, 0.0), np.float32)
        known = solved_body(self.obj).rest
        bare = np.isfinite(known).all(axis=1)
        np.testing.assert_allclose(known[bare], rest[bare], atol=1e-6)
        covered = (rest[:, 0] > 0.1) & (rest[:, 0] < compat.positions(self.obj.data)[:, 0].max() - 0.1)
        self.assertTrue(bare.any() and covered.any())
        self.assertFalse(bare[covered].any())

    def test_it_is_looked_for_once_also_where_one_is_mirrored(self) -> None:
        """The reversed triangles were a new array in each frame, so what is kept for the array was never found."""
        self.obj.rumple.body = self.body
        for garment, body in ((1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)):
            with self.subTest(garment=garment, body=body):
                self.obj.scale.y, self.body.scale.y = garment, body
                bodies.forget_all()
                with mock.patch.object(bodies_at_rest, "of", wraps=bodies_at_rest.of) as looked:
                    for frame in (3, 4, 9):
                        sleeve.at(frame)
                        self.assertGreater(outward(solved_body(self.obj)), 0.0)
                    looked.assert_called_once()

    def test_it_is_not_known_of_what_the_garment_was_not_modelled_on(self) -> None:
        placed(self.body, (9.0, 0.0, 0.0), NOT_TURNED, AS_LARGE)
        self.obj.rumple.body = self.body
        sleeve.at(13)
        self.assertIsNone(solved_body(self.obj).rest)

    def test_it_is_the_same_in_whatever_frame_it_is_read_first(self) -> None:
        """What carries both moves: by the matrices of a frame, rest would differ in its last bits."""
        self.longer()
        carrier = bpy.data.objects.new("Carrier", None)
        bpy.context.scene.collection.objects.link(carrier)
        for obj in (self.obj, self.body):
            obj.parent = carrier
        for frame, turn in ((1, 0.0), (20, 1.3)):
            carrier.location, carrier.rotation_euler = (turn, 0.1 * turn, 0.0), (turn, 0.3 * turn, 2.0 * turn)
            for path in ("location", "rotation_euler"):
                carrier.keyframe_insert(path, frame=frame)
        self.obj.rumple.body = self.body
        found = []
        for frame in (3, 14):
            bodies.forget_all()
            sleeve.at(frame)
            found.append(solved_body(self.obj).rest)
        np.testing.assert_array_equal(*found)

    def test_it_is_not_known_where_one_of_the_objects_is_animated(self) -> None:
        self.longer()
        for frame in (1, 20):
            self.body.location.x = 0.001 * frame
            self.body.keyframe_insert("location", frame=frame)
        self.obj.rumple.body = self.body
        sleeve.at(12)
        self.assertIsNone(solved_body(self.obj).rest)

    def test_a_body_that_is_placed_elsewhere_is_asked_anew(self) -> None:
        self.longer()
        self.obj.rumple.body = self.body
        sleeve.at(12)
        before = solved_body(self.obj).rest
        self.body.location.x = 0.03
        sleeve.at(13)
        after = solved_body(self.obj).rest
        both = np.isfinite(before).all(axis=1) & np.isfinite(after).all(axis=1)
        self.assertTrue(both.any())
        np.testing.assert_allclose(after[both] - before[both], np.array([[0.03, 0.0, 0.0]] * both.sum()), atol=1e-6)

    def test_nor_of_what_follows_no_armature(self) -> None:
        self.body.modifiers.clear()
        self.obj.rumple.body = self.body
        sleeve.at(12)
        self.assertIsNone(solved_body(self.obj).rest)


if __name__ == "__main__":
    unittest.main()
