# SPDX-License-Identifier: GPL-3.0-or-later
"""The base cloth on plain arrays: the coarse mesh becomes cloth around its animation. Never imports bpy."""
from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import Any, Callable

import numpy as np

from ...native import kernels
from ..base import transforms
from ..base.last_result import LastResult
from ..base.vertices import lengths
from ..mesh.body import Body, same_at_rest
from ..mesh.figure_size import size_factor
from ..paint.hangs_free import FREE, room_factor
from ..settings.cloth_settings import ClothSettings, direction_of
from ..settings.fabrics import GRAVITY
from .surroundings import Surroundings

AIR = 1.2  # kg/m^3
MOST = 1e5  # m/s^2, m/s: the library refuses much larger values
# N/m^2 of a force field of strength 1: the same ratio to gravity as in Blender's Cloth at 24 frames/s
FIELD = 20.0 / 24.0
# 1/s^2: so weak that gravity sags cloth by 2 cm. It then hangs from the shoulders, not from its animation
FOLLOW = 150.0
# panels turn as they are pulled. This gives long folds from the shoulder to the waist
HANGING = dict(flat_share=0.05)
# m^2/s^2, of cotton. Swinging cloth must be able to turn freely and to come to rest, and its time steps are short.
SWINGING = dict(stretch=50.0, shear=5.0, compression=0.3, folded=1.0, smoothing=1.0, hem_share=1.0)
BENT = ("compression", "folded", "smoothing")  # the values of SWINGING that grow with a fabric's bending stiffness
THIRTIETH = 1.0 / 30.0  # s: the time that the substeps divide
# least radius / wavelength of lines that folds may run along; from four times this value on, all folds may
LEAST_BEND = 4.0
# Metres: skin that is farther from the cloth at rest is not under it. An example is an arm that an animation moves into
# the side of a shirt.
WORN_WITHIN = 0.12


@dataclass(frozen=True, eq=False)
class ClothInput:
    """What a frame moves the cloth with. n: vertices of the surface."""

    positions: np.ndarray  # (n, 3) float32, animated, object space
    world_from_object: np.ndarray | None = None  # (3, 3), for the direction of gravity; None: the identity
    body: Body | None = None  # the cloth stays outside of it
    seconds: float = 0.0  # since frame 0; read by swinging cloth, as the surroundings are
    surroundings: Surroundings = Surroundings()


@dataclass
class ClothFrame:
    """The base cloth of one frame. The wrinkles are solved over it."""

    positions: np.ndarray  # (n, 3) float32, object space
    gap: np.ndarray  # (n,) float32: height above the body, object units
    body_hint: np.ndarray  # (n,) int32: a triangle of the body near it, or -1; (0,) without a body
    state: kernels.BaseClothState
    report: kernels.BaseClothReport | None  # None: it was read from a file
    swing_input: "SwingInput | None" = None  # of cloth that swings
    drape: kernels.WrinkleLayersState | None = None  # state of the wide folds, which the positions include: drape.py
    # (m, 3) float32, object space: the positions of the coarse mesh that it was solved on; None: of these vertices
    solved: np.ndarray | None = None

    @property
    def nbytes(self) -> int:
        more = sum(part.nbytes for part in (self.drape, self.solved) if part is not None)
        return self.positions.nbytes + self.gap.nbytes + self.body_hint.nbytes + self.state.nbytes + more

    def activated(self) -> "ClothFrame | None":
        """The frame to start from after settings changed. None: hanging cloth starts anew. Swinging cloth keeps its
        motion."""
        if self.swing_input is None:
            return None
        return replace(self, state=self.state.activated(), drape=None)


@dataclass
class SwingInput:
    """The time and the place at which swinging cloth was solved."""

    seconds: float
    world_from_object: np.ndarray  # (3, 3) float64
    location: np.ndarray  # (3,) float64 of the object, world units

    @property
    def object_from_world(self) -> np.ndarray:
        return transforms.inverse(self.world_from_object)


