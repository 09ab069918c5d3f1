"""Force amplification: its filter, and the loop that its rule keeps stable."""

import math

import numpy as np
import pytest
from activesuit.envs.policies import make_policy
from activesuit.envs.policies.amplification import greatest_amplification
from activesuit.envs.policies.filters import LowPass
from activesuit.errors import InputError
from shown import asked, made


def test_it_adds_the_filtered_torque_of_the_person():
    policy, env = made("amplification:alpha=2.5,cutoff=1", gravity="microgravity")
    asked(policy, env)
    for period in range(1, 40):
        torque = asked(policy, env, interaction_torque=[0, 2, -1, 0])
        grown = 1.5 * (1 - math.exp(-math.tau * 0.01 * period))
        np.testing.assert_allclose(torque, grown * np.array([2, -1]), rtol=1e-5)


@pytest.mark.parametrize("cutoff", [0.5, 1.0, 2.0])
def test_the_greatest_amplification_is_stable_with_a_margin_of_two(cutoff):
    gain = greatest_amplification(cutoff) - 1
    assert swing(gain, cutoff) < 1e-3
    assert swing(3 * gain, cutoff) > 1


def swing(gain, cutoff):
    """Returns the last swing of a load of 1 N·m that a led person and the motors share."""
    low = LowPass(cutoff, 0.01)
    low.begin(np.zeros(1))
    reported, motor, person = [0.0] * 5, 0.0, []
    for _ in range(1000):
        person.append(1 - motor)
        reported.append(person[-1])
        command = gain * low.step(np.array([reported.pop(0)]))[0]
        motor += (1 - math.exp(-0.01 / 0.016)) * (command - motor)
    return np.ptp(person[-100:])


@pytest.mark.parametrize(
    ("option", "message"),
    [("alpha=4", "alpha is 4.0: use a number from 1 to 2.8"), ("cutoff=9", "from 0.1 to 5 Hz")],
)
def test_options_out_of_range(option, message):
    _, env = made("amplification")
    with pytest.raises(InputError, match=message):
        make_policy(f"amplification:{option}", env)
