"""The programs: verdicts that follow from the numbers, and the tables of the page."""

import re
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from activesuit.hysteresis import JilesAtherton
from activesuit.identification import bare
from activesuit.json_files import read_json
from activesuit.reproductions import kao_fung_2009, li_2022, li_2022_velocity
from activesuit.reproductions.dispatch import cost_trials
from activesuit.reproductions.results import Results, run
from activesuit.reproductions.verdicts import judged

PAGE = Path(__file__).parents[2] / "docs" / "reproduction.md"
WOBBLE = 1 + 0.01 * np.sin(np.arange(30))
PROGRAMS = {
    "li_2022": ["--trials", "2", "--iterations", "5"],
    "li_2022_velocity": ["--trials", "2", "--iterations", "5"],
    "kao_fung_2009": ["--trials", "2", "--population", "50", "--iterations", "3"],
    "noel_schoukens_2016": [],
}


@pytest.mark.parametrize(
    ("ours", "other", "printed", "word"),
    [
        (1.0, 1.6, 0.465, "reproduced"),
        (1.6, 1.0, 0.465, "not reproduced"),
        (1.0, 1.2, 0.465, "not reproduced"),  # a smaller advantage than printed does not count
        (1.0, 1.3, 0.0, "reproduced"),
        (1.3, 1.0, 0.0, "not reproduced"),
        (1.0, 1.0, 0.0, "undecidable"),
    ],
)
def test_verdicts(ours, other, printed, word):
    found = judged(ours * WOBBLE, other * WOBBLE, printed, seed=0)
    assert found.word == word
    assert found.low < other / ours - 1 < found.high
    assert found.advantage == pytest.approx(other / ours - 1)


def test_few_trials_and_poles_decide_nothing():
    few = judged(WOBBLE[:9], 1.6 * WOBBLE[:9], 0.465, seed=0)
    pole = judged(np.append(WOBBLE, np.inf), 1.6 * WOBBLE, 0.465, seed=0)
    assert (few.word, pole.word) == ("undecidable", "undecidable")
    assert few.cells[1] == "-"


def test_the_bootstrap_where_no_trial_misses_the_optimum():
    found = judged(np.zeros(20), np.zeros(20), 0.2, seed=0, statistic=np.mean)
    assert (found.word, found.low, found.high) == ("not reproduced", 0, 0)


def test_the_printed_percentages_are_of_sa_pso():
    printed = {"shoulder": (6.25, 14.45), "elbow": (20.29, 46.5)}
    for joint, shares in printed.items():
        pairs = (li_2022.ITERATIONS[joint], li_2022.FITNESS[joint])
        assert [100 * (mpso / sa_pso - 1) for sa_pso, mpso in pairs] == pytest.approx(
            shares, abs=0.01
        )


@pytest.mark.parametrize("method", ["sa-pso", "certified"])
def test_runs_by_hand(method):
    runs = li_2022.runs_of("elbow", method, trials=3, seed=1, iterations=12)
    samples = sum(curve.angle.size for curve in runs.fit.curves.fitted())
    for i, trial in enumerate(runs.fit.trials):
        assert runs.fitness[i] == pytest.approx(trial.nrmse / np.sqrt(samples))
        history = np.array(trial.history)
        if method == "certified":
            assert runs.converged[i] == 0
            assert runs.fitness[i] < 1.05 * runs.floor
            continue
        assert runs.fitness[i] == pytest.approx(trial.loss)  # eq. (7)
        at = int(runs.converged[i]) - 1
        assert history[at] <= 1.01 * history[-1]
        assert (history[:at] > 1.01 * history[-1]).all()
    model = bare(runs.fit.trials[1].model)
    assert isinstance(model, JilesAtherton)
    for curve in runs.fit.curves.held_out():
        errors = model.response(curve.angle) - curve.torque
        np.testing.assert_allclose(runs.first_order[curve.name][1], errors)
    again = li_2022.runs_of("elbow", method, trials=3, seed=1, iterations=12)
    np.testing.assert_array_equal(runs.fitness, again.fitness)


def test_the_table_of_vmax_has_the_kept_trials():
    kept = read_json(PAGE.parent / "measured" / li_2022_velocity.KEPT, "kept result")
    rows = li_2022_velocity.rows(kept["result"], seed=0)
    text = PAGE.read_text(encoding="utf-8")
    part = text.partition("<!-- made by: li_2022_velocity -->")[2].partition("<!-- end")[0]
    shown = [line for line in part.splitlines() if line.startswith("|")]
    assert shown[0] == f"| {li_2022_velocity.HEADER} |"
    assert shown[2:] == [f"| {' | '.join(row)} |" for row in rows]
    assert [float(row[1]) for row in rows] == 2 * [0.02, 0.05, 0.2, 1.0]
    assert {row[2] for row in rows} == {"30"}
    # The assumed Vmax has the trials of the table of all claims: one number for one thing.
    for row in (row for row in rows if row[1] == "0.2"):
        claim = next(line for line in text.splitlines() if f"| {row[0]}, best fitness" in line)
        assert claim.endswith(f"| {' | '.join(row[-3:])} |")


def test_the_inference_is_said_and_the_printed_table_stands_beside_ours(tmp_path, capsys):
    costs = {
        (limit, method): cost_trials(method, trials=2, relaxed=limit == "ignored", seed=0)
        for limit in kao_fung_2009.LIMITS
        for method in kao_fung_2009.TABLE_1
    }
    results = Results(tmp_path)
    for show in (kao_fung_2009.table_1, lambda *given: kao_fung_2009.claims(*given, seed=0)):
        show(results, costs)
        printed = capsys.readouterr().out
        assert "describe ten units, 30 buses, 41 lines and 24 hours" in printed
        assert "three units at 850 MW (Walters and Sheble 1993): an inference" in printed
    text = PAGE.read_text(encoding="utf-8")
    assert "**Our three units" in text
    row = "| Kao and Fung | {} | {} | {} | {} | {} of 100 | {} | {} |"
    for method, numbers in kao_fung_2009.TABLE_1.items():
        assert row.format(method, *numbers) in text


@pytest.mark.slow
@pytest.mark.parametrize("name", PROGRAMS)
def test_a_program_makes_its_part_of_the_page(name, tmp_path):
    program = [sys.executable, "-m", f"activesuit.reproductions.{name}", *PROGRAMS[name]]
    page = tmp_path / "page.md"
    page.write_text(PAGE.read_text(encoding="utf-8"), encoding="utf-8")
    command = [*program, "--out", str(tmp_path / name), "--page", str(page)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    kept, made = (outline(path.read_text(encoding="utf-8")) for path in (PAGE, page))
    assert made == kept, f"python -m activesuit.reproductions.{name} --page docs/reproduction.md"
    files = re.findall(rf": {name}/(\w+\.png)", done.stdout)
    assert bool(files) == (name != "li_2022_velocity")
    assert {path.name for path in (tmp_path / name).glob("*.png")} == set(files)


def outline(text: str) -> list[str]:
    """Returns the headings, the headers of tables and the figures of a page."""
    lines = text.splitlines()
    tables = [above for above, line in pairwise(lines) if line[:4] == "|---"]
    return [line for line in lines if re.match(r"#|- Fig|<!--", line)] + tables


def test_a_mistake_is_one_sentence(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["li_2022", "--trials", "0", "--out", str(tmp_path)])
    with pytest.raises(SystemExit, match="error: trials is 0"):
        run(li_2022.main)