class BaseCloth:
    """A garment's cloth and the collider of its body. It has no state: a solve gets the frame before and returns a new
    one."""

    def __init__(self, surface: Any, diagonal: float, unit_scale: float,
                 suggest: Callable[[str], np.ndarray] | None = None, inner: float = 0.0, figure: float = 0.0) -> None:
        """surface: native, at rest. diagonal: of its bounding box, object units. unit_scale: metres per object unit.
        suggest: a function of the up axis that returns (n,) float32, how firmly vertices follow the animation where
        nothing is painted; None: suggested_follow() of the surface. inner: how far the garment's inner side is below
        the surface, object units. figure: height of its wearer, object units; 0: unknown."""
        self.surface, self.unit_scale, self.inner = surface, unit_scale, inner
        self._suggest = suggest or functools.partial(suggested_follow, surface)
        self.model = kernels.build_base_cloth(surface)
        self.size_factor = size_factor(diagonal, unit_scale, figure)
        self._options = LastResult(self._native_settings)
        self._collider: tuple[Body, Any] | None = None
        self._paint: Any = None
        self.follow = np.zeros(0, np.float32)  # (n,) of the last frame: how firmly vertices follow the animation
        self._painted: dict[str, np.ndarray] | None = None
        self._paint_settings = "", 0.0, 0.0

    def solve(self, settings: ClothSettings, paint: dict[str, np.ndarray], given: ClothInput,
              before: ClothFrame | None = None) -> ClothFrame:
        """Solve one frame. before: the previous frame, or None. Raises ValueError."""
        world_from_object, body = _invertible(given.world_from_object), given.body
        if paint is not self._painted or (settings.up, settings.room, settings.free_room) != self._paint_settings:
            self._take_paint(paint, settings)
        options = self._options(settings, world_from_object)
        frame = (self._paint, given.positions, self.collider(body), body.positions if body is not None else None,
                 before.state if before is not None else None)
        if settings.base_cloth != "SWING":
            return ClothFrame(*kernels.solve_base_cloth(self.model, options, *frame))
        now = SwingInput(given.seconds, world_from_object, np.array(given.surroundings.location, np.float64))
        swing = self._swing(settings, given.surroundings, now, before.swing_input if before is not None else None)
        forces = self._forces(settings, given, now, before)
        return ClothFrame(*kernels.swing_base_cloth(self.model, options, swing, *frame, forces), now)

    def collider(self, body: Body | None) -> Any:
        """The native collider of a body; None without a body. It is built again only if triangles or rest change."""
        if body is None or not len(body.triangles):
            return None
        if self._collider is None or not same_at_rest(self._collider[0], body):
            within = WORN_WITHIN * self.size_factor / self.unit_scale
            self._collider = body, kernels.Collider(body.positions, body.triangles, body.rest, within)
        return self._collider[1]

    def thickness(self, settings: ClothSettings) -> float:
        """Thickness of the cloth, including the modelled thickness, object units."""
        return settings.thickness / self.unit_scale + self.inner

    def hidden_depth(self) -> float:
        """Object units. Cloth deeper inside a body is there on purpose, so it is not pushed out."""
        return self._settings_to_scale().depth

    def _take_paint(self, paint: dict[str, np.ndarray], settings: ClothSettings) -> None:
        values = {name: paint[name] for name in ("follow", "room") if name in paint}
        values = values if "follow" in values else {**values, "follow": self._suggest(settings.up)}
        self.follow = values["follow"]
        if FREE in paint:
            factor = room_factor(paint[FREE], settings)
            values["room"] = values["room"] * factor if "room" in values else factor
        self._paint, self._painted = kernels.BaseClothPaint(self.model, values), paint
        self._paint_settings = settings.up, settings.room, settings.free_room

    def _swing(self, settings: ClothSettings, surroundings: Surroundings, now: SwingInput,
               before: SwingInput | None) -> Any:
        """The options of the native solver for swinging cloth. Stiffness is per mass, so the mass matters only for the
        air."""
        object_from_world = now.object_from_world
        options = kernels.BaseClothSwing()
        options.longest_step = THIRTIETH / settings.substeps
        options.damping, options.locomotion = settings.swing_damping, settings.locomotion
        to_scale = self.size_factor / self.unit_scale
        options.drag = AIR * settings.drag / (2.0 * settings.mass * to_scale)
        options.wind = tuple(float(v) for v in to_scale * _into_object(object_from_world, np.array(surroundings.wind)))
        if before is None:
            return options
        options.seconds = max(now.seconds - before.seconds, 0.0)
        if not (np.array_equal(before.world_from_object, now.world_from_object)
                and np.array_equal(before.location, now.location)):
            shift = transforms.turned_one(object_from_world, before.location - now.location)
            turn = transforms.product(object_from_world, before.world_from_object)
            options.place(turn.tolist(), shift.tolist())
        return options

    def _forces(self, settings: ClothSettings, given: ClothInput, now: SwingInput, before: ClothFrame | None) -> Any:
        """The forces of the force fields on every vertex, at its position in the previous frame. None without
        fields."""
        if not given.surroundings.fields:
            return None
        if before is not None and before.swing_input is not None:
            positions, at = before.positions if before.solved is None else before.solved, before.swing_input
        else:
            positions, at = given.positions, now
        in_world = transforms.turned(at.world_from_object, positions) + at.location
        effects = given.surroundings.effects(in_world.astype(np.float32))
        to_scale, of_mass = self.size_factor / self.unit_scale, FIELD / settings.mass
        object_from_world = now.object_from_world
        return kernels.VertexForces(
            to_scale * _all_into_object(object_from_world, effects.air),
            to_scale * _all_into_object(object_from_world, of_mass * effects.push.astype(np.float64)),
            np.minimum(of_mass * effects.resist, MOST) * np.array((1.0, 1.0 / to_scale), np.float32))

    def _settings_to_scale(self, others: dict[str, float] | None = None) -> Any:
        """The solver's default settings in object units. others: values that replace defaults. Lengths are scaled so
        that the cloth of a doll or a giant hangs like a person's."""
        options = kernels.BaseClothSettings()
        for name, value in (others or {}).items():
            setattr(options, name, value)
        to_scale = self.size_factor / self.unit_scale
        for name in ("stretch", "shear", "compression", "folded", "smoothing"):
            setattr(options, name, getattr(options, name) * to_scale**2)
        for name in ("tube_radius", "unknown", "reach", "depth", "spread"):
            setattr(options, name, getattr(options, name) * to_scale)
        return options

    def _native_settings(self, settings: ClothSettings, world_from_object: np.ndarray) -> Any:
        # Independent frames, which some systems have, have no time, so their cloth hangs.
        swings = settings.base_cloth == "SWING" and not getattr(settings, "stateless", False)
        options = self._settings_to_scale(SWINGING if swings else HANGING)
        to_scale = self.size_factor / self.unit_scale
        for name in BENT:
            setattr(options, name, getattr(options, name) * stiffness_over_cotton(settings.bending_length))
        down = downwards(world_from_object)
        options.gravity = (GRAVITY * settings.gravity * to_scale * down).tolist()
        if settings.base_cloth == "OFF":
            options.steps = options.start_steps = 0  # only moves the animated mesh out of the body
        options.follow = FOLLOW
        options.slack, options.hang = settings.slack, _hanging(settings.gravity, down)
        options.friction = settings.friction
        options.room, options.slide_room = settings.room / self.unit_scale, settings.slide_room / self.unit_scale
        options.thickness = self.thickness(settings)
        return options


