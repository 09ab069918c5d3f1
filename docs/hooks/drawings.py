"""Marks drawings on white, which the style of dark pages inverts; photos stay as they are."""

import re
from pathlib import Path

from PIL import Image

PICTURE = re.compile(r'<img (?=[^>]*src="([^":]+\.png)")')


def on_page_content(content: str, page, config, **_: object) -> str:
    """Gives the attribute `data-drawing` to every PNG whose first pixel is white."""
    folder = Path(config["docs_dir"], page.file.src_uri).parent

    def marked(match: re.Match[str]) -> str:
        with Image.open(folder / match[1]) as picture:
            is_drawing = picture.convert("RGB").getpixel((0, 0)) == (255, 255, 255)
        return "<img data-drawing " if is_drawing else match[0]

    return PICTURE.sub(marked, content)
