"""Compensation at the arm's angles, which the cuffs' forces tell."""

import numpy as np
from activesuit.envs.evaluation.rollout import rollout
from activesuit.envs.making import make_arms
from activesuit.envs.plant import Plant
from activesuit.envs.policies import make_policy, needed_options
from activesuit.envs.policies.corrected import CorrectedCompensation
from shown import made

SEEDS = [3, 4]


def test_springs_tell_how_the_arm_is_turned():
    policy, _ = made("corrected", coupling="cuffs", suit="none")
    rng = np.random.default_rng(5)
    angle, turn = rng.uniform(0.2, 1.2, (6, 4)), rng.uniform(-0.1, 0.1, (6, 4))
    spring = policy._stiffness[:, None] * policy._levers(angle)
    seen = {"angle": angle, "cuff_force": -np.einsum("nfj,nj->nf", spring, turn)}
    policy._elastic.begin(seen["cuff_force"])
    np.testing.assert_allclose(policy.turn(seen), turn, atol=2e-3)
    seen["cuff_force"] *= 0  # the dampers tell of it at once, the springs later
    assert 0.5 < np.abs(policy.turn(seen)).sum() / np.abs(turn).sum() < 1


def test_the_corrected_angles_are_those_of_the_arm():
    angles = []

    class Watched(CorrectedCompensation):
        def turn(self, seen):
            found = super().turn(seen)
            angles.append([seen["angle"], seen["angle"] + found])
            return found

    arms = make_arms(
        "ActiveSuit/ArmTracking-v0",
        len(SEEDS),
        **{"coupling": "cuffs", "suit": "emu-like", "gravity": "microgravity"},
        **needed_options("corrected"),
    )
    policy = Watched(Plant.of(arms.episodes))
    true = np.array([trace.angle for trace in rollout(arms, policy, SEEDS)]).swapaxes(0, 1)
    # The first one begins the memory; what is seen in a period is of the end of the one before.
    seen = np.array(angles)[2:].swapaxes(0, 1)
    encoders, corrected = np.sqrt(np.mean((seen - true[:-1]) ** 2, axis=(1, 2)))[:, 1:3]
    assert (encoders > 0.04).all()
    assert (corrected < encoders / 4).all()


def test_it_needs_cuffs():
    assert needed_options("corrected")["sensors"] == ("encoders", "cuffs")
    _, env = made("corrected", coupling="cuffs")
    assert isinstance(make_policy("corrected:lead=0.02", env), CorrectedCompensation)
