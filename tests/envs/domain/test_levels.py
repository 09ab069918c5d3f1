"""Levels: options by a name, which given ones replace; the same seed gives the same episodes."""

from itertools import product

import numpy as np
import pytest
from activesuit.envs import ArmEnv
from activesuit.envs.domain.levels import LEVELS, with_level
from activesuit.envs.domain.randomization import Randomization
from activesuit.envs.evaluation.run import reference_options
from arms import assert_same_states


def play(env, seed, periods=20):
    """Returns the states of two episodes after some control periods."""
    states = []
    for given in (seed, None):
        env.reset(seed=given)
        for _ in range(periods):
            env.step(np.full(env.action_space.shape, 0.1))
        states.append(env.get_state())
    return states


def assert_same(states, others):
    for state, other in zip(states, others, strict=True):
        assert_same_states(state, other)


@pytest.mark.parametrize("level", LEVELS)
def test_a_level_is_its_options_and_the_same_seed_the_same_episodes(level):
    named = ArmEnv(coupling="cuffs", level=level)
    found = play(named, 4)
    assert_same(found, play(named, 4))  # another episode came before
    options = with_level({"coupling": "cuffs", "level": level})
    assert "level" not in options
    assert_same(found, play(ArmEnv(**options), 4))
    assert not np.array_equal(found[0]["physics"], play(named, 5)[0]["physics"])


def test_levels_differ_and_nominal_is_the_default():
    states = {level: play(ArmEnv(level=level), 1) for level in LEVELS}
    assert_same(states["nominal"], play(ArmEnv(), 1))
    one, other = (states[level][0]["physics"] for level in ("nominal", "randomized"))
    assert one.shape == other.shape and not np.array_equal(one, other)
    for level in ("randomized", "shift", "faults"):  # the motion is the same at each
        np.testing.assert_array_equal(states["nominal"][0]["angle"], states[level][0]["angle"])


def test_options_that_are_given_win():
    shift = LEVELS["shift"]
    assert with_level({"level": "shift", "gravity": "moon"}) == {**shift, "gravity": "moon"}
    assert ArmEnv(level="shift", gravity="moon").config.gravity == "moon"
    rows = [({}, shift["pressure"]), ({"suit": "mock-suit"}, None)]  # the pressure is of the suit
    for given, pressure in [*rows, ({"suit": "emu-like", "pressure": 30.0}, 30.0)]:
        config = ArmEnv(level="shift", **given).config
        assert (config.suit, config.pressure) == (given.get("suit", shift["suit"]), pressure)


def test_terms_are_replaced_one_by_one():
    usual = {k: v for k, v in LEVELS["randomized"]["randomize"].items() if k != "misalignment"}
    own = {"pressure": 0.0, "gravity": ["moon", "mars"]}
    found = with_level({"level": "randomized", "randomize": own})["randomize"]
    assert found == {**usual, **own}
    env = ArmEnv(level="randomized", randomize=own)
    assert env.episodes.setup.randomize == Randomization(**usual | own)
    # A Randomization says all of its terms.
    whole = Randomization(load=0.1)
    found = with_level({"level": "randomized", "randomize": whole})["randomize"]
    assert Randomization(**found) == whole
    assert LEVELS["randomized"]["randomize"].keys() > usual.keys()  # nothing has changed there
    assert with_level({"level": "nominal", "randomize": own}) == {"randomize": own}


@pytest.mark.parametrize("level", LEVELS)
def test_what_a_level_says_of_what_is_not_there_does_not_count(level):
    for coupling, suit in product(("rigid", "cuffs", "none"), ("none", "mock-suit")):
        options = with_level({"level": level, "coupling": coupling, "suit": suit})
        terms = options.get("randomize", {})
        assert options["suit"] == suit
        if coupling != "cuffs":
            assert "misalignment" not in terms
        if suit == "none":
            assert "pressure" not in terms
            assert not options.keys() & {"pressure", "preconditioned"}
        ArmEnv(**options).reset(seed=0)  # no check refuses it


@pytest.mark.parametrize(
    ("level", "reference"),
    [("shift", "suited"), ("randomized", "suited"), ("randomized", "unsuited")],
)
def test_references_are_of_the_same_wearers_places_and_motions(level, reference):
    given = {"level": level, "coupling": "cuffs"}
    exo, other = ArmEnv(**given), ArmEnv(**reference_options(reference, given))
    assert not other.action_space.shape[0]
    assert (other.config.suit == "none") == (reference == "unsuited")
    for field in ("gravity", "wearer", "side", "tilt"):
        assert getattr(other.config, field) == getattr(exo.config, field)
    met = set()
    for seed in range(5):
        exo.reset(seed=seed)
        other.reset(seed=seed)
        one, two = exo.get_state(), other.get_state()
        for name in ("angle", "wearer", "load", "free_fall"):
            np.testing.assert_array_equal(one[name], two[name], name)
        met.add(int(one["wearer"][0]))
    assert (len(met) > 1) == (level == "randomized")
