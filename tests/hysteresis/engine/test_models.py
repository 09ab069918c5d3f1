"""Every model inside the engine: the torque of `response`, its energy, one set per simulation."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.hysteresis import (
    Asymmetric,
    Backlash,
    BoucWen,
    Clipped,
    JilesAtherton,
    PoleError,
    PrandtlIshlinskii,
    UncertifiedModelError,
    Viscoelastic,
)
from activesuit.hysteresis.engine import attach, fault_slots, replace_model, take_off
from activesuit.hysteresis.protocol import follow
from helpers import assert_refused
from known_models import ELBOW, KNOWN, RATE, WITHOUT_RATE
from mujoco.batch import Batch

PENDULUM = """<mujoco><option timestep="0.002" integrator="implicitfast"/><worldbody>
  <body><joint name="j" axis="0 1 0" damping=".2"/>
    <geom type="capsule" fromto="0 0 0 0 0 -.5" size=".05" mass="3"/></body></worldbody>
  <actuator><motor joint="j" gear="40"/></actuator></mujoco>"""
STOPS = PrandtlIshlinskii(stiffness=1.5, thresholds=[0.05, 0.2, 0.7], weights=[6, 4, 2])


def pendulum(model, timestep=0.002, integrator="implicitfast", **options):
    spec = mujoco.MjSpec.from_string(PENDULUM)
    spec.option.timestep = timestep
    spec.option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    attach(spec, "j", model, **options)
    return spec.compile()


@pytest.fixture(params=WITHOUT_RATE)
def model(request):
    return KNOWN[request.param]


def bitwise(model):
    """Whether the engine adds up the torque of a model in the order of `response`."""
    return not any(name in str(model.to_dict()) for name in ("polynomial", "gap"))


@pytest.mark.parametrize("integrator", ["implicitfast", "Euler", "RK4"])
def test_the_torque_is_the_response_bit_by_bit(model, integrator):
    compiled = pendulum(model, integrator=integrator)
    data = mujoco.MjData(compiled)
    rng, angles, found = np.random.default_rng(4), [0.0], []
    for i in range(600):
        if i % 30 == 0:
            data.ctrl[0] = rng.uniform(-1, 1)
        mujoco.mj_step(compiled, data)
        for _ in range(1 + i % 3):
            mujoco.mj_forward(compiled, data)  # evaluating more often must change nothing
        angles.append(data.qpos[0])
        found.append(data.sensordata.copy())
        passive = data.qfrc_passive[0] + compiled.dof_damping[0] * data.qvel[0]
        assert passive == pytest.approx(found[-1][0], abs=1e-12)
    torque, stiffness, lost = np.array(found).T
    tolerance = 0 if bitwise(model) else 1e-9 if "gap" in str(model.to_dict()) else 1e-12
    np.testing.assert_allclose(-torque, model.response(angles)[1:], rtol=0, atol=tolerance)
    assert np.ptp(angles) > 1
    assert np.diff(lost).min() > -1e-8
    state = follow(model, model.start(0.0), angles[1:])
    assert lost[-1] == pytest.approx(model.energy(state).dissipated, rel=1e-9)
    assert stiffness[-1] == pytest.approx(model.tangent(state, data.qvel[0]), rel=1e-12)
    assert not data.plugin_state[fault_slots(compiled)].any()


PATH = (-0.5, 0.9, -0.2, 0.9, 0.3)


def torque_and_loss_at(compiled, angle, row=None):
    """Torque and dissipated energy at an angle, after a reset or in a state of one's own."""
    data = mujoco.MjData(compiled)
    if row is not None:
        data.plugin_state[:] = row
    data.qpos[0] = angle
    mujoco.mj_forward(compiled, data)
    return -data.sensor("j_suit_torque").data[0], data.sensor("j_suit_dissipated_energy").data[0]


def test_the_memory_begins_at_the_end_of_its_path(model):
    compiled = pendulum(model, start_angle=0.1, start_torque=0.2, start_path=PATH)
    for angle in (0.3, 0.9, -0.5):
        torque, lost = torque_and_loss_at(compiled, angle)
        expected = model.response([0.1, *PATH, angle], 0.2)[-1]
        assert torque == pytest.approx(expected, rel=0, abs=0 if bitwise(model) else 1e-12)
    state = follow(model, model.start(0.1, 0.2), (*PATH, -0.5))
    assert lost == pytest.approx(model.energy(state).dissipated, rel=1e-9)
    # A replaced model begins with the path too.
    other = model.scaled(torque=0.9)
    for given, path in ((None, PATH), ((0.8, 0.0), (0.8, 0.0)), ((), ())):
        row = mujoco.MjData(compiled).plugin_state.copy()
        replace_model(compiled, row, "j", other, start_path=given)
        torque, _ = torque_and_loss_at(compiled, 0.5, row)
        expected = other.response([0.1, *path, 0.5], 0.2)[-1]
        assert torque == pytest.approx(expected, abs=1e-12)
    replace_model(compiled, row, "j", other, start_angle=0.12, start_torque=0.3, start_path=())
    torque, _ = torque_and_loss_at(compiled, 0.5, row)
    assert torque == pytest.approx(other.response([0.12, 0.5], 0.3)[-1], abs=1e-12)


