# SPDX-License-Identifier: GPL-3.0-or-later
"""Figure 7 of Mueller and Chentanez 2010 from the solver: squeezed_strip.jpg, a strip that its two ends squeeze, with a
stiff base and with a weak one; above the base cloth, below the layers on it.

    RUMPLE_NATIVE=build/release/python docs/pictures/make_squeezed_strip.py
"""
from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parents[1] / "addon")]
from rumple.core.cloth.layers import layer_settings  # noqa: E402
from rumple.core.settings.system_settings import MeshSettings  # noqa: E402
from rumple.native import kernels  # noqa: E402

EDGE, ALONG, BESIDE = 0.03, 20, 6  # metres, and squares of the base
SQUEEZE = 0.85  # length over that at rest
BENT, HALF_WAVES = 0.003, 5  # metres: it is animated in waves that are so low, else a flat strip need not buckle
STIFF = 500.0  # k1, m^2/s^2
LEVELS = 2  # subdivisions that are solved
SETTLE = 200  # frames in which it comes to rest at most
SIZE, FINER, TITLE = (720, 330), 2, 26  # of a tile, pixels; each is the mean of so many in both directions
FONT = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf"
VIEW = np.radians(32.0), np.radians(-20.0)  # from above, from the side
LIGHT = np.array((-0.8, -0.3, 0.52)) / np.linalg.norm((-0.8, -0.3, 0.52))
CLOTH, LINE, BACK = np.array((236.0, 136.0, 104.0)), (60, 40, 34), (250, 250, 250)


def strip() -> tuple[np.ndarray, np.ndarray, kernels.Surface]:
    """(n, 3) at rest, its quads (p, 4), and its surface."""
    across, along = np.meshgrid(np.arange(BESIDE + 1), np.arange(ALONG + 1), indexing="ij")
    rest = EDGE * np.stack([along.ravel(), across.ravel(), np.zeros(along.size)], 1).astype(np.float32)
    row = ALONG + 1
    first = np.array([j * row + i for j in range(BESIDE) for i in range(ALONG)])
    corners = np.stack([first, first + 1, first + 1 + row, first + row], 1).astype(np.int32)
    start = np.arange(0, corners.size + 1, 4, dtype=np.int32)
    triangles = np.concatenate([start[:-1, None] + (0, 1, 2), start[:-1, None] + (0, 2, 3)], 1).reshape(-1, 3)
    return rest, corners, kernels.build_surface(rest, start, corners.ravel(), triangles.astype(np.int32))


def squeezed(rest: np.ndarray) -> np.ndarray:
    """(n, 3) as it is animated."""
    out, long = rest.copy(), EDGE * ALONG
    out[:, 0] = SQUEEZE * (rest[:, 0] - 0.5 * long) + 0.5 * long
    out[:, 2] = BENT * np.sin(HALF_WAVES * np.pi * rest[:, 0] / long)
    return out


def solved(surface: kernels.Surface, rest: np.ndarray, compression: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where the base comes to rest, (n, 3), and the layers on it as they are shown, (d, 3) with their quads (p, 4)."""
    model, animated = kernels.build_base_cloth(surface), squeezed(rest)
    settings = kernels.BaseClothSettings()
    settings.gravity, settings.room, settings.unknown = (0.0, 0.0, 0.0), 0.2, 1.0
    settings.compression, settings.folded = compression, max(settings.folded, compression)
    ends = (rest[:, 0] < 0.9 * EDGE) | (rest[:, 0] > (ALONG - 0.9) * EDGE)
    paint = kernels.BaseClothPaint(model, {"follow": ends.astype(np.float32)})
    base, state = animated, None
    for _ in range(SETTLE):
        before = base
        base, _, _, state, _ = kernels.solve_base_cloth(model, settings, paint, animated, state=state)
        if np.array_equal(base, before):
            break
    layers = kernels.build_wrinkle_layers(surface, LEVELS)
    options = layer_settings(MeshSettings(base_cloth="HANG", layers="CLOTH", slack=1.0, gravity=0.0), layers.count)
    folds = None
    for _ in range(SETTLE):
        folds, _ = kernels.solve_wrinkle_layers(layers, options, None, base, state=folds)
    shown = kernels.show_wrinkle_layers(layers, base, base, folds).positions
    return base, shown, layers.shown.corner_vertex.reshape(-1, 4)


def length(base: np.ndarray) -> float:
    """Of the sides along the strip, over that at rest."""
    return float(np.linalg.norm(np.diff(base.reshape(BESIDE + 1, ALONG + 1, 3), axis=1), axis=2).mean()) / EDGE


def tile(positions: np.ndarray, quads: np.ndarray, title: str, lines: bool) -> Image.Image:
    """Positions (n, 3) with quads (p, 4), lit, the farthest quads first."""
    up, side = VIEW
    middle = positions - 0.5 * EDGE * np.array((ALONG, BESIDE, 0.0))
    x = middle[:, 0] * np.cos(side) - middle[:, 1] * np.sin(side)
    y = middle[:, 0] * np.sin(side) + middle[:, 1] * np.cos(side)
    scale = FINER * SIZE[0] / (EDGE * ALONG)
    flat = np.stack([0.5 * FINER * SIZE[0] + scale * x,
                     0.5 * FINER * (SIZE[1] + TITLE) - scale * (y * np.sin(up) + middle[:, 2] * np.cos(up))], -1)
    image = Image.new("RGB", (FINER * SIZE[0], FINER * SIZE[1]), BACK)
    draw = ImageDraw.Draw(image)
    places = positions[quads]
    normal = np.cross(places[:, 2] - places[:, 0], places[:, 3] - places[:, 1])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    bright = (0.5 + 0.5 * normal @ LIGHT) ** 1.6
    for number in np.argsort(-y[quads].mean(1)):
        color = tuple(int(c) for c in np.clip(bright[number] * CLOTH, 0.0, 255.0))
        draw.polygon([tuple(p) for p in flat[quads[number]].tolist()], fill=color, outline=LINE if lines else color)
    draw.text((FINER * 10, FINER * 6), title, fill=(30, 30, 30), font=ImageFont.truetype(FONT, FINER * 14))
    return image.resize(SIZE, Image.LANCZOS)


def main() -> None:
    rest, quads, surface = strip()
    sheet = Image.new("RGB", (2 * SIZE[0], 2 * SIZE[1]), BACK)
    bases = ("stiff", STIFF), ("weak", kernels.BaseClothSettings().compression)
    for column, (name, compression) in enumerate(bases):
        base, folds, fine = solved(surface, rest, compression)
        title = f"k1 = {compression:.0f} m²/s², {name}: "
        print(f"{title}length {length(base):.3f}, base up to {1e3 * np.abs(base[:, 2]).max():.1f} mm high, with layers "
              f"{1e3 * np.abs(folds[:, 2]).max():.1f} mm")
        title += f"the base, {length(base):.2f} of its length"
        sheet.paste(tile(base, quads, title, True), (column * SIZE[0], 0))
        sheet.paste(tile(folds, fine, "the layers on it", False), (column * SIZE[0], SIZE[1]))
    sheet.save(HERE / "squeezed_strip.jpg", quality=84, optimize=True)


if __name__ == "__main__":
    main()
