"""Loads, pushes, reactions and blows against what mechanics says of them."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs import ArmEnv
from activesuit.envs.evaluation.run import reference_options
from activesuit.envs.model import ArmConfig, Payload, compose
from activesuit.envs.simulation.episode_plan import Plan
from activesuit.envs.tasks import TASKS, Hammer, Ratchet, Task
from activesuit.envs.tasks.tools import HANDLE, IMPACT, RAISED, THROUGH
from arms import addresses, go_on, mass_matrix, physics, posed, state

PICKED, PUT_DOWN, MASS = 100, 600, 3.0  # control periods, kg
G = 9.81
POSTURE = np.array([0.0, 0.9, 0.6, 0.0])
ARMS = {
    "right": {},
    "left, tilted": {"side": "left", "tilt": (0.4, 0.2)},
    "left, cuffs, tilted": {"coupling": "cuffs", "side": "left", "tilt": (-0.3, 0.1)},
    "bare": {"coupling": "none", "suit": "none"},
}


class PickUp(Task):
    """A still arm takes 3 kg, and puts them down."""

    carries = True

    def plan(self, rng, samples, dt, arm):
        still = np.zeros((samples, 4))
        mass = np.zeros(samples)
        mass[PICKED:PUT_DOWN] = MASS
        return Plan((still + POSTURE, still, still), mass)


PICK_UP = PickUp(name="PickUp", duration=6.5)
BARE = {"coupling": "none", "suit": "none"}
AT_ONCE = (0.0, 0.0)  # s, no wait before the first cycle


def jacobian(model, data, *, body=None, site=None):
    """Returns the Jacobian of a body's center of mass or of a site [m], shape (3, nv)."""
    found = np.zeros((3, model.nv))
    if body is not None:
        mujoco.mj_jacBodyCom(model, data, found, None, model.body(body).id)
    else:
        mujoco.mj_jacSite(model, data, found, None, model.site(site).id)
    return found


@pytest.mark.parametrize("options", [BARE, {"coupling": "cuffs"}], ids=["bare", "cuffs"])
def test_a_load_that_is_picked_up_weighs_at_once(options):
    env = ArmEnv(PICK_UP, **options)
    env.reset(seed=0)
    go_on(env, PICKED + 1)
    assert state(env).load[0] == MASS
    bias, still = {}, {}
    for mass in (0.0, MASS):
        model = compose(ArmConfig(payload=Payload(mass=mass), **options), drawn=False)
        data = posed(model, physics(env, "qpos"), physics(env, "qvel"))
        bias[mass] = data.qfrc_bias.copy()
        data.qvel[:] = 0.0
        mujoco.mj_forward(model, data)
        still[mass] = data.qfrc_bias.copy()
    # What a model has that was made with the load, to rounding.
    np.testing.assert_allclose(physics(env, "qfrc_bias"), bias[MASS], rtol=1e-9, atol=1e-9)
    # And m g r more than without it: for an arm that has begun to sink, within a hundredth.
    weight = jacobian(model, data, body="payload").T @ [0, 0, MASS * G]
    np.testing.assert_allclose(bias[MASS] - bias[0.0], weight, atol=0.01 * weight.max())
    np.testing.assert_allclose(still[MASS] - still[0.0], weight, rtol=1e-9, atol=1e-9)
    assert weight.max() > 10


def test_a_wearer_bears_what_he_has_picked_up():
    """After five seconds the slow correction holds the load: m g r more than before, within 1 %."""
    env = ArmEnv(PICK_UP, **BARE)
    env.reset(seed=0)
    before, after = (go_on(env, n)[-1]["human_torque"] for n in (PICKED, PUT_DOWN - PICKED))
    load = env.data.body("payload").xipos
    shoulder = env.data.joint("shoulder_flexion").xanchor
    arm = load[0] - shoulder[0]  # forward
    assert arm > 0.3
    more = after - before
    assert more[JOINTS.index("shoulder_flexion")] == pytest.approx(MASS * G * arm, rel=0.01)
    go_on(env, 40)
    assert state(env).load[0] == 0
    loaded = ArmEnv(PICK_UP, payload={"mass": 0.5}, **BARE)
    loaded.reset(seed=0)
    assert set(state(loaded).carried[0]) == {0.5, 0.5 + MASS}  # the payload stays in the hand


