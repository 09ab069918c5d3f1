"""`activesuit reproduce kao-fung-2009`: the second paper's tables, files and figures."""

import csv
import json

import pytest
from activesuit.identification.benchmarks.dispatch import OPTIMUM
from activesuit.identification.benchmarks.scott_russell_fit import FIRST_SAMPLE
from activesuit.scripts.main import main

SMALL = ["reproduce", "kao-fung-2009", "--population", "60", "--iterations", "4", "--trials", "3"]


def test_writes_tables_and_figures(capsys, tmp_path):
    main([*SMALL, "--out", str(tmp_path / "kf")])
    out = capsys.readouterr().out
    for text in ("8233.6607", "8250.2047", "f_n [Hz]", "RMS error", "gamma", "35/100"):
        assert text in out
    assert max(map(len, out.split("note:")[0].splitlines())) <= 100
    figures = {f"figure-{i}.{suffix}" for i in (6, 7, 8) for suffix in ("png", "svg")}
    tables = {"cost.csv", "parameters.csv", "errors.csv", "convergence.csv", "result.json"}
    assert {path.name for path in (tmp_path / "kf").iterdir()} == figures | tables | {".activesuit"}
    with (tmp_path / "kf" / "cost.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 2 * 2 * 3
    assert all(float(row["cost"]) >= OPTIMUM - 1e-6 for row in rows if row["slack_limit"] == "kept")
    with (tmp_path / "kf" / "errors.csv").open() as file:
        samples = list(csv.reader(file))
    assert len(samples) == 1 + 501 - FIRST_SAMPLE
    assert len(samples[0]) == 2 + 4


def test_json_is_seeded(capsys):
    def run(seed):
        main([*SMALL, "--seed", str(seed), "--json"])
        return json.loads(capsys.readouterr().out)

    first, again, other = run(1), run(1), run(2)
    sums = [[row["sse"] for row in it["identification"]] for it in (first, again, other)]
    assert sums[0] == sums[1] != sums[2]
    assert [row["average"] for row in first["cost"]] == [row["average"] for row in again["cost"]]
    assert first["cost"][1]["published"]["best"] == 8233.6607
    assert first["sse_of_truth"] == pytest.approx(351 * first["noise"] ** 2, rel=0.3)
    assert {row["case"] for row in first["identification"]} == {"n = 1", "n free"}


@pytest.mark.parametrize(
    ("option", "value", "message"),
    [("--trials", "0", "trials is 0"), ("--population", "1", "population is 1: use at least 2")],
)
def test_bad_numbers(capsys, option, value, message):
    with pytest.raises(SystemExit) as stop:
        main(["reproduce", "kao-fung-2009", option, value])
    assert stop.value.code == 2
    assert message in capsys.readouterr().err
