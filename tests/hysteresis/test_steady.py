"""Steady cycles: they repeat, for every model, and their loss factor is what the loop loses."""

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.hysteresis import Asymmetric, BoucWen, PoleError, PrandtlIshlinskii, steady_cycle
from activesuit.hysteresis.around import sprung
from activesuit.hysteresis.protocol import follow
from helpers import assert_refused
from known_models import ELBOW, KNOWN

RANGE = (0.2, 1.4)


@pytest.mark.parametrize("name", KNOWN)
def test_the_cycle_repeats_itself(name):
    model = KNOWN[name]
    cycle = steady_cycle(model, RANGE, start_angle=0.0, start_torque=0.1)
    loop = np.concatenate([cycle.angle, cycle.angle[::-1]])
    path = np.concatenate([[0.0], np.tile(loop, cycle.cycles + 2)])
    torque = model.response(path, 0.1)[1:].reshape(-1, loop.size)
    steady = np.concatenate([cycle.rising, cycle.falling[::-1]])
    assert np.abs(torque[cycle.cycles :] - steady).max() <= 2e-6 * np.ptp(steady)
    assert np.abs(torque[0] - steady).max() > 1e-3 * np.ptp(steady)
    assert cycle.dissipated == pytest.approx(np.trapezoid(steady, loop), rel=1e-12)
    assert 0 < cycle.loss_factor < 1
    state, lost = model.start(0.0, 0.1), []  # the energy of the model tells the same loss
    for _ in range(cycle.cycles + 1):
        state = follow(model, state, RANGE)
        lost.append(model.energy(state).dissipated)
    assert cycle.dissipated == pytest.approx(lost[-1] - lost[-2], rel=1e-3)


def test_a_slider_on_a_spring_has_the_loss_factor_of_its_equation():
    weight, threshold, span = 10.0, 0.1, 1.2
    slider = PrandtlIshlinskii(stiffness=0, thresholds=[threshold], weights=[weight])
    cycle = steady_cycle(slider, RANGE)
    slip, spring = weight * threshold * (span - 2 * threshold), weight * threshold**2 / 2
    assert cycle.dissipated == pytest.approx(2 * slip, rel=1e-4)
    assert cycle.loading_work == pytest.approx(2 * (slip + spring), rel=1e-4)
    assert cycle.cycles == 3  # the third repeats the second, and that not the first


def test_what_is_conservative_has_no_loss_and_adds_none():
    """As P dV/dtheta of a gas: a function of the angle gives all its work back."""
    spring = BoucWen(elastic=3, hysteretic=9, beta=0, gamma=0, n=1)
    alone = steady_cycle(spring, RANGE)
    assert alone.loss_factor == pytest.approx(0, abs=1e-12)
    assert alone.loading_work > 1
    loop = steady_cycle(ELBOW, RANGE)
    bent = steady_cycle(sprung(ELBOW, -2.0, 5.0), RANGE)
    assert bent.dissipated == pytest.approx(loop.dissipated, rel=1e-9)
    offset, stiffness = np.subtract(bent.spring(), loop.spring())
    assert (offset, stiffness) == pytest.approx((-2.0, 5.0))


def test_a_line_is_added_to_any_polynomial():
    short = sprung(Asymmetric(model=ELBOW, polynomial=[1.0]), 0.5, 2.0)
    assert short == Asymmetric(model=ELBOW, polynomial=[1.5, 2.0])
    long = sprung(Asymmetric(model=ELBOW, polynomial=[1.0, 0, 3]), 0.5, 2.0)
    assert long == Asymmetric(model=ELBOW, polynomial=[1.5, 2.0, 3.0])


def test_a_missing_steady_cycle_is_reported(shoulder):
    slow = BoucWen(elastic=0.1, hysteretic=10.0, beta=0.02, gamma=-0.019, n=1)
    with pytest.raises(InputError, match=r"bouc-wen model's torque still changes by .* 128 cycles"):
        steady_cycle(slow, (0.0, 0.5), start_torque=30.0)
    rows = [((1.0, 0.5), "angle_range is"), ((-np.inf, np.inf), "give two finite angles")]
    assert_refused(lambda angles: steady_cycle(ELBOW, angles), rows)
    with pytest.raises(PoleError):
        steady_cycle(shoulder, (0.0, 2.5))
