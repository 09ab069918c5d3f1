"""The bushing: the exact gradient of its energy, in every way of running a simulation."""

import copy
import pickle

import mujoco
import numpy as np
import pytest
from activesuit.envs.model.bushing import Bushing, attach_bushing, replace_bushing
from arms import posed
from helpers import assert_refused
from mujoco.batch import Batch
from scipy.spatial.transform import Rotation

FREE = """<mujoco><option gravity="0 0 0" integrator="RK4" timestep=".00025">
  <flag energy="enable" contact="disable"/></option>
  <worldbody>
  <body pos=".01 .02 .03"><freejoint/><geom type="box" size=".1 .2 .05" mass="2"/>
    <site name="limb" pos=".1 .03 -.02" euler="10 20 30"/></body>
  <body pos=".1 0 0" euler="20 5 50"><freejoint/><geom type="box" size=".2 .05 .06" mass="1"/>
    <body pos=".1 0 0"><geom size=".02"/>
      <site name="exo" pos="-.12 .03 .04" euler="-10 50 5"/></body></body>
  </worldbody>{sensors}</mujoco>"""
CHAINS = """<mujoco><option integrator="RK4" timestep=".00025">
  <flag energy="enable" contact="disable"/></option>
  <default><geom type="capsule" size=".03"/></default>
  <worldbody><body><joint type="slide" axis="1 0 0"/><joint type="hinge" axis="0 0 1"/>
    <geom fromto="0 0 0 0 0 .2" mass="3"/>
    <body><joint axis="0 1 0"/><geom fromto="0 0 0 0 0 -.3" mass="2"/>
      <body pos="0 0 -.3"><joint axis="1 1 0"/><geom fromto="0 0 0 0 0 -.3" mass="1"/>
        <site name="limb" pos="0 0 -.2"/></body></body>
    <body pos=".01 .02 0"><joint type="ball"/><geom fromto="0 0 0 0 0 -.3" mass="1"/>
      <body pos="0 0 -.3"><joint axis="0 1 0"/><geom fromto="0 0 0 0 0 -.3" mass=".5"/>
        <site name="exo" pos=".01 0 -.21" euler="5 10 20"/></body></body>
  </body></worldbody>{sensors}</mujoco>"""
RELATIVE = """<sensor><framepos objtype="site" objname="limb" reftype="site" refname="exo"/>
  <framelinvel objtype="site" objname="limb" reftype="site" refname="exo"/>
  <frameangvel objtype="site" objname="limb" reftype="site" refname="exo"/></sensor>"""
SPRINGS = {
    "stiffness": (4500, 3000, 2100),
    "rotational_stiffness": (30, 60, 20),
    "offset": (0.01, 0, -0.02),
}
DAMPERS = {"damping": (60, 40, 20), "rotational_damping": (0.3, 0.6, 0.1)}
INTEGRATION = mujoco.mjtState.mjSTATE_INTEGRATION


def coupled(mjcf, bushing, sensors=""):
    spec = mujoco.MjSpec.from_string(mjcf.format(sensors=sensors))
    attach_bushing(spec, "cuff", "limb", "exo", bushing)
    model = spec.compile()
    return model, mujoco.MjData(model)


def scatter(model, data, seed, size=1.0):
    rng = np.random.default_rng(seed)
    mujoco.mj_integratePos(model, data.qpos, size * rng.standard_normal(model.nv), 1.0)
    data.qvel[:] = rng.standard_normal(model.nv)
    mujoco.mj_forward(model, data)


@pytest.mark.parametrize(("mjcf", "seed"), [(FREE, 0), (CHAINS, 1)])
def test_the_force_is_the_gradient_of_the_energy(mjcf, seed):
    model, data = coupled(mjcf, Bushing(**SPRINGS))
    scatter(model, data, seed, size=0.5)
    at, force = data.qpos.copy(), data.qfrc_passive.copy()
    step, gradient = 1e-6, np.zeros(model.nv)
    for i, direction in enumerate(np.eye(model.nv)):
        for sign in (1, -1):
            data.qpos[:] = at
            mujoco.mj_integratePos(model, data.qpos, sign * direction, step)
            mujoco.mj_forward(model, data)
            gradient[i] += sign * data.sensor("cuff_energy").data[0] / (2 * step)
    np.testing.assert_allclose(force, -gradient, atol=1e-8 * np.abs(force).max())


