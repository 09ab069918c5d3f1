"""The engine plugin: the model's torque, in every integrator, in every way of saving the state."""

import copy
import math
import multiprocessing
import pickle
import threading

import mujoco
import numpy as np
import pytest
from activesuit.hysteresis import UncertifiedModelError
from activesuit.hysteresis.engine import PLUGIN_NAMES, attach, fault_slots, register
from helpers import assert_refused, attached, python
from mujoco import rollout
from mujoco.batch import Batch

CHAIN = """<mujoco><option timestep="0.002"/><worldbody>
  <body pos="0 0 1"><joint name="one" axis="0 1 0" damping="1" range="-90 90"/>
    <geom type="capsule" fromto="0 0 0 0 0 -.3" size=".05" mass="2"/>
    <body pos="0 0 -.3"><joint name="two" axis="0 1 0" damping=".5" range="-90 90"/>
      <geom type="capsule" fromto="0 0 0 0 0 -.3" size=".04" mass="1"/></body></body>
  <body><joint name="ball" type="ball"/><geom size=".1"/></body>
  </worldbody>
  <actuator><motor joint="one" gear="30"/><motor joint="two" gear="15"/></actuator></mujoco>"""
SLIDE = """<mujoco><worldbody><body><joint name="s" type="slide"/><geom size=".1"/></body>
  </worldbody></mujoco>"""
STATE = mujoco.mjtState.mjSTATE_INTEGRATION


def chain(model, integrator="implicitfast", **options):
    spec = mujoco.MjSpec.from_string(CHAIN)
    spec.option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    for joint in ("one", "two"):
        attach(spec, joint, model, **options)
    return spec.compile()


