"""What docs/training.md reports of learners is what a program has measured."""

import sys

import pytest
from activesuit.tools import learners
from activesuit.tools.learners import BESIDE, LEARNERS, PROGRAMS, kept_learner, measured

PROGRAM = """
import gymnasium, numpy as np
from activesuit.envs.policies import Network, save_policy
env = gymnasium.make("activesuit:ActiveSuit/ElbowFlexion-v0")
weights = {"layer.0.weight": np.zeros((2, 12)), "layer.0.bias": np.zeros(2)}
save_policy(Network(weights, activation="tanh"), "my-torchrl", env)
print("   4096 steps: mean reward 0.250")
"""


@pytest.mark.parametrize("name", LEARNERS)
def test_every_learner_is_kept_with_its_commands(name):
    learner, content = LEARNERS[name], kept_learner(name)
    assert content["commands"] == [
        f"python docs/learners/{learner.program}",
        f"activesuit evaluate --policies {' '.join(BESIDE)} {learner.policy}",
    ]
    assert content["result"]["versions"].keys() == learner.packages.keys()
    assert (PROGRAMS / learner.program).is_file()


@pytest.mark.slow
def test_a_program_is_run_and_its_policy_is_scored(tmp_path, monkeypatch):
    (tmp_path / "mine.py").write_text(PROGRAM)
    learner = LEARNERS["torchrl"]._replace(program="mine.py", packages={"numpy": "NumPy"})
    monkeypatch.setattr(learners, "PROGRAMS", tmp_path)
    monkeypatch.setitem(LEARNERS, "torchrl", learner)
    found = measured("torchrl", sys.executable)
    assert found["rewards"] == {"4096": 0.25}
    assert found["versions"].keys() == {"numpy"}
    relief = {name: one["relief"] for name, one in found["scores"].items()}
    assert relief.keys() == {*BESIDE, "my-torchrl"}
    assert relief["my-torchrl"]["value"] == pytest.approx(relief["none"]["value"], abs=0.01)
    assert relief["compensation"]["low"] > relief["none"]["high"]
