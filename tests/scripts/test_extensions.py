"""A package from outside brings a model, which the command line then has."""

import json
import os
import subprocess
from pathlib import Path

import pytest
from activesuit.assets import curves_path
from helpers import python

# Bouc-Wen under another name is enough: what counts is that nothing here knows the name.
MODULE = """
from activesuit.hysteresis import BoucWen, register_model
from activesuit.identification import fit_bouc_wen, register_fit


class Toy(BoucWen):
    name = "toy"


def fit(curves, *, rng):
    found = fit_bouc_wen(curves, rng=rng).to_dict()
    return Toy(**{key: value for key, value in found.items() if key != "model"})


register_model(Toy)
register_fit("toy", fit)
"""


def installed(folder: Path, module: str) -> Path:
    """Puts a distribution with one module and one entry point into a folder, as pip would."""
    information = folder / "toy_suit-0.dist-info"
    information.mkdir()
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: toy-suit\nVersion: 0\n")
    (information / "entry_points.txt").write_text("[activesuit]\ntoy = toy_suit\n")
    (folder / "toy_suit.py").write_text(module)
    return folder


def run(folder: Path, *arguments: object) -> subprocess.CompletedProcess:
    environment = {**os.environ, "PYTHONPATH": str(folder), "COLUMNS": "100"}
    return python("-m", "activesuit.scripts.main", *arguments, env=environment)


@pytest.mark.slow
def test_a_model_of_an_extension_goes_from_curves_to_a_simulated_suit(tmp_path):
    shown = run(installed(tmp_path, MODULE), "identify", "--help")
    assert ",toy}" in "".join(shown.stdout.replace("│", "").split())
    fit = ["identify", curves_path("elbow"), "--model", "toy", "--out", tmp_path / "fit"]
    fitted = run(tmp_path, *fit, "--json")
    assert fitted.returncode == 0, fitted.stderr
    assert json.loads(fitted.stdout)["model_name"] == "toy"
    arguments = ["--suit", tmp_path / "fit" / "suit.json", "--motions", 8, "--json"]
    simulated = run(tmp_path, "evaluate", "--unadapted", "--policies", "none", *arguments)
    assert simulated.returncode == 0, simulated.stderr
    scores = json.loads(simulated.stdout)["scores"]
    assert scores["none"]["failures"] == 0


def test_a_broken_extension_ends_with_one_sentence(tmp_path):
    broken = run(installed(tmp_path, "import no_such_module\n"), "list", "suits")
    assert broken.returncode == 2
    assert broken.stdout == ""
    (sentence,) = broken.stderr.strip().splitlines()
    assert "the extension 'toy-suit' cannot be imported (ModuleNotFoundError" in sentence
    assert run(tmp_path, "--version").returncode == 0
