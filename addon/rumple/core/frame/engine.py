# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkles: the evaluator of one object, common to all systems. It solves, stores and replays frames, so that the
result of a frame does not depend on the order of frames. Never imports bpy."""
from __future__ import annotations

import contextlib
import functools
import time
from dataclasses import replace
from typing import Any, Callable, Iterator

import numpy as np

from ...native import kernels
from ...native.surface import Model
from ..base.digests import digest_of_paint, digest_of_settings
from ..base.wording import user_error
from ..cloth.base_cloth import ClothFrame, ClothInput, suggested_follow
from ..cloth.carried_cloth import ClothMesh
from ..cloth.draped_cloth import PAINTED, DrapedCloth
from ..cloth.on_cloth import OnCloth, OnClothReport, State, cloth_of, system_state
from ..cloth.surroundings import Surroundings
from ..mesh.base_mesh import BaseMesh
from ..mesh.body import Body, OwnSkin
from ..mesh.frame_result import FrameResult, PreviewFrame
from ..mesh.outer_side import OuterSide
from ..mesh.shown_mesh import ShownMesh, ViewportMesh
from ..paint.by_hand import ByHand
from ..paint.fold_guides import GUIDES
from ..settings.system_settings import SystemSettings
from .clip_labels import ClipLabels
from .found_frame import FoundFrame
from .frame_cache import CachedFrame, FrameCache, chain_of
from .frame_input import FrameInput, FrameRequest
from .system_steps import Pose, SystemSteps

MOST_VERTICES = 4_000_000
TABLES = (PROFILE := "profile", GUIDES)  # paint that is a table, not a value for each vertex


class Wrinkles(SystemSteps):
    """A shown mesh that is bound to a base mesh, and the frames that were solved for it.

    A system adds build() and the steps of SystemSteps.
    """

    in_viewport: ViewportMesh | None = None  # the mesh of viewports, if it has fewer vertices
    outer: OuterSide | None = None  # set if the garment has modelled thickness: then only its outer side is solved
    # finds `cloth_mesh`; None: the system does not need one
    find_cloth_mesh: Callable[[], ClothMesh | None] | None = None
    _last_pose: tuple[np.ndarray | None, Pose | None] = (None, None)  # positions, and the pose made from them

    def __init__(self, base: BaseMesh, source: BaseMesh, surface: kernels.Surface, model: Model,
                 warnings: list[str], unit_scale: float) -> None:
        """base, source: healed. surface: native, of the base."""
        self.name, self.base, self.source = base.name, base, source
        self.surface = surface
        self.solved_surface = surface  # the surface that the base cloth and the system use
        self.model = model
        self.shown = model.shown
        self.warnings = warnings
        self.unit_scale = unit_scale  # metres per object unit
        self.frame_cache = FrameCache()
        self.paint_digest = b""  # of the paint of the last solve
        # by timeline: digest of the settings, frame
        self._last_settings: dict[tuple[int, float], tuple[bytes, float]] = {}
        self._clip_labels = ClipLabels()
        self._paint: Any = None
        self._by_hand = ByHand()
        self._draped_cloths: dict[bool, DrapedCloth] = {}
        self.settings_are_keyed = True  # if False, different settings at another frame are a change by the artist too
        self._cloth_paint: dict[str, np.ndarray] = {}

    # --- frames
    def find_frame(self, request: FrameRequest) -> FoundFrame:
        """Look a frame up: whether it is stored for the same input, or which state it is solved from. Raises
        UserError."""
        began = time.perf_counter()
        positions, body = self.base.points(request.positions), request.body
        if self.base.rigid is not None and request.settings.base_cloth != "OFF":
            body = self.base.rigid.skin.joined(positions, body)
        request = replace(request, positions=positions, body=body,
                          in_viewport=request.in_viewport and self.in_viewport is not None)
        with self._refusing(request.frame):
            return self._find(request, self._take_inputs(request), self._frame_input(request), began)

    def finish_frame(self, found: FoundFrame) -> FrameResult | PreviewFrame:
        """The result of the frame that was looked up last: replayed if it is stored, otherwise solved and stored. Any
        thread may call it. Raises UserError."""
        with self._refusing(found.request.frame):
            return self._finish(found)

    @contextlib.contextmanager
    def _refusing(self, frame: float) -> Iterator[None]:
        try:
            yield
        except ValueError as error:
            self.frame_cache.refuse(frame)
            raise user_error(self.name, error) from error

    def _finish(self, found: FoundFrame) -> FrameResult | PreviewFrame:
        request, began = found.request, time.perf_counter()
        cached, pose = (found.cached, None) if found.cached is not None else self._solve_and_store(found)
        replayed = found.cached is not None
        if request.for_preview and cached.waits:
            return PreviewFrame(proxy_offset=self._proxy_offset(found.frame_input.animated), replayed=replayed)
        solved = time.perf_counter()
        make = functools.partial(self._result_of, request, cached, pose,
                                 replace(found.frame_input, cloth=cloth_of(cached.state)))
        is_kept = replayed and not request.for_preview
        result = self.frame_cache.picture(cached, request.in_viewport, make) if is_kept else make()
        spent = dict(solve=1e3 * (found.seconds + solved - began), show=1e3 * (time.perf_counter() - solved))
        return replace(result, report=cached.report, replayed=replayed, milliseconds=spent,
                       unplayed=request.settings.swings and (found.before is None and not cached.final
                                                             or request.frame <= request.start - 1))

    def _frame_input(self, request: FrameRequest) -> FrameInput:
        """The parts of the request that the result depends on."""
        settings, rate = request.settings, request.frame_rate
        matrix = labels = None
        if request.world_from_object is not None and (self._reads_world(settings) or settings.base_cloth != "OFF"):
            matrix = np.ascontiguousarray(request.world_from_object, np.float32)
        if request.body is None:
            labels = self._clip_labels.at(request.frame, request.positions)
        return FrameInput(request.frame, request.frame / rate, matrix, request.positions, labels, request.body,
                          surroundings=request.surroundings if settings.swings else Surroundings(),
                          in_viewport=request.in_viewport)

    def _find(self, request: FrameRequest, settings_digest: bytes, frame_input: FrameInput, began: float) -> FoundFrame:
        """began: when looking it up began, by time.perf_counter()."""
        settings, frame = request.settings, request.frame
        input_digest = frame_input.digest(settings_digest, settings.swings)
        begins = settings.stateless or frame <= request.start
        before = None if begins else self.frame_cache.before(frame)
        final = begins or (before is not None and before.final)
        cached = self.frame_cache.find(frame, input_digest, final, before)
        may_wait = (cached is None and request.for_preview and before is not None
                    and self._may_wait(settings, frame_input))
        return FoundFrame(request, frame_input, settings_digest, input_digest, before, final, may_wait, cached,
                          time.perf_counter() - began)

    def _solve_and_store(self, found: FoundFrame) -> tuple[CachedFrame, Pose | None]:
        """The new cache entry of a frame, and the pose if it was solved and does not wait."""
        settings, before, frame_input = found.request.settings, found.before, found.frame_input
        chain = chain_of(found.input_digest, before)
        same_settings = before is not None and before.settings_digest == found.settings_digest
        pose = None
        if before is not None and found.may_wait:
            kept = replace(frame_input, animated=frame_input.animated.copy())
            cached = CachedFrame.waiting(before, found.input_digest, found.settings_digest, found.final, lambda state:
                                         self._solve_over(settings, state, same_settings, kept)[:2], chain)
        else:
            began = time.perf_counter()
            state, report, pose = self._solve_over(settings, before.state if before is not None else None,
                                                   same_settings, frame_input)
            cached = CachedFrame.of(state, found.input_digest, found.settings_digest, found.final, report, chain,
                                    time.perf_counter() - began)
        self.frame_cache.put(found.request.frame, cached)
        return cached, pose

    def _result_of(self, request: FrameRequest, cached: CachedFrame, pose: Pose | None,
                   frame_input: FrameInput) -> FrameResult | PreviewFrame:
        """The result of a solved frame. pose: the pose if the frame was solved now, or None."""
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
        """The positions under the wrinkles of a stored frame, object space: the base cloth, or without it the animated
        positions, which are given. They belong to `base`, whose first vertices are the coarse ones."""
        return self._solved_over(frame, self.base.points(positions))

    def _solved_over(self, frame: float, positions: np.ndarray) -> np.ndarray:
        """Like solved_over(). positions: of `base`."""
        cloth = self._cloth_at(frame)
        return positions if cloth is None else cloth.positions

    def _cloth_at(self, frame: float) -> ClothFrame | None:
        """The base cloth of a stored frame. A waiting frame has none."""
        cached = self.frame_cache.get(frame)
        return None if cached is None or cached.waits else cloth_of(cached.state)

    # --- the base cloth
    def _solve_over(self, settings: SystemSettings, before: State | None, same_settings: bool,
                    frame_input: FrameInput) -> tuple[State, Any, Pose]:
        """Solve the base cloth, or move the animated mesh out of a body. Then solve the system over it. Arguments and
        results as in _solve(), and the pose."""
        positions, own = self._positions_solved(frame_input.animated), system_state(before)
        if settings.base_cloth == "OFF" and frame_input.body is None:
            pose = self._pose(positions, frame_input)
            return *self._solve(settings, pose, own, same_settings, frame_input), pose
        cloth = cloth_of(before)
        if cloth is not None and not same_settings:
            cloth = cloth.activated()
        given = ClothInput(positions, frame_input.world_from_object, frame_input.body, frame_input.seconds,
                           frame_input.surroundings)
        draped = self.draped_cloth(coarse=settings.base_cloth != "OFF" and self.cloth_mesh is not None)
        cloth = draped.solve(settings, self._cloth_paint, given, cloth, covers=not self._keeps_off_bodies())
        pose = self._pose(cloth.positions, frame_input)
        state, report = self._solve(settings, pose, own, same_settings, replace(frame_input, cloth=cloth))
        has_body, is_free = self._has_other_body(frame_input.body), settings.base_cloth != "OFF"
        return OnCloth(cloth, state), OnClothReport(cloth.report, report, has_body, is_free), pose

    def _has_other_body(self, body: Body | None) -> bool:
        """Whether there is a body other than the skin in the garment's own mesh."""
        rigid = self.base.rigid
        return body is not None and (rigid is None or not rigid.skin.is_all_of(body))

    def _pose_at(self, frame: float, positions: np.ndarray) -> Any:
        """The pose of a stored frame, for functions that display it: the last pose if it has these positions, otherwise
        the positions, from which the library makes a pose."""
        over = self.solved_over(frame, positions)
        made_of, pose = self._last_pose
        return pose if made_of is not None and np.array_equal(made_of, over) else over

    def draped_cloth(self, coarse: bool = False) -> DrapedCloth:
        """What solves the base cloth. It is built once. coarse: on the coarse mesh of `cloth_mesh`, which is there."""
        if coarse not in self._draped_cloths:
            mesh, outer = self.cloth_mesh if coarse else None, self._outer_side(coarse)
            self._draped_cloths[coarse] = DrapedCloth(
                self.solved_surface, self.base.diagonal(), self.unit_scale,
                lambda up: self._where_solved(suggested_follow(self._cloth_surface(outer), up)),
                0.0 if outer is None else outer.thickness, self.base.figure, None if mesh is None else mesh.coarse)
        return self._draped_cloths[coarse]

    @functools.cached_property
    def cloth_mesh(self) -> ClothMesh | None:
        """The mesh that the base cloth of a dense or thick garment is solved on under a Wrinkle Field or Paths. None:
        that of all vertices."""
        return None if self.find_cloth_mesh is None else self.find_cloth_mesh()

    def _outer_side(self, has_base_cloth: bool) -> OuterSide | None:
        """The side of a garment with modelled thickness that its cloth is solved on; None: the whole garment."""
        mesh = self.cloth_mesh if has_base_cloth else None
        return self.outer if mesh is None else mesh.outer

    def suggested_follow(self, settings: Any) -> np.ndarray:
        """(n,) float32: how firmly the base cloth follows the animation while nothing is painted. New paint starts with
        these values."""
        outer = self._outer_side(settings.base_cloth != "OFF")
        return suggested_follow(self._cloth_surface(outer), settings.up)[:self.coarse_count]

    def _cloth_surface(self, outer: OuterSide | None) -> kernels.Surface:
        """The surface of the base without an inner side, because a mesh with an inner side has no borders."""
        return self.surface if outer is None else outer.surface

    def _result(self, shown: Any, frame_input: FrameInput, **own: np.ndarray) -> FrameResult:
        """The result, from the native output of a frame. Positions over the base cloth are embedded in the animated
        mesh."""
        if frame_input.cloth is not None:
            kernels.embed_frame(shown, frame_input.animated)
        return FrameResult.of(shown, **own)

    def _add_rigid_parts(self, result: FrameResult | PreviewFrame, animated: np.ndarray, over: np.ndarray,
                         mesh: ShownMesh) -> None:
        """Add the rigid parts to a result. over: the positions under the wrinkles. mesh: the shown mesh."""
        attached = mesh.attached_parts
        if attached is None:
            return
        if isinstance(result, FrameResult):
            attached.add_to(result, animated, len(mesh.corner_vertex), self.ATTRIBUTES)
        elif result.proxy_offset is not None:
            inside = attached.parts.vertex < len(result.proxy_offset)  # not vertices that healing added
            result.proxy_offset[attached.parts.vertex[inside]] = attached.displacements(animated, over)[inside]

    # --- what changes
    def _take_inputs(self, request: FrameRequest) -> bytes:
        """A digest of the settings. If the artist changed them or the paint, stored frames are removed."""
        timeline = (request.start, request.frame_rate if request.settings.reads_time else 0.0)
        settings_digest = digest_of_settings(request.settings, *timeline)
        repainted = self._take_painted(request.paint)
        self._forget_changed(timeline, request.frame, settings_digest, repainted)
        return settings_digest

    def _take_painted(self, paint: dict[str, np.ndarray]) -> bool:
        """Whether the paint differs from the last one."""
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
        """Remove stored frames if the artist changed something. Animated settings also differ from frame to frame, but
        then the stored frames stay.

        timeline: first frame and frame rate. Each timeline has frames of its own, because scenes may differ in them.
        """
        self.frame_cache.follow(timeline)
        last, at = self._last_settings.get(timeline, (settings_digest, frame))
        if repainted or (settings_digest != last and (frame == at or not self.settings_are_keyed)):
            self.frame_cache.clear()
            self._last_settings.clear()
        self._last_settings[timeline] = settings_digest, frame

    def follow_inputs_of(self, former: "Wrinkles") -> None:
        """Take over the last inputs of other wrinkles. From now on, only differences from these are changes."""
        self.paint_digest, self._last_settings = former.paint_digest, dict(former._last_settings)

    # --- seeing ahead
    def analyze_clip(self, clip: dict[float, np.ndarray], settings: Any, *, frame_rate: float = 24.0) -> None:
        """Label a whole clip before its frames are solved, for adaptive rest shapes. Their changes are then chosen for
        the whole clip at once, not frame by frame. Stored frames are removed. An empty clip removes the labels.

        clip: (n, 3) float32 positions by whole frame, ascending. If a frame is later solved with other positions, its
        labels are not used, and it is added to `pose_mismatches`. A subframe has the labels of the next whole frame.
        Over a base cloth or a body no clip is labelled, because the positions of the cloth are not known in advance.
        Raises UserError. Cost for each frame and 1,000 triangles: about 1 ms; half a megabyte during the cut, for at
        most 500 such frames, or 60 of any mesh; a kilobyte afterwards.
        """
        self.frame_cache.clear()
        self._clip_labels = ClipLabels()
        if not clip or not settings.sees_ahead:
            return
        clip = {frame: self.base.points(positions) for frame, positions in clip.items()}
        try:
            self._clip_labels = ClipLabels.of(self.model, self._native_settings(settings), clip, frame_rate)
        except ValueError as error:
            raise user_error(self.name, error) from error

    @property
    def pose_mismatches(self) -> set[float]:
        """Frames whose pose differs from the pose in the analysed clip."""
        return self._clip_labels.pose_mismatches

    # --- what others ask
    @classmethod
    def build(cls, base: BaseMesh, settings: Any, *, unit_scale: float = 1.0,
              most_vertices: int = MOST_VERTICES) -> "Wrinkles":
        """Make the shown mesh and bind it. unit_scale: metres per object unit. most_vertices: upper limit of the shown
        mesh, which also limits how fine folds can be. Raises UserError."""
        raise NotImplementedError

    def status(self, result: FrameResult | PreviewFrame) -> list[str]:
        """A report on the solve of a frame, in lines for the artist."""
        report, rigid = result.report, self.base.rigid
        if report is None:
            return []  # a waiting frame
        outer = self._outer_side(isinstance(report, OnClothReport) and report.is_free)
        parts = self._by_hand.notes(self.name) + ([] if rigid is None else rigid.lines())
        parts += [] if outer is None else [outer.line(self.unit_scale)]
        if not isinstance(report, OnClothReport):
            return [*self._status(report), *parts]
        return [*self._status(report.wrinkles), *report.lines(self.name, self.unit_scale), *parts]

    def unplayed_message(self, frame: float, start: int) -> str:
        """The message for a result that is `unplayed`."""
        if frame < start:  # not the shutter of the first frame
            return (f"{self.name}: frame {frame:g} is before frame {start}, with which the clip begins, so its cloth "
                    "hangs and does not swing: set Start of the scene to an earlier frame")
        return (f"{self.name}: frame {frame:g} was reached by a jump, so its cloth hangs and does not swing: play from "
                f"frame {start}, or bake")

    def worn_surface(self, frame: float, positions: np.ndarray, settings: SystemSettings) -> Body | None:
        """The surface that another garment lies on in a stored frame, object space. None: the animated coarse mesh.
        positions: of the animated coarse mesh in this frame. settings: of this frame."""
        worn = self._worn_cloth(frame, positions, settings)
        if worn is None or self.base.rigid is None:
            return worn
        return self._worn_skin.joined(self.base.points(positions), worn)

    def _worn_cloth(self, frame: float, positions: np.ndarray, settings: SystemSettings) -> Body | None:
        """Like worn_surface(), without skin in the garment's own mesh."""
        state, over = self.wrinkles_of(frame), self.solved_over(frame, positions)  # a frame that waits is solved
        if state is None or len(over) != len(self.base.positions):  # solved on a coarser mesh
            return None
        crests = self._crests(settings, over, self._pose_at(frame, positions), state)
        if crests is None:
            return None if self._cloth_at(frame) is None else Body(over, self.base.triangles)
        return Body(over + crests, self.base.triangles)

    @functools.cached_property
    def _worn_skin(self) -> OwnSkin:
        assert self.base.rigid is not None
        return OwnSkin(self.base.rigid.skin.triangles)