def test_a_bad_path_is_refused(shoulder):
    with pytest.raises(InputError, match=r"start_path\[1\] is nan: give finite numbers \(rad\)"):
        pendulum(ELBOW, start_path=[0.1, math.nan])
    with pytest.raises(PoleError):
        pendulum(shoulder, start_path=[2.5, -1.0], allow_uncertified=True)


def test_a_diverged_simulation_starts_again_in_any_thread():
    compiled = pendulum(ELBOW, start_angle=0.1, start_path=PATH)
    batch = Batch(compiled, nsim=16, nthread=4)
    states = batch.bind("plugin_state").reshape(16, -1)
    states[:], batch.bind("qvel")[:] = 1.0, math.nan
    batch.step()
    again = mujoco.MjData(compiled)
    mujoco.mj_step(compiled, again)
    np.testing.assert_array_equal(states, np.tile(again.plugin_state, (16, 1)))


def test_a_start_that_a_changed_model_forbids_is_a_fault(capfd):
    compiled = pendulum(KNOWN["duhem"])
    data = mujoco.MjData(compiled)
    compiled.qpos0[0] = 5.0  # where the spring alone has more torque than the friction allows
    mujoco.mj_resetData(compiled, data)
    assert data.plugin_state[fault_slots(compiled)].tolist() == [1.0]
    mujoco.mj_forward(compiled, data)
    assert data.qfrc_passive[0] == -compiled.dof_damping[0] * data.qvel[0]
    assert "outside the certificate" in capfd.readouterr().err


def test_one_set_of_parameters_per_simulation(model):
    compiled = pendulum(model)
    batch = Batch(compiled, nsim=3, nthread=2)
    batch.reset()
    states = batch.bind("plugin_state").reshape(3, -1)
    factors = (0.5, 1.0, 2.0)
    for row, factor in zip(states, factors, strict=True):
        replace_model(compiled, row, "j", model.scaled(torque=factor))
    ctrl = batch.bind("ctrl")
    for i in range(200):
        ctrl[:] = math.sin(i / 20)
        batch.step()
    for sim, factor in enumerate(factors):
        alone = pendulum(model.scaled(torque=factor))
        data = mujoco.MjData(alone)
        for i in range(200):
            data.ctrl[:] = math.sin(i / 20)
            mujoco.mj_step(alone, data)
        np.testing.assert_allclose(batch.bind("qpos").reshape(3, -1)[sim], data.qpos, atol=1e-9)


def test_replacing_needs_the_same_kind_and_size(elbow, shoulder):
    bent = Asymmetric(model=elbow, polynomial=[0.0, 1.0])
    kept = Clipped(model=elbow, angle_range=(-1.0, 0.3))  # two more numbers, like the polynomial
    play, rate = Backlash(model=elbow, gap=0.05), Viscoelastic(model=elbow, **RATE)
    fewer = replace(STOPS, thresholds=[0.1], weights=[1])
    others = ((elbow, KNOWN["dahl"]), (STOPS, fewer), (bent, kept), (kept, bent), (elbow, bent))
    for compiled_with, other in (*others, (play, elbow), (rate, elbow), (elbow, play)):
        compiled = pendulum(compiled_with)
        state = mujoco.MjData(compiled).plugin_state
        with pytest.raises(InputError, match="compiled with another kind or size of model"):
            replace_model(compiled, state, "j", other)
    with pytest.raises(UncertifiedModelError):
        replace_model(compiled, state, "j", shoulder)
    rows = [(state, "knee", "unknown joint with a hysteresis model 'knee'")]
    for wrong in (state.tolist(), state.astype(np.float32), None):
        rows.append((wrong, "j", "plugin_state must be"))
    rows.append((state[:3], "j", "plugin_state has 3 numbers"))
    assert_refused(lambda given, joint: replace_model(compiled, given, joint, elbow), rows)


def test_only_known_models_enter_the_engine(elbow):
    class Own(JilesAtherton):
        pass

    own = Own(**{k: v for k, v in elbow.to_dict().items() if k != "model"})
    rows = [(one, 0.0, "give one of activesuit's hysteresis models") for one in (own, None, "x")]
    rows.append((elbow, "x", "angle is 'x': give a number"))
    assert_refused(lambda one, start: pendulum(one, start_angle=start), rows)


