# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of a mesh of clothes that are no cloth by the bones that move them, and parts that stay cloth."""
from __future__ import annotations

import unittest

import numpy as np
from rumple.core.base.vertices import places
from rumple.core.mesh.base_mesh import BaseMesh
from rumple.core.mesh.connected import parts
from rumple.core.parts.measured_parts import measured
from rumple.core.parts.moved_parts import Moved, find_moved
from support.meshes import quad_mesh, sheet, tube
from support.solved_meshes import box, together

TUNIC = tube(24, 20, 0.2, 0.9)  # along z
BONES = 8  # hips, chest, forearm, hand and four fingers
HIPS, CHEST, FOREARM, HAND = range(4)
BELOW = np.eye(BONES, dtype=bool)
BELOW[HIPS, :], BELOW[CHEST, 1:], BELOW[FOREARM, 2:], BELOW[HAND, 3:] = True, True, True, True


def moved_by(bone: int, mesh: BaseMesh) -> np.ndarray:
    """All vertices by one bone."""
    return np.tile(np.eye(BONES, dtype=np.float32)[bone], (len(mesh.positions), 1))


def bent(mesh: BaseMesh, low: int = HIPS, high: int = CHEST) -> np.ndarray:
    """From one bone to another along z."""
    z = mesh.positions[:, 2]
    share = np.clip((z - z.min()) / np.ptp(z), 0.0, 1.0)[:, None].astype(np.float32)
    return (1.0 - share) * moved_by(low, mesh) + share * moved_by(high, mesh)


def placed(mesh: BaseMesh, place: tuple[float, float, float]) -> BaseMesh:
    return quad_mesh(mesh.name, mesh.positions + np.array(place, np.float32), mesh.corner_vertex.reshape(-1, 4))


def thick_band(radius: float, low: float, high: float, thickness: float = 0.008) -> BaseMesh:
    """A closed ring around z with an inner and an outer side."""
    around, turns = 24, np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    rings = [(radius, low), (radius + thickness, low), (radius + thickness, high), (radius, high)]
    points = [(r * np.cos(turn), r * np.sin(turn), z) for r, z in rings for turn in turns]
    quads = [(k * around + i, (k + 1) % 4 * around + i, (k + 1) % 4 * around + (i + 1) % around,
              k * around + (i + 1) % around) for k in range(4) for i in range(around)]
    return quad_mesh("Band", np.array(points), np.array(quads)[:, ::-1])


def frame(width: float) -> BaseMesh:
    """A buckle in the xz plane that faces -y, open at its back: two borders around the same middle."""
    def ring(half: float, y: float) -> list[tuple[float, float, float]]:
        return [(-half, y, -half), (half, y, -half), (half, y, half), (-half, y, half)]
    points = [*ring(0.5 * width, 0.0), *ring(0.5 * width, -0.03), *ring(0.3 * width, -0.03), *ring(0.3 * width, 0.0)]
    quads = [(4 * k + i, 4 * k + (i + 1) % 4, 4 * k + 4 + (i + 1) % 4, 4 * k + 4 + i)
             for k in range(3) for i in range(4)]
    return quad_mesh("Buckle", np.array(points), np.array(quads))


def glove(length: float) -> BaseMesh:
    """A tube along z with a closed end, as a hand is."""
    made = tube(12, 8, 0.03, length)
    made.positions[-12:, :2] *= 1e-3
    return made


class MovedParts(unittest.TestCase):
    """A tunic that bends, and a part in its mesh."""

    def found(self, other: BaseMesh, weights: np.ndarray, tunic: np.ndarray | None = None) -> Moved:
        base = together(TUNIC, other)
        place = places(base.positions)
        part = parts(base, place)
        of_all = np.concatenate([bent(TUNIC) if tunic is None else tunic, weights])
        found = find_moved(base, measured(base, part, place), part, np.zeros(part.max() + 1, bool), of_all, BELOW)
        own = part[len(TUNIC.positions)]
        self.assertFalse(found.rigid[part[0]] or found.hands[part[0]])
        return Moved(found.rigid[own:own + 1], found.hands[own:own + 1])

    def test_books_plates_and_buckles(self) -> None:
        things = (box((0.24, 0.0, 0.4), (0.05, 0.16, 0.2)), box((0.24, 0.0, 0.7), (0.01, 0.15, 0.15)),
                  placed(frame(0.12), (0.0, -0.21, 0.5)))
        for thing in things:
            self.assertTrue(self.found(thing, moved_by(HIPS, thing)).rigid[0])
            self.assertFalse(self.found(thing, bent(thing)).rigid[0], "it bends")

    def test_where_nothing_bends_the_bones_say_nothing(self) -> None:
        book = box((0.24, 0.0, 0.4), (0.05, 0.16, 0.2))
        self.assertFalse(self.found(book, moved_by(HIPS, book), moved_by(HIPS, TUNIC)).rigid[0])

    def test_two_bones_that_move_it_as_one(self) -> None:
        book = box((0.24, 0.0, 0.4), (0.05, 0.16, 0.2))
        both = 0.6 * moved_by(HIPS, book) + 0.4 * moved_by(CHEST, book)
        self.assertTrue(self.found(book, both).rigid[0])

    def test_a_belt_around_the_middle(self) -> None:
        for belt in (thick_band(0.205, 0.4, 0.45), placed(tube(24, 1, 0.205, 0.05), (0.0, 0.0, 0.4))):
            self.assertTrue(self.found(belt, moved_by(HIPS, belt)).rigid[0])
            self.assertFalse(self.found(belt, bent(belt)).rigid[0])

    def test_cuffs_collars_and_hems_are_cloth(self) -> None:
        """They are where the garment ends."""
        for low, high in ((-0.02, 0.03), (0.86, 0.92), (0.0, 0.06)):
            for band in (thick_band(0.205, low, high), placed(tube(24, 1, 0.205, high - low), (0.0, 0.0, low))):
                self.assertFalse(self.found(band, moved_by(HIPS, band)).rigid[0])

    def test_sleeves_and_pockets_are_cloth(self) -> None:
        pocket = placed(sheet(4, 4, 0.15), (-0.07, 0.0, 0.0))
        pocket = quad_mesh("Pocket", pocket.positions[:, [0, 2, 1]] + (0.0, -0.21, 0.3),
                           pocket.corner_vertex.reshape(-1, 4))
        sleeve = placed(tube(16, 6, 0.06, 0.25), (0.35, 0.0, 0.5))
        for part in (pocket, sleeve, placed(thick_band(0.06, 0.0, 0.2), (0.35, 0.0, 0.5))):
            self.assertFalse(self.found(part, moved_by(FOREARM, part)).rigid[0])

    def test_a_hand_with_fingers(self) -> None:
        hand = placed(glove(0.18), (0.4, 0.0, 0.2))
        weights = bent(hand, HAND, BONES - 1)
        weights[:, HAND + 1:BONES - 1] += 0.2
        found = self.found(hand, weights / weights.sum(axis=1, keepdims=True))
        self.assertEqual((found.hands[0], found.rigid[0]), (True, False))
        sleeve = placed(tube(12, 8, 0.03, 0.18), (0.4, 0.0, 0.2))
        self.assertFalse(self.found(sleeve, weights / weights.sum(axis=1, keepdims=True)).hands[0], "two openings")
        self.assertFalse(self.found(hand, bent(hand, FOREARM, HAND)).hands[0], "a sleeve that is closed at its end")
        moved_too = bent(TUNIC, HAND, BONES - 1)
        self.assertFalse(self.found(hand, weights, moved_too).hands[0], "these bones move most of the mesh")


if __name__ == "__main__":
    unittest.main()
