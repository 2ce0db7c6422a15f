# SPDX-License-Identifier: GPL-3.0-or-later
"""The stage before every system: solves the base cloth of a garment, and defines the state of a frame over it. Never
imports bpy."""
from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Callable

import numpy as np

from ...native import kernels
from ...native.surface import FrameState
from ..base.digests import digest_of
from ..mesh.body import Body
from ..paint.hangs_free import FREE
from ..paint.keep_smooth import SMOOTH, share_of_folds
from ..settings.cloth_settings import ClothSettings
from .base_cloth import BaseCloth, ClothFrame
from .drape import Drape
from .surroundings import Surroundings

PAINTED = ("follow", "room", FREE, SMOOTH)  # the paint of the base cloth itself
LEAST_UNDER = 0.02  # least share of vertices with the body under them: with fewer, something is wrong


@dataclass
class OnCloth:
    """The state of a frame that has a base cloth."""

    cloth: ClothFrame
    wrinkles: FrameState

    @property
    def nbytes(self) -> int:
        return self.cloth.nbytes + self.wrinkles.nbytes


State = FrameState | OnCloth  # of a frame


@dataclass
class OnClothReport:
    """How a frame that has a base cloth was solved."""

    cloth: Any  # native
    wrinkles: Any  # the system's report
    has_body: bool  # whether it was worn over a body
    is_free: bool = True  # False: there is no base cloth, and the animated mesh was only moved out of a body

    @property
    def layers(self) -> list[Any]:
        """The system's report on each layer, coarse first."""
        return self.wrinkles if isinstance(self.wrinkles, list) else [self.wrinkles]

    def lines(self, name: str, unit_scale: float) -> list[str]:
        """Lines for the artist. name: of the object; unit_scale: metres per object unit."""
        offset = 1000.0 * unit_scale * self.cloth.offset_mean
        under = 100.0 * self.cloth.body_known
        lines = [f"Base cloth: {offset:.1f} mm from the animation on average, {under:.0f} % has the body under it"
                 if self.is_free else
                 f"Body: it moves the mesh by {offset:.1f} mm on average, {under:.0f} % has the body under it"]
        if self.has_body and self.cloth.body_known < LEAST_UNDER:
            lines.append(f"{name}: its body does not lie under it: choose another body")
        return lines


def system_state(state: State | None) -> FrameState | None:
    """A system's own part of a stored state, or None."""
    return state.wrinkles if isinstance(state, OnCloth) else state


def cloth_of(state: State | None) -> ClothFrame | None:
    """The base cloth of a stored state, or None."""
    return state.cloth if isinstance(state, OnCloth) else None


def _digest_of_start(settings: ClothSettings, paint: dict[str, np.ndarray], positions: np.ndarray,
                     world_from_object: np.ndarray | None, body: Body | None, covers: bool, seconds: float,
                     surroundings: Surroundings) -> bytes:
    """A digest of all inputs of a base cloth frame without a frame before it."""
    own = [getattr(settings, one.name) for one in fields(ClothSettings)]
    has_time = settings.base_cloth == "SWING"  # also for independent frames, because the stored frame contains its time
    about = repr((own, settings if settings.draped else None, settings.swings, covers, sorted(paint), body is None,
                  seconds if has_time else None))
    arrays = (world_from_object, *(paint[name] for name in sorted(paint)), *(body.arrays() if body else ()))
    return digest_of(about.encode(), np.ascontiguousarray(positions), *arrays,
                     surroundings.array() if has_time else None)


class Stage:
    """Solves the base cloth of one garment, for any system. It gets and returns frames. The last frame without one
    before it is kept, because a brush or a slider that changes only the wrinkles needs the same base cloth again."""

    def __init__(self, surface: Any, diagonal: float, unit_scale: float,
                 suggest: Callable[[str], np.ndarray] | None = None, inner: float = 0.0) -> None:
        """Arguments as in BaseCloth()."""
        self.cloth = BaseCloth(surface, diagonal, unit_scale, suggest, inner)
        self._cover: Any = None
        self._drape: Drape | None = None
        self._begun: tuple[bytes, ClothFrame] | None = None  # digest of what it was solved from

    def solve(self, settings: ClothSettings, paint: dict[str, np.ndarray], positions: np.ndarray,
              world_from_object: np.ndarray | None, body: Body | None, before: ClothFrame | None, covers: bool,
              seconds: float = 0.0, surroundings: Surroundings = Surroundings()) -> ClothFrame:
        """Solve one frame. Arguments as in BaseCloth.solve(). covers: also keep the smooth surface of the cloth off the
        body, for systems that do not handle bodies. Raises ValueError."""
        rest = (settings, paint, positions, world_from_object, body)
        if before is not None:
            return self._solve(*rest, before, covers, seconds, surroundings)
        digest = _digest_of_start(*rest, covers, seconds, surroundings)
        if self._begun is None or self._begun[0] != digest:
            self._begun = digest, self._solve(*rest, None, covers, seconds, surroundings)
        return self._begun[1]

    def _solve(self, settings: ClothSettings, paint: dict[str, np.ndarray], positions: np.ndarray,
               world_from_object: np.ndarray | None, body: Body | None, before: ClothFrame | None, covers: bool,
               seconds: float, surroundings: Surroundings) -> ClothFrame:
        """Like solve(), without the kept frame."""
        frame = self.cloth.solve(positions, settings, paint, world_from_object, body, before, seconds, surroundings)
        collider = self.cloth.collider(body)
        if settings.draped:
            self.drape.add_to(frame, settings, world_from_object, before.drape if before is not None else None,
                              self.contact(frame, settings, body), paint.get(SMOOTH))
        smooth = paint.get(SMOOTH)
        if (covers or smooth is not None) and body is not None and collider is not None:
            self._lift(frame, settings, collider, body, None if covers else smooth)
        return frame

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

    def _lift(self, frame: ClothFrame, settings: ClothSettings, collider: Any, body: Body,
              where: np.ndarray | None) -> None:
        """Lift the cloth out of the body where its smooth surface cuts through between the vertices. where: (n,) the
        paint Keep Smooth, only there; None: everywhere."""
        if self._cover is None:
            self._cover = kernels.build_cloth_cover(self.cloth.surface)
        lifts = kernels.cover_bodies(self.cloth.surface, self._cover, collider, body.positions, frame.positions,
                                     frame.body_hint, self.cloth.thickness(settings), self.cloth.hidden_depth())
        if where is not None:
            lifts = lifts * (np.float32(1.0) - share_of_folds(where))[:, None]
        frame.positions = frame.positions + lifts
        frame.gap = frame.gap + np.linalg.norm(lifts, axis=1)
