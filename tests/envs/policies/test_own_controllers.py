"""The controllers of docs/controllers.md, beside the shipped ones."""

import re
from pathlib import Path

import numpy as np
import pytest
from activesuit.envs.making import make_arms
from activesuit.envs.policies import make_policy

PAGE = Path(__file__).parents[3] / "docs" / "controllers.md"
BLOCKS = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(), re.DOTALL | re.MULTILINE)
(CLASSES,) = (block for block in BLOCKS if "(TorquePolicy)" in block)
SENSORS = ["encoders", "preview", "interaction"]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "my_policies.py").write_text(CLASSES, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    return tmp_path


def actions(policy, rows=3, steps=40):
    """The actions of a policy in rows of arms that another one moves."""
    arms = make_arms("ActiveSuit/ArmTracking-v0", rows, sensors=SENSORS, gravity="microgravity")
    made, mover = make_policy(policy, arms), make_policy("compensation", arms)
    observation, _ = arms.reset(seed=3)
    found = []
    for _ in range(steps):
        found.append(made.act(observation))
        observation, *_ = arms.step(mover.act(observation))
    return np.array(found)


@pytest.mark.parametrize(
    ("own", "shipped"),
    [
        ("my_policies:PDPlusSuit:kp=0,kd=0", "feedforward"),
        ("my_policies:PDPlusSuit:kp=0,kd=0,suit=emu-like", "feedforward:suit=emu-like"),
        ("my_policies:Damped:damping=0", "compensation"),
    ],
)
def test_without_their_own_part_they_are_the_shipped_ones(folder, own, shipped):
    found = actions(own)
    np.testing.assert_array_equal(found, actions(shipped))
    assert np.abs(found).max() > 0.01


def test_their_own_part_acts(folder):
    for own in ("my_policies:PDPlusSuit:kp=5", "my_policies:Damped"):
        base = "feedforward" if "PD" in own else "compensation"
        assert np.abs(actions(own) - actions(base)).max() > 1e-3


def test_the_observer_finds_what_the_shipped_one_finds(folder):
    difference = actions("my_policies:Observed") - actions("observer")
    assert np.abs(difference).max() < 0.15  # the friction, which the shipped one knows
    assert np.abs(actions("my_policies:Observed") - actions("gravity")).max() > 0.05