@pytest.mark.parametrize("mjcf", [FREE, CHAINS])
def test_sensors_agree_with_the_relative_motion(mjcf):
    springs = SPRINGS | {"rotational_stiffness": (20, 20, 20)}
    bushing = Bushing(**springs, **DAMPERS)
    model, data = coupled(mjcf, bushing, RELATIVE)
    for seed in range(20):
        scatter(model, data, seed)
        position, velocity, spin = data.sensordata[:9].reshape(3, 3)
        stretch = position - bushing.offset
        axes = [Rotation.from_matrix(data.site(s).xmat.reshape(3, 3)) for s in ("exo", "limb")]
        turn = (axes[0].inv() * axes[1]).as_rotvec()
        force, torque = (data.sensor(f"cuff_{name}").data for name in ("force", "torque"))
        expected = -np.multiply(bushing.stiffness, stretch) - np.multiply(bushing.damping, velocity)
        np.testing.assert_allclose(force, expected, rtol=1e-10, atol=1e-9)
        expected = -20 * turn - np.multiply(bushing.rotational_damping, spin)
        np.testing.assert_allclose(torque, expected, rtol=1e-10, atol=1e-9)
        energy = np.dot(bushing.stiffness, stretch**2) / 2 + 10 * np.dot(turn, turn)
        assert data.sensor("cuff_energy").data[0] == pytest.approx(energy, rel=1e-12)


@pytest.mark.parametrize("axis", ["1 0 0", ".6 -.48 .64"])
def test_the_torque_is_right_at_every_angle(axis):
    spec = mujoco.MjSpec.from_string(
        f'<mujoco><worldbody><site name="exo"/><body><joint axis="{axis}"/><geom size=".1"/>'
        '<site name="limb"/></body></worldbody></mujoco>'
    )
    attach_bushing(spec, "cuff", "limb", "exo", Bushing(rotational_stiffness=(30, 30, 30)))
    model = spec.compile()
    for angle in (0, 1e-200, 1e-9, 0.0999, 0.1001, 1.57, 2.1, 3.1, 3.141592, 4.0, 6.0):
        for sign in (1, -1):
            data = posed(model, sign * angle)
            turn = sign * (angle if angle < np.pi else angle - 2 * np.pi)
            assert data.qfrc_passive[0] == pytest.approx(-30 * turn, rel=1e-14, abs=1e-13)


@pytest.mark.parametrize("integrator", ["IMPLICITFAST", "RK4"])
def test_every_way_of_resuming_is_bit_identical(integrator):
    model, data = coupled(CHAINS, Bushing(**SPRINGS, **DAMPERS))
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator}")
    mujoco.mj_step(model, data, nstep=100)
    saved = np.empty(mujoco.mj_stateSize(model, INTEGRATION))
    mujoco.mj_getState(model, data, saved, INTEGRATION)
    others = [copy.deepcopy(data), pickle.loads(pickle.dumps(data)), mujoco.MjData(model)]
    mujoco.mj_setState(model, others[-1], saved, INTEGRATION)
    mujoco.mj_step(model, data, nstep=100)
    for other in others:
        mujoco.mj_step(model, other, nstep=100)
        np.testing.assert_array_equal(other.qpos, data.qpos)
    batch = Batch(model, nsim=3, nthread=2)
    batch.reset()
    for _ in range(200):
        batch.step()
    assert (batch.bind("qpos") == data.qpos).all()


def test_each_simulation_of_a_batch_may_have_its_own():
    soft, hard = Bushing(stiffness=(100, 100, 100)), Bushing(**SPRINGS, **DAMPERS)
    model, single = coupled(CHAINS, soft)
    batch = Batch(model, nsim=2, nthread=1)
    batch.reset()
    replace_bushing(model, batch.bind("plugin_state").reshape(2, -1)[1], "cuff", hard)
    other_model, other = coupled(CHAINS, hard)
    for _ in range(100):
        batch.step()
    mujoco.mj_step(model, single, nstep=100)
    mujoco.mj_step(other_model, other, nstep=100)
    np.testing.assert_array_equal(batch.bind("qpos"), [single.qpos, other.qpos])
    assert np.abs(single.qpos - other.qpos).max() > 1e-3
    replace_bushing(model, single.plugin_state, "cuff", hard)
    np.testing.assert_array_equal(single.plugin_state, hard.parameter_vector)
    mujoco.mj_resetData(model, single)
    np.testing.assert_array_equal(single.plugin_state, soft.parameter_vector)


def test_two_bushings_and_a_site_on_the_world():
    spec = mujoco.MjSpec.from_string(FREE.format(sensors=""))
    spec.worldbody.add_site(name="wall")
    attach_bushing(spec, "one", "limb", "exo", Bushing(stiffness=(10, 10, 10)))
    attach_bushing(spec, "two", "wall", "limb", Bushing(stiffness=(20, 20, 20)))
    model = spec.compile()
    data = posed(model)
    limb, exo = data.site("limb").xpos, data.site("exo").xpos
    np.testing.assert_allclose(data.qfrc_passive[:3], 10 * (exo - limb) - 20 * limb, rtol=1e-12)
    assert model.nsensor == 6


