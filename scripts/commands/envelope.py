"""`activesuit evaluate envelope`: hand positions that a wearer can hold without getting tired."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from ...assets import JOINTS
from ...envs.envelope import BRANCHES, CONDITIONS, SUSTAINED, Envelope, work_envelope
from ...envs.envelope.envelope import SPACING
from ...envs.envelope.holding import Branch, Condition
from ...envs.model import ArmConfig, suit_of_config
from ...envs.rendering import RenderingUnavailableError
from ..arm_options import USUAL, ArmOptions
from ..conclusion import conclude
from ..options import Force, Gravity, Json, Suit
from ..output import Rows, RunFolder, progress

COLUMNS = ("condition", "branch", "forward_m", "left_m", "up_m", "share_of_strength")


def envelope(
    suit: Suit = None,
    gravity: Gravity = None,
    measured: bool = False,
    spacing: float = SPACING,
    out: Path | None = None,
    force: Force = False,
    arm: ArmOptions = USUAL,
    json: Json = False,
) -> None:
    """Measure the work envelope: unsuited, suited and assisted.

    It is the volume of the hand positions that take at most 15 % of isometric strength at every
    joint, on the loading and on the unloading branch of the suit's steady cycle, with
    --preconditioned or without.

    Args:
        measured: Bend the joints of the suit only within the ranges of its file, for which its
            models were identified; without, these extrapolate.
        spacing: Distance of neighboring hand positions, 0.004 to 0.1 [m].
        out: Folder for result.json, points.csv, report.html and the figures: a new or an empty one,
            or that of an earlier envelope.
    """
    options = arm.config(suit, gravity)
    config = ArmConfig.from_dict(options)
    suit_of_config(config)  # its mistakes are reported before anything is computed
    cases: list[tuple[Condition, Branch]] = [
        (condition, branch)
        for condition in CONDITIONS
        for branch in (BRANCHES[:1] if condition == "unsuited" else BRANCHES)
    ]
    folder = RunFolder(out, "envelope", force=force) if out else None
    found = []
    with progress("envelopes", len(cases)) as bar:
        for i, case in enumerate(cases):
            found.append(
                work_envelope(
                    *(config, *case),
                    measured=measured,
                    spacing=spacing,
                    on_progress=lambda done, i=i: bar.move_to(i + done),
                )
            )
    result = {
        **options,
        "share_of_strength": SUSTAINED,
        "measured": measured,
        "spacing": spacing,
        "envelopes": [_row(one) for one in found],
    }
    remarks = [*_answers(found), *(_write(folder, found) if folder else ())]
    place = f"{config.gravity}, {options['suit']}"
    conclude(
        *(result, {f"Work envelope: {place}": _table(found)}, remarks),
        folder=folder,
        json=json,
        settings={**options, "measured": measured, "spacing": spacing},
    )


def _row(one: Envelope) -> dict[str, Any]:
    return {
        "condition": one.condition,
        "branch": _branch(one),
        "held_litres": one.volume(),
        "standard_error_litres": one.volume_error(),
        "reachable_litres": one.reachable,
        "postures": one.postures,
    }


def _branch(one: Envelope) -> str | None:
    return None if one.condition == "unsuited" else one.branch


def _table(found: Sequence[Envelope]) -> Rows:
    header = ["condition", "branch", "can be kept [l]", "reachable [l]", "postures [million]"]
    rows = [
        [
            one.condition,
            _branch(one) or "-",
            f"{one.volume():.1f} ± {one.volume_error():.1f}",
            f"{one.reachable:.0f}",
            f"{one.postures / 1e6:.2f}",
        ]
        for one in found
    ]
    return header, rows


def _answers(found: Sequence[Envelope]) -> Iterator[str]:
    """Yields a sentence for each branch: the envelope without suit, in it and with motors."""
    litres = {(one.condition, _branch(one)): f"{one.volume():.1f} l" for one in found}
    for branch in BRANCHES:
        yield (
            f"With at most {SUSTAINED:.0%} of strength the hand can stay in "
            f"{litres['unsuited', None]} without a suit; on the {branch} branch in "
            f"{litres['suited', branch]} in the suit, and in {litres['assisted', branch]} with the "
            "exoskeleton."
        )


def _write(folder: RunFolder, found: Sequence[Envelope]) -> Iterator[str]:
    """Writes points and figures; yields why there is no picture, where there is none."""
    from ...envs.envelope.figures import (  # draws, which takes most of a second to import
        envelope_picture,
        sections_figure,
    )

    folder.csv("points.csv", [*COLUMNS, *JOINTS], _points(found))
    folder.figure("sections", sections_figure(found))
    for branch in BRANCHES:
        shown = [
            one for one in found if one.branch == branch and one.condition in ("suited", "assisted")
        ]
        try:
            folder.picture(f"arm-{branch}", envelope_picture(shown))
        except RenderingUnavailableError as error:
            yield f"no picture of the arm: {error}"
            return


def _points(found: Sequence[Envelope]) -> Iterator[list[str]]:
    for one in found:
        kept = one.effort <= SUSTAINED
        columns = (one.position, one.effort[:, None], one.posture)
        for numbers in zip(*(column[kept] for column in columns), strict=True):
            values = (f"{value:.5g}" for column in numbers for value in column)
            yield [one.condition, _branch(one) or "", *values]
