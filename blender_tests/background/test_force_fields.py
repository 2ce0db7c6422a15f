# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's force fields: ours against Blender's own Cloth, and cloth that swings in them."""
from __future__ import annotations

import unittest
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix, Vector, noise
from rumple.blender.objects import wind
from rumple.blender.ui import panels
from rumple.core.cloth.base_cloth import FIELD
from rumple.core.cloth.surroundings import Surroundings
from support import sleeve
from support.cloth_scenes import Cloth, difference, garment, pictures, played


def add(kind: str, shape: str = "POINT", at: tuple[float, float, float] = (0.0, 0.0, 0.0),
        **settings: Any) -> bpy.types.Object:
    """A force field. Blender's own operator makes it, so that its defaults are Blender's; what is active stays so."""
    active = bpy.context.object
    bpy.ops.object.effector_add(type=kind, location=at)
    effector = bpy.context.object
    sleeve.make_active(active)
    effector.field.shape = shape
    for name, value in settings.items():
        setattr(effector.field, name, value)
    bpy.context.view_layer.update()
    return effector


def read(effector: bpy.types.Object) -> Surroundings:
    effector = effector.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return Surroundings(fields=(wind._field(effector.field, effector.matrix_world),))


class AsBlendersCloth(unittest.TestCase):
    """A flat sheet of Blender's Cloth without stiffness: how far its vertices move in their first frame tells the
    force on them, against how far they fall by gravity."""

    PLACE, MASS = Vector((0.5, 0.3, 0.4)), 0.3

    def sheet(self, gravity: float) -> bpy.types.Object:
        sleeve.empty_file()
        bpy.context.scene.render.fps = 24
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=6, y_subdivisions=6, size=1.0)
        obj = bpy.context.object
        obj.matrix_world = Matrix.Translation(self.PLACE)
        settings = obj.modifiers.new("Cloth", "CLOTH").settings
        for name in ("air_damping", "tension_damping", "compression_damping", "shear_damping", "bending_damping",
                     "tension_stiffness", "compression_stiffness", "shear_stiffness", "bending_stiffness"):
            setattr(settings, name, 0.0)
        settings.mass, settings.quality, settings.effector_weights.gravity = self.MASS, 20, gravity
        return obj

    def moved(self, obj: bpy.types.Object, first: int = 1) -> np.ndarray:
        """(n, 3), in a frame."""
        found = []
        for frame in (first, first + 1):
            bpy.context.scene.frame_set(frame)
            mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
            positions = np.empty(len(mesh.vertices) * 3)
            mesh.vertices.foreach_get("co", positions)
            found.append(positions.reshape(-1, 3))
        return found[1] - found[0]

    def expected(self, obj: bpy.types.Object, pressure: np.ndarray) -> np.ndarray:
        """(n, 3) accelerations. pressure: (n, 3), N/m^2. How Blender's Cloth shares it out among the corners."""
        force = np.zeros_like(pressure)
        obj.data.calc_loop_triangles()
        for triangle in obj.data.loop_triangles:
            corners = list(triangle.vertices)
            force[corners] += (pressure[corners].sum(axis=0) + pressure[corners]) * triangle.area / 12.0
        return force / self.MASS

    def check(self, kind: str, shape: str, strength: float = 50.0, turn: float = 0.4, **settings: Any) -> None:
        falling = self.moved(self.sheet(1.0))[:, 2].mean() / -9.81
        obj = self.sheet(0.0)
        effector = add(kind, shape, (0.05, -0.1, 0.02), strength=strength, **settings)
        effector.rotation_euler = (turn, 0.3, 0.0)
        bpy.context.view_layer.update()
        found = self.moved(obj) / falling
        positions = np.array([vertex.co for vertex in obj.data.vertices], np.float32) + np.array(self.PLACE, np.float32)
        effects = read(effector).effects(positions)
        pressure = (effects.push + effects.air).astype(np.float64) * FIELD
        if kind == "WIND":  # as speed it pushes along the normal alone, here as Blender counts it
            pressure *= (0.0, 0.0, 1.0)
        expected = self.expected(obj, pressure)
        scale = np.linalg.norm(expected, axis=1).max()
        self.assertGreater(scale, 0.2, f"{kind} {shape}: too weak to tell")
        worst = np.linalg.norm(found - expected, axis=1).max() / scale
        self.assertLess(worst, 0.02, f"{kind} {shape} {settings}")

    def test_force(self) -> None:
        for shape in ("POINT", "LINE", "PLANE"):
            self.check("FORCE", shape)
        self.check("FORCE", "POINT", falloff_power=2.0)
        self.check("FORCE", "POINT", use_gravity_falloff=True)

    def test_falloffs(self) -> None:
        limits = dict(use_min_distance=True, distance_min=0.1, use_max_distance=True, distance_max=0.6,
                      falloff_power=1.0)
        self.check("FORCE", "POINT", **limits)
        self.check("FORCE", "PLANE", z_direction="POSITIVE", **limits)
        self.check("FORCE", "POINT", z_direction="NEGATIVE", turn=2.0)
        radial = dict(use_radial_min=True, use_radial_max=True, radial_falloff=2.0)
        self.check("FORCE", "POINT", falloff_type="TUBE", radial_min=0.1, radial_max=0.7, **radial, **limits)
        self.check("FORCE", "POINT", falloff_type="CONE", radial_min=20.0, radial_max=60.0, **radial)

    def test_vortex(self) -> None:
        for shape in ("POINT", "PLANE"):
            self.check("VORTEX", shape, strength=10.0)

    def test_harmonic(self) -> None:
        self.check("HARMONIC", "POINT")
        self.check("HARMONIC", "PLANE", rest_length=0.3)

    def test_turbulence(self) -> None:
        for shape in ("POINT", "PLANE"):
            self.check("TURBULENCE", shape, size=0.7)
        self.check("TURBULENCE", "POINT", size=1.5, use_global_coords=True)

    def test_wind(self) -> None:
        """At rest: Blender's pressure is linear in the speed. Ours is its square: docs/base_cloth.md."""
        self.check("WIND", "PLANE", flow=0.0)
        self.check("WIND", "POINT", falloff_power=1.0)

    def test_what_takes_velocity(self) -> None:
        """A sheet that falls, for six frames, its vertices each for itself. Blender's Linear is the drag of the square
        of the velocity, and its Quadratic that of the velocity."""
        for kind, settings in (("DRAG", dict(linear_drag=0.0, quadratic_drag=2.0)),
                               ("DRAG", dict(linear_drag=2.0, quadratic_drag=0.0)),
                               ("FORCE", dict(strength=0.0, flow=1.5)), ("VORTEX", dict(strength=0.0))):
            fallen = [0.0, 0.0]
            for shown in range(2):  # without the field, and with it
                obj = self.sheet(1.0)
                obj.modifiers["Cloth"].settings.mass = self.MASS / 30.0
                if shown:
                    effector = add(kind, "PLANE" if kind == "VORTEX" else "POINT", **settings)
                for frame in range(1, 6):
                    bpy.context.scene.frame_set(frame)
                fallen[shown] = -self.moved(obj, 6)[:, 2]
            linear, square = read(effector).effects(np.zeros((1, 3), np.float32)).resist[0] * FIELD
            velocity = np.zeros((len(obj.data.vertices), 3))
            way = 0.0
            for step in range(6 * 20):  # of Blender's quality, a thousandth of the acceleration a frame
                pressure = -(linear + square * 24.0 * np.abs(velocity)) * 24.0 * velocity
                gained = self.expected(obj, pressure) * 30.0 - (0.0, 0.0, 9.81)
                velocity += gained / 1000.0 / 20.0
                way = way - velocity[:, 2] / 20.0 if step >= 5 * 20 else 0.0
            lost = fallen[0] - way
            self.assertGreater(lost.min(), 0.02 * fallen[0].max(), f"{kind} {settings}")
            np.testing.assert_allclose(fallen[0] - fallen[1], lost, rtol=0.05, err_msg=f"{kind} {settings}")


