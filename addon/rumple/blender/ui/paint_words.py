# SPDX-License-Identifier: GPL-3.0-or-later
"""What the brush says of maps that are painted from 0 on: without paint they do nothing."""
from __future__ import annotations

from ...core.keep_smooth import SMOOTH
from ...core.painted_rigid import RIGID

TIPS = {
    SMOOTH: "Paint where no folds may be, from all of them (0) to none (1), in Weight Paint mode. Again: leave the "
            "mode",
    RIGID: "Paint what is no cloth, as a badge or a belt, from cloth (0) to rigid (1), in Weight Paint mode. Again: "
           "leave the mode",
}
HOW = {
    SMOOTH: "Paint with weight 1 where the cloth stays smooth, with 0 where it folds again",
    RIGID: "Paint with weight 1 what keeps its shape, with 0 what is cloth",
}