def downwards(world_from_object: np.ndarray | None) -> np.ndarray:
    """(3,) unit vector of gravity, in object space. world_from_object: (3, 3); None: the identity."""
    down = transforms.turned_one(transforms.inverse(_invertible(world_from_object)), np.array((0.0, 0.0, -1.0)))
    length = transforms.length(down)
    return down / length if length > 0.0 else down


def hanging(gravity: float, world_from_object: np.ndarray | None) -> tuple[float, ...]:
    """The direction in which its own weight pulls cloth taut: object space, length 0 to 1. gravity: 1 is the
    earth's."""
    return _hanging(gravity, downwards(world_from_object))


def _hanging(gravity: float, down: np.ndarray) -> tuple[float, ...]:
    return tuple((min(max(gravity, 0.0), 1.0) * down).tolist())


def suggested_follow(surface: Any, up: str) -> np.ndarray:
    """(n,) float32: how firmly every vertex follows the animation where nothing is painted. up: as in the settings."""
    return kernels.suggest_follow(surface, tuple(direction_of(up)))


def length_over_cotton(bending_length: float) -> float:
    """Ratio of a bending length (metres) to that of cotton. It is rounded to six digits because Blender's properties
    hold only seven, and cotton must give exactly 1."""
    return round(bending_length / ClothSettings.bending_length, 6)


def stiffness_over_cotton(bending_length: float) -> float:
    """Ratio of the bending stiffness per mass to that of cotton. It also scales the resistance of the base cloth to
    compression, because compressed cloth buckles between its vertices. bending_length: metres."""
    return length_over_cotton(bending_length) ** 3


def bend_radius(settings: ClothSettings, wavelength: float, unit_scale: float) -> float:
    """Object units: lines with a smaller radius of curvature get no folds (spare_cloth() of the library). Without a
    base cloth it is 0, so all lines may. wavelength: of the folds, metres; unit_scale: metres per object unit."""
    return 0.0 if settings.base_cloth == "OFF" else LEAST_BEND * wavelength / unit_scale


def _invertible(world_from_object: np.ndarray | None) -> np.ndarray:
    """(3, 3) float64; the identity if the object has no size."""
    if world_from_object is None or abs(transforms.determinant(world_from_object)) < 1e-12:
        return np.eye(3)
    return world_from_object.astype(np.float64)


def _into_object(object_from_world: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """A world vector turned into object space, (3,), with its length unchanged."""
    turned = transforms.turned_one(object_from_world, vector)
    length = transforms.length(turned)
    return turned * (transforms.length(vector) / length) if length > 0.0 else np.zeros(3)


def _all_into_object(object_from_world: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Like _into_object(), for (n, 3), with lengths limited to MOST. float32."""
    vectors = vectors.astype(np.float64)
    turned = transforms.turned(object_from_world, vectors)
    factor = np.minimum(lengths(vectors), MOST) / np.maximum(lengths(turned), 1e-300)
    return (turned * factor[:, None]).astype(np.float32)
