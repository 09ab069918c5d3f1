"""Combinations of parameters that curves do not determine, in words."""

from collections.abc import Iterator, Sequence

import numpy as np

from ...arrays import Array
from ...hysteresis.jiles_atherton.model import PARAMETERS
from .likelihood import Likelihood

MORE_ERROR = 0.01  # increase of the root mean square that counts as the same fit
LOOSE = np.log(1.1)  # change of a coordinate that is worth a sentence
FARTHEST = np.log(2)  # largest change of a coordinate in a sentence
SMALL = 0.05  # change of a coordinate that a sentence leaves out
ALIKE, ASIDE = 0.75, 0.5  # least ratio of two coordinates that move together; largest of the others
FACTORS = {0: "Ms", 1: "a", 3: "(c-1)", 4: "k"}  # coordinates that are logarithms


def sloppy_directions(
    likelihood: Likelihood, units: Array, unit_names: Sequence[str]
) -> Iterator[str]:
    """Yields a sentence for each combination of parameters that could change nearly unnoticed.

    The combinations are the singular vectors of the Jacobian, the loosest first. How far they go is
    not linearized: on the way the stiffer ones are fitted anew.

    Args:
        likelihood: The likelihood of the model.
        units: The units of the parameters in the sentences, shape (n,).
        unit_names: The units of the parameters that are given as differences; empty for the others.
    """
    names = (*PARAMETERS, "initial torque")
    growth = ((1 + MORE_ERROR) ** 2 - 1) * likelihood.variance * likelihood.freedom
    jacobian = likelihood.jacobian(likelihood.best)
    _, singular, directions = np.linalg.svd(jacobian, full_matrices=False)
    for i in reversed(range(singular.size)):
        largest = directions[i, np.argmax(np.abs(directions[i]))]
        if np.sqrt(growth) * abs(largest) < LOOSE * singular[i]:
            return
        direction = directions[i] * np.sign(largest)
        farthest = FARTHEST / abs(largest)
        end, _ = likelihood.walk(direction, growth, farthest, fixed=directions[i + 1 :])
        before, after = likelihood.row(likelihood.best), likelihood.row(end)
        change = end - likelihood.best
        parts = [
            f"{name} {(new - old) * unit:+.2g} {unit_name}"
            if unit_name
            else f"{name} {new / old - 1:+.0%}"
            for name, old, new, unit, unit_name, moved in zip(
                names, before, after, units, unit_names, change, strict=False
            )
            if abs(moved) >= SMALL
        ]
        if parts:
            raising = "together raise" if len(parts) > 1 else "raises"
            yield (
                f"{', '.join(parts)} {raising} the error by less than {MORE_ERROR:.0%}"
                f"{_known_of_two(change)}"
            )


def _known_of_two(change: Array) -> str:
    """Names the ratio or product that is still known, if mainly two factors change."""
    first, second, *others = np.argsort(-np.abs(change)).tolist()
    alike = abs(change[second]) >= ALIKE * abs(change[first])
    aside = np.abs(change[others]).max() <= ASIDE * abs(change[second])
    if not (alike and aside and first in FACTORS and second in FACTORS):
        return ""
    one, other = FACTORS[min(first, second)], FACTORS[max(first, second)]
    between = "/" if change[first] * change[second] > 0 else " "
    return f": of {one} and {other} hardly more than {one}{between}{other} is known"
