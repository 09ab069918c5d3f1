"""Models with constant torque outside a range, and their certificates."""

import numpy as np
import pytest
from activesuit.hysteresis import Asymmetric, Clipped, UncertifiedModelError
from helpers import attached, sweep

RANGE = (0.35, 1.22)


@pytest.fixture
def kept(shoulder):
    return Clipped(model=shoulder, angle_range=RANGE)


def test_it_is_the_model_inside_and_constant_outside(kept, shoulder):
    inside = sweep(0.4, 1.2, 0.5, 1.1)
    np.testing.assert_array_equal(kept.response(inside), shoulder.response(inside))
    torque = kept.response([0.35, 1.22, 1.5, 2.0, 1.3, 1.22, 0.9])
    assert torque[1] == torque[2] == torque[3] == torque[4] == torque[5] > torque[6]
    assert kept.tangent(kept.start(2.0), 1) == kept.tangent(kept.start(2.0), -1) == 0
    assert kept.tangent(kept.start(1.22), 1) == 0
    assert kept.tangent(kept.start(1.22), -1) > 0


def test_the_published_shoulder_is_safe_in_its_range(kept, shoulder):
    assert not shoulder.certificate().certified
    certificate = kept.certificate()
    assert certificate.certified
    assert certificate.dissipative
    assert certificate.angle_range == (-np.inf, np.inf)
    torque = kept.response(np.random.default_rng(0).normal(0.8, 1.5, 8000))
    assert np.abs(torque).max() <= certificate.torque_bound


def test_the_engine_accepts_it(kept, shoulder):
    text = '<mujoco><worldbody><body><joint name="j"/><geom size=".1"/></body></worldbody></mujoco>'
    with pytest.raises(UncertifiedModelError):
        attached(text, "j", shoulder, start_angle=0.35)
    attached(text, "j", kept, start_angle=0.35)
    with pytest.raises(UncertifiedModelError, match="start of joint 'j'"):
        attached(text, "j", kept, start_angle=0.35, start_torque=9.0)


def test_a_polynomial_beside_it_changes_no_start(kept, shoulder):
    bent = Asymmetric(model=kept, polynomial=[3.0, -7.0])
    covered = []
    for torque in np.linspace(-60, 60, 25):
        start = kept.start(0.5, torque)
        same = bent.start(0.5, torque + float(bent.elastic(0.5)))
        covered.append(kept.start_is_certified(start))
        assert bent.start_is_certified(same) == covered[-1]
        lag = abs(torque - kept.anhysteretic(start))
        assert covered[-1] == (lag <= kept.certificate().memory_bound)
    assert 0 < sum(covered) < len(covered)
    alone = [shoulder.start_is_certified(shoulder.start(0.5, t)) for t in np.linspace(-60, 60, 25)]
    assert alone != covered  # the range has a bound of its own
