"""The run of a training: its folder, and which of the files are of this machine."""

import math
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Self

from ...assets import load_suit, suit_names
from ...envs.policies.network import CARD, WEIGHTS, Card, card_file, read_card
from ...envs.policies.trained import OWN_SUIT
from ...errors import InputError
from ...json_files import read_json
from ..folders import RunFolder
from ..output import messages
from ..own_files import is_own, note, notes_folder
from ..writer import PAGE, RESULT

CHECKPOINT = "model.zip"
RENEWED = ("steps", "patience")  # what may be new in a resume


def read_checkpoint(out: Path, *, trust: bool) -> bytes:
    """Returns the checkpoint of a run, without looking into it.

    Raises:
        InputError: The file is missing, or was not written on this machine.
    """
    path = out / CHECKPOINT
    if not path.is_file():
        raise InputError(
            f"{str(out)!r} holds no {CHECKPOINT} to resume: train without --resume first"
        )
    content = path.read_bytes()
    if not trust and not is_own(content):
        raise InputError(
            f"{str(path)!r} was not written by you on this machine, and to resume it runs "
            "whatever code it holds: add --trust if you trust whoever made it, or train anew"
        )
    return content


def refuse_trained(out: Path) -> None:
    """Refuses a folder in which a training or a policy would be lost."""
    if (out / CHECKPOINT).exists():
        raise InputError(
            f"{str(out)!r} holds a trained run: add --resume to go on, --force to begin anew, or "
            "choose another --out"
        )
    if (out / WEIGHTS).exists():
        raise InputError(
            f"{str(out)!r} holds a trained policy: add --force to replace it, or choose another "
            "--out"
        )


@dataclass(frozen=True, kw_only=True)
class Run:
    """A training in its folder.

    Attributes:
        folder: Folder of the run.
        card: Card of the policy, whose `training` has all that describes the training.
        options: Options of the environment.
        checkpoint: Checkpoint from which the training continues; None begins anew.
    """

    folder: RunFolder
    card: Card
    options: dict[str, Any]
    checkpoint: bytes | None = None

    def begun(self, *others: str) -> Self:
        """Writes the card, and a copy of the suit file if there is one; returns the run with both.

        In a resume the card of the policy that was kept gets what is new, which holds from now on.
        """
        folder, card, new = self.folder, self.card, self.checkpoint is None
        for name in (RESULT, PAGE, CHECKPOINT, WEIGHTS, *others) if new else ():
            folder.remove(name)
        suit = card.environment["suit"]
        if suit != "none" and suit not in suit_names():
            if Path(suit) != folder / OWN_SUIT:
                with folder.replacing(OWN_SUIT) as scratch:
                    load_suit(suit).save(scratch)
            card = card.model_copy(update={"environment": {**card.environment, "suit": OWN_SUIT}})
        run = replace(self, card=card)
        if new:
            run.write({CARD: card_file(card)})
            return run
        kept = read_card(folder.path)
        changes = {name: one for name, one in card.training.items() if name in RENEWED}
        renewed = kept.model_copy(update={"training": {**kept.training, **changes}})
        if renewed != kept:
            run.write({CARD: card_file(renewed)})
        return run

    def write(self, contents: Mapping[str, bytes | Callable[[Path], object]]) -> None:
        """Writes files that belong together, which take their places at once, and notes them."""
        with ExitStack() as all_written:
            for name, content in contents.items():
                scratch = all_written.enter_context(self.folder.replacing(name))
                if isinstance(content, bytes):
                    scratch.write_bytes(content)
                else:
                    content(scratch)
                # Noted before it is in its place: a run that is killed in between is still ours.
                if not note(scratch, self.folder / name):
                    _tell_unnoted()

    def rounded(self, part: int, parts: str, done: int = 0) -> int:
        """Returns the steps of the training in whole parts, and says so where they are more."""
        steps = self.card.training["steps"]
        total = done + math.ceil(max(0, steps - done) / part) * part
        if total > max(steps, done):
            messages.print(f"note: {steps} steps are rounded up to {total}, in whole {parts}")
        return total


@cache  # once
def _tell_unnoted() -> None:
    messages.print(f"note: {notes_folder()} cannot be written, so that --resume will need --trust")


def asked(training: Mapping[str, Any]) -> dict[str, Any]:
    """Returns what a training is asked for that may be new in a resume."""
    return {name: training.get(name) for name in RENEWED}


def finished(folder: Path) -> bool:
    """Returns whether the training in a folder is at its end, with a page of its result."""
    result, page = folder / RESULT, folder / PAGE
    try:
        found: Any = read_json(result, "result of a training")
        whole = page.stat().st_mtime_ns >= result.stat().st_mtime_ns
    except (InputError, OSError):  # one is missing or damaged, and is written again
        return False
    whole = whole and isinstance(found, dict) and (folder / CHECKPOINT).is_file()
    return whole and found.get("asked") == asked(read_card(folder).training)
