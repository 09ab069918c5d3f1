"""Impedance: springs and dampers to the intention, and how they follow from the rule."""

import numpy as np
from activesuit.envs.plant import Plant
from activesuit.envs.simulation.simulation import PREVIEW
from shown import asked, made

PLACE = {"gravity": "microgravity", "suit": "none"}


def test_pull_of_springs_and_dampers():
    policy, env = made("impedance", **PLACE)
    np.testing.assert_allclose(
        asked(policy, env, target=[0.1, -0.05] * 3), policy.stiffness * [0.1, -0.05], rtol=1e-5
    )
    # Preview of a motion at 0.2 rad/s that is at 0 at the nearest time.
    moving = np.outer(np.array(PREVIEW) - PREVIEW[0], [0.2, 0.2]).ravel()
    pull = asked(policy, env, target=moving)
    np.testing.assert_allclose(pull, 0.2 * policy.damping, rtol=1e-4)


def test_springs_give_the_believed_arm_its_bandwidth():
    policy, env = made("impedance:bandwidth=1.5,damping_ratio=0.7")
    inertia = Plant.of(env.episodes).believed().inertia().nominal()
    pole = 2 * np.pi * 1.5
    np.testing.assert_allclose(policy.stiffness / inertia, pole**2)
    np.testing.assert_allclose(policy.damping / inertia, 2 * 0.7 * pole)
