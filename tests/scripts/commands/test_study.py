"""`activesuit reproduce li-2022`: the same tables however it was run, and nothing lost."""

import csv
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from importlib.util import find_spec

import pytest
from activesuit.assets import curves_path
from activesuit.scripts.main import main
from helpers import without_figures

SMALL = ["--trials", "3", "--swarm-size", "10", "--iterations", "8"]
TABLES = ["config.json", "result.json", "trials.csv", "table.csv", "report.md"]


def study(out, *arguments) -> None:
    with without_figures():
        drawn_study(out, *arguments)


def drawn_study(out, *arguments) -> None:
    main(["reproduce", "li-2022", "--out", str(out), *SMALL, *map(str, arguments)])


def tables(out) -> dict[str, bytes]:
    trials = {path.name: path.read_bytes() for path in sorted((out / "trials").glob("[!.]*"))}
    return trials | {name: (out / name).read_bytes() for name in TABLES}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The folder of a finished study; take a copy to change it."""
    out = tmp_path_factory.mktemp("whole")
    study(out, "--workers", 1)
    return out


@pytest.fixture(scope="module")
def whole(made):
    return tables(made)


@pytest.fixture
def copied(made, tmp_path):
    """A copy of the finished study."""
    return shutil.copytree(made, tmp_path / "copy", copy_function=shutil.copy2)


def fails(capsys, *arguments) -> str:
    with pytest.raises(SystemExit) as stop:
        main([str(argument) for argument in arguments])
    captured = capsys.readouterr()
    assert stop.value.code == 2
    assert "Traceback" not in captured.err
    return " ".join(captured.err.split())


def test_prints_tables_and_writes_everything(capsys, tmp_path, whole):
    drawn_study(tmp_path)
    out = capsys.readouterr().out
    for word in ("best of 3 trials", "sa-pso", "mpso", "undecidable", "report.md"):
        assert word in out
    assert len(whole) == len(TABLES) + 2 * 2 * 3
    figures = ("curves", "convergence", "loops", "ecdf")
    for figure in (*figures, "prediction", "prediction-errors", "multi-order"):
        assert (tmp_path / f"{figure}.png").stat().st_size > 10_000
        assert (tmp_path / f"{figure}.svg").exists()
    report = (tmp_path / "report.md").read_text()
    assert "the first whose best fitness is within 1 % of the trial's final one" in report
    assert "- shoulder, mpso: **worse**. The error is" in report
    for claim in ("6.25 %", "20.29 %", "14.45 %", "46.5 %", "predicts better"):
        assert claim in report
    assert len((tmp_path / "trials.csv").read_text().splitlines()) == 1 + 2 * 2 * 3
    with (tmp_path / "table.csv").open(newline="") as file:
        for row in csv.DictReader(file):
            assert float(row["multi_order_ratio_q1"]) <= float(row["multi_order_ratio_q3"])
            assert 0 <= int(row["multi_order_as_well"]) <= 3


def test_json(capsys, tmp_path):
    study(tmp_path, "--json")
    result = json.loads(capsys.readouterr().out)
    assert result == json.loads((tmp_path / "result.json").read_text())
    assert len(result["summaries"]) == 4
    assert {claim["verdict"] for claim in result["claims"]} == {"undecidable"}  # 3 trials
    assert "within 1 %" in result["definitions"]["converged at"]


@pytest.mark.parametrize(
    "arguments", [("--workers", 2), ("--backend", "loky", "--workers", 2)], ids=["threads", "loky"]
)
def test_workers_and_processes_change_nothing(tmp_path, whole, arguments):
    study(tmp_path, *arguments)
    assert tables(tmp_path) == whole


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["dask", "ray"])
def test_a_cluster_of_two_workers_changes_nothing(tmp_path, whole, backend):
    if find_spec("distributed" if backend == "dask" else "ray") is None:
        pytest.skip(f"{backend} is not installed")
    study(tmp_path, "--backend", backend, "--workers", 2)
    if backend == "ray":  # whoever joins may run code, and its ports are open to the network
        assert os.environ["RAY_AUTH_MODE"] == "token"
    assert tables(tmp_path) == whole


def test_resumes_where_it_stopped(copied, whole):
    kept = sorted((copied / "trials").iterdir())
    for path in kept[::2]:
        path.unlink()
    for name in TABLES[1:]:
        (copied / name).unlink()
    times = {path: path.stat().st_mtime_ns for path in kept[1::2]}
    study(copied)
    assert tables(copied) == whole
    assert times == {path: path.stat().st_mtime_ns for path in kept[1::2]}  # not run again


def test_killed_and_run_again(tmp_path, whole):
    arguments = ["reproduce", "li-2022", "--out", str(tmp_path / "out"), *SMALL, "--workers", "1"]
    # Each bar step waits, so that the kill falls among the trials on any machine.
    code = (
        "import sys, time\n"
        "from activesuit.scripts import output\n"
        "output.Bar.advance = lambda self, steps=1: time.sleep(0.3)\n"
        "from activesuit.scripts.main import main\n"
        "main(sys.argv[1:])\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code, *arguments],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    trials, deadline = tmp_path / "out" / "trials", time.monotonic() + 120
    while time.monotonic() < deadline and len(list(trials.glob("[!.]*"))) < 4:
        assert process.poll() is None
        time.sleep(0.02)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    assert 4 <= len(list(trials.glob("[!.]*"))) < 12
    study(tmp_path / "out")
    assert tables(tmp_path / "out") == whole


def test_ctrl_c_says_what_is_kept(capsys, tmp_path, monkeypatch):
    from activesuit.scripts.output import Bar

    def interrupt(self, steps=1):
        raise KeyboardInterrupt

    monkeypatch.setattr(Bar, "advance", interrupt)
    message = fails(capsys, "reproduce", "li-2022", "--out", tmp_path, *SMALL, "--workers", 1)
    assert "interrupted: the finished trials (1 of 12) are kept in" in message


def test_csv_files_without_held_out_curves(capsys, tmp_path):
    text = curves_path("elbow").read_text()
    kept = [line for line in text.splitlines() if ",predict," not in line]
    (tmp_path / "knee.csv").write_text("\n".join(kept))
    options = ("--joints", tmp_path / "knee.csv", "--methods", "mpso", "certified")
    study(tmp_path / "out", *options)
    assert "knee" in capsys.readouterr().out
    assert (tmp_path / "out" / "loops.png").exists()
    assert not (tmp_path / "out" / "prediction.png").exists()
    assert "claims" not in (tmp_path / "out" / "report.md").read_text()  # of other joints


def test_a_csv_file_with_a_motion_that_turns_more_than_once(capsys, tmp_path):
    elbow, motions = curves_path("elbow"), curves_path("elbow").with_stem("elbow_multi_order")
    rows = [line for line in motions.read_text().splitlines() if line.startswith("multi-order 1")]
    (tmp_path / "knee.csv").write_text(elbow.read_text() + "\n".join(rows))
    study(tmp_path / "out", "--joints", tmp_path / "knee.csv", "--methods", "mpso", "--json")
    (summary,) = json.loads(capsys.readouterr().out)["summaries"]
    assert summary["multi_order"]["curves"] == ["multi-order 1"]
    assert set(summary["prediction_max_error"]) == {"1.05", "1.40"}


def test_another_study_in_the_folder(capsys, copied):
    message = fails(capsys, "reproduce", "li-2022", "--out", copied, "--trials", 5)
    assert "holds a study whose trials is 3, not 5" in message
    message = fails(capsys, "reproduce", "li-2022", "--out", copied, *SMALL, "--joints", "elbow")
    assert "holds a study whose joints is" in message
    known = (copied / "config.json").read_text()
    for content, message in (
        ("{", "config.json is not complete JSON (line 1: "),
        ("[]", "is not the configuration of a study"),
        ("[" * 10_000, "lists or objects inside each other"),
        ("9" * 5000, "has a number of 5,000 digits"),
        ('{"trials": 3, "trials": 3}', "has 'trials' twice in one object"),
        (b"\xff\xfe", "config.json': not a UTF-8 text file"),
        (known.replace("{", '{"extra": 1,', 1), "holds a study whose extra is 1, not None"),
    ):
        (copied / "config.json").write_bytes(
            content if isinstance(content, bytes) else content.encode()
        )
        assert message in fails(capsys, "reproduce", "li-2022", "--out", copied, *SMALL)


def test_broken_or_misplaced_trials(capsys, copied):
    first, second = sorted((copied / "trials").iterdir())[:2]
    whole = first.read_text()
    first.write_text(whole[:100])
    message = fails(capsys, "reproduce", "li-2022", "--out", copied, *SMALL)
    assert first.name in message
    assert "delete it" in message
    for content, message in (
        (b"\xff\xfe", "not a UTF-8 text file"),
        (b"[" * 10_000, "lists or objects inside each other: delete it"),
        (whole.replace("[", "[9" + "9" * 5000 + ", ", 1).encode(), "a number of 5,001 digits"),
        (b'{"key": 1, ' + whole[1:].encode(), "has 'key' twice in one object"),
        (whole.replace('"1.05"', '"1.06"').encode(), "predicts ['1.06', '1.40'"),
    ):
        first.write_bytes(content)
        assert message in fails(capsys, "reproduce", "li-2022", "--out", copied, *SMALL)
    first.write_text(second.read_text())
    assert f"is the trial {second.name}" in fails(
        capsys, "reproduce", "li-2022", "--out", copied, *SMALL
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--methods", "sa-psoo"], "did you mean 'sa-pso'"),
        (["--joints", "knee"], "joint 'knee': use shipped curves (elbow, shoulder) or a CSV file"),
        (["--joints", "elbow", "elbow"], "two joints are named 'elbow'"),
        (["--joints", "none.csv"], "No such file"),
        (["--trials", "0"], "trials is 0"),
        (["--workers", "0"], "workers is 0"),
    ],
)
def test_mistakes(capsys, tmp_path, arguments, message):
    assert message in fails(capsys, "reproduce", "li-2022", "--out", tmp_path / "out", *arguments)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("backend", "package"), [("ray", "ray"), ("dask", "distributed")])
def test_a_missing_cluster_package(capsys, tmp_path, monkeypatch, backend, package):
    monkeypatch.setitem(sys.modules, package, None)
    message = fails(capsys, "reproduce", "li-2022", "--out", tmp_path, *SMALL, "--backend", backend)
    assert f"--backend {backend} needs packages that are not installed" in message
    assert "pip install -e '.[cluster]' -c constraints.txt" in message
    assert not list(tmp_path.iterdir())


def test_an_unwritable_folder(capsys, tmp_path):
    (tmp_path / "file").write_text("")
    assert "choose another --out" in fails(
        capsys, "reproduce", "li-2022", "--out", tmp_path / "file", *SMALL
    )