@pytest.mark.parametrize("name", KNOWN)
def test_a_garbage_state_never_harms_the_process(name):
    model = KNOWN[name]
    for value in [math.nan, math.inf, -math.inf, 1e9, -1e300, 0.0]:
        compiled = pendulum(model)
        data = mujoco.MjData(compiled)
        data.plugin_state[1:] = value
        data.qpos[0] = 0.3
        mujoco.mj_forward(compiled, data)
        mujoco.mj_step(compiled, data, 3)


WRONG = [(Backlash(model=ELBOW, gap=0.05), -2, wrong) for wrong in (-1.0, 0.0, math.nan)]
WRONG.append((Viscoelastic(model=ELBOW, **RATE), -7, -5.0))


@pytest.mark.parametrize("model, place, wrong", WRONG)
def test_numbers_that_a_user_wrote_into_the_state_are_not_followed(model, place, wrong):
    compiled = pendulum(model)
    data = mujoco.MjData(compiled)
    assert data.plugin_state[place] == (RATE["damping"] if place == -7 else 0.05)
    data.plugin_state[place], data.qvel[0] = wrong, 1.0
    mujoco.mj_step(compiled, data, 5)
    assert data.plugin_state[0] == 1
    assert np.isfinite(data.qpos[0])


@pytest.mark.parametrize("name", KNOWN)
def test_a_reset_begins_anew(name):
    compiled = pendulum(KNOWN[name], start_path=PATH)
    data = mujoco.MjData(compiled)
    fresh, data.qvel[0] = data.plugin_state.copy(), 1.0
    mujoco.mj_step(compiled, data, 50)
    assert not np.array_equal(data.plugin_state, fresh)
    mujoco.mj_resetData(compiled, data)
    np.testing.assert_array_equal(data.plugin_state, fresh)


def test_a_model_that_is_taken_off_gives_no_torque_until_it_is_put_on(elbow):
    other = BoucWen(elastic=1, hysteretic=2, beta=1, gamma=0, n=1.0)
    spec = mujoco.MjSpec.from_string(PENDULUM)
    attach(spec, "j", elbow)
    attach(spec, "j", other, taken_off=True)
    both = spec.compile()
    alone = {name: pendulum(model) for name, model in {"elbow": elbow, "other": other}.items()}
    for name, put_on in {"elbow": None, "other": other}.items():
        one, two = mujoco.MjData(both), mujoco.MjData(alone[name])
        if put_on is not None:
            replace_model(both, one.plugin_state, "j", put_on)
        for step in range(200):
            for model, data in ((both, one), (alone[name], two)):
                data.qfrc_applied[0] = 3 * math.sin(step / 30)
                mujoco.mj_step(model, data)
        assert one.qpos[0] == two.qpos[0]
        suffix = "" if put_on is None else "_2"
        for sensor in ("torque", "stiffness", "dissipated_energy"):
            shown = one.sensor(f"j_suit{suffix}_{sensor}").data[0]
            assert shown == two.sensor(f"j_suit_{sensor}").data[0]
            assert one.sensor(f"j_suit{'_2' if put_on is None else ''}_{sensor}").data[0] == 0
    data = mujoco.MjData(both)
    take_off(both, data.plugin_state, "j")
    data.qpos[0] = 0.5
    mujoco.mj_forward(both, data)
    assert not data.sensordata.any()
    assert list(data.plugin_state[fault_slots(both)]) == [2.0, 2.0]
    with pytest.raises(InputError, match="compiled with another kind or size of model than this"):
        replace_model(both, data.plugin_state, "j", STOPS)


def test_no_number_in_a_bouc_wen_state_hangs_the_engine():
    for value in [0.5, -3.0, 1e7, -1e7, 1e-300]:
        for slot in range(10):
            # Series and steps of the flow ended for the signs of its branches only: -1, 0 and 1.
            compiled = pendulum(BoucWen(elastic=1, hysteretic=9, beta=4, gamma=-1, n=1.7))
            data = mujoco.MjData(compiled)
            data.plugin_state[4 + slot] = value
            data.qpos[0] = 0.3
            mujoco.mj_step(compiled, data, 3)


def test_the_nearest_certified_model_is_offered(shoulder):
    message = r"margin is -0\.245.*nearest certified"
    with pytest.raises(UncertifiedModelError, match=message) as caught:
        pendulum(shoulder)
    assert caught.value.margin == pytest.approx(-0.2447, abs=1e-4)
    pendulum(caught.value.nearest)
    runaway = BoucWen(elastic=0, hysteretic=1, beta=1, gamma=-3, n=2)
    with pytest.raises(UncertifiedModelError, match=r"margin is -0\.5.*use other parameters"):
        pendulum(runaway)