@pytest.mark.parametrize("options", ARMS.values(), ids=ARMS)
def test_a_push_acts_as_a_force_on_the_grip(options):
    env = ArmEnv(replace(TASKS["Handrail"], duration=1.5, wait=AT_ONCE), **options)
    env.reset(seed=1)
    go_on(env, 100)
    model, data = env.model, env.data
    push = state(env).push[0, 99]  # of the last control period
    assert np.linalg.norm(push) > 10
    pushes = addresses(env).pushes
    np.testing.assert_array_equal(data.ctrl[pushes], push)
    torque = []
    for force in (push, np.zeros(3)):
        data.ctrl[pushes] = force
        mujoco.mj_forward(model, data)
        torque.append(data.qfrc_actuator.copy())
    outward = 1 if options.get("side") == "left" else -1
    turn = data.body("torso").xmat.reshape(3, 3)
    site = "hand_grip" if options.get("coupling") == "none" else "attachment_ring"
    expected = jacobian(model, data, site=site).T @ turn @ (push * [1, outward, 1])
    np.testing.assert_allclose(torque[0] - torque[1], expected, rtol=1e-9, atol=1e-10)
    on_arm = np.abs(expected[addresses(env).joints]).max()
    on_ring = np.abs(expected[addresses(env).exo_joints]).max()
    assert on_ring > 1
    assert (on_arm == 0) == (options.get("coupling") == "cuffs")


@pytest.mark.parametrize(
    ("side", "coupling"), [("right", "rigid"), ("left", "cuffs"), ("left", "none")]
)
def test_a_ratchet_never_drives(coupling, side):
    limit = 25.0
    task = Ratchet(name="Ratchet", duration=1.6, reaction=limit, wait=AT_ONCE)
    # A control period is one step of the physics.
    env = ArmEnv(task, coupling=coupling, side=side, control_dt=0.002, sim_dt=0.002)
    assert env.episodes.simulation.substeps == 1
    env.reset(seed=0)
    reported, motors = [], np.zeros(env.action_space.shape)
    number = env.model.actuator("ratchet").id
    site = "hand_grip" if coupling == "none" else "attachment_ring"
    for _ in range(800):
        env.step(motors)
        data = env.data
        mujoco.mj_forward(env.model, data)
        point = jacobian(env.model, data, site=site)
        forward = data.site(site).xmat.reshape(3, 3)[:, 0]
        speed = forward @ point @ data.qvel
        reported.append((data.actuator_force[number], speed))
    force, speed = np.array(reported).T
    assert (force * speed <= 0).all()
    assert (force[speed < 0] == 0).all()  # on the way back, which is free
    assert (speed < -0.1).sum() > 100
    assert force.min() == pytest.approx(-limit)  # a quick stroke meets the limit, and not more
    assert force.max() == 0


def blow(model, push):
    """Lets a hammer that is pushed along the anvil's normal fly into it; nothing else acts on it.

    Returns speed of the head along the normal [m/s] and kinetic energy [J], before and after.
    """
    disable = mujoco.mjtDisableBit
    off = (
        *(disable.mjDSBL_GRAVITY, disable.mjDSBL_ACTUATION, disable.mjDSBL_SPRING),
        *(disable.mjDSBL_DAMPER, disable.mjDSBL_LIMIT, disable.mjDSBL_FRICTIONLOSS),
    )
    model.opt.disableflags = sum(int(flag) for flag in off)
    data = mujoco.MjData(model)
    head, anvil = (model.geom(name).id for name in ("hammer_head", "anvil"))
    for share in np.linspace(0, 0.3, 1001):  # just before it meets
        data.qpos[:4] = IMPACT - share * (IMPACT - RAISED)
        mujoco.mj_forward(model, data)
        if mujoco.mj_geomDistance(model, data, head, anvil, 1.0, None) > 0.002:
            break
    normal = data.geom_xmat[anvil].reshape(3, 3)[:, 2]

    def state():
        point = np.zeros((3, model.nv))
        body = model.geom_bodyid[head]
        mujoco.mj_forward(model, data)
        mujoco.mj_jac(model, data, point, None, data.geom_xpos[head], body)
        inertia = mass_matrix(model, data)
        along = normal @ point
        return along, inertia, along @ data.qvel, 0.5 * data.qvel @ inertia @ data.qvel

    along, inertia, *_ = state()
    # A blow along the normal alone: all of the energy is in it.
    response = np.linalg.solve(inertia, along)
    data.qvel[:] = -push * response / (along @ response)
    met, reported = False, [state()[2:]]
    for _ in range(200):
        before = state()[2:]
        mujoco.mj_step(model, data)
        if data.ncon and not met:
            met, reported = True, [before]
        if met and not data.ncon:
            return (*reported, state()[2:])
    raise AssertionError(f"the hammer did not {'leave' if met else 'meet'} the anvil")


