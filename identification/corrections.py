"""Corrections of measured curves, and terms that are fitted beside or before a model."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple, get_args

from ..errors import InputError, unknown_name
from ..hysteresis.around import Viscoelastic
from ..hysteresis.protocol import HysteresisModel
from .curves import Curves
from .cycles import averaged_cycles
from .fits.play import Play, play_of
from .fits.rate import Rate, rate_of
from .fits.registry import Fitted
from .remarks import Remark
from .softening import Count, Softening, Softens, found_softening, without_change
from .tare import Tare, checked_tare, found_tare, tared


@dataclass(frozen=True, kw_only=True)
class Corrections:
    """What a fit takes off the curves, or fits beside the model.

    Attributes:
        tare: Offset of the torque sensor [N·m], which is subtracted from all curves; "zero" is the
            mean torque with which they begin, "fit" the one that the certified fit prefers (of
            Jiles-Atherton where the model is selected).
        rate: Rate-dependent part of the torque that is fitted beside the certified model:
            nothing ("none"), a dashpot ("viscous"), or a dashpot and a Maxwell element
            ("relaxing"); the model is then `Viscoelastic`, and the curves need times.
        play: Whether the certified model is fitted behind a gap in the transmission ("fit"), at
            which contact opens at zero torque, or without one ("none"); the model is then
            `Backlash`, if a gap was found.
        softening: Whether a change of the torque over the cycles is estimated with the certified
            fit, as the tare is, and removed from the curves ("fit"), or there is none ("none").
            The model is then that of the end of the measurement.
        average_cycles: Whether all cycles of each record but the first are replaced by their mean,
            see `averaged_cycles`.
    """

    tare: Tare = 0.0
    rate: Rate = "none"
    play: Play = "none"
    softening: Softens = "none"
    average_cycles: bool = False

    def __post_init__(self) -> None:
        checked_tare(self.tare)
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
        """What is fitted beside or before the model, as options of `fit_model`."""
        return {
            name: value
            for name, value in (("rate", self.rate), ("play", self.play))
            if value != "none"
        }


class Corrected(NamedTuple):
    """Curves after the corrections.

    Attributes:
        family: All curves.
        measured: The curves to fit, perhaps thinned.
        tare: Offset that was subtracted [N·m].
        softening: Change over the cycles that was removed; None if none was.
        faults: Remarks on mistakes of the recording.
    """

    family: Curves
    measured: Curves
    tare: float
    softening: Softening | None
    faults: tuple[Remark, ...] = ()


def averaged(curves: Curves, corrections: Corrections) -> Curves:
    """Returns the curves with averaged cycles where that is asked for."""
    return averaged_cycles(curves) if corrections.average_cycles else curves


def corrected(
    family: Curves,
    measured: Curves,
    corrections: Corrections,
    fitted: Callable[[Curves], Fitted],
) -> Corrected:
    """Returns the curves without tare and softening.

    Args:
        family: All curves.
        measured: The curves to fit.
        corrections: What to take off.
        fitted: Certified fit of the model to curves.
    """
    offset = found_tare(measured, corrections.tare, lambda curves: fitted(curves).loss)
    family, measured = tared(family, offset), tared(measured, offset)
    count, change = Count(family), None
    if corrections.softening == "fit":
        change = found_softening(measured, count, fitted)
    if change is not None:
        family, measured = (
            without_change(family, change, count),
            without_change(measured, change, count),
        )
    return Corrected(family, measured, offset, change)


def remarks_on(
    corrections: Corrections, model: HysteresisModel, change: Softening | None
) -> Iterator[Remark]:
    """Yields remarks on terms that were asked for and not found, or only in part.

    Args:
        corrections: What was asked for.
        model: The fitted model.
        change: The change over the cycles that was found.
    """
    if corrections.softening == "fit" and change is None:
        yield Remark("softening", "no change from cycle to cycle was found", ("softening", "none"))
    if change is not None and not change.is_complete:
        yield Remark(
            "softening",
            f"the torque still changes at the end of {change.measured:.2g} cycles, so that the "
            f"steady one, {change.steady:.3g} times the last, is extrapolated: measure more cycles",
        )
    if corrections.play == "fit" and play_of(model) == "none":
        yield Remark("play", "no gap was found", ("play", "none"))
    if isinstance(model, Viscoelastic) and rate_of(model) == "viscous":
        if model.damping == 0:
            yield Remark("rate", "the torque was not found to depend on the rate", ("rate", "none"))
        elif corrections.rate == "relaxing":
            yield Remark("rate", "no relaxation was found beside the dashpot", ("rate", "viscous"))
