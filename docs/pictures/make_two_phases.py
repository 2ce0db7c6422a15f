# SPDX-License-Identifier: GPL-3.0-or-later
"""Figure 6 of Mueller and Chentanez 2010 from the solver: two_phases.svg. Readable on light and on dark pages.

    RUMPLE_NATIVE=build/release/python docs/pictures/make_two_phases.py

One triangle with equal sides is pulled back to other sizes by a spring of known stiffness. Where it comes to rest, that
pull is the force of its sides: the dots. The lines are what docs/base_cloth.md says.
"""
from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "addon")]
from charts import svg, words  # noqa: E402
from rumple.native import kernels  # noqa: E402

SIDE = 0.2  # metres
FOLLOW = 8000.0  # 1/s^2
FOLDED = (30.0, 100.0)  # k2, m^2/s^2: the add-on's, and a stiffer one
# Sizes that the triangle is pulled to, over its own.
TARGETS = (*np.linspace(0.02, 0.98, 25), *np.linspace(1.1, 1.9, 7))
SHORTEST, LONGEST, MOST = 0.3, 1.08, 20.0  # what is drawn: length over that at rest, force over weight and length
LEFT, TOP, WIDE, HIGH = 78, 46, 560, 340


def made_settings(folded: float) -> kernels.BaseClothSettings:
    """The add-on's springs alone, all of them counted."""
    settings = kernels.BaseClothSettings()
    settings.gravity = (0.0, 0.0, 0.0)
    settings.follow, settings.room, settings.unknown = FOLLOW, 10.0, 1.0
    settings.folded = folded
    settings.start_steps, settings.most_cg_iterations = 60, 200
    return settings


def solved(settings: kernels.BaseClothSettings) -> list[tuple[float, float]]:
    """(length over that at rest, force over weight and length) of every target. A corner has a third of the area A, a
    side the weight 2 A / (3 SIDE^2), so at rest the force is FOLLOW SIDE^2 / 6 (target - length)."""
    rest = SIDE * np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.5, np.sqrt(0.75), 0.0)], np.float32)
    index = np.arange(3, dtype=np.int32)
    surface = kernels.build_surface(rest, np.array([0, 3], np.int32), index, index[None])
    model = kernels.build_base_cloth(surface)
    paint = kernels.BaseClothPaint(model)
    out = []
    for target in TARGETS:
        positions = kernels.solve_base_cloth(model, settings, paint, (target * rest).astype(np.float32))[0]
        length = float(np.mean(np.linalg.norm(positions - np.roll(positions, 1, axis=0), axis=1))) / SIDE
        out.append((length, FOLLOW * SIDE ** 2 / 6.0 * (length - float(target))))
    return out


def law(settings: kernels.BaseClothSettings, length: float) -> float:
    """What pushes apart is above zero."""
    if length > 1.0:
        beyond = max(length - 1.0 - settings.strain_limit, 0.0)
        return -settings.stretch * (length - 1.0 + 9.0 * beyond)
    folded = max(settings.compression_limit - length, 0.0)
    return settings.compression * (1.0 - length) + (settings.folded - settings.compression) * folded


def across(length: float) -> float:
    return LEFT + WIDE * (length - SHORTEST) / (LONGEST - SHORTEST)


def down(force: float) -> float:
    return TOP + HIGH * (MOST - force) / (2.0 * MOST)


def axes(limit: float) -> str:
    """With lines at even numbers and at the compression limit."""
    parts = [f'<path class="grid" d="M{LEFT} {down(force)}h{WIDE}"/>' +
             words(f"{force:.0f}", LEFT - 10, down(force) + 4, "end") for force in np.arange(-MOST, MOST + 1.0, 10.0)]
    parts += [f'<path class="grid" d="M{across(length):.1f} {TOP}v{HIGH}"/>' +
              words(f"{length:.1f}", across(length), TOP + HIGH + 20) for length in np.arange(0.3, 1.05, 0.1)]
    parts.append(f'<path class="grid" stroke-dasharray="4 4" style="stroke:var(--text)" '
                 f'd="M{across(limit):.1f} {TOP}v{HIGH}"/>')
    parts.append(words("c_l", across(limit) + 6, TOP + HIGH - 8, "start"))
    parts.append(words("length / length that the cloth is cut to", LEFT + WIDE / 2, TOP + HIGH + 42))
    parts.append(words("force / (w L), m²/s²: above 0 it pushes apart", LEFT - 56, TOP - 20, "start"))
    return "".join(parts)


def chart() -> str:
    """The SVG; says on the screen how far the dots are off the lines."""
    parts = [axes(made_settings(FOLDED[0]).compression_limit)]
    for number, folded in enumerate(FOLDED):
        settings, color = made_settings(folded), f"--k{number}"
        lengths = np.linspace(SHORTEST, LONGEST, 2000)
        line = [(x, law(settings, x)) for x in lengths.tolist()]
        parts.append(f'<polyline style="stroke:var({color})" points="' + " ".join(
            f"{across(x):.1f},{down(y):.1f}" for x, y in line[::4] if abs(y) <= MOST) + '"/>')
        dots = [(x, y) for x, y in solved(settings) if SHORTEST <= x <= LONGEST and abs(y) <= MOST]
        off = max(abs(y - law(settings, x)) for x, y in dots)
        print(f"k2 = {folded:.0f}: {len(dots)} dots, at most {off:.4f} m^2/s^2 off the law")
        parts += [f'<circle cx="{across(x):.1f}" cy="{down(y):.1f}" r="3.4" style="fill:var({color})"/>'
                  for x, y in dots]
        at = (0.45, 0.59)[number]
        aside, below, anchor = ((10, 26, "end"), (12, -8, "start"))[number]
        parts.append(words(f"k2 = {folded:.0f}", across(at) + aside, down(law(settings, at)) + below, anchor, color))
    settings = made_settings(FOLDED[0])
    parts.append(words(f"k1 = {settings.compression:.0f}", across(0.86), down(law(settings, 0.86)) - 12))
    parts.append(words(f"stretch {settings.stretch:.0f}", across(1.0) - 8, down(-14.0), "end"))
    return svg("Force of a spring by its length, from the solver and as written", "make_two_phases.py",
               LEFT + WIDE + 30, TOP + HIGH + 58, parts)


if __name__ == "__main__":
    Path(__file__).with_name("two_phases.svg").write_text(chart(), encoding="utf-8")
