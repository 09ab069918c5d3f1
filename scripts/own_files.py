"""Files that trainings of this user on this machine wrote, which alone may hold Python objects.

To read Python objects from a file can run any code. So a training notes the SHA-256 of each such
file outside its run folder, in `~/.local/state/activesuit/runs` (or below XDG_STATE_HOME), and a
file that is not noted there is somebody else's, whatever the folder says about itself.
"""

import hashlib
import math
import os
from contextlib import suppress
from pathlib import Path

from ..errors import InputError
from ..files import write_text

MOST = 10_000  # notes; a training makes about twenty


def notes_folder() -> Path:
    """Returns the folder of the notes, one file for each file that was written."""
    state = os.environ.get("XDG_STATE_HOME", "")
    base = Path(state) if os.path.isabs(state) else Path.home() / ".local" / "state"
    return base / "activesuit" / "runs"


def note(path: Path, place: Path) -> bool:
    """Notes that this machine wrote a file; returns False where no note can be kept.

    A note outlives its file, because a copy of the file is of this machine as well; of many notes
    the oldest are removed.
    """
    try:
        folder = notes_folder()
        folder.mkdir(parents=True, exist_ok=True)
        write_text(folder / _digest(path.read_bytes()), f"{place.resolve()}\n")
        _remove_oldest(folder)
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


def _remove_oldest(folder: Path) -> None:
    notes = list(folder.iterdir())
    if len(notes) > MOST:
        for old in sorted(notes, key=_written)[: len(notes) - MOST]:
            old.unlink(missing_ok=True)


def _written(kept: Path) -> float:
    """Returns when a note was written [s]; never for one that another training has removed."""
    try:
        return kept.stat().st_mtime
    except FileNotFoundError:
        return math.inf
