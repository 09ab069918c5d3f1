"""Muscles on the command line: table, result, picture, film, and bad input."""

import json
import sys

import pytest
from activesuit.scripts.main import main
from helpers import shorten_tasks

SHORT = ("--env", "ActiveSuit/ElbowFlexion-v0", "--episodes", "8")


@pytest.fixture
def extra():
    pytest.importorskip("myo_sim")


@pytest.mark.slow
@pytest.mark.usefixtures("extra")
def test_evaluate_adds_table_result_and_picture(tmp_path, capsys, monkeypatch):
    shorten_tasks(monkeypatch, 0.5)
    folder = tmp_path / "muscles"
    main(["evaluate", "--muscles", *SHORT, "--policies", "compensation", "--out", str(folder)])
    out = capsys.readouterr().out
    assert "Muscles: the suit changes the metabolic power" in out
    found = json.loads((folder / "result.json").read_text())["scores"]
    for name, one in found.items():
        muscles = one["muscles"]
        assert len(muscles["power"]["standard"]) == 8 and len(muscles["loaded"]) == 3
        assert muscles["units"]["power"] == "W"
        low, high = muscles["power_relief_range"]
        assert low <= muscles["power_relief"]["value"] <= high, name
    assert (folder / "muscles.png").read_bytes()[:4] == b"\x89PNG"
    assert "Activation of the muscles" in (folder / "report.html").read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.render
@pytest.mark.usefixtures("extra")
def test_animate_draws_the_muscles(tmp_path, monkeypatch):
    shorten_tasks(monkeypatch, 0.3)
    size = ("--width", "240", "--height", "120", "--fps", "10")
    films = [tmp_path / "loops.gif", tmp_path / "muscles.gif"]
    for film, more in zip(films, ((), ("--muscles",)), strict=True):
        main(["animate", "--env", SHORT[1], "--out", str(film), *size, *more])
    loops, muscles = (film.read_bytes() for film in films)
    assert muscles[:3] == b"GIF" and loops != muscles


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        (("--table",), "--table has no muscles"),
        (("--set", "fatigue=true"), "this wearer tires"),
    ],
)
@pytest.mark.usefixtures("extra")
def test_bad_input_is_one_sentence(given, sentence, tmp_path, capsys):
    folder = tmp_path / "out"
    with pytest.raises(SystemExit) as stopped:
        main(["evaluate", "--muscles", *given, "--out", str(folder)])
    assert stopped.value.code == 2
    assert sentence in capsys.readouterr().err
    assert not folder.exists()


@pytest.mark.parametrize(
    "command", [["evaluate"], ["animate"], ["benchmark", "run"], ["view", "--web"]]
)
def test_a_missing_extra_is_named_before_anything_runs(command, tmp_path, capsys, monkeypatch):
    from activesuit.envs.muscles import MyoArm

    MyoArm.load.cache_clear()
    monkeypatch.setitem(sys.modules, "myo_sim", None)
    with pytest.raises(SystemExit) as stopped:
        out = [] if "view" in command else ["--out", str(tmp_path / "out.gif")]
        main([*command, "--muscles", *out])
    assert stopped.value.code == 2
    assert "activesuit[muscles]" in capsys.readouterr().err
    assert not (tmp_path / "out.gif").exists()
