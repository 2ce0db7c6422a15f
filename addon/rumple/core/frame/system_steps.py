# SPDX-License-Identifier: GPL-3.0-or-later
"""SystemSteps: the methods that every system implements, and that engine.py calls in a frame. Never imports bpy."""
from __future__ import annotations

from typing import Any

import numpy as np

from ...native.surface import FramePose
from ..mesh.base_mesh import BaseMesh
from ..mesh.frame_result import COMMON_ATTRIBUTES, Attribute, FrameResult, PreviewFrame
from ..mesh.shown_mesh import ShownMesh
from .frame_input import FrameInput

Pose = FramePose | np.ndarray  # the pose of a frame; or positions, from which the library makes a pose


class SystemSteps(ShownMesh):
    """Every system has its own classes of settings, poses, states and reports. Here their type is Any."""

    ATTRIBUTES: tuple[Attribute, ...] = COMMON_ATTRIBUTES
    SUGGESTED = "wavelength"  # the setting that is adapted to the mesh when wrinkles are added: see suggested_length()
    HEIGHTS: tuple[str, ...] = ()  # attributes that contain the height of folds, and are scaled with them
    HEIGHT_PAINT = ""  # paint that reduces folds in the solve; empty: the solved result is flattened instead
    HAS_CURVES = False  # whether it implements curves()
    previewed = True  # whether the GPU preview draws wrinkles with this paint: see is_previewed()

    # --- for other modules
    @staticmethod
    def suggested_length(base: BaseMesh, unit_scale: float) -> float:
        """A value of the setting SUGGESTED, in metres, that suits the mesh. unit_scale: metres per object unit."""
        raise NotImplementedError

    def measure_frame(self, frame: float, positions: np.ndarray, settings: Any) -> Any:
        """The measures of a stored frame; None if the system has none."""
        return None

    def curves(self, frame: float, positions: np.ndarray, settings: Any) -> Any:
        """The folds of a solved frame as curves (see curve_rows.py). positions: as in the solve."""
        raise NotImplementedError

    def curve_points(self, settings: Any) -> float:
        """The approximate number of points of the curves if the whole garment is folded."""
        raise NotImplementedError

    def is_previewed(self, settings: Any, has_body: bool) -> bool:
        """Whether the GPU preview draws these wrinkles correctly. settings: of the system, or Blender's own settings
        with the same names. has_body: whether the garment collides with a body."""
        return self.previewed

    # --- for the engine
    def _crests(self, settings: Any, positions: np.ndarray, pose: Pose, state: Any) -> np.ndarray | None:
        """(n, 3) float32 from the base's vertices to the height of the folds around them, object space, for a garment
        that is worn over this one. None: these folds have no height. Arguments as in _show()."""
        return None

    def _status(self, report: Any) -> list[str]:
        """Lines for the artist about the system's report."""
        raise NotImplementedError

    def _may_wait(self, settings: Any, frame_input: FrameInput) -> bool:
        """Whether the preview can show the frame without its state, so that the solve may wait."""
        return False

    def _proxy_offset(self, positions: np.ndarray) -> np.ndarray | None:
        """PreviewFrame.proxy_offset of a frame that waits. positions: (n, 3) of the animated base."""
        return None

    def _keeps_off_bodies(self) -> bool:
        """Whether the system itself keeps its wrinkles off bodies under the base cloth."""
        return False

    def _where_solved(self, values: np.ndarray) -> np.ndarray:
        """Values (n,) of the base's vertices -> values of the solved vertices."""
        return values

    def _positions_solved(self, positions: np.ndarray) -> np.ndarray:
        """(n, 3) float32 of the deformed base -> positions of the solved vertices."""
        return positions

    def _reads_world(self, settings: Any) -> bool:
        """Whether the solve depends on the object's place in the world."""
        return False

    def _native_settings(self, settings: Any) -> Any:
        """The native settings."""
        raise NotImplementedError

    def _take_paint(self, paint: dict[str, np.ndarray]) -> Any:
        """The native paint."""
        raise NotImplementedError

    def _pose(self, positions: np.ndarray, frame_input: FrameInput) -> Pose:
        """The system's pose of the positions under the wrinkles. It is made once per frame, for all later steps."""
        raise NotImplementedError

    def _solve(self, settings: Any, pose: Any, before: Any, same_settings: bool,
               frame_input: FrameInput) -> tuple[Any, Any]:
        """(state, report). before: the state of the frame before. same_settings: it was solved with the same
        settings."""
        raise NotImplementedError

    def _show(self, settings: Any, positions: np.ndarray, pose: Any, state: Any,
              frame_input: FrameInput) -> FrameResult:
        """The result of a solved frame. positions: from which the pose was made."""
        raise NotImplementedError

    def _preview(self, settings: Any, positions: np.ndarray, pose: Any, state: Any,
                 frame_input: FrameInput) -> FrameResult | PreviewFrame:
        """The frame for a viewport that draws the wrinkles itself, if the system supports this."""
        raise NotImplementedError
