"""Own files: files that trainings of this user wrote on this machine.

Python objects are read from own files only, since reading them can run any code. So a training
notes the SHA-256 of each such file outside its run folder, in `~/.local/state/activesuit/runs` (or
below XDG_STATE_HOME). A file without a note there counts as a file of somebody else.
"""

import hashlib
import os
from contextlib import suppress
from pathlib import Path

from ..errors import InputError
from ..files import write_text


def notes_folder() -> Path:
    """Returns the folder of the notes, which holds one file for each own file."""
    state = os.environ.get("XDG_STATE_HOME", "")
    base = Path(state) if os.path.isabs(state) else Path.home() / ".local" / "state"
    return base / "activesuit" / "runs"


def note(path: Path, place: Path) -> bool:
    """Notes that this machine wrote a file; returns False where no note can be written.

    A note outlives its file, because a copy of an own file is an own file too.
    """
    try:
        folder = notes_folder()
        folder.mkdir(parents=True, exist_ok=True)
        write_text(folder / _digest(path.read_bytes()), f"{place.resolve()}\n")
    except (OSError, RuntimeError, InputError):  # no home, a full disk, a read-only folder
        return False
    return True


def is_own(content: bytes) -> bool:
    """Returns whether a training of this user on this machine wrote `content`."""
    with suppress(OSError, RuntimeError):
        return (notes_folder() / _digest(content)).is_file()
    return False


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
