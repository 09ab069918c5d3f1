"""Whether random changes of the best known plan leave the wearer with less effort."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ..arrays import Array
from ..envs.benchmark.suites import BELIEVED, Setting
from ..envs.evaluation import FIRST_SEED, REFERENCES
from ..envs.evaluation.best_known_plan import clairvoyant
from ..envs.evaluation.relief import relief
from ..envs.evaluation.run import run
from ..envs.evaluation.scores import score
from ..envs.evaluation.wearers import ArmLost, Wearers
from ..envs.policies.model_based import Planned
from ..scripts.output import progress
from ..tables import Rows

TASKS = ("ElbowFlexion", "ArmTracking", "ReachPanel", "Hammer", "Ratchet")
LEVELS = ("nominal", "shift")
MOTIONS = 20
LARGEST = 0.2  # of the plan's root mean square, size of a change
SHORTEST, LATEST = 0.05, 0.03  # s, width of a bump and greatest shift of the plan
MARGIN = 0.01  # relief that counts


@dataclass(frozen=True, kw_only=True)
class Attack:
    """What changes of the plan gain in one setting.

    Attributes:
        task: Name of the task.
        suit: Name of the suit that is worn.
        level: Name of the level.
        relief: Mean relief of the plan; None where the suit costs too little.
        last_pass: Share of effort that the last pass took off, the mean over motions.
        changes: Number of random changes, of all motions together.
        gain: Mean over motions of the gain of relief by the best change of that motion, 0 where
            none gains; None as `relief`.
        better: Share of changes that gain more than 0.01 in their motion; None as `relief`.
    """

    task: str
    suit: str
    level: str
    relief: float | None
    last_pass: float
    changes: int
    gain: float | None
    better: float | None

    def to_dict(self) -> dict[str, Any]:
        """Returns the numbers for JSON."""
        return asdict(self)


def attacks(repeats: int) -> list[Attack]:
    """Changes the plan of each motion at random, under wearers who adapt to each change.

    Args:
        repeats: Number of changes of each of the 20 motions in each setting.
    """
    settings = [
        Setting(task, level, suit)
        for task in TASKS
        for level in LEVELS
        for suit in BELIEVED
        if level != "shift" or suit == BELIEVED[0]  # a plan has no belief
    ]
    with progress("changing plans", len(settings) * repeats) as bar:
        return [attack(setting, repeats, bar.advance) for setting in settings]


def attack(setting: Setting, repeats: int, advance: Callable[[], None]) -> Attack:
    """Changes the plan at random in one setting; where arms are lost, nothing is gained."""
    env, options = f"ActiveSuit/{setting.task}-v0", {**setting.options, "threads": 0}
    seeds = range(FIRST_SEED, FIRST_SEED + MOTIONS)
    references = [run(name, name, env, seeds, **options).score.effort for name in REFERENCES]
    wearers, passes = Wearers(env, MOTIONS, **options), []

    def reliefs(plan: Planned) -> Array | None:
        effort = score("", wearers.adapted(lambda: plan, seeds)).effort
        return relief(references[0], references[1], effort)

    try:
        plan = clairvoyant(wearers, seeds, on_pass=passes.append)
        base, gains = reliefs(plan), [np.zeros(MOTIONS)]
        rng, dt = np.random.default_rng(0), wearers.arms.episodes.simulation.control_dt
        for _ in range(repeats if base is not None else 0):
            try:
                found = reliefs(Planned(changed(plan.commands, dt, rng)))
                if base is not None and found is not None:
                    gains.append(found - base)
            except ArmLost:
                gains.append(np.full(MOTIONS, -np.inf))
            advance()
    finally:
        wearers.close()
    last = 1 - passes[-1] / passes[-2] if len(passes) > 1 else np.zeros(MOTIONS)
    known = base is not None
    return Attack(
        task=setting.task,
        suit=setting.true_suit,
        level=setting.level,
        relief=float(base.mean()) if known else None,
        last_pass=float(np.mean(last)),
        changes=repeats * MOTIONS,
        gain=float(np.max(gains, axis=0).mean()) if known else None,
        better=float(np.mean(np.array(gains[1:]) > MARGIN)) if known else None,
    )


def changed(commands: Array, dt: float, rng: np.random.Generator) -> Array:
    """Returns plans that are scaled, shifted in time, and have smooth bumps, each in its own way.

    Args:
        commands: The plans, torque over peak, shape (rows, periods, 2).
        dt: Control period [s].
        rng: Source of the changes; they are small as often as large.
    """
    return np.array([_changed(plan, dt, rng) for plan in commands])


def _changed(plan: Array, dt: float, rng: np.random.Generator) -> Array:
    size = LARGEST * 10 ** rng.uniform(-2, 0)
    shift = rng.uniform(-1, 1) * size / LARGEST * LATEST / dt
    periods = np.arange(len(plan))
    moved = np.array([np.interp(periods - shift, periods, one) for one in plan.T]).T
    width = SHORTEST / dt * 10 ** rng.uniform(0, 1.5)
    bumps = gaussian_filter1d(rng.normal(size=plan.shape), width, axis=0, mode="wrap")
    bumps *= np.sqrt(np.mean(plan**2) / np.mean(bumps**2))
    scale = 1 + size * rng.uniform(-1, 1, 2)
    return np.clip(scale * moved + size * rng.integers(0, 2) * bumps, -1, 1)


def attack_table(found: Sequence[Attack]) -> Rows:
    """Returns the table of the attacks: header and rows."""
    header = ["task", "suit", "level", "relief", "last pass took\n[% of effort]"]
    header += ["best change of\neach motion [relief]", f"changes that gain\nmore than {MARGIN:g}"]
    rows = []
    for one in found:
        gain = "-" if one.gain is None else f"{one.gain:+.3f}"
        better = "-" if one.better is None else f"{one.better:.1%} of {one.changes}"
        relief = "-" if one.relief is None else f"{one.relief:.2f}"
        rows.append(
            [one.task, one.suit, one.level, relief, f"{100 * one.last_pass:.1f}", gain, better]
        )
    return header, rows
