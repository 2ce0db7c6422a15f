# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on's icon, 256 x 256: a piece of cloth that is gathered at one corner; icon.png beside this file.

    python3 docs/pictures/make_icon.py
"""
from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

SIZE = 256
FINER = 4   # each pixel is the mean of so many in both directions
CLOTH = np.array((1.0, 0.47, 0.30))
DARK = np.array((0.27, 0.03, 0.13))     # what is deep between the folds
LIGHT = np.array((-0.45, -0.62, 0.64))  # towards the light; y points down


def smooth(low: float, high: float, x: np.ndarray) -> np.ndarray:
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def height(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Folds that fan out from the upper left corner, and fade towards the free edges."""
    px, py = x + 1.05, y + 1.05
    way, angle = np.hypot(px, py), np.arctan2(py, px)
    turned = angle + 0.10 * np.sin(1.7 * way + 0.6) - 0.05 * way
    waves = 0.0
    for count, phase, part in ((6.0, 0.75, 1.0), (10.0, 2.1, 0.3)):
        waves = waves + part * (1.0 - 2.0 * np.sqrt(np.sin(count * turned + phase) ** 2 + 0.012))   # round crests
    return 0.15 * waves * way ** 0.55 * (1.0 - 0.35 * smooth(1.4, 2.6, way))


def main() -> None:
    n = SIZE * FINER
    axis = (np.arange(n) + 0.5) / n * 2.0 - 1.0
    x, y = np.meshgrid(axis, axis)
    z = height(x, y)
    step = 2.0 / n
    normal = np.stack([-np.gradient(z, step, axis=1), -np.gradient(z, step, axis=0), np.ones_like(z)], -1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    light = LIGHT / np.linalg.norm(LIGHT)
    facing = np.clip(normal @ light, 0.0, 1.0)
    half_way = light + np.array((0.0, 0.0, 1.0))
    gloss = np.clip(normal @ (half_way / np.linalg.norm(half_way)), 0.0, 1.0) ** 18
    open_sky = smooth(-0.32, 0.30, z)
    lit = (0.26 + 1.0 * facing) * (0.42 + 0.68 * open_sky)
    color = DARK + (CLOTH - DARK) * np.clip(lit, 0.0, 1.0)[..., None] + 0.22 * gloss[..., None]
    # The outline: a square with round corners whose lower and right edges rise and fall with the folds.
    edge = 0.90 + 0.16 * height(x, y)
    inside = (np.abs(x) ** 5 + np.abs(y) ** 5) ** 0.2 / edge
    alpha = 1.0 - smooth(0.995, 1.005, inside)
    rgba = np.concatenate([np.clip(color, 0.0, 1.0) * alpha[..., None], alpha[..., None]], -1)
    rgba = rgba.reshape(SIZE, FINER, SIZE, FINER, 4).mean((1, 3))
    rgba[..., :3] = (rgba[..., :3] / np.maximum(rgba[..., 3:], 1e-6)) ** (1.0 / 1.25)
    Image.fromarray(np.round(255.0 * np.clip(rgba, 0.0, 1.0)).astype(np.uint8)).save(
        Path(__file__).resolve().parent / "icon.png", optimize=True)


if __name__ == "__main__":
    main()
