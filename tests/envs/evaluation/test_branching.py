"""Branches of one motion: they share its past, and what each policy remembers of it is right."""

import sys
import types

import numpy as np
import pytest
from activesuit.envs.evaluation import rollout
from activesuit.envs.evaluation.branching import SERIES, branch
from activesuit.envs.making import make_arms
from activesuit.envs.policies import make_policy
from activesuit.errors import InputError
from helpers import shorten_tasks

ENV = "ActiveSuit/ArmTracking-v0"
OPTIONS = {"suit": "emu-like", "gravity": "microgravity", "threads": 1}
AT = 0.6, 1.0
POLICIES = "feedforward", "none", "oracle"


@pytest.fixture(scope="module", autouse=True)
def short():
    with pytest.MonkeyPatch.context() as patch:
        shorten_tasks(patch, 2.0)
        yield


@pytest.fixture(scope="module")
def forks(short):
    return branch(ENV, POLICIES, at=AT, seed=3, **OPTIONS)


@pytest.fixture(scope="module")
def whole(short):
    """The motion under the base policy, which nobody interrupts."""
    arms = make_arms(ENV, 1, **OPTIONS, control={"adaptation": 0.0})
    (trace,) = rollout(arms, make_policy("feedforward", arms), [3])
    arms.close()
    return trace


def test_branches_share_the_past_bit_for_bit(forks, whole):
    for fork, at in zip(forks, AT, strict=True):
        periods = round(100 * at)
        assert fork.at == pytest.approx(at)
        for name in ("time", *SERIES):
            np.testing.assert_array_equal(
                getattr(fork.past, name), getattr(whole, name)[:periods], err_msg=name
            )
        for future in fork.futures.values():
            assert len(future.time) == 100
            np.testing.assert_array_equal(future.time, whole.time[periods : periods + 100])
            target = whole.target_angle[periods : periods + 100]
            np.testing.assert_array_equal(future.target_angle, target)


def test_the_base_policy_goes_on_as_if_nothing_had_happened(forks, whole):
    for fork in forks:
        begin = round(100 * fork.at)
        for name in SERIES:
            np.testing.assert_array_equal(
                getattr(fork.futures["feedforward"], name),
                getattr(whole, name)[begin : begin + 100],
                err_msg=name,
            )


def test_a_branch_does_not_hang_on_the_others(forks):
    (alone,) = branch(ENV, ["oracle"], at=AT[1:], seed=3, **OPTIONS)
    for name in SERIES:
        one, other = (fork.futures["oracle"] for fork in (alone, forks[1]))
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_a_policy_has_watched_the_past(monkeypatch):
    watched = []

    class Watching:
        sensors = ("encoders",)

        def __init__(self, arms):
            self.shape = (1, 2)

        def reset(self):
            watched.clear()

        def act(self, observation):
            watched.append(observation.copy())
            return np.full(self.shape, -0.2)

    module = types.ModuleType("watching")
    vars(module)["Watching"] = Watching
    monkeypatch.setitem(sys.modules, "watching", module)
    branch(ENV, ["watching:Watching"], base="none", at=[0.5], horizon=0.2, **OPTIONS)
    assert len(watched) == 50 + 20
    reported = np.array(watched)[:51, 0, -2:]
    assert (reported == 0).all()  # the last action: what it answered to the past did not count
    assert (np.array(watched)[51:, 0, -2:] == np.float32(-0.2)).all()


def test_regret_is_effort_above_the_clairvoyant(forks):
    for fork in forks:
        assert set(fork.futures) == {*POLICIES, "best-known-plan"}
        assert fork.regret("best-known-plan") == 0
        assert fork.regret("none") > fork.regret("oracle") > 0
        effort = np.sqrt(np.mean(fork.futures["none"].effort ** 2))
        assert fork.futures["none"].mean_effort == pytest.approx(effort)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"at": [0.0]}, "begins at 0 s: begin at 0.01 to 1 s, as the motion takes 2 s"),
        ({"at": [1.5]}, "begins at 1.5 s"),
        ({"horizon": 0.0}, "horizon is 0 s: give at least 0.01 s"),
        ({"at": [float("nan")]}, "at is nan"),
        ({"at": []}, "no branch point"),
        ({"base": "magic"}, "unknown policy 'magic'"),
        ({"seed": -1}, "seed is -1"),
    ],
)
def test_branches_that_cannot_be(options, message):
    with pytest.raises(InputError, match=message):
        branch(ENV, ["none"], **{"at": [0.5], **options}, **OPTIONS)