def test_wrong_names_and_numbers_are_refused():
    spec = mujoco.MjSpec.from_string(FREE.format(sensors=""))
    attach_bushing(spec, "cuff", "limb", "exo", Bushing())
    model = spec.compile()
    state = mujoco.MjData(model).plugin_state
    rows = [
        (attach_bushing, spec, "a", "limp", "exo", r"unknown site 'limp'.*did you mean 'limb'"),
        (attach_bushing, spec, "a", "limb", "limb", "are on one body: a bushing connects two"),
        (attach_bushing, spec, "cuff", "limb", "exo", "plugin instance 'cuff' already"),
        (replace_bushing, model, state, "cuf", "unknown bushing 'cuf': use one of cuff"),
        (replace_bushing, model, state[:3], "cuff", r"plugin_state has the shape \(3,\)"),
    ]
    assert_refused(lambda call, *given: call(*given, Bushing()), rows)
    rows = [
        ({"stiffness": (4500, -1, 0)}, "stiffness of a bushing is .* of at least 0"),
        ({"rotational_damping": (0, 0, np.inf)}, "rotational_damping of a bushing is .* finite"),
        ({"damping": 3.0}, "damping of a bushing is 3.0: give three"),
        ({"offset": (0, 0, 0.11)}, "offset of a bushing is .* from -0.1 to 0.1 m"),
    ]
    assert_refused(lambda change: Bushing(**change), rows)


def plain_mjcf(config, sensor="a_force"):
    keys = "".join(f'<config key="{key}" value="{value}"/>' for key, value in config.items())
    plugin = f'<plugin plugin="activesuit.bushing"><instance name="i">{keys}</instance></plugin>'
    sensors = f'<sensor><plugin name="{sensor}" instance="i"/></sensor>'
    text = FREE.format(sensors=sensors)
    return text.replace("<option", f"<extension>{plugin}</extension><option", 1)


def test_plain_mjcf_works_and_its_mistakes_get_one_sentence():
    ends = {"limb": "limb", "exo": "exo"}
    config = {name: " ".join(map(str, numbers)) for name, numbers in SPRINGS.items()}
    model = mujoco.MjModel.from_xml_string(plain_mjcf(ends | config))
    expected = Bushing(**SPRINGS).parameter_vector
    np.testing.assert_array_equal(mujoco.MjData(model).plugin_state, expected)
    rows = [
        ({"limb": "limb"}, "a_force", "of limb 'limb': exo is '': the model has no such site"),
        (ends | {"exo": "limb"}, "a_force", "same body"),
        (
            ends | {"stiffness": "1 2"},
            "a_force",
            r"stiffness of a bushing is \(1.0, 2.0\): give three",
        ),
        (
            ends | {"damping": "1 -2 3"},
            "a_force",
            r"damping of a bushing is \(1.0, -2.0, 3.0\): .* least 0",
        ),
        (ends, "a_pressure", "must end in force, torque or energy"),
    ]
    for config, sensor, sentence in rows:
        with pytest.raises(ValueError, match=sentence):
            mujoco.MjModel.from_xml_string(plain_mjcf(config, sensor))


@pytest.mark.parametrize(
    ("integrator", "ratio"), [("implicitfast", 0.0), ("implicitfast", 1.0), ("Euler", 0.5)]
)
def test_the_largest_stable_step_is_as_documented(integrator, ratio):
    mass, stiffness = 0.6, 4500.0
    rate = np.sqrt(stiffness / mass)
    spec = mujoco.MjSpec.from_string(
        f'<mujoco><option gravity="0 0 0" integrator="{integrator}">'
        '<flag autoreset="disable"/></option><worldbody><site name="exo"/>'
        f'<body><joint type="slide"/><geom size=".1" mass="{mass}"/><site name="limb"/></body>'
        "</worldbody></mujoco>"
    )
    damping = 2 * ratio * np.sqrt(stiffness * mass)
    bushing = Bushing(stiffness=(0, 0, stiffness), damping=(0, 0, damping))
    attach_bushing(spec, "cuff", "limb", "exo", bushing)
    model = spec.compile()
    largest = 2 * (np.sqrt(1 + ratio**2) - ratio) / rate
    reached = []
    for step in (0.99 * largest, 1.01 * largest):
        model.opt.timestep = step
        data = mujoco.MjData(model)
        data.qvel[:] = 1e-6
        mujoco.mj_step(model, data, nstep=500)
        reached.append(abs(data.qpos[0]))
    assert reached[0] < 1e-6
    assert not reached[1] < 1e-4  # it may be NaN
