"""The demo: one command from loops to report."""

import json
import re
import subprocess
import sys

import numpy as np
import pytest
from activesuit.assets import load_suit
from activesuit.scripts.demo import demo
from activesuit.scripts.output import Bar


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("demo")
    demo(out=path, trials=2, episodes=1)
    return path


def test_report_shows_every_figure(folder):
    report = (folder / "report.md").read_text()
    pictures = re.findall(r"!\[.*?\]\((.*?)\)", report)
    assert len(pictures) >= 8
    for picture in pictures:
        assert (folder / picture).stat().st_size > 10_000
        if picture != "arm.png":
            assert (folder / picture).with_suffix(".svg").exists()
    assert "synthetic" in report


def test_numbers_are_there(folder):
    fits = json.loads((folder / "fits.json").read_text())
    for joint in ("shoulder", "elbow"):
        assert set(fits[joint]) == {"sa-pso", "mpso", "certified"}
        assert fits[joint]["certified"]["certificate"]["certified"]
        assert len(fits[joint]["mpso"]["prediction_max_error"]) == 2
    scores = json.loads((folder / "evaluation.json").read_text())
    for gravity in ("earth", "microgravity"):
        named = {score["policy"]: score for score in scores[gravity]}
        for joint, value in named["oracle"]["reduction"].items():
            assert named["feedforward"]["reduction"][joint] >= 0.6 * value > 0
    assert set(load_suit(str(folder / "suit.json")).joints) == set(load_suit("mock-suit").joints)
    trace = np.genfromtxt(folder / "trace-earth-none.csv", delimiter=",", names=True)
    assert trace.size == 1000
    assert json.loads((folder / "config.json").read_text())["seed"] == 0


def test_without_opengl_it_says_so_and_goes_on(tmp_path, monkeypatch, capsys):
    from activesuit.envs.rendering import Renderer, RenderingUnavailableError

    def unavailable(self, model, data):
        raise RenderingUnavailableError("no OpenGL context")

    monkeypatch.setattr(Renderer, "picture", unavailable)
    demo(out=tmp_path, trials=1, episodes=1)
    assert "no picture of the arm: no OpenGL context" in capsys.readouterr().out
    assert not (tmp_path / "arm.png").exists()
    assert "arm.png" not in (tmp_path / "report.md").read_text()


def test_interrupt_keeps_the_finished_fits(tmp_path, monkeypatch, capsys):
    advance, calls = Bar.advance, []

    def interrupt(self, steps=1):
        calls.append(steps)
        if len(calls) == 3:
            raise KeyboardInterrupt
        advance(self, steps)

    monkeypatch.setattr(Bar, "advance", interrupt)
    with pytest.raises(KeyboardInterrupt, match="finished fits are kept"):
        demo(out=tmp_path, trials=2, episodes=1)
    assert "sa-pso" in json.loads((tmp_path / "fits.json").read_text())["shoulder"]
    assert len((tmp_path / "trials.csv").read_text().splitlines()) >= 3


def test_needs_no_torch(tmp_path):
    code = (
        "import sys\n"
        "from activesuit.scripts.main import main\n"
        f"main(['demo', '--trials', '1', '--episodes', '1', '--out', {str(tmp_path)!r}])\n"
        "assert not {'torch', 'stable_baselines3'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)
    assert (tmp_path / "report.md").exists()
