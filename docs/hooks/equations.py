"""Draws the equations of a page as SVG while the site is built, so that no page needs a network."""

import html
import re
from xml.etree import ElementTree

import ziamath

EQUATION = re.compile(  # as pymdownx.arithmatex leaves them
    r'<(span|div) class="arithmatex">\\([(\[])(.+?)\\[)\]]</\1>', re.DOTALL
)
SIZE = 17  # of the letters, in px beside body text of 16
MARGIN = 0.5  # px, for strokes at the border


def on_page_content(content: str, **_: object) -> str:
    """Replaces every equation of a page by its picture."""
    return EQUATION.sub(_picture, content)


def _picture(match: re.Match[str]) -> str:
    source = html.unescape(match[3]).strip()
    inline = match[2] == "("
    drawing = ziamath.Latex(source, SIZE, color="currentColor", inline=inline, margin=MARGIN)
    svg = drawing.svgxml()
    for side in ("width", "height"):
        svg.set(side, _em(float(svg.get(side, 0))))
    svg.set("style", f"vertical-align: {_em(drawing.getyofst() - MARGIN)}")
    svg.set("role", "img")
    svg.set("aria-label", source)
    text = ElementTree.tostring(svg, encoding="unicode")
    return text if inline else f'<div class="equation">{text}</div>'


def _em(pixels: float) -> str:
    return f"{pixels / 16:.4f}em"
