# SPDX-License-Identifier: GPL-3.0-or-later
"""What the charts share: colours for light and for dark pages, text, and the SVG around them."""
from __future__ import annotations

STYLE = """
svg { --back: #ffffff; --text: #1c1e21; --line: #c3c9d0; --k0: #2f6fae; --k1: #c0602a; }
@media (prefers-color-scheme: dark) {
    svg { --back: #16181b; --text: #e4e6e9; --line: #3a4048; --k0: #7db6ea; --k1: #f0a070; }
}
text { font: 13px system-ui, "DejaVu Sans", sans-serif; fill: var(--text); }
polyline { fill: none; stroke-width: 1.6; }
.grid { stroke: var(--line); stroke-width: 1; }
"""


def words(text: str, x: float, y: float, anchor: str = "middle", color: str = "--text") -> str:
    return f'<text x="{x:.0f}" y="{y:.0f}" text-anchor="{anchor}" style="fill:var({color})">{text}</text>'


def svg(title: str, maker: str, wide: int, high: int, parts: list[str]) -> str:
    """maker: the script that makes it. wide, high: pixels."""
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {wide} {high}" width="{wide}" height="{high}" '
            f'role="img"><!-- SPDX-License-Identifier: GPL-3.0-or-later; made by {maker} -->'
            f'<title>{title}</title><style>{STYLE}</style>'
            f'<rect width="100%" height="100%" fill="var(--back)"/>{"".join(parts)}</svg>\n')
