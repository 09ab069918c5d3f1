"""`identify`: from measured curves to a judged model, as `activesuit identify` does it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from ..checks import at_least
from ..errors import InputError
from .corrections.corrections import Corrections
from .corrections.cycles import averaged_cycles, cycles_of
from .data.curves import Curve, Curves
from .data.files import Motion
from .data.parts import questions
from .fit_curves import NONE, fit_curves
from .fits.objective import InitialTorque
from .fits.registry import FITS
from .judging.coverage import Coverage, any_motion, coverage, motion_coverage
from .judging.sentences import sentence
from .methods import DEFAULT_MODEL, Method, method_of
from .report import Identification
from .selection import select

AUTO, CERTIFIED = "auto", "certified"
ANY = "any"


def identify(
    curves: Sequence[Curve],
    *,
    model: str | None = None,
    method: str | Method | None = None,
    objective: str | None = None,
    normalize: str | None = None,
    trials: int | None = None,
    corrections: Corrections = NONE,
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    initial_torque: InitialTorque | None = None,
    use: str | None = None,
    intended: Sequence[Motion] = (),
    samples: int = 0,
    seed: int = 0,
    workers: int = -1,
    on_step: Callable[[int, int], None] | None = None,
) -> Identification:
    """Identifies a hysteresis model from measured curves, and judges it.

    First, cycles are averaged if `corrections` say so. Then `fit_curves` fits a model by one
    method, or `select` chooses the kind of model. Ctrl-C keeps the finished trials or models.

    Args:
        curves: The measurements; those with role "predict" are kept out of the fit and tested.
        model: Name of the model, by default "jiles-atherton"; see `fit_curves`.
        method: "auto" (`select`), or a method of `fit_curves`. The default is "auto" for a single
            record with enough reversals, if no other option of the fit is given; otherwise
            "certified".
        objective: Objective of a swarm or optimizer that is given by its name; see `Search`.
        normalize: Torque that divides the errors of this objective; see `Search`.
        trials: Number of independent runs of a method that is given by its name.
        corrections: Corrections of the curves, and terms that are fitted beside the model.
        fixed: Parameters that keep a value, such as {"c": 1.2}; see `fit_curves`.
        bounds: Lower and upper bound of parameters, such as {"k": (1, 50)}; likewise.
        initial_torque: The torque with which each curve begins; see `fit_curves`.
        use: Name of the use of the model; "any" means any motion in the range of the curves.
        intended: The motions of this use.
        samples: Number of further models, which the curves allow too, to draw; 0 leaves the
            uncertainty out.
        seed: Seed of all random numbers.
        workers: The number of threads; -1 uses all cores.
        on_step: Function that gets the numbers of finished and of all trials or models.
    """
    at_least("samples", samples, 0)
    family, notes = Curves(curves), []
    if corrections.average_cycles:
        counts = ", ".join(f"{cycles_of(one)} of {one.name}" for one in family)
        notes.append(sentence("averaged", counts=counts))
        family = averaged_cycles(family)
    used = replace(corrections, average_cycles=False)
    given = {"model": model, "objective": objective, "normalize": normalize, "trials": trials}
    if method is None:
        method = CERTIFIED
        is_open = all(one is None for one in given.values()) and not (fixed or bounds)
        if is_open and _is_divisible(family):
            method = AUTO
            notes.append(sentence("auto"))
    needed = _needed(family, use, intended)
    done = 0

    def step(_: object) -> None:
        nonlocal done
        done += 1
        if on_step:
            on_step(done, total)

    common: dict[str, Any] = {"corrections": used, "initial_torque": initial_torque, "seed": seed}
    common |= {"workers": workers, "needed": needed, "fixed": fixed, "bounds": bounds}
    if method == AUTO:
        for name, value in given.items():
            if value is not None:
                raise InputError(
                    f"{name} is {value!r}: method 'auto' chooses the model once, and minimizes the "
                    "NRMSE over the family; leave one of them out"
                )
        total = len(FITS) * (2 if used.tare == "fit" else 1)  # again without a tare that is open
        result = select(family, intended=intended, on_candidate=step, **common)
    else:
        chosen = method_of(method, trials=trials, objective=objective, normalize=normalize)
        total = chosen.trials
        result = fit_curves(
            family, model=model or DEFAULT_MODEL, method=chosen, on_trial=step, **common
        )
    return Identification(
        result=result,
        seed=seed,
        uncertainty=result.uncertainty(samples=samples, seed=seed) if samples else None,
        corrections=corrections,
        use=use,
        needed=needed,
        notes=tuple(notes),
    )


def _is_divisible(family: Curves) -> bool:
    """Returns whether curves are a single record, of which a part can be left out of a fit."""
    if len(family.fitted()) != 1:
        return False
    try:
        questions(family.fitted())
    except InputError:  # too few reversals
        return False
    return True


def _needed(family: Curves, use: str | None, intended: Sequence[Motion]) -> Coverage | None:
    """Returns the coverage that the intended use needs; None without a use."""
    if use == ANY:
        return any_motion(coverage(family.fitted() or family))
    return motion_coverage(intended) if intended else None
