"""What policies believe: the suite 'belief', and the inertia against MuJoCo and energy."""

import numpy as np
import pytest
from activesuit.assets import Suit, SuitJoint
from activesuit.envs import ArmEnv
from activesuit.envs.plant import Plant
from activesuit.envs.policies import make_policy
from activesuit.hysteresis import Viscoelastic
from arms import mass_matrix, posed

SENSORS = ["encoders", "belief"]
WEIGHTLESS = {"sensors": [*SENSORS, "privileged"], "gravity": "microgravity"}


@pytest.mark.parametrize("believed", [{}, {"suit": "emu-like", "payload": {"mass": 2.0}}])
def test_it_is_what_the_policies_of_that_belief_command(believed):
    env, other = ArmEnv(sensors=SENSORS, belief=believed), ArmEnv(**believed)
    suit = make_policy({"name": "feedforward", "suit": believed.get("suit")}, env)
    weight = make_policy("gravity", other)
    peak = env.episodes.simulation.addresses.peak_torque
    observation, _ = env.reset(seed=2)
    for _ in range(60):
        shown = observation[env.layout["belief"]]
        np.testing.assert_allclose(shown[:2], suit.act(observation) * peak, rtol=1e-5, atol=1e-4)
        # The belief is of the angles 0.02 s later.
        turned = 0.02 * np.abs(observation[env.layout["rate"]]).max()
        static = weight.act(observation[:12]) * peak
        assert np.abs(shown[2:] - static).max() < 1e-3 + 60 * turned
        observation, *_ = env.step(suit.act(observation))
    assert np.abs(shown).min() > 0.01


def test_it_does_not_depend_on_what_is_drawn():
    drawn = ArmEnv(**WEIGHTLESS, randomize={"pressure": 0.5})
    nominal = make_policy("feedforward", ArmEnv(**WEIGHTLESS))
    errors = []
    for seed in range(4):
        observation, _ = drawn.reset(seed=seed)
        nominal.reset()
        believed = observation[drawn.layout["belief"]][:2]
        peak = drawn.episodes.simulation.addresses.peak_torque
        np.testing.assert_allclose(believed, nominal.act(observation) * peak, rtol=1e-5)
        true = -observation[drawn.layout["suit_torque"]][[1, 2]]
        errors.append(np.abs(believed - true).max() / np.abs(believed).max())
    assert max(errors) > 0.1


@pytest.fixture
def viscous_suit(elbow):
    joint = Viscoelastic(model=elbow, damping=0.5, relaxation_stiffness=4, relaxation_time=0.3)
    fields = {"range": (0.52, 1.57), "start_angle": 0.52, "grade": "assumed", "source": "a test"}
    joints = {"elbow_flexion": SuitJoint.from_model(joint, **fields)}
    return Suit(name="viscous", description="A test.", joints=joints)


def test_it_follows_what_depends_on_the_rate(viscous_suit):
    slow = viscous_suit.joints["elbow_flexion"]
    slow = slow.model_copy(update={"model": slow.model.model})
    beliefs = viscous_suit, viscous_suit.model_copy(update={"joints": {"elbow_flexion": slow}})
    errors = []
    for believed in beliefs:
        env = ArmEnv(suit=viscous_suit, belief={"suit": believed}, **WEIGHTLESS)
        observation, _ = env.reset(seed=3)
        wrong = []
        for _ in range(300):
            shown = observation[env.layout["belief"]][1]
            wrong.append(shown + observation[env.layout["suit_torque"]][2])
            observation, *_ = env.step(np.zeros(2))
        errors.append(np.sqrt(np.mean(np.square(wrong[20:]))))
    assert errors[0] < 0.25 * errors[1]  # the rest is the 0.02 s by which it looks ahead


POSES = np.random.default_rng(0).uniform(-1, 2, (6, 4))
RATES = np.random.default_rng(1).normal(size=(6, 4))


@pytest.fixture(scope="module")
def arm():
    return Plant.of(ArmEnv().episodes).believed()


def test_it_is_the_mass_matrix_of_the_model(arm):
    model = arm.model()
    for pose, found in zip(POSES, arm.inertia()(POSES), strict=True):
        np.testing.assert_allclose(found, mass_matrix(model, posed(model, pose)), atol=1e-12)


def test_motion_changes_momentum_by_the_slope_of_the_energy(arm):
    inertia, step = arm.inertia(), 1e-5
    _, gyration = inertia.momentum(POSES, RATES)
    for place, joint in enumerate((1, 2)):
        away = step * np.eye(4)[joint]
        more, less = (
            np.einsum("ni,nij,nj->n", RATES, inertia(POSES + way * away), RATES) / 2
            for way in (1, -1)
        )
        np.testing.assert_allclose(gyration[:, place], (more - less) / (2 * step), atol=1e-8)


def test_what_is_carried_and_cuffs(arm):
    whole, carried = arm.inertia(), arm.carried_inertia()
    exo = arm.exo_inertia()
    assert (0 < exo.nominal()).all()
    assert (exo.nominal() < carried.nominal()).all()
    assert (carried.nominal() < whole.nominal()).all()
    cuffs = Plant.of(ArmEnv(coupling="cuffs").episodes).believed()
    np.testing.assert_allclose(cuffs.inertia()(POSES), whole(POSES), atol=1e-9)
