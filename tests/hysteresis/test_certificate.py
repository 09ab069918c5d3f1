"""What the certificate promises, attacked by random motions."""

import numpy as np
import pytest
from activesuit.hysteresis import JilesAtherton
from activesuit.hysteresis import _jiles_atherton_kernels as kernels
from hypothesis import given, settings
from hypothesis import strategies as st


def test_margins_of_table_2(table_2):
    steepness = {name: 1 - model.certificate().margin for name, model in table_2.items()}
    assert steepness["shoulder-mpso"] == pytest.approx(1.36, abs=0.005)
    assert steepness["shoulder-sa-pso"] == pytest.approx(1.24, abs=0.005)
    assert steepness["elbow-mpso"] == pytest.approx(0.86, abs=0.005)
    assert table_2["elbow-sa-pso"].certificate().certified
    assert not table_2["shoulder-sa-pso"].certificate().certified


@st.composite
def certified_models(draw):
    steepness = draw(st.floats(-1.9, 0.99))
    Ms = 10 ** draw(st.floats(0, 2))
    a = 10 ** draw(st.floats(-1, 3.7))
    c = 1 + 10 ** draw(st.floats(-2, 1))
    k = 10 ** draw(st.floats(0, 3.3))
    alpha = steepness * 3 * a / ((2 * c - 1) * Ms)
    return JilesAtherton(Ms=Ms, a=a, alpha=alpha, c=c, k=k, angle_unit="deg")


angles = st.lists(st.floats(-400, 400), min_size=2, max_size=40)


@settings(max_examples=400, deadline=None)
@given(model=certified_models(), degrees=angles, lag=st.floats(-1, 1), field=st.floats(-3, 3))
def test_no_motion_meets_the_pole_and_the_bounds_hold(model, degrees, lag, field):
    certificate = model.certificate()
    assert certificate.certified
    assert certificate.dissipative
    # A start anywhere inside the memory bound, up to its edge.
    Ms, a, alpha, *_ = model.kernel_arguments
    torque = Ms * kernels.langevin(field)[0] + lag * certificate.memory_bound
    state = model.start(field * a - alpha * torque, torque)
    for angle in np.radians(degrees):
        state, torque = model.step(state, angle)
        assert abs(torque) <= certificate.torque_bound * (1 + 1e-9)
        lag = abs(torque - model.anhysteretic(state))
        assert lag <= certificate.memory_bound * (1 + 1e-6) + 1e-9 * model.Ms


@settings(max_examples=200, deadline=None)
@given(model=certified_models(), degrees=angles)
def test_dissipated_energy_never_decreases(model, degrees):
    arguments = model.kernel_arguments
    angle = torque = lost = 0.0
    dissipated = 0.0
    scale = model.Ms * model.kernel_arguments[4] * model.c
    for target in np.radians(degrees):
        torque, loss = kernels.advance(angle, torque, target, *arguments)
        angle, lost = target, lost + loss
        recoverable = kernels.recoverable_energy(angle, torque, *arguments)
        assert recoverable >= 0
        assert lost - recoverable >= dissipated - 1e-7 * scale
        dissipated = max(dissipated, lost - recoverable)


def test_work_is_elastic_energy_plus_loss(elbow):
    Ms, a, alpha, c, k, limit = elbow.kernel_arguments

    def elastic(angle, torque):
        x = (angle + alpha * torque) / a
        return Ms * a * np.log(np.sinh(x) / x) - alpha * torque**2 / 2

    angle = np.concatenate([np.linspace(0.3, 1.5, 4000), np.linspace(1.5, 0.6, 4000)])
    torque = elbow.response(angle)
    work = np.trapezoid(torque, angle)
    loss = sum(
        kernels.advance(angle[i - 1], torque[i - 1], angle[i], Ms, a, alpha, c, k, limit)[1]
        for i in range(1, angle.size)
    )
    change = elastic(angle[-1], torque[-1]) - elastic(angle[0], torque[0])
    assert work == pytest.approx(change + loss, rel=1e-6)


def test_recoverable_energy_is_what_turning_back_returns(elbow):
    arguments = elbow.kernel_arguments
    angle, torque = 1.3, elbow.response([0.5, 1.3])[-1]
    claimed = kernels.recoverable_energy(angle, torque, *arguments)
    returned, best = 0.0, 0.0
    for target in np.linspace(1.3, 0.3, 4001)[1:]:
        torque, loss = kernels.advance(angle, torque, target, *arguments)
        angle, returned = target, returned - loss
        best = max(best, returned)
    assert claimed == pytest.approx(best, rel=1e-5)
    assert claimed > 0
