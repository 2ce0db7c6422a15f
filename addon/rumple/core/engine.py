# SPDX-License-Identifier: GPL-3.0-or-later
"""What the systems share: pictures, and frames that do not depend on how one got there. Never imports bpy."""
from __future__ import annotations

import functools
import time
from dataclasses import replace
from typing import Any, Callable

import numpy as np

from ..native import kernels
from ..native.surface import Model
from . import wording
from .base_mesh import BaseMesh
from .body import Body, OwnSkin
from .by_hand import ByHand
from .clip_labels import ClipLabels
from .cloth import ClothFrame, suggested_follow
from .digests import digest_of_paint, digest_of_settings
from .fold_guides import GUIDES
from .frame_cache import CachedFrame, FrameCache, chain_of
from .frame_input import FrameInput, FrameRequest
from .frame_result import FrameResult, PreviewFrame
from .on_cloth import PAINTED, OnCloth, OnClothReport, Stage, State, cloth_of, system_state
from .outer_side import OuterSide
from .settings import SystemSettings
from .shown_mesh import ShownMesh, ViewportMesh
from .surroundings import Surroundings
from .system_steps import Pose, SystemSteps

MOST_VERTICES = 4_000_000
UserError = wording.UserError  # for those who see the engine only
TABLES = (PROFILE := "profile", GUIDES)  # paint that is not a value for each vertex


