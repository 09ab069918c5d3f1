"""Validations of believed suits: tables, sentences, and the matrix of believed and true suits."""

from collections.abc import Iterable, Iterator, Mapping
from itertools import chain
from pathlib import Path

import numpy as np

from ...arrays import Array
from ...assets import Suit
from ...plots import Cells as Colored
from ...plots import Panel, Plot
from ...tables import Rows
from .compare import Evaluation
from .statistics import Interval, interval_text, mean_interval
from .validation import LIMITS, NOT_VALID, TRUE, CurveError, TorqueError, Validation

Cells = Mapping[tuple[str, str], Validation]  # keys are believed and true suit

RULE = (
    "The verdict is by the root mean square of the torque error over the largest true torque, of "
    "the joint where the upper end of the 95 % interval is highest: "
    + ", ".join(f"{name} up to {limit:.0%}" for name, limit in LIMITS.items())
    + f", {NOT_VALID} beyond; and it holds for these angles only."
)
LEAST, MOST = 0.01, 0.5  # NRMSE, between which the colors of the matrix change
LESS = "less than"
NOTHING, SAME = "nothing to judge", "the same suit"


def torque_table(found: Validation) -> Rows:
    """Returns one row per joint, and one of all: the errors of the believed torque."""
    header = ["joint", "RMS\n[N·m]", "largest\n[N·m]", "bias\n[N·m]", "late by\n[ms]"]
    header += ["RMS of the\npeak [%]", "over fit\nnoise"]
    rows = []
    for joint, error in found.torque.joints.items():
        noise = found.torque.noise[joint]
        ratio = f"{error.rms.value / noise:.3g}" if noise else "-"
        rows.append([joint.removesuffix("_flexion"), *_errors(error), ratio])
    if found.torque.together:
        rows.append(["together", *_errors(found.torque.together), ""])
    return header, rows


def _errors(error: TorqueError) -> Iterator[str]:
    percent = Interval(*(100 * end for end in vars(error.nrmse).values()))
    sizes = [(one, "z.2f") for one in (error.rms, error.peak, error.bias)]
    for one, form in (*sizes, (error.lag, "z.0f"), (percent, "z.1f")):
        yield interval_text(one, form, lines=True)


def matrix_table(cells: Cells) -> Rows:
    """Returns one row per believed suit and one column per true one."""
    labels = names_of(chain(*cells))
    believed, plants = _axes(cells)
    rows = [[labels[one], *(_cell(cells[one, other]) for other in plants)] for one in believed]
    return ["believes", *(f"wears\n{labels[other]}" for other in plants)], rows


def matrix_plot(cells: Cells) -> Plot:
    """Returns a heat map of torque errors; each cell tells error, relief and verdict."""
    header, rows = matrix_table(cells)
    believed, plants = _axes(cells)
    found = [[cells[one, other].torque.nrmse for other in plants] for one in believed]
    errors = np.array([[one.value if one else 0.0 for one in row] for row in found])
    share = np.log(np.clip(errors, LEAST, MOST) / LEAST) / np.log(MOST / LEAST)
    names = [row[0] for row in rows], [name.removeprefix("wears\n") for name in header[1:]]
    marks = [Colored(share, [row[1:] for row in rows], *names)]
    panel = Panel(x="true suit", y="believed suit", marks=marks)
    title = f"Torque error by believed and true suit, green {LEAST:.0%}, red {MOST:.0%} and more"
    return Plot(title=title, panels=[panel], height=1.4 + len(rows))


def story(found: Validation, believed: str, suit: Suit) -> Iterator[str]:
    """Yields sentences about one believed suit: verdict with its range, limits, and relief.

    Args:
        found: Validation of that suit.
        believed: Name of the believed suit.
        suit: The believed suit.
    """
    nrmse = found.torque.nrmse
    if nrmse is None:
        yield f"{believed}: {NOTHING}, as the true suit resists no assisted joint"
    elif found.same:
        yield f"{believed}: no verdict, since it is the true suit too; {_covered(found)}"
    else:
        yield (
            f"{believed}: {found.verdict} for {_ranges(found)}; torque error "
            f"{nrmse.value:.1%} ({nrmse.low:.1%} to {nrmse.high:.1%}) of the peak"
        )
    yield from _beyond(found, believed, suit)
    silent = [joint for joint, noise in found.torque.noise.items() if noise is None]
    if silent:
        yield f"{believed} does not tell how noisy its curves were: {', '.join(silent)}"
    if found.relief is None:
        yield "The suit costs less than 1 % of strength here, so that relief has no meaning."
        return
    yield (
        f"relief {interval_text(found.relief)}, "
        f"{interval_text(found.difference)} beside the true model's; "
        f"{interval_text(found.share_of_true)} of it, and "
        f"{interval_text(found.share_of_bound)} of the best known plan's"
    )


def _ranges(found: Validation) -> str:
    """Returns the angles that the motions covered, by joint."""
    covered = found.torque.covered.items()
    return ", ".join(f"{joint} from {low:.2f} to {high:.2f} rad" for joint, (low, high) in covered)


def _covered(found: Validation) -> str:
    return f"the motions cover {_ranges(found)}"


