"""Models behind play: where contact opens, and that no motion gets energy."""

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.hysteresis import Asymmetric, Backlash, Clipped
from activesuit.hysteresis.around import backlash_kernels as kernels
from activesuit.hysteresis.protocol import follow
from helpers import sweep
from known_models import KNOWN

GAP = 0.05
RISING = (  # models whose torque rises with the angle, in the motions here
    *("J-A elbow-sa-pso", "elbow-sa-pso in a range", "asymmetric in a range", "bouc-wen, n = 1.7"),
    *("prandtl-ishlinskii stops", "hinged stops"),
)


@pytest.fixture
def joint(elbow):
    return Backlash(model=elbow, gap=GAP)


def test_contact_opens_at_no_torque_and_closes_on_the_other_face(joint):
    angle = sweep(0.52, 1.2, 0.52, samples=4001)
    torque = joint.response(angle)
    free = np.flatnonzero(np.abs(torque[4001:]) <= kernels.ZERO) + 4001
    assert free.size > 100
    assert np.all(np.diff(free) == 1)
    step = angle[1] - angle[0]
    assert angle[free[0]] - angle[free[-1]] == pytest.approx(GAP, abs=2 * step)
    assert torque[free[0] - 1] > 0 > torque[free[-1] + 1]


def test_in_contact_it_is_the_model_at_the_angle_of_the_suit(joint, elbow):
    loading = sweep(0.52, 1.2, samples=500)
    suit = np.maximum(loading - GAP / 2, 0.52)
    np.testing.assert_array_equal(joint.response(loading), elbow.response(suit))
    loaded = joint.response([0.8, 1.0, 0.9], 3.0)
    suit = np.array([0.8, 1.0, 0.9]) - GAP / 2
    np.testing.assert_allclose(loaded, elbow.response(suit, 3.0), rtol=1e-12)
    pulled = joint.response([0.8, 0.7], -3.0)
    np.testing.assert_allclose(pulled, elbow.response([0.8 + GAP / 2, 0.7 + GAP / 2], -3.0))


def test_a_motion_within_the_gap_meets_nothing(joint):
    torque = joint.response(0.8 + 0.49 * GAP * np.sin(np.arange(50)))
    np.testing.assert_array_equal(torque, 0.0)
    assert joint.tangent(joint.start(0.8), 1) == joint.tangent(joint.start(0.8), -1) == 0.0
    touching, _ = joint.step(joint.start(0.8), 0.8 + GAP)
    assert joint.tangent(touching, 1) > 0
    assert joint.energy(joint.start(0.8)).dissipated == 0


@pytest.mark.slow
def test_where_the_torque_falls_the_suit_snaps_across_and_gives_no_energy_either(elbow):
    rng, falling = np.random.default_rng(4), Asymmetric(model=elbow, polynomial=[8.0, -20.0, 4.0])
    snapped = 0
    for _ in range(200):
        joint = Backlash(model=falling, gap=rng.uniform(0.05, 0.4))
        turns = rng.uniform(-0.2, 1.6, rng.integers(2, 6))
        cycle = sweep(*turns, turns[0], samples=300)
        states = [follow(joint, joint.start(turns[0]), cycle[1:])]
        for angle in cycle[1:]:
            states.append(joint.step(states[-1], angle)[0])
        torques = np.array([state.torque for state in states])
        ends = np.array([state.memory[-1] for state in states])
        snapped += np.count_nonzero(np.abs(np.diff(ends)) > 0.04)
        gained = joint.energy(states[-1]).stored - joint.energy(states[0]).stored
        most = np.maximum(torques[1:] * np.diff(cycle), torques[:-1] * np.diff(cycle)).sum()
        assert most >= gained
    assert snapped > 20


def test_the_work_is_what_the_model_takes_and_closed_cycles_give_no_energy():
    rng = np.random.default_rng(1)
    for model in map(KNOWN.__getitem__, RISING):
        for _ in range(20):
            joint = Backlash(model=model, gap=rng.uniform(0.001, 0.4))
            turns = rng.uniform(0.0, 1.6, 4)
            angle = sweep(*turns, turns[0], samples=2000)
            first = last = joint.start(turns[0], 0.0)
            lost = 0.0
            for turn in (*turns[1:], turns[0]):
                last, _ = joint.step(last, turn)
                now = joint.energy(last).dissipated
                assert now >= lost - 5e-9  # the tolerance of a step, 1e-9 k Ms
                lost = now
            assert lost >= -1e-9
            change = np.subtract(joint.energy(last), joint.energy(first)).sum()
            work = np.trapezoid(joint.response(angle), angle)
            assert work == pytest.approx(change, abs=1e-5)


def test_the_certificate_is_that_of_what_the_suit_can_reach(elbow, shoulder):
    joint = Backlash(model=elbow, gap=0.2)
    assert joint.certificate() == elbow.certificate()
    wide = elbow.certificate((0.4, 1.6))
    assert joint.certificate((0.5, 1.5)).torque_bound == wide.torque_bound
    assert joint.certificate((0.5, 1.5)).angle_range == (0.5, 1.5)
    assert joint.free_parameters == 6
    kept = Clipped(model=shoulder, angle_range=(0.35, 1.22))
    far, near = kept.start(0.8, 30.0), kept.start(0.8, 0.0)
    behind = Backlash(model=kept, gap=0.0001)
    for state in (far, near):
        same = behind.start(0.8, state.torque)
        assert behind.start_is_certified(same) == kept.start_is_certified(state)


def test_a_pole_on_the_way_is_reported(shoulder):
    joint = Backlash(model=shoulder, gap=GAP)
    assert not joint.certificate().certified
    with pytest.raises(InputError, match="torque becomes infinite between"):
        joint.response(sweep(0.35, 3.0, -3.0, 3.0))
