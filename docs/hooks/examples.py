"""Puts the pages of docs/examples into the menu, so that a new one needs no line elsewhere."""

from pathlib import Path
from typing import Any


def on_config(config: Any) -> Any:
    """Adds each page under "Examples", by its heading."""
    pages = sorted(Path(config["docs_dir"], "examples").glob("*.md"))
    examples = [{_heading(page): f"examples/{page.name}"} for page in pages]
    config["nav"].insert(3, {"Examples": examples})
    return config


def _heading(page: Path) -> str:
    return page.read_text(encoding="utf-8").partition("\n")[0].removeprefix("# ")
