"""Tuning of hyperparameters: a study that goes on, and what it keeps."""

import json
import sys

import pytest

pytest.importorskip("optuna")
from activesuit.tools import tune_training


class Parallel:
    """The calls of joblib, one after the other and in this process."""

    def __init__(self, workers):
        self.workers = workers

    def __enter__(self):
        return lambda calls: [call(*given, **options) for call, given, options in calls]

    def __exit__(self, *error):
        return None


@pytest.mark.slow
def test_a_study_goes_on_with_other_trials(tmp_path, monkeypatch, capsys):
    """A trial that was stopped does not count, and none is tried twice."""
    tried = []

    def score(settings, algo, steps):
        tried.append(settings)
        if len(tried) == 4:
            raise KeyboardInterrupt
        return {"alone": settings["learning_rate"] == "nothing", "correction": len(tried) / 10}

    monkeypatch.setattr(tune_training, "Parallel", Parallel)
    monkeypatch.setattr(tune_training, "score", score)
    monkeypatch.setattr(tune_training, "FOLDER", tmp_path)
    given = ["--algo", "recurrent-ppo", "--trials", "6", "--out", str(tmp_path / "study.db")]
    monkeypatch.setattr(sys, "argv", ["tune_training", *given])
    with pytest.raises(KeyboardInterrupt):
        tune_training.main()
    tune_training.main()
    assert len(tried) == 4 + 4 + 1  # two of the first four are kept; the last are the shipped ones
    assert len({json.dumps(one) for one in tried}) == len(tried)
    found = json.loads((tmp_path / "hyperparameters-recurrent-ppo.json").read_text())
    assert found["result"]["trials"] == 6
    reliefs = [one["correction"] for one in found["result"]["rows"]]
    assert reliefs[:-1] == sorted(reliefs[:-1], reverse=True)
    assert found["result"]["rows"][-1]["trial"] == "shipped"