def test_every_way_of_resuming_is_bit_identical(elbow):
    for integrator in ["implicitfast", "Euler", "RK4"]:
        model = chain(elbow, integrator)
        data = mujoco.MjData(model)
        ctrl = np.repeat(np.random.default_rng(0).uniform(-1, 1, (20, 2)), 20, axis=0)
        start = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
        mujoco.mj_getState(model, data, start, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        saved = np.empty(mujoco.mj_stateSize(model, STATE))
        copies, positions = {}, [data.qpos[:2].copy()]
        for i, u in enumerate(ctrl):
            if i == 200:
                mujoco.mj_getState(model, data, saved, STATE)
                copies["deepcopy"] = copy.deepcopy(data)
                copies["pickle"] = pickle.loads(pickle.dumps(data))
            data.ctrl[:] = u
            mujoco.mj_step(model, data)
            positions.append(data.qpos[:2].copy())
        shown = copy.deepcopy(data)
        mujoco.mj_forward(model, shown)
        for joint, angle in zip(("one", "two"), np.array(positions).T, strict=True):
            torque = -shown.sensor(f"{joint}_suit_torque").data[0]
            assert torque == pytest.approx(elbow.response(angle)[-1], abs=1e-9)
            assert np.ptp(angle) > 0.3
        copies["setState"] = mujoco.MjData(model)
        mujoco.mj_setState(model, copies["setState"], saved, STATE)
        for other in copies.values():
            for u in ctrl[200:]:
                other.ctrl[:] = u
                mujoco.mj_step(model, other)
            np.testing.assert_array_equal(other.qpos, data.qpos)
            np.testing.assert_array_equal(other.plugin_state, data.plugin_state)
        batch = Batch(model, nsim=3, nthread=2)
        batch.reset()
        bound = batch.bind("ctrl")
        for u in ctrl:
            bound[:] = u
            batch.step()
        assert (batch.bind("qpos") == data.qpos).all()
        assert (batch.bind("plugin_state").reshape(3, -1) == data.plugin_state).all()
        states, _ = rollout.rollout(model, mujoco.MjData(model), start[None], ctrl[None])
        np.testing.assert_array_equal(states[0, -1, 1 : 1 + model.nq], data.qpos)


def test_a_written_position_is_no_turning_point(elbow):
    for integrator in ["implicitfast", "RK4"]:
        model = chain(elbow, integrator, start_angle=0.3)
        data = mujoco.MjData(model)
        data.qpos[0], data.qvel[0] = 1.1, -5.0
        mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        assert data.qpos[0] < 1.1
        expected = elbow.response([0.3, data.qpos[0]])[-1]
        assert data.sensor("one_suit_torque").data[0] == pytest.approx(-expected, abs=1e-12)


def test_a_slide_joint_works(elbow):
    data = attached(SLIDE, "s", elbow)
    data.qpos[0] = 0.4
    mujoco.mj_forward(data.model, data)
    assert data.qfrc_passive[0] == pytest.approx(-elbow.response([0.0, 0.4])[-1], abs=1e-12)


def test_pole_holds_the_torque_and_raises_the_flag(shoulder):
    data = attached(CHAIN, "one", shoulder, allow_uncertified=True)
    model = data.model
    model.opt.gravity[:] = 0
    for angle in np.radians([45, 90, 60, 0]):
        data.qpos[0], data.qvel[:] = angle, 0
        mujoco.mj_step(model, data)
    assert data.plugin_state[fault_slots(model)].tolist() == [1.0]
    mujoco.mj_forward(model, data)
    kept = shoulder.response([0, math.pi / 4, math.pi / 2])[-1]
    assert data.sensor("one_suit_torque").data[0] == pytest.approx(-kept, rel=0.01)
    mujoco.mj_resetData(model, data)
    assert not data.plugin_state[fault_slots(model)].any()


def test_a_diverged_simulation_returns(elbow):
    for angle in [math.nan, math.inf, 1e9, 1e300]:
        model = chain(elbow)
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
        data = mujoco.MjData(model)
        data.qpos[0] = angle
        mujoco.mj_forward(model, data)
        mujoco.mj_step(model, data)


def test_a_state_of_another_model_writes_only_its_own_sensors(elbow):
    plain = chain(elbow, sensors=False)
    data, other = mujoco.MjData(plain), mujoco.MjData(chain(elbow))
    assert data.plugin_state.size == other.plugin_state.size
    data.plugin_state[:] = other.plugin_state
    mujoco.mj_step(plain, data, 10)
    data.plugin_state[:] = 1e9  # garbage is garbage torque, never a wild write
    mujoco.mj_step(plain, data)


def test_numbers_do_not_depend_on_the_locale(elbow):
    code = (
        "import locale, sys, mujoco, activesuit.hysteresis.engine\n"
        "for name in ('de_DE.UTF-8', 'fr_FR.UTF-8', 'C'):\n"
        "    try: locale.setlocale(locale.LC_ALL, name); break\n"
        "    except locale.Error: pass\n"
        "model = mujoco.MjModel.from_xml_string(sys.stdin.read())\n"
        "print(mujoco.MjData(model).plugin_state.tolist())"
    )
    spec = mujoco.MjSpec.from_string(CHAIN)
    attach(spec, "one", elbow, start_angle=0.125)
    there = python("-c", code, check=True, input=spec.to_xml())
    state = eval(there.stdout)
    assert state == mujoco.MjData(spec.compile()).plugin_state.tolist()
    memory = elbow.start(0.125).memory
    np.testing.assert_array_equal(state[1:9], memory)
    np.testing.assert_array_equal(state[9:20], elbow.parameter_vector)


def test_the_default_start_is_the_reference_position(elbow):
    xml = (
        '<mujoco><compiler angle="{unit}"/><worldbody><body><joint name="j" ref="{ref}"/>'
        '<geom size=".1"/></body></worldbody></mujoco>'
    )
    for unit, ref in (("degree", "60"), ("radian", "1.0471975511965976")):
        near = attached(xml.format(unit=unit, ref=ref), "j", elbow)
        assert near.plugin_state[1] == pytest.approx(math.pi / 3)
        with pytest.raises(UncertifiedModelError, match=r"start of joint 'j' at 3\.14"):
            attached(xml.format(unit=unit, ref=float(ref) * 3), "j", elbow)


def test_attach_refuses(elbow, shoulder):
    spec = mujoco.MjSpec.from_string(CHAIN)
    rows = [
        (spec, "twoo", r"unknown joint 'twoo'.*did you mean 'two'"),
        (CHAIN, "one", r"attach got a str: give a mujoco\.MjSpec"),
        (spec, "ball", r"ball.*use a hinge or a slide"),
    ]
    assert_refused(lambda spec, joint: attach(spec, joint, elbow), rows)
    with pytest.raises(UncertifiedModelError, match=r"margin is -0\.245.*allow_uncertified"):
        attach(spec, "one", shoulder)
    with pytest.raises(UncertifiedModelError, match="start of joint 'one' at 3 rad"):
        attach(spec, "one", elbow, start_angle=3.0)
    attach(spec, "one", elbow)
    assert_refused(attach, [(spec, "one", elbow, "has a hysteresis model already")])


def test_registration_is_idempotent_and_thread_safe():
    slots = []
    threads = [threading.Thread(target=lambda: slots.append(register())) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(slot == slots[0] for slot in slots)
    assert sorted(slots[0]) == sorted(PLUGIN_NAMES)


def worker(xml):
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 100)
    return data.qpos.tolist()


def test_a_forked_process_agrees(elbow):
    spec = mujoco.MjSpec.from_string(CHAIN)
    attach(spec, "one", elbow)
    xml = spec.to_xml()
    here = worker(xml)
    with multiprocessing.get_context("fork").Pool(1) as pool:
        assert pool.apply(worker, (xml,)) == here


SECOND = """
import mujoco
from activesuit.hysteresis import TABLE_2, Backlash
from activesuit.hysteresis.engine import attach
spec = mujoco.MjSpec()
body = spec.worldbody.add_body(mass=1.0, inertia=[1.0, 1.0, 1.0])
body.add_joint(name="joint")
model = Backlash(model=TABLE_2["elbow-sa-pso"], gap=0.05)
attach(spec, "joint", model)
spec.compile()
model.response([0.5, 1.0, 0.6])
"""


@pytest.mark.slow
def test_a_second_process_compiles_nothing(monkeypatch):
    monkeypatch.setenv("NUMBA_DEBUG_CACHE", "1")
    for _ in range(2):
        reported = python("-c", SECOND, check=True).stdout
    assert "data loaded from" in reported
    assert "data saved to" not in reported
