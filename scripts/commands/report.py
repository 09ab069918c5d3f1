"""`activesuit report`: makes the page of a run again, from the files of its folder."""

from pathlib import Path
from typing import Annotated

import tyro

from ...errors import InputError
from ..folders import RunFolder
from ..html.subjects import SUBJECTS
from ..html.writing import PAGE, report_page
from ..options import Force
from ..output import say
from ..record import command_of_folder


def report(run: Annotated[Path, tyro.conf.Positional], /, force: Force = False) -> None:
    """Make report.html of a run again, from the files of its folder.

    The page works without a network. Its figures are interactive with the extra `report`.

    Args:
        run: Folder of a run.
    """
    command = command_of_folder(run)
    if command not in SUBJECTS:
        raise InputError(
            f"{str(run)!r} holds a run of {command}, which has no report: give a folder of "
            f"{', '.join(subject.command for subject in SUBJECTS.values())}"
        )
    page = report_page(run)
    folder = RunFolder(run, command, force=force)
    folder.text(PAGE, page)
    say(f"wrote {run}/{PAGE}")
