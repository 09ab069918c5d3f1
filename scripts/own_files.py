"""Files that trainings of this user on this machine wrote, which alone may hold Python objects.

To read Python objects from a file can run any code. So a training notes the SHA-256 of each such
file outside its run folder, in `~/.local/state/activesuit/runs` (or below XDG_STATE_HOME), and a
file that is not noted there is somebody else's, whatever the folder says about itself.
"""

import hashlib
import os
from contextlib import suppress
from pathlib import Path

from ..errors import InputError
from ..files import write_text


def notes_folder() -> Path:
    """Returns the folder of the notes, one file for each file that was written."""
    state = os.environ.get("XDG_STATE_HOME", "")
    base = Path(state) if os.path.isabs(state) else Path.home() / ".local" / "state"
    return base / "activesuit" / "runs"


def digest(path: Path) -> str:
    """Returns the SHA-256 of a file; "" if there is none."""
    if not path.is_file():
        return ""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def note(path: Path, place: Path) -> bool:
    """Notes that this machine wrote a file; returns False where no note can be kept.

    Args:
        path: Path of the file.
        place: Path that it is going to have, for a person who reads the note.
    """
    try:
        folder = notes_folder()
        folder.mkdir(parents=True, exist_ok=True)
        write_text(folder / digest(path), f"{place.resolve()}\n")
    except (OSError, RuntimeError, InputError):  # no home, a full disk, a read-only folder
        return False
    return True


def forget(old: str) -> None:
    """Removes the note of a file that has been replaced, by its digest."""
    with suppress(OSError, RuntimeError):
        if old:
            (notes_folder() / old).unlink(missing_ok=True)


def is_own(content: bytes) -> bool:
    """Returns whether a training of this user on this machine wrote `content`."""
    with suppress(OSError, RuntimeError):
        return (notes_folder() / hashlib.sha256(content).hexdigest()).is_file()
    return False
