"""The environments' benchmark; that it reports ratios is tested with the command line."""

import importlib.util

import pytest
from activesuit.benchmarks import env

pytestmark = pytest.mark.slow


def test_without_stable_baselines_its_row_is_left_out(monkeypatch, capsys):
    for part in ("_some_rows", "_resets", "_memory"):
        monkeypatch.setattr(env, part, lambda *_: [])
    for part in ("_single", "_many_rows"):
        monkeypatch.setattr(env, part, lambda *_: None)
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: None)
    assert env.rows(1) == [None, None]
    assert "Stable-Baselines3 is left out" in capsys.readouterr().err
