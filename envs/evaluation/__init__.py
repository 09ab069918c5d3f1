"""Closed-loop evaluation of policies: motions, adapted wearers, references, bounds and scores."""

from .best_known_plan import BOUNDS
from .compare import Evaluation, evaluate
from .rollout import Trace, rollout
from .run import FIRST_SEED
from .scores import REFERENCES, Score, score
from .statistics import Interval
from .suit_validation import SuitValidation, validate

__all__ = [
    "BOUNDS",
    "FIRST_SEED",
    "REFERENCES",
    "Evaluation",
    "Interval",
    "Score",
    "SuitValidation",
    "Trace",
    "evaluate",
    "rollout",
    "score",
    "validate",
]
