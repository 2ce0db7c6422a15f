# SPDX-License-Identifier: GPL-3.0-or-later
"""The chart of docs/which_system.md: which_system.svg. Readable on light and on dark pages.

    docs/pictures/make_which_system.py
"""
from __future__ import annotations

from pathlib import Path
from xml.sax.saxutils import escape

WIDTHS, HIGH, GAP = {"question": 310, "answer": 190}, 64, 34
WIDE = WIDTHS["question"]
LEFT, RIGHT = 24, 24 + WIDE + 90  # of the questions, of the answers
# Question, answer to "yes" and to "no"; a number is another question.
QUESTIONS = (
    ("Is it a face, or bare skin?", 1, 2),
    ("For a game engine, or by single\nbones without a solve?", "Wrinkle Maps", "Wrinkle Mesh,\nBare Skin"),
    ("Must the mesh keep its triangles?\n(folds in the shading alone)", "Wrinkle Field", 3),
    ("Do you want to draw the folds?", "Wrinkle Field,\nrest wrinkles", 4),
    ("No good rest pose,\nor noisy motion?", "Wrinkle Paths", 5),
    ("Single crisp folds that travel?", "Wrinkle Paths", "Wrinkle Mesh"),
)
STYLE = """
svg { --back: #ffffff; --text: #1c1e21; --line: #53585f; --question: #eef1f5; --answer: #d7e6f5; }
@media (prefers-color-scheme: dark) {
    svg { --back: #16181b; --text: #e4e6e9; --line: #a9b0b8; --question: #262b31; --answer: #1f3d59; }
}
text { font: 15px system-ui, "DejaVu Sans", sans-serif; fill: var(--text); }
.said { font-size: 13px; }
.answer { font-weight: 700; }
path { fill: none; stroke: var(--line); stroke-width: 1.6; }
"""


def words(text: str, x: float, y: float, kind: str = "", anchor: str = "middle") -> str:
    """Lines of text around a height."""
    lines = text.split("\n")
    first = y - 9.5 * (len(lines) - 1) + 5
    return "".join(f'<text x="{x}" y="{first + 19 * number}" text-anchor="{anchor}" class="{kind}">'
                   f'{escape(line)}</text>' for number, line in enumerate(lines))


def box(text: str, x: float, y: float, kind: str) -> str:
    corner = 8 if kind == "question" else HIGH / 2
    return (f'<rect x="{x}" y="{y}" width="{WIDTHS[kind]}" height="{HIGH}" rx="{corner}" fill="var(--{kind})" '
            f'stroke="var(--line)"/>' + words(text, x + WIDTHS[kind] / 2, y + HIGH / 2, kind))


def arrow(way: str, said: str, x: float, y: float) -> str:
    return f'<path d="{way}" marker-end="url(#head)"/>' + words(said, x, y, "said", "start")


def chart() -> str:
    """The SVG. Questions stand below one another; answers to the right, "no" of a last one below them."""
    tops = [20.0 + number * (HIGH + GAP) for number in range(len(QUESTIONS))]
    parts = []
    for number, (question, yes, no) in enumerate(QUESTIONS):
        y, middle = tops[number], tops[number] + HIGH / 2
        parts.append(box(f"{number + 1}. {question}", LEFT, y, "question"))
        for said, answer in (("yes", yes), ("no", no)):
            if isinstance(answer, str) and said == "yes":
                parts.append(box(answer, RIGHT, y, "answer"))
                parts.append(arrow(f"M{LEFT + WIDE} {middle}H{RIGHT - 4}", said, LEFT + WIDE + 12, middle - 14))
            elif isinstance(answer, str):   # beside the answer to yes, or below a last question
                if number == len(QUESTIONS) - 1:
                    parts.append(box(answer, RIGHT, y + HIGH + GAP, "answer"))
                    parts.append(arrow(f"M{LEFT + WIDE / 2} {y + HIGH}V{y + 1.5 * HIGH + GAP}H{RIGHT - 4}", said,
                                       LEFT + WIDE / 2 + 8, y + HIGH + 18))
                else:
                    far = RIGHT + WIDTHS["answer"] + 50
                    parts.append(box(answer, far, y, "answer"))
                    parts.append(arrow(f"M{LEFT + WIDE - 40} {y + HIGH}V{y + HIGH + GAP / 2}"
                                       f"H{far + WIDTHS['answer'] / 2}V{y + HIGH + 4}", said,
                                       LEFT + WIDE - 32, y + HIGH + 13))
            elif answer == number + 1:
                parts.append(arrow(f"M{LEFT + WIDE / 2} {y + HIGH}V{tops[answer] - 4}", said, LEFT + WIDE / 2 + 8,
                                   y + HIGH + GAP / 2))
            else:   # past the next one, at its left
                parts.append(arrow(f"M{LEFT + 20} {y + HIGH}V{y + HIGH + 8}H8V{tops[answer] + HIGH / 2}H{LEFT - 4}",
                                   said, LEFT + 26, y + HIGH + GAP / 2))
    wide, high = RIGHT + 2 * WIDTHS["answer"] + 70, tops[-1] + 2 * HIGH + GAP + 20
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {wide} {high:.0f}" width="{wide}" '
            f'height="{high:.0f}" role="img">'
            '<!-- SPDX-License-Identifier: GPL-3.0-or-later; made by make_which_system.py -->'
            f'<title>Which system? Six questions</title><style>{STYLE}</style><defs>'
            '<marker id="head" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="8" markerHeight="8" orient="auto">'
            '<path d="M0 0L8 4L0 8z" style="fill:var(--line);stroke:none"/></marker></defs>'
            f'<rect width="100%" height="100%" fill="var(--back)"/>{"".join(parts)}</svg>\n')


if __name__ == "__main__":
    Path(__file__).with_name("which_system.svg").write_text(chart(), encoding="utf-8")