def _beyond(found: Validation, believed: str, suit: Suit) -> Iterator[str]:
    """Yields joints that moved beyond the range in which they were identified."""
    for joint, (low, high) in found.torque.covered.items():
        least, most = suit.joints[joint].range
        if low < least - 0.05 or high > most + 0.05:
            yield f"{believed}, {joint}: identified for {least:.2f} to {most:.2f} rad only"


def answer(
    found: Validation, believed: str, suit: Suit, policy: str, evaluation: Evaluation
) -> Iterator[str]:
    """Yields how well a controller with an identified model works, and what that leaves out.

    Args:
        found: Validation of the suit where its own model and samples are the true ones.
        believed: Name of the suit.
        suit: The suit.
        policy: Policy that believes it.
        evaluation: Motions of that policy beside those of the references.
    """
    joints = {joint: suit.joints[joint] for joint in found.torque.covered}
    nrmse = found.torque.nrmse
    if nrmse is None:
        return
    count = max(len(entry.samples) for entry in joints.values())
    yield _plain_words(policy, evaluation)
    relief = f"a relief of {interval_text(found.relief)}"
    if found.relief is None:
        relief = "no relief that has a meaning, as the suit costs less than 1 % of strength,"
    yield (
        f"{policy} with this model has {relief} and a torque error of {nrmse.value:.1%} "
        f"({nrmse.low:.1%} to {nrmse.high:.1%}) of the peak, where the true suit is drawn among "
        f"the model and {count} others that its curves allow"
    )
    yield f"no verdict, since a suit says nothing against itself; {_covered(found)}"
    yield from _beyond(found, believed, suit)
    left_open = dict.fromkeys(one for entry in joints.values() for one in entry.left_open)
    yield f"not contained: {'; '.join([*left_open, 'other persons, pressures and tasks'])}"


def _plain_words(policy: str, evaluation: Evaluation) -> str:
    """Returns whether the wearer works less than without exoskeleton, and what limits that."""
    (own,) = (score for name, score in evaluation.scores.items() if name.startswith("by "))
    suited, true = (np.array(evaluation.scores[name].effort) for name in ("suited", TRUE))
    effort = np.array(own.effort)
    text = (
        f"with {policy} and this model the wearer works {_compared(effort, suited)} without "
        f"exoskeleton (effort {effort.mean():.1%} against {suited.mean():.1%} of strength), "
        f"and {_compared(effort, true)} with the true model ({true.mean():.1%})"
    )
    if _compared(true, suited) == LESS:
        return text
    text += ": the limit is the controller and its motors here, not your measurement"
    if evaluation.relief("suited") is None:
        unsuited = float(np.mean(evaluation.scores["unsuited"].effort))
        return f"{text}; there is little to give back, as the effort without suit is {unsuited:.1%}"
    return text if policy == "compensation" else f"{text}; try --policy compensation"


def _compared(effort: Array, other: Array) -> str:
    """Returns how the effort of the same motions compares with another, by its 95 % interval."""
    apart = mean_interval(effort - other)
    return LESS if apart.high < 0 else "more than" if apart.low > 0 else "as much as"


def covered_text(cells: Cells) -> str:
    """Returns a sentence that names the angles which the motions of all cells covered."""
    covered: dict[str, tuple[float, float]] = {}
    for found in cells.values():
        for joint, (low, high) in found.torque.covered.items():
            least, most = covered.get(joint, (low, high))
            covered[joint] = min(low, least), max(high, most)
    ranges = (f"{joint} {low:.2f} to {high:.2f} rad" for joint, (low, high) in covered.items())
    return f"The motions covered {', '.join(ranges) or 'no joint that is judged'}."


def curve_table(found: Mapping[str, Mapping[str, list[CurveError]]]) -> Rows:
    """Returns one row per suit, joint and measured curve."""
    header = ["suit", "joint", "curve", "RMS\n[N·m]", "largest\n[N·m]", "bias\n[N·m]"]
    header.append("RMS of the\npeak [%]")
    rows = [
        [
            *(suit, joint, error.curve),
            *(f"{value:.2f}" for value in (error.rms, error.peak, error.bias)),
            f"{100 * error.nrmse:.1f}",
        ]
        for suit, by_joint in found.items()
        for joint, errors in by_joint.items()
        for error in errors
    ]
    return header, rows


def names_of(suits: Iterable[str]) -> dict[str, str]:
    """Returns short names of suits: of a file without its folder, where that is enough."""
    suits = list(dict.fromkeys(suits))
    short = [Path(suit).stem if suit.endswith(".json") else suit for suit in suits]
    return {
        suit: name if short.count(name) == 1 else suit
        for suit, name in zip(suits, short, strict=True)
    }


def _axes(cells: Cells) -> Iterator[list[str]]:
    """Yields the names of the believed suits, then of the true ones."""
    return (list(dict.fromkeys(names)) for names in zip(*cells, strict=True))


def _cell(found: Validation) -> str:
    if found.torque.nrmse is None:
        return NOTHING
    relief = "-" if found.relief is None else f"{found.relief.value:.2f}"
    return f"{found.torque.nrmse.value:.1%}\nrelief {relief}\n{found.verdict or SAME}"
