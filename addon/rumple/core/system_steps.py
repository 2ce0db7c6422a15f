# SPDX-License-Identifier: GPL-3.0-or-later
"""What tells a system from another: the steps of a frame that engine.py calls. Never imports bpy."""
from __future__ import annotations

from typing import Any

import numpy as np

from ..native.surface import FramePose
from .base_mesh import BaseMesh
from .frame_input import FrameInput
from .frame_result import COMMON_ATTRIBUTES, Attribute, FrameResult, PreviewFrame
from .shown_mesh import ShownMesh

Pose = FramePose | np.ndarray  # of a frame; or positions, where the library makes poses of them


class SystemSteps(ShownMesh):
    """Settings, poses, states and reports are of a system's own classes: here they are Any."""

    ATTRIBUTES: tuple[Attribute, ...] = COMMON_ATTRIBUTES
    SUGGESTED = "wavelength"  # the setting that suits the mesh when wrinkles are added: see suggested_length()
    HEIGHTS: tuple[str, ...] = ()  # attributes that say how high folds are, scaled with them
    HEIGHT_PAINT = ""  # paint that keeps folds off: where empty, what is solved is made flat
    HAS_CURVES = False  # whether curves() has something to say
    previewed = True  # whether a preview that draws wrinkles by itself draws these as they are

    # --- for others
    @staticmethod
    def suggested_length(base: BaseMesh, unit_scale: float) -> float:
        """Value of the setting SUGGESTED, in metres, that suits a mesh as it is; unit_scale: metres per object unit."""
        raise NotImplementedError

    def measure_frame(self, frame: float, positions: np.ndarray, settings: Any) -> Any:
        """What a system can say of a stored frame in numbers; None where there is nothing."""
        return None

    def curves(self, frame: float, positions: np.ndarray, settings: Any) -> Any:
        """The folds of a solved frame as curves (see curve_rows.py). positions: as they were solved."""
        raise NotImplementedError

    def curve_points(self, settings: Any) -> float:
        """About how many points its curves have when it is folded all over."""
        raise NotImplementedError

    # --- for the engine
    def _status(self, report: Any) -> list[str]:
        """Of what the system reports."""
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

    def _pose(self, positions: np.ndarray, frame_input: FrameInput) -> Pose:
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
