"""Lets mkdocstrings find the package, although its folder, the repository, has another name.

It takes the command `activesuit` beside `mkdocs` for the package if it can; without it, it asks
Python.
"""

import sys
from pathlib import Path


def on_startup(**_: object) -> None:
    """Takes the folder of commands out of the places where modules are searched."""
    sys.path[:] = [place for place in sys.path if not Path(place, "activesuit").is_file()]
