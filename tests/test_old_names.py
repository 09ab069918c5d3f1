"""Names of version 0.2 are answered with the new ones, and its files are read."""

import json

import activesuit
import pytest
from activesuit.assets import FOLDER, curves_path, load_suit
from activesuit.hysteresis import Clipped, model_from_dict
from activesuit.identification import identify, load_curves
from activesuit.scripts.old_names import MOVED, OLD_OPTIONS
from helpers import fails


@pytest.mark.parametrize("old", MOVED)
def test_old_commands(capsys, old):
    message = fails(capsys, *old.split(), "--out", "here")
    assert f"no command since version 0.3: run {MOVED[old]}" in message


def test_an_old_function():
    with pytest.raises(AttributeError, match=r"activesuit.envs.model.load_model"):
        activesuit.load("arm.mjb")


@pytest.mark.parametrize("old", OLD_OPTIONS)
def test_old_options(capsys, old):
    message = fails(capsys, "evaluate", old)
    assert f"{old} was an option of version 0.2: {OLD_OPTIONS[old]}" in message


def test_a_suit_file_with_the_old_name_of_a_model(tmp_path):
    content = json.loads((FOLDER / "suits" / "mock-suit.json").read_text())
    model = content["joints"]["shoulder_flexion"]["model"]
    assert model["model"] == "clipped"
    model["model"] = "held"
    (tmp_path / "old.json").write_text(json.dumps(content))
    old = load_suit(tmp_path / "old.json").joints["shoulder_flexion"].model
    assert isinstance(old, Clipped)
    assert old == load_suit("mock-suit").joints["shoulder_flexion"].model == model_from_dict(model)


def test_the_old_class():
    with pytest.raises(ImportError, match=r"'Held' was a name of version 0.2: write 'Clipped'"):
        from activesuit.hysteresis import Held  # noqa: F401


def test_identify_returned_a_fit():
    with pytest.raises(AttributeError, match=r"write identify\(\.\.\.\)\.fit\.nrmse"):
        _ = identify(load_curves(curves_path("elbow"))).nrmse
