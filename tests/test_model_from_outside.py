"""A hysteresis model from outside the package: fit and engine; test_extensions has its commands."""

import math

import mujoco
import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.hysteresis import (
    MODELS,
    Asymmetric,
    Clipped,
    HysteresisModel,
    model_from_dict,
    register_model,
)
from activesuit.hysteresis.engine import attach, register, replace_model
from activesuit.identification import (
    first_order_motions,
    fit_curves,
    measure,
    register_fit,
    select,
)
from activesuit.identification.fits.registry import FITS
from helpers import attached
from maxwell_slip import MaxwellSlip, fit_maxwell_slip

TRUTH = MaxwellSlip(elastic=2.0, spring=20.0, limit=3.0)
ARM = """<mujoco><option timestep="0.005" gravity="0 0 0"/>
  <worldbody><body><geom size=".1"/><joint name="hinge" armature="1"/></body></worldbody>
  <actuator><position joint="hinge" kp="4000" dampratio="1"/></actuator></mujoco>"""


@pytest.fixture(autouse=True)
def known():
    register_model(MaxwellSlip)
    register_fit("maxwell-slip", fit_maxwell_slip)
    yield
    del MODELS["maxwell-slip"], FITS["maxwell-slip"]


@pytest.fixture
def curves():
    motions = first_order_motions((0.5, 0.8, 1.1), start_angle=0.1, angle_step=0.01)
    return measure(TRUTH, motions, rng=0, noise_fraction=0.01, predict=["0.80"])


def test_dictionaries_know_it():
    assert model_from_dict(TRUTH.to_dict()) == TRUTH
    kept = Clipped(model=TRUTH, angle_range=(0.0, 1.0))
    assert model_from_dict(kept.to_dict()) == kept


def test_it_is_fitted(curves):
    fit = fit_curves(curves, model="maxwell-slip")
    assert fit.model.spring == pytest.approx(TRUTH.spring, rel=0.05)
    assert fit.model.limit == pytest.approx(TRUTH.limit, rel=0.05)
    assert fit.nrmse < 0.012
    assert max(fit.prediction_errors.values()) < 0.3


def test_auto_tries_it(curves):
    found = select([*curves.fitted()])
    assert "maxwell-slip" in {one.name for one in found.candidates}
    assert found.fit.model_name == "maxwell-slip"  # it has the fewest parameters


AROUND = Asymmetric(model=Clipped(model=TRUTH, angle_range=(-0.2, 0.3)), polynomial=[0.2, -1.0])


@pytest.mark.parametrize("model", [TRUTH, AROUND], ids=lambda model: model.name)
def test_the_engine_has_its_torque(model):
    data = attached(ARM, "hinge", model)
    angle, torque = [0.0], [0.0]
    for i in range(300):
        data.ctrl[0] = 0.5 * np.sin(0.05 * i)
        mujoco.mj_step(data.model, data)
        mujoco.mj_forward(data.model, data)
        angle.append(float(data.qpos[0]))
        torque.append(-float(data.sensor("hinge_suit_torque").data[0]))
    np.testing.assert_allclose(torque, model.response(angle), atol=1e-12)
    state = model.start(0.0)
    for one in angle[1:]:
        state, _ = model.step(state, one)
    lost = data.sensor("hinge_suit_dissipated_energy").data[0]
    assert lost == pytest.approx(model.energy(state).dissipated)
    assert lost > 0.5


def test_each_simulation_may_have_its_own():
    data = attached(ARM, "hinge", TRUTH)
    replace_model(data.model, data.plugin_state, "hinge", TRUTH.scaled(torque=2))
    data.qpos[0] = 0.4
    mujoco.mj_forward(data.model, data)
    assert -data.sensor("hinge_suit_torque").data[0] == 2 * TRUTH.response([0, 0.4])[-1]


def test_a_memory_that_is_kept_keeps_the_torque_and_the_lost_energy():
    data = attached(ARM, "hinge", TRUTH)
    data.ctrl[0] = 0.5
    mujoco.mj_step(data.model, data, 300)

    def shown():
        mujoco.mj_forward(data.model, data)
        names = ("torque", "dissipated_energy")
        return [float(data.sensor(f"hinge_suit_{name}").data[0]) for name in names]

    before = shown()
    assert before[1] > 0
    stiffer = TRUTH.scaled(torque=1.1)
    replace_model(data.model, data.plugin_state, "hinge", stiffer, keep_memory=True)
    assert shown() == pytest.approx(before, rel=1e-12)


def test_plain_mjcf_and_its_own_complaints():
    assert "activesuit.maxwell_slip" in register()
    spec = mujoco.MjSpec.from_string(ARM)
    attach(spec, "hinge", TRUTH)
    text = spec.to_xml()
    mujoco.MjModel.from_xml_string(text)
    with pytest.raises(ValueError, match=r"spring is -1\.0: a slider needs more than 0"):
        mujoco.MjModel.from_xml_string(text.replace('value="20.0"', 'value="-1"'))


def test_what_is_no_model_is_refused():
    class Nameless(HysteresisModel):
        pass

    for wrong, message in (
        (MaxwellSlip(elastic=1, spring=1, limit=1), "give a class derived from HysteresisModel"),
        (dict, "give a class derived from HysteresisModel"),
        (Nameless, "model Nameless lacks certificate, name, kernels: define that"),
        (type("Other", (MaxwellSlip,), {}), "there is another model 'maxwell-slip'"),
        (
            type("Part", (MaxwellSlip,), {"kernels": math}),
            "lacks kernels.memory_size, kernels.begin",
        ),
    ):
        with pytest.raises(InputError, match=message):
            register_model(wrong)