@pytest.mark.parametrize(("rebound", "mass"), [(0.2, 1.0), (0.7, 0.6)])
def test_a_hammer_leaves_the_anvil_with_its_share_of_the_speed(rebound, mass):
    """The closed form is of continuous time, and the usual step an eighth of the contact.

    So the share is exact to 0.01 with a quarter of that step, and to 0.04 with it.
    """
    task = Hammer(name="Hammer", rebound=rebound, mass=mass)
    model = compose(ArmConfig(**BARE), drawn=False, edits=task.edits)
    for step, error in ((model.opt.timestep, 0.04), (0.0005, 0.01)):
        model.opt.timestep = step
        (before, energy), (after, left) = blow(model, 2.0)
        assert before == pytest.approx(-2.0, rel=0.05)
        assert -after / before == pytest.approx(rebound, abs=error)
        assert np.sqrt(left / energy) == pytest.approx(rebound, abs=error)


@pytest.mark.parametrize("side", ["right", "left"])
def test_the_hammers_head_meets_the_middle_of_the_anvil(side):
    model = compose(ArmConfig(side=side, **BARE), edits=TASKS["Hammer"].edits)
    data = mujoco.MjData(model)
    data.qpos[:4] = IMPACT
    mujoco.mj_kinematics(model, data)
    anvil = data.geom("anvil")
    away = data.geom("hammer_head").xpos - anvil.xpos
    thick = model.geom("anvil").size[2] + model.geom("hammer_head").size[0]
    np.testing.assert_allclose(away @ anvil.xmat.reshape(3, 3), [0, 0, thick - THROUGH], atol=1e-9)
    handle = data.geom("hammer_head").xpos - data.site("hand_grip").xpos
    assert np.linalg.norm(handle) == pytest.approx(HANDLE)


@pytest.mark.parametrize("reference", ["unsuited", "suited"])
def test_both_references_bear_the_reaction_of_a_tool(reference):
    torque = []
    for pull in ((0.0, 0.0), (40.0, 40.0)):
        task = replace(TASKS["Handrail"], duration=4.0, pull=pull, wait=AT_ONCE)
        env = ArmEnv(task, **reference_options(reference, {}))
        env.reset(seed=0)
        torque.append([env.step(np.zeros(0))[-1]["human_torque"] for _ in range(150)])
    assert np.abs(np.subtract(*torque)).mean() > 2  # N·m


@pytest.mark.parametrize("name", ["Scoop", "Handrail"])
def test_randomize_load_multiplies_masses_and_pushes(name):
    task = replace(TASKS[name], duration=1.0, wait=AT_ONCE)
    plain, drawn = (ArmEnv(task, coupling="none", randomize={"load": share}) for share in (0, 0.5))
    factors = []
    for seed in range(12):
        loads = []
        for env in (plain, drawn):
            env.reset(seed=seed)
            own = state(env).push if name == "Handrail" else state(env).carried
            loads.append(own[0].copy())
            angle = state(env).angle[0].copy()
        np.testing.assert_array_equal(angle, state(plain).angle[0])  # the motion is the same
        there = loads[0] != 0
        ratio = loads[1][there] / loads[0][there]
        np.testing.assert_allclose(ratio, ratio[0], rtol=1e-12)
        np.testing.assert_array_equal(loads[1][~there], 0.0)
        factors.append(ratio[0])
    assert 0.5 <= min(factors) < 0.8 and 1.2 < max(factors) <= 1.5
