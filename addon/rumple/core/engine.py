# SPDX-License-Identifier: GPL-3.0-or-later
"""What the systems share: pictures, and frames that do not depend on how one got there. Never imports bpy."""
from __future__ import annotations

import functools
import hashlib
import math
import time
from dataclasses import replace
from typing import Any, Callable

import numpy as np

from ..native import kernels
from . import wording
from .base_mesh import BaseMesh
from .body import Body
from .by_hand import ByHand
from .cloth import ClothFrame, suggested_follow
from .fold_guides import GUIDES
from .frame_cache import CachedFrame, FrameCache, chain_of, digest_of
from .frame_input import FrameInput
from .frame_result import COMMON_ATTRIBUTES, Attribute, FrameResult, PreviewFrame
from .on_cloth import PAINTED, OnCloth, OnClothReport, Stage, cloth_of, system_state
from .shown_mesh import ShownMesh, ViewportMesh
from .surroundings import Surroundings

MOST_VERTICES = 4_000_000
UserError = wording.UserError  # for those who see the engine only
TABLES = (PROFILE := "profile", GUIDES)  # paint that is not a value for each vertex


class Wrinkles(ShownMesh):
    """A shown mesh bound to a base, and the frames that were solved for it.

    A system adds build() and the steps at the end of this class.
    """

    ATTRIBUTES: tuple[Attribute, ...] = COMMON_ATTRIBUTES
    SUGGESTED = "wavelength"  # the setting that suits the mesh when wrinkles are added: see suggested_length()
    HEIGHTS: tuple[str, ...] = ()  # attributes that say how high folds are, scaled with them
    HEIGHT_PAINT = ""  # paint that keeps folds off: where empty, what is solved is made flat
    HAS_CURVES = False  # whether curves() has something to say
    previewed = True  # whether a preview that draws wrinkles by itself draws these as they are
    in_viewport: ViewportMesh | None = None  # what viewports show, where that has fewer vertices
    _last_pose: tuple[Any, Any] = (None, None)  # positions, and the pose that was made of them

    def __init__(self, base: BaseMesh, source: BaseMesh, surface: Any, model: Any, warnings: list[str],
                 unit_scale: float) -> None:
        """base, source: healed. surface: native, of the base."""
        self.name, self.base, self.source = base.name, base, source
        self.surface = surface
        self.solved_surface = surface  # what the base cloth and the system are solved on
        self.model = model
        self.shown = model.shown
        self.warnings = warnings
        self.unit_scale = unit_scale  # metres per object unit
        self.frame_cache = FrameCache()
        self.paint_digest = b""  # of the paint of the last solve
        self._last: dict[tuple[int, float], tuple[bytes, float]] = {}  # by timeline: digest of the settings, frame
        self._clip: dict[float, tuple[bytes, np.ndarray]] = {}  # by frame: digest of the pose, labels
        self.pose_mismatches: set[float] = set()  # frames that came with another pose than the clip that was looked at
        self._paint: Any = None
        self._by_hand = ByHand()
        self._stage: Stage | None = None
        self._cloth_paint: dict[str, np.ndarray] = {}

    # --- frames
    def solve_frame(self, frame: float, positions: np.ndarray, settings: Any, paint: dict[str, np.ndarray], *,
                    start: int, world_from_object: np.ndarray | None = None, frame_rate: float = 24.0,
                    following: tuple[float, np.ndarray] | None = None, for_preview: bool = False,
                    body: Body | None = None, surroundings: Surroundings = Surroundings(),
                    in_viewport: bool = False) -> FrameResult | PreviewFrame:
        """The result of a frame: replayed when it is stored for the same input, else solved and stored.

        positions: (n, 3) float32, deformed base, object space. paint: values per base vertex, by name.
        start: first frame of the clip; it needs no frame before it. frame_rate: frames a second. following: frame
        and positions of the next one, where they are known: a rest shape that adapts looks ahead. for_preview: a
        PreviewFrame is enough. body: what cloth stays outside of in this frame. surroundings: what cloth that swings
        meets. in_viewport: the result of the mesh `in_viewport`, where there is one. Raises UserError.
        """
        if following is not None:
            following = following[0], self.base.points(following[1])
        try:
            return self._solve_frame(frame, self.base.points(positions), settings, paint, start, world_from_object,
                                     frame_rate, following if settings.sees_ahead and body is None else None,
                                     for_preview, body, surroundings,
                                     in_viewport and self.in_viewport is not None)
        except ValueError as error:
            self.frame_cache.refuse(frame)
            raise wording.user_error(self.name, error) from error

    def _solve_frame(self, frame: float, positions: np.ndarray, settings: Any, paint: dict[str, np.ndarray],
                     start: int, world_from_object: np.ndarray | None, frame_rate: float,
                     following: tuple[float, np.ndarray] | None, for_preview: bool, body: Body | None,
                     surroundings: Surroundings, in_viewport: bool) -> FrameResult | PreviewFrame:
        timed = settings.swings or self._reads_time(settings)
        settings_digest = self._take_inputs(frame, settings, paint, start, frame_rate if timed else 0.0)
        world = (self._reads_world(settings) or settings.base_cloth != "OFF") and world_from_object is not None
        matrix = np.ascontiguousarray(world_from_object, np.float32) if world else None
        labels = self._clip_labels_at(frame, positions) if body is None else None
        coming = (0.0, None) if following is None or labels is not None else (following[0] / frame_rate, following[1])
        frame_input = FrameInput(frame, frame / frame_rate, matrix, positions, labels, *coming, body,
                                 surroundings=surroundings if settings.swings else Surroundings(),
                                 in_viewport=in_viewport)
        began = time.perf_counter()
        cached, replayed, pose = self._stored(settings, settings_digest, start, frame_input, for_preview)
        if for_preview and cached.waits:
            return PreviewFrame(replayed=replayed)
        solved = time.perf_counter()
        make = functools.partial(self._result_of, settings, cached, pose,
                                 replace(frame_input, cloth=cloth_of(cached.state)), for_preview)
        result = self.frame_cache.picture(cached, in_viewport, make) if replayed and not for_preview else make()
        spent = dict(solve=1e3 * (solved - began), show=1e3 * (time.perf_counter() - solved))
        return replace(result, report=cached.report, replayed=replayed, milliseconds=spent,
                       unplayed=settings.swings and not cached.final)

    def _stored(self, settings: Any, settings_digest: bytes, start: int, frame_input: FrameInput,
                for_preview: bool) -> tuple[CachedFrame, bool, Any]:
        """The entry of a frame, which is solved and stored where it was not; whether it was; and the pose that it was
        solved in now."""
        frame, digest = frame_input.frame, frame_input.digest(settings_digest, settings.swings)
        before = None if settings.stateless or frame <= start else self.frame_cache.before(frame)
        final = settings.stateless or frame <= start or (before is not None and before.final)
        cached = self.frame_cache.find(frame, digest, final, before)
        if cached is not None:
            return cached, True, None
        chain = chain_of(digest, before)
        same_settings, pose = before is not None and before.settings_digest == settings_digest, None
        if for_preview and before is not None and self._may_wait(settings, frame_input):
            kept = replace(frame_input, animated=frame_input.animated.copy())
            cached = CachedFrame.waiting(before, digest, settings_digest, final, lambda state: self._solve_over(
                settings, state, same_settings, kept)[:2], chain)
        else:
            state, report, pose = self._solve_over(settings, before.state if before is not None else None,
                                                   same_settings, frame_input)
            cached = CachedFrame.of(state, digest, settings_digest, final, report, chain)
        self.frame_cache.put(frame, cached)
        return cached, False, pose

    def _result_of(self, settings: Any, cached: CachedFrame, pose: Any, frame_input: FrameInput,
                   for_preview: bool) -> FrameResult | PreviewFrame:
        """What is shown of a solved frame. pose: that it was solved in now, or None."""
        show: Callable[..., Any] = self._preview if for_preview else self._show
        over = self._over(frame_input.frame, frame_input.animated)
        if pose is None:
            pose = self._pose(over, frame_input)
        self._last_pose = (over.copy(), pose)
        result: FrameResult | PreviewFrame = show(settings, over, pose, system_state(cached.state), frame_input)
        mesh = frame_input.in_viewport and self.in_viewport or self
        if isinstance(result, FrameResult):
            self._by_hand.add_to(result, mesh, frame_input.animated, over, self.HEIGHTS)
        self._add_rigid_parts(result, frame_input.animated, over, mesh)
        return result

    def state_of(self, frame: float) -> Any:
        """The stored state of a frame, or None. With a base cloth: an OnCloth."""
        cached = self.frame_cache.get(frame)
        return cached.state if cached is not None else None

    def wrinkles_of(self, frame: float) -> Any:
        """The system's own state of a stored frame, or None."""
        return system_state(self.state_of(frame))

    def solved_over(self, frame: float, positions: np.ndarray) -> np.ndarray:
        """Object space, of `base`, whose first vertices are the coarse ones: what the wrinkles of a stored frame lie
        on, the base cloth. Without one: the animated positions, which are given."""
        return self._over(frame, self.base.points(positions))

    def _over(self, frame: float, positions: np.ndarray) -> np.ndarray:
        """The same. positions: of `base`."""
        cloth = self._cloth_at(frame)
        return positions if cloth is None else cloth.positions

    def _cloth_at(self, frame: float) -> ClothFrame | None:
        """The base cloth of a stored frame. A frame that waits has none."""
        cached = self.frame_cache.get(frame)
        return None if cached is None or cached.waits else cloth_of(cached.state)

    # --- the base cloth
    def _solve_over(self, settings: Any, before: Any, same_settings: bool,
                    frame_input: FrameInput) -> tuple[Any, Any, Any]:
        """The base cloth, or the animated mesh out of a body, then the system over it. Everything as _solve() has it;
        and the pose that it was solved in."""
        positions, own = self._positions_solved(frame_input.animated), system_state(before)
        if settings.base_cloth == "OFF" and frame_input.body is None:
            pose = self._pose(positions, frame_input)
            return *self._solve(settings, pose, own, same_settings, frame_input), pose
        cloth = cloth_of(before)
        if cloth is not None and not same_settings:
            cloth = cloth.activated()
        cloth = self.base_cloth().solve(settings, self._cloth_paint, positions, frame_input.world_from_object,
                                        frame_input.body, cloth, not self._keeps_off_bodies(), frame_input.seconds,
                                        frame_input.surroundings)
        pose = self._pose(cloth.positions, frame_input)
        state, report = self._solve(settings, pose, own, same_settings, replace(frame_input, cloth=cloth))
        has_body, is_free = frame_input.body is not None, settings.base_cloth != "OFF"
        return OnCloth(cloth, state), OnClothReport(cloth.report, report, has_body, is_free), pose

    def _pose_of(self, frame: float, positions: np.ndarray) -> Any:
        """The pose of a stored frame, for who looks at it: the one that was made last, if it is of these positions."""
        over = self.solved_over(frame, positions)
        return self._last_pose[1] if np.array_equal(self._last_pose[0], over) else over

    def base_cloth(self) -> Stage:
        """Built once."""
        if self._stage is None:
            self._stage = Stage(self.solved_surface, self.base.diagonal(), self.unit_scale,
                                lambda up: self._where_solved(suggested_follow(self.surface, up)))
        return self._stage

    def suggested_follow(self, settings: Any) -> np.ndarray:
        """(n,) float32: how firmly the base cloth follows the animation while nothing is painted: what paint starts
        from."""
        return suggested_follow(self.surface, settings.up)[:self.coarse_count]

    def _result(self, shown: Any, frame_input: FrameInput, **own: np.ndarray) -> FrameResult:
        """From a native picture of a frame: what was solved over the base cloth is embedded in the animated mesh."""
        if frame_input.cloth is not None:
            kernels.embed_frame(self.surface, self.shown, frame_input.animated, shown)
        return FrameResult.of(shown, **own)

    def _add_rigid_parts(self, result: FrameResult | PreviewFrame, animated: np.ndarray, over: np.ndarray,
                         mesh: ShownMesh) -> None:
        """over: what the wrinkles lie on. mesh: that is shown."""
        riders = mesh.riders
        if riders is None:
            return
        if isinstance(result, FrameResult):
            riders.add_to(result, animated, len(mesh.corner_vertex), self.ATTRIBUTES)
        elif result.proxy_offset is not None:
            inside = riders.parts.vertex < len(result.proxy_offset)  # not what healing has made
            result.proxy_offset[riders.parts.vertex[inside]] = riders.displacements(animated, over)[inside]

    def _take_inputs(self, frame: float, settings: Any, paint: dict[str, np.ndarray], start: int,
                     frame_rate: float) -> bytes:
        """A digest of the settings. Forgets stored frames when the artist changed them, or the paint.

        Settings that differ at another frame are animated: then every frame has its own, and stays stored.
        """
        painted = hashlib.blake2b(digest_size=16)
        for key in sorted(paint):
            painted.update(key.encode())
            painted.update(np.ascontiguousarray(paint[key], np.float32).data)
        settings_digest = hashlib.blake2b(repr((settings, start, frame_rate)).encode(), digest_size=16).digest()
        repainted = self._paint is None or painted.digest() != self.paint_digest
        if repainted:
            solved = {name: values if name in TABLES else self._where_solved(self.base.points(values))
                      for name, values in paint.items()}
            self._cloth_paint = {name: solved.pop(name) for name in PAINTED if name in solved}
            self._by_hand = ByHand.taken(paint, self.base, self.HEIGHT_PAINT, solved, self._where_solved)
            self._paint = self._take_paint(solved)
        timeline = (start, frame_rate)  # of another, frames are other ones: each scene has its own
        self.frame_cache.follow(timeline)
        last, at = self._last.get(timeline, (settings_digest, frame))
        if repainted or (settings_digest != last and frame == at):
            self.frame_cache.clear()
            self._last.clear()
        self.paint_digest, self._last[timeline] = painted.digest(), (settings_digest, frame)
        return settings_digest

    # --- seeing ahead
    def analyze_clip(self, clip: dict[float, np.ndarray], settings: Any, *, frame_rate: float = 24.0) -> None:
        """Label a whole clip before its frames are solved, for rest shapes that adapt: changes are then chosen for
        all of it at once, not frame by frame. An empty clip: forget it. Stored frames are forgotten.

        clip: (n, 3) float32 positions by whole frame, ascending. A frame that is solved with other positions is solved
        as live, and noted in `pose_mismatches`; a subframe has the labels of the whole frame that it leads to. Over a
        base cloth or a body no clip is labelled: what it will be is not known. Raises UserError. Cost: per frame and
        1,000 triangles about 1 ms; half a megabyte while it is cut, at most 250; a kilobyte afterwards.
        """
        self.frame_cache.clear()
        self._clip, self.pose_mismatches = {}, set()
        if not clip or not settings.sees_ahead:
            return
        times = np.array([frame / frame_rate for frame in clip], np.float64)
        try:
            labels = kernels.label_clip(self.model, self._native_settings(settings), times,
                                        np.concatenate([self.base.points(positions) for positions in clip.values()]))
        except ValueError as error:
            raise wording.user_error(self.name, error) from error
        self._clip = {frame: (digest_of(b"", self.base.points(positions)), row)
                      for (frame, positions), row in zip(clip.items(), labels)}

    def _clip_labels_at(self, frame: float, positions: np.ndarray) -> np.ndarray | None:
        """The labels of a frame from the clip that was looked at."""
        digest, labels = self._clip.get(float(math.ceil(frame)), (b"", None))
        if labels is None or frame != math.ceil(frame):
            return labels
        if digest != digest_of(b"", positions):
            self.pose_mismatches.add(frame)
            return None
        self.pose_mismatches.discard(frame)  # an object that follows another comes as it was looked at in a second pass
        return labels

    # --- what a system says
    @staticmethod
    def suggested_length(base: BaseMesh, unit_scale: float) -> float:
        """Value of the setting SUGGESTED, in metres, that suits a mesh as it is; unit_scale: metres per object unit."""
        raise NotImplementedError

    @classmethod
    def build(cls, base: BaseMesh, settings: Any, *, unit_scale: float = 1.0,
              most_vertices: int = MOST_VERTICES) -> "Wrinkles":
        """Make the shown mesh and bind it. unit_scale: metres per object unit. most_vertices: folds become no finer
        than they allow. Raises UserError."""
        raise NotImplementedError

    def measure_frame(self, frame: float, positions: np.ndarray, settings: Any) -> Any:
        """What a system can say of a stored frame in numbers; None where there is nothing."""
        return None

    def status(self, result: FrameResult | PreviewFrame) -> list[str]:
        """How the solve of a picture went, in lines for the artist."""
        report, rigid = result.report, self.base.rigid
        if report is None:
            return []  # of a frame that waits
        parts = self._by_hand.notes(self.name)
        parts += [] if rigid is None else [f"Rigid parts that ride on the cloth: {rigid.count}"]
        if not isinstance(report, OnClothReport):
            return [*self._status(report), *parts]
        return [*self._status(report.wrinkles), *report.lines(self.name, self.unit_scale), *parts]

    def _status(self, report: Any) -> list[str]:
        """Of what the system reports."""
        raise NotImplementedError

    def unplayed_message(self, frame: float, start: int) -> str:
        """What to say of a picture that is `unplayed`."""
        return (f"{self.name}: frame {frame:g} was reached by a jump, so its cloth hangs and does not swing: play from "
                f"frame {start}, or bake")

    def worn_surface(self, frame: float) -> Body | None:
        """What another garment lies on in a stored frame, object space; None: on the animated coarse mesh."""
        cloth = self._cloth_at(frame)
        if cloth is None:
            return None
        return Body(cloth.positions, self.base.triangles)

    def curves(self, frame: float, positions: np.ndarray, settings: Any) -> Any:
        """The folds of a solved frame as curves (see curve_rows.py). positions: as they were solved."""
        raise NotImplementedError

    def curve_points(self, settings: Any) -> float:
        """About how many points its curves have when it is folded all over."""
        raise NotImplementedError

    def _may_wait(self, settings: Any, frame_input: FrameInput) -> bool:
        """Whether a preview shows the frame without its state."""
        return False

    def _keeps_off_bodies(self) -> bool:
        """Whether it sees itself to what is worn under the base cloth."""
        return False

    def _where_solved(self, values: np.ndarray) -> np.ndarray:
        """(n,) of the base's vertices -> of the vertices that are solved on."""
        return values

    def _positions_solved(self, positions: np.ndarray) -> np.ndarray:
        """(n, 3) float32 of the deformed base -> of the vertices that are solved on."""
        return positions

    def _reads_world(self, settings: Any) -> bool:
        """Whether the solve depends on where the object stands in the world."""
        return False

    def _reads_time(self, settings: Any) -> bool:
        """Whether the solve depends on the frame rate."""
        return False

    def _native_settings(self, settings: Any) -> Any:
        """As native solves take them."""
        raise NotImplementedError

    def _take_paint(self, paint: dict[str, np.ndarray]) -> Any:
        """The native paint."""
        raise NotImplementedError

    def _pose(self, positions: np.ndarray, frame_input: FrameInput) -> Any:
        """What the system makes of the positions that the wrinkles lie on: made once a frame, for all that follows."""
        raise NotImplementedError

    def _solve(self, settings: Any, pose: Any, before: Any, same_settings: bool,
               frame_input: FrameInput) -> tuple[Any, Any]:
        """(state, report) from the state of the frame before; same_settings: it was solved with these."""
        raise NotImplementedError

    def _show(self, settings: Any, positions: np.ndarray, pose: Any, state: Any,
              frame_input: FrameInput) -> FrameResult:
        """positions: what the pose was made of."""
        raise NotImplementedError

    def _preview(self, settings: Any, positions: np.ndarray, pose: Any, state: Any,
                 frame_input: FrameInput) -> FrameResult | PreviewFrame:
        """Where the viewport can draw frames by itself."""
        raise NotImplementedError
