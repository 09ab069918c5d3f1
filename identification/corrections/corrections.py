"""Corrections of measured curves before a fit, and terms that are fitted beside a model."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, get_args

from ...checks import number
from ...errors import InputError, unknown_name
from ..data.curves import Curves, refuse_driven
from ..data.parts import JUDGED, thinned
from ..fits.registry import Fitted, Play, Rate
from .softening import Count, Softening, Softens, found_softening, without_change
from .tare import Tare, found_tare, tared


@dataclass(frozen=True, kw_only=True)
class Corrections:
    """Corrections of the curves before a fit, and terms that are fitted beside the model.

    Attributes:
        tare: Offset of the torque sensor [N·m], which is subtracted from all curves; "zero" is the
            mean torque at their beginning, "fit" the offset with the least error of the certified
            fit (of Jiles-Atherton if the model is selected).
        rate: Rate-dependent part of the torque that is fitted beside the certified model:
            nothing ("none"), a dashpot ("viscous"), or a dashpot and a Maxwell element
            ("relaxing"); the model is then `Viscoelastic`, and the curves need times.
        play: Whether the certified model is fitted behind a gap in the transmission ("fit"), at
            which contact opens at zero torque, or without one ("none"); the model is then
            `Backlash`, if a gap was found.
        softening: Whether a change of the torque over the cycles is estimated with the certified
            fit and removed from the curves ("fit"), so that the model is that of the end of the
            measurement, or not ("none").
        average_cycles: Whether `identify` replaces all cycles of each record but the first by their
            mean, see `averaged_cycles`.
    """

    tare: Tare = 0.0
    rate: Rate = "none"
    play: Play = "none"
    softening: Softens = "none"
    average_cycles: bool = False

    def __post_init__(self) -> None:
        if not isinstance(self.tare, str):
            number("tare", self.tare, "N·m")
        elif self.tare not in ("zero", "fit"):
            raise InputError(f"tare is {self.tare!r}: give a number in N·m, 'zero' or 'fit'")
        for name, known in (("rate", Rate), ("play", Play), ("softening", Softens)):
            given = getattr(self, name)
            if given not in get_args(known):
                raise unknown_name(name, given, get_args(known))
        if self.softening == "fit" and self.tare == "fit":
            raise InputError(
                "tare and softening are both 'fit': fit the tare first, and give it as a number"
            )
        if self.softening == "fit" and self.average_cycles:
            raise InputError("average_cycles hides what softening looks for: leave one of them out")

    @property
    def beside(self) -> dict[str, Any]:
        """Rate and play that are fitted with the model, as options of `fit_model`."""
        return {
            name: value
            for name, value in (("rate", self.rate), ("play", self.play))
            if value != "none"
        }


class Corrected(NamedTuple):
    """Curves after the corrections."""

    family: Curves  # all curves
    measured: Curves  # those to fit, thinned if they are long
    judged: Curves  # the same, thinned further for the verdict
    tare: float  # offset that was subtracted [N·m]
    softening: Softening | None  # change over the cycles that was removed, if there was one
    read: Curves  # the curves before the corrections


def corrected(
    read: Curves, corrections: Corrections, fitted: Callable[[Curves], Fitted]
) -> Corrected:
    """Returns curves without tare and softening; `fitted` is the certified fit of the model."""
    measured = thinned(read.fitted())
    refuse_driven(measured)
    offset = found_tare(measured, corrections.tare, lambda curves: fitted(curves).loss)
    family, measured = tared(read, offset), tared(measured, offset)
    count, change = Count(family), None
    if corrections.softening == "fit":
        change = found_softening(measured, count, fitted)
    if change is not None:
        family, measured = (without_change(one, change, count) for one in (family, measured))
    judged = thinned(family.fitted(), JUDGED)
    return Corrected(family, measured, judged, offset, change, read)
