"""`replace_model` with the memory kept: the torque changes no more than the parameters do."""

from itertools import pairwise

import mujoco
import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.hysteresis import BoucWen, Dahl, Preisach, model_from_dict
from activesuit.hysteresis.engine import fault_slots, replace_model, take_off
from helpers import assert_refused, attached
from known_models import ELBOW, KNOWN

# So heavy that a step does not move it: the tests say where it is.
JOINT = """<mujoco><option timestep="0.01" gravity="0 0 0"/><worldbody>
  <body><joint name="j" axis="0 1 0" armature="1e14"/><geom size=".1"/></body>
  </worldbody></mujoco>"""
TURNS = (0.0, 0.9, 0.1, 0.7, 0.3, 0.55)
PATH = np.concatenate([np.linspace(*ends, 41)[1:] for ends in pairwise(TURNS)])
SMALL = 1e-3


@pytest.fixture(params=KNOWN)
def model(request):
    return KNOWN[request.param]


def simulation(model):
    return attached(JOINT, "j", model)


def moved(data, angles):
    """Moves the joint through angles; returns the torque and the dissipated energy at each."""
    found = []
    for angle in angles:
        data.qpos[0], data.qvel[0] = angle, 0.0
        mujoco.mj_step(data.model, data)
        data.qpos[0], data.qvel[0] = angle, 0.0
        found.append(shown(data))
    return np.array(found)


def shown(data):
    mujoco.mj_forward(data.model, data)
    names = ("torque", "dissipated_energy")
    torque, lost = (data.sensor(f"j_suit_{name}").data[0] for name in names)
    return -torque, lost


def change(content, factor):
    """Dictionaries of a model with one of its numbers, or one of its lists, times a factor."""
    for key, value in content.items():
        if isinstance(value, dict):
            yield from ({**content, key: other} for other in change(value, factor))
        elif isinstance(value, list):
            first, *rest = value
            yield {**content, key: [np.multiply(one, factor).tolist() for one in value]}
            if not isinstance(first, list) and key not in ("levels", "thresholds", "knots"):
                yield {**content, key: [first * factor, *rest]}
        elif isinstance(value, float):
            yield {**content, key: value * factor}


def changed(model, factor):
    """The models with one of the parameters times a factor that there can be."""
    found = []
    for content in change(model.to_dict(), factor):
        try:
            other = model_from_dict(content)
        except InputError:
            continue
        if other.certificate().certified and other.certificate().dissipative:
            found.append(other)
    assert len(found) >= 2
    return found


def test_a_small_change_of_a_parameter_changes_the_torque_no_more_than_that(model):
    for factor in [1 + SMALL, 1 - SMALL]:
        data = simulation(model)
        before = moved(data, PATH)
        kept, size = data.plugin_state.copy(), np.abs(before[:, 0]).max()
        for other in changed(model, factor):
            data.plugin_state[:] = kept
            replace_model(data.model, data.plugin_state, "j", other, keep_memory=True)
            torque, lost = shown(data)
            assert abs(torque - before[-1, 0]) <= 5 * SMALL * size, other
            assert lost == pytest.approx(before[-1, 1], abs=SMALL * size), other
            assert moved(data, PATH[-30:])[-1, 1] >= lost - 1e-9


def test_the_same_model_changes_no_bit_and_without_its_memory_the_torque_jumps(model):
    data = simulation(model)
    before = moved(data, PATH)
    kept = data.plugin_state.copy()
    replace_model(data.model, data.plugin_state, "j", model, keep_memory=True)
    np.testing.assert_array_equal(data.plugin_state, kept)
    replace_model(data.model, data.plugin_state, "j", model)
    jump = abs(shown(data)[0] - before[-1, 0])
    assert jump > 3 * SMALL * np.abs(before[:, 0]).max()


def test_a_scaled_model_goes_on_with_the_scaled_torque(model):
    one, two = simulation(model), simulation(model)
    moved(one, PATH)
    moved(two, PATH)
    replace_model(two.model, two.plugin_state, "j", model.scaled(torque=1.3), keep_memory=True)
    rest = np.concatenate([np.linspace(0.55, 0.2, 20), np.linspace(0.2, 0.95, 40)])
    expected = 1.3 * moved(one, rest)[:, 0]
    np.testing.assert_allclose(moved(two, rest)[:, 0], expected, rtol=1e-7, atol=1e-8)


def test_a_limit_that_falls_takes_the_state_along():
    data = simulation(BoucWen(elastic=0, hysteretic=10, beta=3, gamma=2, n=1))
    moved(data, PATH)
    tight = BoucWen(elastic=0, hysteretic=10, beta=30, gamma=20, n=1)
    replace_model(data.model, data.plugin_state, "j", tight, keep_memory=True)
    assert shown(data)[0] == pytest.approx(10 * tight.z_bound)
    data = simulation(ELBOW)
    moved(data, np.linspace(0, 2, 50))
    soft = ELBOW.scaled(angle=0.01).scaled(angle=1.0)
    replace_model(data.model, data.plugin_state, "j", soft, keep_memory=True)
    assert fault_slots(data.model).size == 1
    assert np.all(np.diff(moved(data, np.linspace(2, -2, 50))[:, 1]) >= -1e-9)


def test_fewer_turning_points_between_new_levels():
    density = [[0.1] * (i + 1) for i in range(4)]
    wide = Preisach(levels=[-1, -0.5, 0, 0.5, 1], density=density)
    narrow = Preisach(levels=[-0.2, 0, 0.2, 0.3, 0.4], density=density)
    data = simulation(wide)
    moved(data, PATH)
    replace_model(data.model, data.plugin_state, "j", narrow, keep_memory=True)
    other = simulation(narrow)
    moved(other, PATH)
    there = np.linspace(0.55, -0.3, 30)
    found, expected = (np.diff(moved(one, there)[:, 0]) for one in (data, other))
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_what_keeps_no_memory_is_refused():
    dahl = Dahl(spring=[0.0, 1.0], stiffness=9, friction=1.5)
    data = simulation(dahl)

    def replaced(model, **options):
        replace_model(data.model, data.plugin_state, "j", model, keep_memory=True, **options)

    message = "keep_memory is True, and a start is given: leave"
    starts = {"start_angle": 0.1, "start_torque": 0.0, "start_path": ()}
    rows = [(dahl, {start: value}, message) for start, value in starts.items()]
    for other in (ELBOW, Dahl(spring=[0.0, 1.0, 2.0], stiffness=9, friction=1.5)):
        rows.append((other, {}, "compiled with another kind or size of model than this"))
    assert_refused(lambda model, start: replaced(model, **start), rows)
    take_off(data.model, data.plugin_state, "j")
    assert_refused(replaced, [(dahl, "the dahl model of joint 'j' has no memory to keep: it")])
    data.plugin_state[fault_slots(data.model)] = 1.0
    assert_refused(replaced, [(dahl, "its torque has met a pole; leave keep_memory out")])
