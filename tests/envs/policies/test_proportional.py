"""Proportional assist: a share of the EMG, and wearers who settle with it."""

import numpy as np
import pytest
from activesuit.envs.evaluation import evaluate
from activesuit.envs.policies import make_policy
from activesuit.errors import InputError
from shown import asked, made


def test_it_gives_a_share_beside_transparency():
    policy, env = made("proportional:gain=0.3")
    angle = [0, 0.5, 1, 0]
    own = asked(make_policy("transparent", env), env, angle=angle)
    found = asked(policy, env, angle=angle, emg=[9, 4, -2, 9])
    np.testing.assert_allclose(found - own, [1.2, -0.6], rtol=1e-4)


def test_more_gain_leaves_less_effort():
    names = [f"proportional:gain={gain}" for gain in (0, 0.25, 0.5)]
    found = evaluate("ActiveSuit/ElbowFlexion-v0", names, episodes=1, references=False).scores
    none, little, more = (found[name].effort[0] for name in found)
    assert more < 0.9 * little < 0.81 * none


def test_options_out_of_range():
    _, env = made("proportional")
    with pytest.raises(InputError, match=r"gain is 2.0: use a number from 0 to 1"):
        make_policy("proportional:gain=2", env)
