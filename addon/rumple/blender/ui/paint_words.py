# SPDX-License-Identifier: GPL-3.0-or-later
"""Instructions for the brush. They differ for maps that have no effect at 0, and for all other maps."""
from __future__ import annotations

import bpy

from ...core.paint.hangs_free import FREE
from ...core.paint.keep_smooth import SMOOTH
from ...core.paint.painted_rigid import RIGID
from ..objects.painted_maps import PaintedMap
from ..translation import said

TIPS = {
    FREE: "Paint where the cloth hangs free of the body (1), and where it lies on it (0), in Weight Paint mode. Again: "
          "leave the mode",
    SMOOTH: "Paint where no folds may be, from all of them (0) to none (1), in Weight Paint mode. Again: leave the "
            "mode",
    RIGID: "Paint what is not cloth, such as a badge or a belt, from cloth (0) to rigid (1), in Weight Paint mode. "
           "Again: leave the mode",
}
HOW = {
    FREE: "Paint with weight 1 where the cloth hangs free of the body, with 0 where it lies on it",
    SMOOTH: "Paint with weight 1 where the cloth stays smooth, with 0 where it folds again",
    RIGID: "Paint with weight 1 what keeps its shape, with 0 what is cloth",
}
CTRL = "Hold Ctrl to paint the opposite"


def how(painted: PaintedMap) -> str:
    """The meaning of the weights, in Blender's language."""
    words = said(HOW.get(painted.key) or
                 f"Paint with weight 0 where {said(painted.label)} fades, with 1 where it comes back")
    return f"{words}. {said(CTRL)}" if ctrl_inverts() else words


def ctrl_inverts() -> bool:
    """Whether a Weight Paint stroke with Ctrl paints 1 instead of 0, in the keymap of this Blender and artist."""
    keymap = bpy.context.window_manager.keyconfigs.user.keymaps.get("Weight Paint")
    return any(item.idname == "paint.weight_paint" and item.active and item.ctrl and item.properties.mode == "INVERT"
               for item in (keymap.keymap_items if keymap is not None else ()))
