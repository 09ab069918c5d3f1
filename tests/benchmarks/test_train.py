"""The benchmark of training: what it reports; times are not tested."""

import json

import pytest
from activesuit.benchmarks import train
from activesuit.benchmarks.__main__ import main
from activesuit.scripts.training import hyperparameters
from helpers import fails, set_all

pytestmark = pytest.mark.slow


def test_without_the_extra_one_sentence_says_so(capsys, monkeypatch):
    monkeypatch.setitem(hyperparameters.ALGORITHMS, "ppo", ("no_such_package", "PPO"))
    message = fails(capsys, "train", program=main)
    assert "training by ppo needs no-such-package: use `make train`" in message


def test_ratios_shares_and_goals(capsys, monkeypatch):
    pytest.importorskip("stable_baselines3")
    usual = hyperparameters.hyperparameters("ppo", train.ENV)
    few = {**usual, "n_envs": 4, "n_steps": 8, "batch_size": 16}
    before = {"n_envs": 2, "n_steps": 8, "batch_size": 8, "n_epochs": 2}
    set_all(monkeypatch, train, hyperparameters=lambda *_: few, STEPS=32, PASSES=2, BEFORE=before)
    monkeypatch.setattr(train, "AS_LONG", {"n_envs": 2, "n_steps": 16})
    main(["train", "--repeats", "2", "--json"])
    result = json.loads(capsys.readouterr().out)
    pairs = [row for row in result["rows"] if row["ratio"] is not None]
    assert [row["target"] for row in pairs] == [3.0, None, None]
    for row in pairs:
        assert row["lowest"] <= row["ratio"] <= row["highest"]
    share, million = (row for row in result["rows"] if row["ratio"] is None)
    rows, before, as_long = result["training"]
    assert share["ours"] == pytest.approx(100 * rows["shares"]["environment"])
    assert million["ours"] == pytest.approx(1e6 / rows["speed"] / 60)
    for one in (rows, before, as_long):
        assert one["slowest"] <= one["speed"] <= one["fastest"]
        assert min(one["shares"].values()) > 0
        assert sum(one["shares"].values()) < 1.05  # medians need not add up
    header, cells = train.training_table([train.Training(**one) for one in result["training"]])
    assert {len(row) for row in cells} == {len(header)}
