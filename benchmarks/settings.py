"""Policies on Earth, Mars, Moon and in microgravity, in two suits, rigid and on cuffs."""

from itertools import product
from typing import Any

from ..envs.domain.levels import NOMINAL
from ..envs.evaluation import BOUNDS, FIRST_SEED, Evaluation, evaluate
from ..scripts.output import progress
from ..tables import Rows

ENV = "ActiveSuit/ArmTracking-v0"
PLACES = ("earth", "mars", "moon", "microgravity")
SUITS = ("mock-suit", "emu-like")
COUPLINGS = ("rigid", "cuffs")
LAWS = ("none", "transparent", "gravity", "feedforward", "compensation", "complement")
MOTIONS = 20


def settings(motions: int = MOTIONS) -> dict[str, Any]:
    """Returns the evaluation of each setting, and a table of each, by their titles.

    Args:
        motions: Number of motions of each policy.
    """
    found: list[dict[str, Any]] = []
    tables: dict[str, Rows] = {}
    policies = (*LAWS, *BOUNDS)
    with progress("settings", len(COUPLINGS) * len(SUITS) * len(PLACES)) as bar:
        for coupling, suit, gravity in product(COUPLINGS, SUITS, PLACES):
            options: dict[str, Any] = {
                "level": NOMINAL,
                "suit": suit,
                "gravity": gravity,
                "coupling": coupling,
            }
            one: Evaluation = evaluate(ENV, policies, motions=motions, threads=0, **options)
            found.append({"env": ENV, **options, **one.to_dict()})
            tables[f"{gravity}, {suit}, {coupling}"] = one.tables()["Scores"]
            bar.advance()
    return {"motions": motions, "seed": FIRST_SEED, "settings": found, "tables": tables}
