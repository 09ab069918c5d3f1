"""The run of a training: its folder, and notes of the files that this machine wrote."""

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
RENEWED = ("steps", "patience")  # options that a resume may change


def read_checkpoint(out: Path, *, trust: bool) -> bytes:
    """Returns the bytes of the checkpoint of a run; refuses a file of another machine."""
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
    """Refuses a folder with a training or a policy, which a new training would replace."""
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

    The card of the policy has all options of the training, and `options` those of the environment.
    The training continues from `checkpoint`; None begins a new training.
    """

    folder: RunFolder
    card: Card
    options: dict[str, Any]
    checkpoint: bytes | None = None

    def begun(self, *others: str) -> Self:
        """Writes the card and a copy of a suit file; returns the run with the new card.

        In a resume the card of the kept policy gets the changed options.
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
        """Writes files that belong together: all are complete before the first replaces a file."""
        with ExitStack() as all_written:
            for name, content in contents.items():
                scratch = all_written.enter_context(self.folder.replacing(name))
                if isinstance(content, bytes):
                    scratch.write_bytes(content)
                else:
                    content(scratch)
                # Noted first, so that a run that is killed between both steps is still ours.
                if not note(scratch, self.folder / name):
                    _tell_unnoted()

    def rounded(self, part: int, parts: str, done: int = 0) -> int:
        """Returns the steps of the training rounded up to whole parts, and reports the rounding."""
        steps = self.card.training["steps"]
        total = done + math.ceil(max(0, steps - done) / part) * part
        if total > max(steps, done):
            messages.print(f"note: {steps} steps are rounded up to {total}, in whole {parts}")
        return total


@cache  # the note is printed once
def _tell_unnoted() -> None:
    messages.print(f"note: {notes_folder()} cannot be written, so that --resume will need --trust")


def asked(training: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the options of a training that a resume may change."""
    return {name: training.get(name) for name in RENEWED}


def finished(folder: Path) -> bool:
    """Returns whether the training in a folder has ended, and its page is written."""
    result, page = folder / RESULT, folder / PAGE
    try:
        found: Any = read_json(result, "result of a training")
        whole = page.stat().st_mtime_ns >= result.stat().st_mtime_ns
    except (InputError, OSError):  # a missing or damaged file is written again
        return False
    whole = whole and isinstance(found, dict) and (folder / CHECKPOINT).is_file()
    return whole and found.get("asked") == asked(read_card(folder).training)
