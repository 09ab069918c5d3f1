"""Models beside a dashpot and a Maxwell element: the torque, its passivity, and the engine."""

import mujoco
import numpy as np
import pytest
from activesuit.hysteresis import Backlash, Viscoelastic
from activesuit.hysteresis.around import viscoelastic_kernels as kernels
from activesuit.hysteresis.engine import replace_model
from helpers import attached, is_safe
from known_models import KNOWN, RATE

HINGE = """<mujoco><compiler angle="radian"/><option gravity="0 0 0"/><worldbody><body>
  <joint name="j" ref="0.52"/><geom size=".1"/></body></worldbody></mujoco>"""


@pytest.fixture
def joint(elbow):
    return Viscoelastic(model=elbow, **RATE)


def moved(samples, duration=3.0):
    time = np.linspace(0.0, duration, samples)
    return time, 0.52 + 0.5 * (1 - np.cos(2 * time))


def test_without_time_it_is_the_slow_model(joint, elbow):
    _, angle = moved(200)
    np.testing.assert_array_equal(joint.response(angle), elbow.response(angle))
    slow = np.linspace(0, 1e7, angle.size)
    np.testing.assert_allclose(joint.response(angle, time=slow), elbow.response(angle), atol=1e-6)


def test_a_dashpot_resists_the_rate(elbow):
    time, angle = moved(3001)
    dashpot = Viscoelastic(model=elbow, damping=0.3)
    more = dashpot.response(angle, time=time) - elbow.response(angle)
    np.testing.assert_allclose(more, 0.3 * np.sin(2 * time), atol=1e-3)


def test_a_maxwell_element_fades_after_a_ramp(elbow):
    time = np.concatenate([np.linspace(0, 0.5, 501), np.linspace(0.5, 2.0, 1501)[1:]])
    angle = 0.52 + np.minimum(time, 0.5)
    element = Viscoelastic(model=elbow, relaxation_stiffness=1.5, relaxation_time=0.4)
    more = element.response(angle, time=time) - elbow.response(angle)
    top = 1.5 * 0.4 * (1 - np.exp(-0.5 / 0.4))
    assert more[500] == pytest.approx(top, rel=1e-9)
    np.testing.assert_allclose(more[500:], top * np.exp((0.5 - time[500:]) / 0.4), rtol=1e-9)


def test_ten_thousand_random_closed_cycles_dissipate(elbow):
    rng = np.random.default_rng(0)
    for _ in range(10_000):
        damping, stiffness, relaxation = np.exp(rng.uniform(-5, 3, 3))
        element = {"relaxation_stiffness": stiffness, "relaxation_time": relaxation}
        joint = Viscoelastic(model=elbow, damping=damping, **element)
        turns = rng.uniform(0.52, 1.57, 6)
        rate, state = joint.numbers, joint.start(turns[0])
        kernels.relax(rate, turns[0], 1.0)
        losses = [0.0]
        for turn in (*turns[1:], turns[0]):
            kernels.relax(rate, turn, np.exp(rng.uniform(-8, 3)))
            state, _ = joint.step(state, turn)
            losses.append(rate[kernels.LOSS])
        kernels.relax(rate, turns[0], 1e6 * relaxation)  # its spring is as at the start again
        assert rate[kernels.TORQUE] == pytest.approx(0.0, abs=1e-12)
        assert np.diff(losses).min() >= 0
        assert rate[kernels.LOSS] > 0
        assert joint.energy(state).dissipated > 0


def test_the_work_is_stored_and_dissipated(joint):
    time, angle = moved(20_001)
    rate, torque = joint.numbers, np.empty_like(angle)
    kernels.follow(rate, time, angle, torque)
    work = np.trapezoid(joint.rate_torque(angle, time), angle)
    stored = rate[kernels.TORQUE] ** 2 / (2 * joint.relaxation_stiffness)
    assert work == pytest.approx(stored + rate[kernels.LOSS], rel=1e-5)


def hinged(joint):
    return attached(HINGE, "j", joint, start_angle=0.52)


def simulated(joint, step):
    """Returns time, angle, resistance and dissipated energy of a hinge that is pushed around."""
    data, found = hinged(joint), []
    data.model.opt.timestep = step
    for i in range(round(2.0 / step)):
        data.qfrc_applied[0] = 8 * np.sin(3 * i * step)
        mujoco.mj_forward(data.model, data)
        found.append([data.time, data.qpos[0], -data.qfrc_passive[0], *data.sensordata[[0, 2]]])
        mujoco.mj_step(data.model, data)
    return np.array(found).T


def test_the_engine_converges_to_response_in_the_first_order(joint):
    errors = []
    for step in (2e-3, 1e-3, 5e-4):
        time, angle, torque, sensed, lost = simulated(joint, step)
        assert np.diff(lost).min() >= 0
        np.testing.assert_array_equal(torque, -sensed)
        errors.append(np.abs(torque - joint.response(angle, time=time))[3:].max())
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert np.all((orders > 0.8) & (orders < 1.2)), (errors, orders)


def test_a_dashpot_around_play_resists_in_the_gap(elbow):
    data = hinged(Viscoelastic(model=Backlash(model=elbow, gap=0.05), damping=0.2))
    data.qpos[0], data.qvel[0] = 0.52, 0.5
    mujoco.mj_forward(data.model, data)
    assert -data.qfrc_passive[0] == pytest.approx(0.1)


def test_a_replaced_model_begins_relaxed(joint):
    data = hinged(joint)
    data.qvel[0] = 1.0
    mujoco.mj_step(data.model, data, 50)
    replace_model(data.model, data.plugin_state, "j", joint.scaled(torque=2.0))
    assert data.plugin_state[-kernels.SIZE :].tolist() == [0.6, 3.0, 0.4, 0, 0, 0, 0]


def test_a_scaled_model_keeps_its_time():
    joint = KNOWN["all wrappers"]
    time, angle = moved(200)
    twice = joint.scaled(torque=2.0, angle=2.0).response(2 * angle, time=time)
    np.testing.assert_allclose(twice, 2 * joint.response(angle, time=time), rtol=1e-9)


def test_the_certificate_bounds_what_can_be_bounded(joint, elbow):
    inside = (0.5, 1.5)
    inner = elbow.certificate(inside)
    spring = Viscoelastic(model=elbow, relaxation_stiffness=1.5, relaxation_time=0.4)
    assert spring.certificate(inside).torque_bound == pytest.approx(inner.torque_bound + 1.5)
    assert joint.certificate(inside).torque_bound == np.inf
    assert is_safe(joint, inside)
    assert (joint.free_parameters, spring.free_parameters) == (8, 7)
