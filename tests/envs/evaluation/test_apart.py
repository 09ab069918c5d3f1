"""A user's policy carries nothing into another rollout, in whatever way it tries."""

import shutil
import sys

import own_policies
import pytest
from activesuit.envs.evaluation import FIRST_SEED, evaluate
from activesuit.envs.evaluation.run import FIRST_DRAWN, run
from activesuit.envs.evaluation.wearers import Wearers
from activesuit.envs.plant import Plant
from activesuit.envs.policies import policy_spec
from helpers import assert_refused
from own_policies import FOLDER, ByClass, ByFile, ByMemory, ByModule, Ends, Honest, Practices, Push

ELBOW, SEEDS = "ActiveSuit/ElbowFlexion-v0", range(70_000, 70_002)
SHORT = {"max_episode_steps": 100, "gravity": "microgravity", "threads": 1}
CHEATS = ("ByClass", "ByModule", "ByFile", "ByOpenFile", "ByPipe", "ByName")


@pytest.fixture(autouse=True)
def forgotten():
    shutil.rmtree(FOLDER, ignore_errors=True)
    own_policies.NOTES.clear()
    ByClass.notes.clear()
    yield
    shutil.rmtree(FOLDER, ignore_errors=True)


@pytest.fixture(scope="module")
def honest():
    return run("honest", Honest, ELBOW, SEEDS, **SHORT).score.effort


def test_the_process_changes_no_number(honest):
    shipped = run("shipped", policy_spec("compensation"), ELBOW, SEEDS, **SHORT).score.effort
    assert honest == pytest.approx(shipped, rel=1e-9)


@pytest.mark.parametrize("name", CHEATS)
def test_who_rehearses_scores_like_the_honest_twin(name, honest):
    found = run(name, getattr(own_policies, name), ELBOW, SEEDS, **SHORT).score.effort
    assert found == honest


@pytest.mark.parametrize("kind", [ByClass, ByModule, ByFile])
def test_in_one_process_a_rehearsal_would_pay(kind, honest):
    wearers = Wearers(ELBOW, len(SEEDS), **SHORT)
    plant = Plant.of(wearers.arms.episodes)
    traces = wearers.adapted(lambda: kind(plant), SEEDS)
    wearers.close()
    efforts = [float((one.effort**2).mean() ** 0.5) for one in traces]
    assert efforts != pytest.approx(honest, rel=1e-3)


def test_practice_is_on_other_motions_one_arm_each_and_kept():
    options = {**SHORT, "adapted": False}
    practiced = run("mine", Practices, ELBOW, SEEDS, **options).traces
    # Three rollouts of practice; then each motion gets a copy that has practiced.
    for one in practiced:
        assert one.assist_torque[-1] / one.peak_torque == pytest.approx([0.04, 0.04], rel=0.05)


def test_a_user_sees_what_went_wrong():
    def failing(plant):
        raise KeyError("gain")

    locked = sys.stdout
    rows = [
        (ByMemory, r"cannot be made \(PermissionError: .*may map files for reading alone"),
        (Ends, "the process of policy 'mine' ended before its rollout"),
        (failing, r"policy 'mine' cannot be made \(KeyError"),
        (lambda plant: locked, "policy 'mine' cannot be sent to a process of its own"),
    ]
    assert_refused(lambda given: run("mine", given, ELBOW, SEEDS, **SHORT), rows)


def test_a_policy_of_the_user_is_scored_on_seeds_that_are_drawn_late():
    few = {"motions": 1, "references": False, "adapted": False, **SHORT}
    known = evaluate(ELBOW, ["none"], **few)
    assert (known.first_seed, known.drawn) == (FIRST_SEED, False)
    assert not any("drawn after" in one for one in known.sentences())
    one, other = (evaluate(ELBOW, {"mine": Push}, **few) for _ in range(2))
    assert one.drawn and FIRST_DRAWN <= one.first_seed != other.first_seed
    assert f"seed {one.first_seed} repeats them" in " ".join(one.sentences())
    again = evaluate(ELBOW, {"mine": Push}, seed=one.first_seed, **few)
    assert not again.drawn and again.scores["mine"].effort == one.scores["mine"].effort
    assert again.first_seed == one.first_seed


def test_the_same_motion_counts_once():
    few = {"motions": 9, "references": False, "adapted": False, "threads": 1}
    found = evaluate("ActiveSuit/RangeOfMotion-v0", ["none"], **few, max_episode_steps=20)
    score = found.scores["none"]
    assert score.distinct == len({*score.motion}) <= 9
    assert all(score.motion[one] == one for one in score.motion)
