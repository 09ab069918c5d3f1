"""Muscles as a score of `evaluate` and the benchmark, which finds them by their name alone."""

from ..extras import Score
from .analysis import check_wearer
from .figures import activation_figure
from .scores import LEAST_COST, muscle_scores

SCORE = Score(
    check=check_wearer,
    scored=muscle_scores,
    figure=activation_figure,
    least=LEAST_COST,
    units={
        **{"power": "W", "rest": "W", "largest_reserve": "N·m"},
        **dict.fromkeys(("effort", "loaded", "reserve", "saturated", "outside"), "1"),
    },
    text=(
        "*Power* is the metabolic power of all muscles and *effort* their root mean square "
        "activation. Conventions are those of sharing torque among muscles. *Loaded* are three "
        "muscles with the greatest activation in a setting."
    ),
    limits={
        "saturated": (
            0.0,
            "a muscle is fully active in {:.1%} of the time, so that its load may be larger than "
            "these numbers",
        ),
        "outside": (0.0, "{:.1%} of the postures are outside the ranges of MyoArm's joints"),
        "reserve": (0.01, "muscles cannot give {:.1%} of the torque"),
    },
    packages=("myo-sim",),
)
