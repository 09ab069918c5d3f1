"""The arm of the live viewer: its policy, task, suit and place change while it moves."""

import itertools
from types import SimpleNamespace

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.scripts.arm_options import USUAL
from activesuit.scripts.live import TAIL, panel
from activesuit.scripts.runs import scene
from activesuit.scripts.stage import Stage
from helpers import shorten_tasks


@pytest.fixture
def stage(monkeypatch):
    shorten_tasks(monkeypatch, 1.0)
    chosen = scene(USUAL, env="ActiveSuit/ElbowFlexion-v0", gravity="moon", policies=("none",))
    made = Stage(chosen, seed=3)
    yield made
    made.env.close()


def advance(motion, steps):
    return list(itertools.islice(motion, steps))[-1]


def test_what_is_offered(stage):
    choices = stage.live.choices
    assert choices["policy"] == ["none", "feedforward", "compensation", "adaptive"]
    assert stage.live.chosen == {
        "policy": "none",
        "task": "ElbowFlexion",
        "suit": "mock-suit",
        "place": "moon",
    }
    assert {"ArmTracking", "OverheadHold"} < {*choices["task"]}
    assert {"emu-like"} < {*choices["suit"]}


def test_another_policy_is_a_branch_of_the_same_motion(stage):
    motion = stage.motion()
    env = advance(motion, 41)
    assert np.abs([one.motor for one in stage.live.samples]).max() < 1e-12
    assert len(stage.live.samples) == 40
    stage.live.chosen["policy"] = "compensation"
    assert advance(motion, 20) is env
    times = [one.time for one in stage.live.samples]
    np.testing.assert_allclose(np.diff(times), 0.01, atol=1e-9)  # nothing began again
    assert np.abs([one.motor for one in stage.live.samples][-10:]).max() > 1


@pytest.mark.parametrize(
    ("kind", "name"), [("suit", "emu-like"), ("place", "earth"), ("task", "ArmTracking")]
)
def test_another_suit_place_or_task_begins_a_new_motion(stage, kind, name):
    motion = stage.motion()
    before = advance(motion, 30)
    stage.live.chosen[kind] = name
    after = advance(motion, 2)
    assert after is not before
    assert len(stage.live.samples) <= 1
    config = after.config
    assert {"suit": config.suit, "place": config.gravity, "task": name}[kind] == name


def test_a_pause_and_the_next_motion(stage):
    motion = stage.motion()
    advance(motion, 30)
    stage.live.paused = True
    advance(motion, 10)
    assert len(stage.live.samples) == 29
    stage.live.paused = False
    stage.live.restarted += 1
    advance(motion, 2)
    assert len(stage.live.samples) <= 1
    assert stage.live.status.startswith("motion 4")


def test_motions_go_on_without_end_and_the_panel_keeps_a_tail(stage):
    advance(stage.motion(), 350)
    assert "motion 6" in stage.live.status
    assert len(stage.live.samples) <= TAIL


def test_a_choice_that_cannot_be_is_said_and_nothing_changes(stage):
    motion = stage.motion()
    before = advance(motion, 10)
    stage.live.chosen["suit"] = "nothing-like-it"
    assert advance(motion, 2) is before
    assert "nothing-like-it" in stage.live.note
    assert stage.live.chosen["suit"] == "mock-suit"
    assert len(stage.live.samples) == 11


def test_a_policy_that_cannot_act_is_refused():
    chosen = scene(USUAL, env="ActiveSuit/ElbowFlexion-v0", policies=("compensation:suit=nowhere",))
    with pytest.raises(InputError, match="nowhere"):
        Stage(chosen, seed=0)


def test_muscles_move_with_the_arm_and_reach_the_viewer(monkeypatch):
    pytest.importorskip("myo_sim")
    messages = pytest.importorskip("mujoco.studio.messages")
    shorten_tasks(monkeypatch, 1.0)
    chosen = scene(USUAL, env="ActiveSuit/ElbowFlexion-v0", policies=("none",))
    stage = Stage(chosen, seed=0, draw="muscles")
    motion = stage.motion()
    advance(motion, 3)
    assert stage.live.beside == []
    advance(motion, 10)
    before = stage.live.beside
    advance(motion, 10)
    assert len(before) > 32 and before[-1].end.tolist() != stage.live.beside[-1].end.tolist()
    shown = panel(stage.live)
    shown.viewer = SimpleNamespace(extra_geoms=["of before"])
    shown.on_update(messages.UpdateEvent())
    colors = [geom.rgba for geom in shown.viewer.extra_geoms]
    np.testing.assert_allclose(colors, [one.color for one in stage.live.beside], atol=1e-6)
    # A wearer who tires has no muscles: the choice is taken back, and why is said.
    stage.live.chosen["task"] = "OverheadHold"
    advance(motion, 2)
    assert "does not tire" in stage.live.note and stage.live.chosen["task"] == "ElbowFlexion"
    stage.env.close()
