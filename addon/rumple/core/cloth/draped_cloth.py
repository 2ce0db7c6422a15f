# SPDX-License-Identifier: GPL-3.0-or-later
"""The stage before every system: the base cloth of a garment, with wide folds and a smooth surface where they are asked
for. Never imports bpy."""
from __future__ import annotations

import functools
from dataclasses import fields, replace
from typing import Any, Callable

import numpy as np

from ...native import kernels
from ..base.digests import digest_of
from ..mesh.body import Body
from ..paint.hangs_free import FREE
from ..paint.keep_smooth import SMOOTH, share_of_folds
from ..settings.cloth_settings import ClothSettings
from .base_cloth import BaseCloth, ClothFrame, ClothInput
from .carried_cloth import CarriedCloth, painted_on
from .drape import Drape

PAINTED = ("follow", "room", FREE, SMOOTH)  # the paint of the base cloth itself


class DrapedCloth:
    """The base cloth of one garment as any system is solved over it: with the drape, if the settings ask for it, and
    outside of the body. It gets and returns frames. The last frame without one before it is kept, because a brush or a
    slider that changes only the wrinkles needs the same base cloth again."""

    def __init__(self, surface: Any, diagonal: float, unit_scale: float, suggest: Callable[[str], np.ndarray],
                 inner: float = 0.0, figure: float = 0.0, coarse: Any = None) -> None:
        """coarse: native, the coarse mesh that the base cloth and the drape are solved on; None: the surface. The other
        arguments are those of BaseCloth()."""
        self.surface, self.coarse = surface, coarse
        self.cloth = BaseCloth(surface if coarse is None else coarse.surface, diagonal, unit_scale,
                               suggest if coarse is None else lambda up: painted_on(coarse, suggest(up)), inner, figure)
        self._carried: CarriedCloth | None = None
        self._cover: Any = None
        self._drape: Drape | None = None
        self._begun: tuple[bytes, ClothFrame] | None = None  # digest of what it was solved from

    def solve(self, settings: ClothSettings, paint: dict[str, np.ndarray], given: ClothInput,
              before: ClothFrame | None, covers: bool) -> ClothFrame:
        """Solve one frame. Arguments as in BaseCloth.solve(). covers: also keep the smooth surface of the cloth off the
        body, for systems that do not handle bodies. Raises ValueError."""
        if before is not None and (before.solved is None) != (self.coarse is None):
            before = None  # it was solved on the other vertices, because Base Cloth was switched off or on
        if before is not None:
            return self._solve(settings, paint, given, before, covers)
        digest = _digest_of_start(settings, paint, given, covers)
        if self._begun is None or self._begun[0] != digest:
            self._begun = digest, self._solve(settings, paint, given, None, covers)
        return self._begun[1]

    def _solve(self, settings: ClothSettings, paint: dict[str, np.ndarray], given: ClothInput,
               before: ClothFrame | None, covers: bool) -> ClothFrame:
        """Like solve(), without the kept frame."""
        if self.coarse is not None:
            frame = self._solve_coarse(self.coarse, settings, paint, given, before)
        else:
            frame = self.cloth.solve(settings, paint, given, before)
        body, smooth = given.body, paint.get(SMOOTH)
        if settings.draped and self.coarse is None:
            self.drape.add_to(frame, settings, given.world_from_object, before.drape if before is not None else None,
                              self.contact(frame, settings, body), smooth)
        if covers:
            frame.positions = kernels.untangle_cloth(self.surface, given.positions, frame.positions)
        if (covers or smooth is not None) and body is not None and len(body.triangles):
            self._lift(frame, settings, body, None if covers else smooth)
        return frame

    def _solve_coarse(self, coarse: Any, settings: Any, paint: dict[str, np.ndarray], given: ClothInput,
                      before: ClothFrame | None) -> ClothFrame:
        """The base cloth with its drape, solved on the coarse mesh and carried to the surface. The drape is solved even
        if it has no height, because its state carries the cloth."""
        if self._carried is None:
            self._carried = CarriedCloth(self.surface, coarse, self.drape)
        solved = replace(given, positions=coarse.positions(given.positions))
        frame = self.cloth.solve(settings, self._carried.paint(paint), solved, before)
        frame.positions = self._carried.smoothed(frame.positions, solved.positions, self.cloth.follow)
        solve = functools.partial(self.drape.solve, frame, world_from_object=given.world_from_object,
                                  contact=self.contact(frame, settings, given.body))
        carried = self._carried.carried(frame, solve(settings, before=before.drape if before is not None else None),
                                        given.positions)
        if settings.draped and SMOOTH in paint:
            plain = self._carried.positions(solve(replace(settings, drape=0.0), before=None), given.positions)
            kept = np.float32(1.0) - share_of_folds(paint[SMOOTH])[:, None]
            carried.positions = carried.positions - kept * (carried.positions - plain)
        return carried

    @property
    def drape(self) -> Drape:
        """The wide folds under a system that has none of its own. It is built once."""
        if self._drape is None:
            self._drape = Drape(self.cloth)
        return self._drape

    def contact(self, frame: ClothFrame, settings: ClothSettings, body: Body | None) -> dict[str, Any]:
        """The collision arguments of solve_wrinkle_layers(), for layers over this frame."""
        collider = self.cloth.collider(body)
        if collider is None or body is None:
            return dict(gap=frame.gap)
        return dict(gap=frame.gap, collider=collider, body_positions=body.positions, body_hint=frame.body_hint,
                    thickness=self.cloth.thickness(settings) - self.cloth.inner, inner=self.cloth.inner)

    def _lift(self, frame: ClothFrame, settings: ClothSettings, body: Body, where: np.ndarray | None) -> None:
        """Lift the cloth out of the body where its smooth surface cuts through between the vertices. where: (n,) the
        paint Keep Smooth, only there; None: everywhere."""
        if self._cover is None:
            self._cover = kernels.build_cloth_cover(self.surface)
        # a whole surface has its inner side, which may be as near to the body as cloth without a thickness
        thickness = self.cloth.thickness(settings) - (0.0 if self.coarse is None else self.cloth.inner)
        lifts, room = kernels.cover_bodies(self._cover, self.cloth.collider(body), body.positions, frame.positions,
                                           frame.body_hint, thickness, self.cloth.hidden_depth())
        if where is not None:
            lifts = lifts * (np.float32(1.0) - share_of_folds(where))[:, None]
        frame.positions = frame.positions + lifts
        gap = frame.gap + np.linalg.norm(lifts, axis=1)
        frame.gap = gap if where is not None else np.minimum(gap, room)  # between the vertices too


def _digest_of_start(settings: ClothSettings, paint: dict[str, np.ndarray], given: ClothInput, covers: bool) -> bytes:
    """A digest of all inputs of a base cloth frame without a frame before it."""
    own = [getattr(settings, one.name) for one in fields(ClothSettings)]
    has_time = settings.base_cloth == "SWING"  # also for independent frames, because the stored frame contains its time
    about = repr((own, settings if settings.draped else None, settings.swings, covers, sorted(paint),
                  given.body is None, given.seconds if has_time else None))
    arrays = (given.world_from_object, *(paint[name] for name in sorted(paint)),
              *(given.body.arrays() if given.body else ()))
    return digest_of(about.encode(), np.ascontiguousarray(given.positions), *arrays,
                     given.surroundings.array() if has_time else None)