class Wrinkles(SystemSteps):
    """A shown mesh bound to a base, and the frames that were solved for it.

    A system adds build() and the steps of SystemSteps.
    """

    in_viewport: ViewportMesh | None = None  # what viewports show, where that has fewer vertices
    outer: OuterSide | None = None  # where the thickness of a garment is modelled, and its outer side alone is solved
    _last_pose: tuple[np.ndarray | None, Pose | None] = (None, None)  # positions, and what was made of them

    def __init__(self, base: BaseMesh, source: BaseMesh, surface: kernels.Surface, model: Model,
                 warnings: list[str], unit_scale: float) -> None:
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
        self._last_settings: dict[tuple[int, float], tuple[bytes, float]] = {}  # by timeline: their digest, the frame
        self._clip_labels = ClipLabels()
        self._paint: Any = None
        self._by_hand = ByHand()
        self._stage: Stage | None = None
        self.settings_are_keyed = True  # where not, other settings at another frame are a change as well
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
        in_viewport, positions = in_viewport and self.in_viewport is not None, self.base.points(positions)
        if self.base.rigid is not None and settings.base_cloth != "OFF":
            body = self.base.rigid.skin.joined(positions, body)
        request = FrameRequest(frame, positions, settings, paint, start, world_from_object, frame_rate, following,
                               for_preview, body, surroundings, in_viewport)
        try:
            return self._solve_frame(request)
        except ValueError as error:
            self.frame_cache.refuse(frame)
            raise wording.user_error(self.name, error) from error

    def _solve_frame(self, request: FrameRequest) -> FrameResult | PreviewFrame:
        settings_digest = self._take_inputs(request)
        frame_input = self._frame_input(request)
        began = time.perf_counter()
        cached, replayed, pose = self._find_or_solve(request, settings_digest, frame_input)
        if request.for_preview and cached.waits:
            return PreviewFrame(replayed=replayed)
        solved = time.perf_counter()
        make = functools.partial(self._result_of, request, cached, pose,
                                 replace(frame_input, cloth=cloth_of(cached.state)))
        is_kept = replayed and not request.for_preview
        result = self.frame_cache.picture(cached, request.in_viewport, make) if is_kept else make()
        spent = dict(solve=1e3 * (solved - began), show=1e3 * (time.perf_counter() - solved))
        return replace(result, report=cached.report, replayed=replayed, milliseconds=spent,
                       unplayed=request.settings.swings and not cached.final)

    def _frame_input(self, request: FrameRequest) -> FrameInput:
        """What of it counts."""
        settings, rate = request.settings, request.frame_rate
        matrix, labels, following = None, None, None
        if request.world_from_object is not None and (self._reads_world(settings) or settings.base_cloth != "OFF"):
            matrix = np.ascontiguousarray(request.world_from_object, np.float32)
        if request.body is None:
            labels = self._clip_labels.at(request.frame, request.positions)
            following = request.following if settings.sees_ahead and labels is None else None
        coming = (0.0, None) if following is None else (following[0] / rate, self.base.points(following[1]))
        return FrameInput(request.frame, request.frame / rate, matrix, request.positions, labels, *coming, request.body,
                          surroundings=request.surroundings if settings.swings else Surroundings(),
                          in_viewport=request.in_viewport)

    def _find_or_solve(self, request: FrameRequest, settings_digest: bytes,
                       frame_input: FrameInput) -> tuple[CachedFrame, bool, Pose | None]:
        """The entry of a frame, which is solved and stored where it was not; whether it was; and the pose that it was
        solved in now."""
        settings, frame = request.settings, request.frame
        input_digest = frame_input.digest(settings_digest, settings.swings)
        begins = settings.stateless or frame <= request.start
        before = None if begins else self.frame_cache.before(frame)
        final = begins or (before is not None and before.final)
        cached = self.frame_cache.find(frame, input_digest, final, before)
        if cached is not None:
            return cached, True, None
        chain = chain_of(input_digest, before)
        same_settings, pose = before is not None and before.settings_digest == settings_digest, None
        if request.for_preview and before is not None and self._may_wait(settings, frame_input):
            kept = replace(frame_input, animated=frame_input.animated.copy())
            cached = CachedFrame.waiting(before, input_digest, settings_digest, final, lambda state: self._solve_over(
                settings, state, same_settings, kept)[:2], chain)
        else:
            state, report, pose = self._solve_over(settings, before.state if before is not None else None,
                                                   same_settings, frame_input)
            cached = CachedFrame.of(state, input_digest, settings_digest, final, report, chain)
        self.frame_cache.put(frame, cached)
        return cached, False, pose

    def _result_of(self, request: FrameRequest, cached: CachedFrame, pose: Pose | None,
                   frame_input: FrameInput) -> FrameResult | PreviewFrame:
        """What is shown of a solved frame. pose: that it was solved in now, or None."""
        show: Callable[..., Any] = self._preview if request.for_preview else self._show
        over = self._solved_over(frame_input.frame, frame_input.animated)
        if pose is None:
            pose = self._pose(over, frame_input)
        self._last_pose = (over.copy(), pose)
        result: FrameResult | PreviewFrame = show(request.settings, over, pose, system_state(cached.state), frame_input)
        mesh = frame_input.in_viewport and self.in_viewport or self
        if isinstance(result, FrameResult):
            self._by_hand.add_to(result, mesh, frame_input.animated, over, self.HEIGHTS)
        self._add_rigid_parts(result, frame_input.animated, over, mesh)
        return result

    def state_of(self, frame: float) -> State | None:
        """The stored state of a frame, or None. With a base cloth: an OnCloth."""
        cached = self.frame_cache.get(frame)
        return cached.state if cached is not None else None

    def wrinkles_of(self, frame: float) -> Any:
        """The system's own state of a stored frame, or None."""
        return system_state(self.state_of(frame))

    def solved_over(self, frame: float, positions: np.ndarray) -> np.ndarray:
        """Object space, of `base`, whose first vertices are the coarse ones: what the wrinkles of a stored frame lie
        on, the base cloth. Without one: the animated positions, which are given."""
        return self._solved_over(frame, self.base.points(positions))

    def _solved_over(self, frame: float, positions: np.ndarray) -> np.ndarray:
        """The same. positions: of `base`."""
        cloth = self._cloth_at(frame)
        return positions if cloth is None else cloth.positions

    def _cloth_at(self, frame: float) -> ClothFrame | None:
        """The base cloth of a stored frame. A frame that waits has none."""
        cached = self.frame_cache.get(frame)
        return None if cached is None or cached.waits else cloth_of(cached.state)

    # --- the base cloth
    def _solve_over(self, settings: SystemSettings, before: State | None, same_settings: bool,
                    frame_input: FrameInput) -> tuple[State, Any, Pose]:
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
        has_body, is_free = self._has_other_body(frame_input.body), settings.base_cloth != "OFF"
        return OnCloth(cloth, state), OnClothReport(cloth.report, report, has_body, is_free), pose

    def _has_other_body(self, body: Body | None) -> bool:
        """Whether there is a body beside the skin in the same mesh."""
        rigid = self.base.rigid
        return body is not None and (rigid is None or not rigid.skin.is_all_of(body))

    def _pose_at(self, frame: float, positions: np.ndarray) -> Any:
        """The pose of a stored frame, for who looks at it: the one that was made last, if it is of these positions;
        else what the library makes one of."""
        over = self.solved_over(frame, positions)
        made_of, pose = self._last_pose
        return pose if made_of is not None and np.array_equal(made_of, over) else over

    def base_cloth(self) -> Stage:
        """Built once."""
        if self._stage is None:
            self._stage = Stage(self.solved_surface, self.base.diagonal(), self.unit_scale,
                                lambda up: self._where_solved(suggested_follow(self._cloth_surface, up)),
                                0.0 if self.outer is None else self.outer.thickness)
        return self._stage

    def suggested_follow(self, settings: Any) -> np.ndarray:
        """(n,) float32: how firmly the base cloth follows the animation while nothing is painted: what paint starts
        from."""
        return suggested_follow(self._cloth_surface, settings.up)[:self.coarse_count]

    @property
    def _cloth_surface(self) -> kernels.Surface:
        """Of the base, without an inner side, which has no borders."""
        return self.surface if self.outer is None else self.outer.surface

    def _result(self, shown: Any, frame_input: FrameInput, **own: np.ndarray) -> FrameResult:
        """From a native picture of a frame: what was solved over the base cloth is embedded in the animated mesh."""
        if frame_input.cloth is not None:
            kernels.embed_frame(self.surface, self.shown, frame_input.animated, shown)
        return FrameResult.of(shown, **own)

    def _add_rigid_parts(self, result: FrameResult | PreviewFrame, animated: np.ndarray, over: np.ndarray,
                         mesh: ShownMesh) -> None:
        """over: what the wrinkles lie on. mesh: that is shown."""
        attached = mesh.attached_parts
        if attached is None:
            return
        if isinstance(result, FrameResult):
            attached.add_to(result, animated, len(mesh.corner_vertex), self.ATTRIBUTES)
        elif result.proxy_offset is not None:
            inside = attached.parts.vertex < len(result.proxy_offset)  # not what healing has made
            result.proxy_offset[attached.parts.vertex[inside]] = attached.displacements(animated, over)[inside]

    # --- what changes
    def _take_inputs(self, request: FrameRequest) -> bytes:
        """A digest of the settings. Stored frames are forgotten when the artist changed them, or the paint."""
        timed = request.settings.swings or self._reads_time(request.settings)
        timeline = (request.start, request.frame_rate if timed else 0.0)
        settings_digest = digest_of_settings(request.settings, *timeline)
        repainted = self._take_painted(request.paint)
        self._forget_changed(timeline, request.frame, settings_digest, repainted)
        return settings_digest

    def _take_painted(self, paint: dict[str, np.ndarray]) -> bool:
        """Whether it is another paint than before."""
        digest = digest_of_paint(paint)
        repainted = digest != self.paint_digest
        if self._paint is not None and not repainted:
            return False
        solved = {name: values if name in TABLES else self._where_solved(self.base.points(values))
                  for name, values in paint.items()}
        self._cloth_paint = {name: solved.pop(name) for name in PAINTED if name in solved}
        self._by_hand = ByHand.taken(paint, self.base, self.HEIGHT_PAINT, solved, self._where_solved)
        self._paint = self._take_paint(solved)
        self.paint_digest = digest
        return repainted

    def _forget_changed(self, timeline: tuple[int, float], frame: float, settings_digest: bytes,
                        repainted: bool) -> None:
        """Settings that are animated differ from frame to frame: each has its own, and stays stored.

        timeline: first frame and frame rate. Of another, frames are other ones: each scene has its own.
        """
        self.frame_cache.follow(timeline)
        last, at = self._last_settings.get(timeline, (settings_digest, frame))
        if repainted or (settings_digest != last and (frame == at or not self.settings_are_keyed)):
            self.frame_cache.clear()
            self._last_settings.clear()
        self._last_settings[timeline] = settings_digest, frame

    def follow_inputs_of(self, former: "Wrinkles") -> None:
        """What changes from now on is what differs from those inputs."""
        self.paint_digest, self._last_settings = former.paint_digest, dict(former._last_settings)

    # --- seeing ahead
    def analyze_clip(self, clip: dict[float, np.ndarray], settings: Any, *, frame_rate: float = 24.0) -> None:
        """Label a whole clip before its frames are solved, for rest shapes that adapt: changes are then chosen for
        all of it at once, not frame by frame. An empty clip: forget it. Stored frames are forgotten.

        clip: (n, 3) float32 positions by whole frame, ascending. A frame that is solved with other positions is solved
        as live, and noted in `pose_mismatches`; a subframe has the labels of the whole frame that it leads to. Over a
        base cloth or a body no clip is labelled: what it will be is not known. Raises UserError. Cost: per frame and
        1,000 triangles about 1 ms; half a megabyte while it is cut, for at most 500 frames of those, or 60 of any mesh;
        a kilobyte afterwards.
        """
        self.frame_cache.clear()
        self._clip_labels = ClipLabels()
        if not clip or not settings.sees_ahead:
            return
        clip = {frame: self.base.points(positions) for frame, positions in clip.items()}
        try:
            self._clip_labels = ClipLabels.of(self.model, self._native_settings(settings), clip, frame_rate)
        except ValueError as error:
            raise wording.user_error(self.name, error) from error

    @property
    def pose_mismatches(self) -> set[float]:
        """Frames that came with another pose than the clip that was looked at."""
        return self._clip_labels.pose_mismatches

    # --- what others ask
    @classmethod
    def build(cls, base: BaseMesh, settings: Any, *, unit_scale: float = 1.0,
              most_vertices: int = MOST_VERTICES) -> "Wrinkles":
        """Make the shown mesh and bind it. unit_scale: metres per object unit. most_vertices: folds become no finer
        than they allow. Raises UserError."""
        raise NotImplementedError

    def status(self, result: FrameResult | PreviewFrame) -> list[str]:
        """How the solve of a picture went, in lines for the artist."""
        report, rigid = result.report, self.base.rigid
        if report is None:
            return []  # of a frame that waits
        parts = self._by_hand.notes(self.name)
        parts += [] if rigid is None else rigid.lines()
        if not isinstance(report, OnClothReport):
            return [*self._status(report), *parts]
        return [*self._status(report.wrinkles), *report.lines(self.name, self.unit_scale), *parts]

    def unplayed_message(self, frame: float, start: int) -> str:
        """What to say of a picture that is `unplayed`."""
        return (f"{self.name}: frame {frame:g} was reached by a jump, so its cloth hangs and does not swing: play from "
                f"frame {start}, or bake")

    def worn_surface(self, frame: float, positions: np.ndarray) -> Body | None:
        """What another garment lies on in a stored frame, object space; None: on the animated coarse mesh. positions:
        of that, in the frame."""
        worn = self._worn_cloth(frame)
        if worn is None or self.base.rigid is None:
            return worn
        return self._worn_skin.joined(self.base.points(positions), worn)

    def _worn_cloth(self, frame: float) -> Body | None:
        """The same without skin in the same mesh."""
        cloth = self._cloth_at(frame)
        if cloth is None or len(cloth.positions) != len(self.base.positions):  # solved on a coarser mesh
            return None
        return Body(cloth.positions, self.base.triangles)

    @functools.cached_property
    def _worn_skin(self) -> OwnSkin:
        assert self.base.rigid is not None
        return OwnSkin(self.base.rigid.skin.triangles)
