"""Certified, dissipative models of every kind, on which tests ask what every model promises."""

import numpy as np
from activesuit.benchmarks.references import EXAMPLES
from activesuit.hysteresis import (
    TABLE_2,
    Asymmetric,
    Backlash,
    Clipped,
    HysteresisModel,
    Viscoelastic,
)

ELBOW = TABLE_2["elbow-sa-pso"]
IN_A_RANGE = Clipped(model=ELBOW, angle_range=(0.2, 1.2))
BEHIND_PLAY = Backlash(model=Asymmetric(model=IN_A_RANGE, polynomial=[0.2, 0.5, -0.1]), gap=0.02)
RATE = {"damping": 0.3, "relaxation_stiffness": 1.5, "relaxation_time": 0.4}
KNOWN: dict[str, HysteresisModel] = {
    example.name: example.model
    for examples in EXAMPLES.values()
    for example in examples
    if example.model.certificate().certified and example.model.certificate().dissipative
} | {
    "elbow-sa-pso in a range": IN_A_RANGE,
    "asymmetric in a range": BEHIND_PLAY.model,
    "behind play": BEHIND_PLAY,
    "all wrappers": Viscoelastic(model=BEHIND_PLAY, **RATE),
}
WITHOUT_RATE = {name: model for name, model in KNOWN.items() if not isinstance(model, Viscoelastic)}


def ledger(model: HysteresisModel, angle: np.ndarray, torque: float = 0.0) -> np.ndarray:
    """Stored and dissipated energy at each angle [J], taken step by step, shape (2, n)."""
    state = model.start(angle[0], torque)
    energies = [model.energy(state)]
    for one in angle[1:]:
        state, _ = model.step(state, one)
        energies.append(model.energy(state))
    return np.array(energies).T
