"""Shared data: the published models and a small family of curves."""

import activesuit.scripts  # noqa: F401  (chooses EGL on a machine without a display)
import numpy as np
import pytest
from activesuit.hysteresis import JilesAtherton
from activesuit.identification import Curve
from helpers import TABLE_2, sweep


@pytest.fixture(scope="session")
def table_2() -> dict[str, JilesAtherton]:
    """The four published models."""
    return {
        name: JilesAtherton(Ms=Ms, a=a, alpha=alpha, c=c, k=k, angle_unit="deg")
        for name, (Ms, a, alpha, c, k) in TABLE_2.items()
    }


@pytest.fixture(scope="session")
def elbow(table_2) -> JilesAtherton:
    """The published elbow, which is certified."""
    return table_2["elbow-sa-pso"]


@pytest.fixture(scope="session")
def shoulder(table_2) -> JilesAtherton:
    """The published shoulder, which is not certified."""
    return table_2["shoulder-sa-pso"]


@pytest.fixture(scope="session")
def small_family(elbow) -> list[Curve]:
    """Three fitted and one predicted elbow curve with 1 % noise, coarse enough to be fast."""
    rng = np.random.default_rng(0)
    curves = []
    for turn, role in ((0.87, "fit"), (1.22, "fit"), (1.57, "fit"), (1.40, "predict")):
        angle = sweep(0.52, turn, 0.52, samples=60)
        noise = 0.057 * rng.standard_normal(angle.size)
        curves.append(Curve(angle, elbow.response(angle) + noise, f"{turn:.2f}", role))
    return curves
