"""Marks drawings on white, which the style of dark pages inverts; photos stay as they are."""

import re
from pathlib import Path

import numpy as np
from PIL import Image

PICTURE = re.compile(r'<img (?=[^>]*src="([^":]+\.png)")')


def on_page_content(content: str, page, config, **_: object) -> str:
    """Gives the attribute `data-drawing` to every PNG of which more than half is white."""
    folder = Path(config["docs_dir"], page.file.src_uri).parent

    def marked(match: re.Match[str]) -> str:
        with Image.open(folder / match[1]) as picture:
            white = np.asarray(picture.convert("L")) >= 250
        return "<img data-drawing " if white.mean() > 0.5 else match[0]

    return PICTURE.sub(marked, content)