class AsBlendersNoise(unittest.TestCase):

    def test_the_lattice_is_blenders(self) -> None:
        sleeve.empty_file()
        effector = add("TURBULENCE", strength=1.0, size=1.0, use_global_coords=True)
        points = np.random.default_rng(3).uniform(-9.0, 9.0, (50, 3)).astype(np.float32)
        found = read(effector).effects(points).push[:, 0]
        for point, value in zip(points, found):
            octaves = [noise.noise(Vector(point) * 2.0**k, noise_basis="PERLIN_NEW") / 2.0**k for k in range(3)]
            self.assertAlmostEqual(value, sum(octaves) * 4.0 / 7.0, delta=2e-5)


class Swinging(Cloth):

    def setUp(self) -> None:
        self.obj = garment(base_cloth="SWING")
        sleeve.bend_until(1000)  # the pose hardly moves
        self.calm = played(self.obj, 10)

    def test_each_kind_moves_it_and_what_is_hidden_or_does_not_act_on_locations_does_not(self) -> None:
        for kind in ("FORCE", "VORTEX", "HARMONIC", "TURBULENCE"):
            effector = add(kind, at=(0.3, 0.2, -0.4), strength=20.0)
            self.assertGreater(difference(played(self.obj, 10)[10], self.calm[10]), 1e-3, kind)
            self.assertEqual(self.obj.rumple.message, "")
            effector.field.apply_to_location = False
            bpy.context.view_layer.update()
            self.same(played(self.obj, 10), self.calm)
            effector.field.apply_to_location = True
            effector.hide_viewport = True
            bpy.context.view_layer.update()
            self.same(played(self.obj, 10), self.calm)
            bpy.data.objects.remove(effector)

    def test_frames_replay_to_the_bit_and_a_change_of_a_field_counts(self) -> None:
        effector = add("TURBULENCE", at=(0.1, 0.2, 0.3), strength=20.0, size=0.3, noise=3.0)
        effector.field.seed = 7
        first = played(self.obj, 10)
        self.same(pictures(self.obj, (7, 3, 9, 1, 10)), first)
        self.assertTrue(sleeve.picture(self.obj).replayed)
        bpy.ops.object.rumple_clear_frames()
        self.same(played(self.obj, 10), first)
        effector.field.seed = 8
        bpy.context.view_layer.update()
        self.assertGreater(difference(played(self.obj, 10)[10], first[10]), 1e-5)
        effector.field.seed, effector.field.noise = 7, 0.0
        bpy.context.view_layer.update()
        self.assertGreater(difference(played(self.obj, 10)[10], first[10]), 1e-5)

    def test_a_field_that_is_animated_is_felt_when_it_is(self) -> None:
        effector = add("FORCE", "PLANE", strength=0.0)
        for frame, strength in ((5, 0.0), (6, 30.0)):
            effector.field.strength = strength
            effector.field.keyframe_insert("strength", frame=frame)
        shown = played(self.obj, 10)
        self.assertLess(difference(shown[5], self.calm[5]), 1e-6)
        self.assertGreater(difference(shown[10], self.calm[10]), 1e-3)

    def test_a_held_field_is_held_and_noise_never_is(self) -> None:
        sleeve.bend_until(8)
        bpy.context.scene.frame_end = 60
        calm = played(self.obj, 60)
        effector = add("TURBULENCE", strength=10.0, size=0.3)
        shown = played(self.obj, 60)
        np.testing.assert_array_equal(shown[59], shown[60])
        self.assertGreater(difference(shown[60], calm[60]), 1e-3)
        effector.field.noise = 3.0
        bpy.context.view_layer.update()
        shown = played(self.obj, 60)
        self.assertGreater(difference(shown[59], shown[60]), 1e-5)

    def test_a_bake_has_the_fields(self) -> None:
        add("TURBULENCE", strength=20.0, size=0.3, noise=2.0)
        shown = played(self.obj, 10)
        self.saved()
        bpy.ops.object.rumple_clear_frames()
        self.obj.rumple.bake_start, self.obj.rumple.bake_end = 2, 8
        sleeve.make_active(self.obj)
        self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})
        sleeve.at(8)
        baked = sleeve.evaluated(self.obj).data
        positions = np.empty(len(baked.vertices) * 3, np.float32)
        baked.vertices.foreach_get("co", positions)
        self.assertLess(difference(positions.reshape(-1, 3), shown[8]), 1e-5)

    def test_drag_slows_it(self) -> None:
        add("FORCE", "PLANE", (0.0, 0.0, -9.0), strength=5.0)
        free = difference(played(self.obj, 3)[3], self.calm[3])
        add("DRAG", quadratic_drag=2.0, linear_drag=2.0)
        self.assertLess(difference(played(self.obj, 3)[3], self.calm[3]), 0.95 * free)

    def test_what_is_not_felt_is_said(self) -> None:
        def says() -> str:
            return "\n".join(line for line, _icon in panels.status_lines(self.obj))
        add("FORCE").name = "Push"
        add("CHARGE").name = "Charge"  # Blender's Cloth does not feel it either
        sleeve.at(2)
        self.assertNotIn("force field", says())
        add("MAGNET").name = "Magnet"
        sleeve.at(3)
        self.assertIn("Magnet: the cloth does not feel a force field", says())
        self.assertNotIn("Push", says())

    def test_numbers_that_are_too_large_do_not_stop_it(self) -> None:
        add("FORCE", strength=1e30, use_max_distance=True, distance_max=1e38)
        played(self.obj, 3)
        self.assertEqual(self.obj.rumple.message, "")


if __name__ == "__main__":
    unittest.main()
