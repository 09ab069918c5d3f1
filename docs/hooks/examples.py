"""Puts the pages of the examples into the menu, so that a new one needs no line elsewhere."""

from pathlib import Path
from typing import Any

FOLDER = "numbers/examples"


def on_config(config: Any) -> Any:
    """Adds each page under "Examples" in the last group of the menu, by its heading."""
    pages = sorted(Path(config["docs_dir"], FOLDER).glob("*.md"))
    examples = [{_heading(page): f"{FOLDER}/{page.name}"} for page in pages]
    (*_, reference) = config["nav"]
    reference["Reference"].append({"Examples": examples})
    return config


def _heading(page: Path) -> str:
    return page.read_text(encoding="utf-8").partition("\n")[0].removeprefix("# ")
