"""The command line: answers a program can read, and one clear sentence for every mistake."""

import csv
import json
from contextlib import suppress
from functools import partial

import pytest
from activesuit.assets import JOINTS, curves_path, load_suit
from activesuit.benchmarks import engine as engine_bench
from activesuit.benchmarks import env as env_bench
from activesuit.benchmarks import identify as identify_bench
from activesuit.benchmarks import starts
from activesuit.benchmarks.bench import bench
from activesuit.hysteresis import model_from_dict
from activesuit.identification import Search, fit_curves, identify, load_curves
from activesuit.scripts.commands import COMMANDS
from activesuit.scripts.folders import to_json
from activesuit.scripts.main import main
from activesuit.scripts.output import Bar
from helpers import fails, in_this_process, interrupt, python, run, set_all

ELBOW = str(curves_path("elbow"))
FEW = ["--motions", "8", "--json"]


def identified(capsys, *arguments) -> str:
    """Runs `identify`, whose model may not describe the curves: exit code 0 or 3."""
    with suppress(SystemExit):
        main([str(argument) for argument in ("identify", *arguments)])
    return capsys.readouterr().out


# The files of `identify --out`.
FIT_FILES = {*"suit.json result.json trials.csv report.html loops.csv loops.png loops.svg".split()}


@pytest.mark.usefixtures("short")
def test_identify_writes_a_suit_that_simulates(capsys, tmp_path):
    run(capsys, "identify", ELBOW, "--method", "certified", "--out", tmp_path / "fit")
    assert {path.name for path in (tmp_path / "fit").iterdir()} == FIT_FILES
    result = json.loads((tmp_path / "fit" / "result.json").read_text())
    found = identify(load_curves(ELBOW), method="certified", samples=20)
    assert result == json.loads(to_json(found.to_dict()))
    assert str(found).startswith("verdict: the model describes the curves, not beyond")
    assert result["nrmse"] < 0.0105
    assert max(result["prediction_max_error"].values()) < 0.25
    assert result["certificate"]["certified"]
    assert result["certificate"]["margin"] > 0
    suit = load_suit(str(tmp_path / "fit" / "suit.json"))
    assert set(suit.joints) == {"elbow_flexion"}
    assert suit.joints["elbow_flexion"].range == pytest.approx((0.52, 1.57))
    arguments = ["--policies", "oracle", *FEW, "--unadapted"]
    out = run(capsys, "evaluate", "--suit", tmp_path / "fit" / "suit.json", *arguments)
    result = json.loads(out)
    assert result["adapted"] is False
    score = result["scores"]["oracle"]
    assert score["failures"] == 0
    assert score["effort"] == score["unadapted_effort"]


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn", "short")
def test_one_measured_joint_goes_all_the_way(capsys, tmp_path):
    run(capsys, "identify", ELBOW, "--out", tmp_path / "one")
    suit = tmp_path / "one" / "suit.json"
    arguments = ["--env", "ActiveSuit/ElbowFlexion-v0", *FEW]
    result = json.loads(run(capsys, "validate", suit, "--plant", "mock-suit", *arguments))
    (cell,) = result["cells"]
    assert set(cell["torque"]["joints"]) == {"elbow_flexion"}
    assert cell["verdict"] == "valid"
    true = result["evaluations"]["mock-suit"]["scores"]["true model"]["relief"]
    assert cell["relief"]["value"] < true["value"]
    result = json.loads(run(capsys, "validate", suit, "--plant", suit, *arguments))
    assert set(result["cells"][0]["torque"]["joints"]) == {"elbow_flexion"}
    run(capsys, "identify", ELBOW, "--samples", 3, "--out", tmp_path / "three")
    drawn = tmp_path / "three" / "suit.json"
    result = json.loads(run(capsys, "validate", suit, "--plant", drawn, "--samples", *arguments))
    assert 0 < result["cells"][0]["torque"]["joints"]["elbow_flexion"]["nrmse"]["value"] < 0.05
    run(capsys, "identify", ELBOW, "--base", "mock-suit", "--out", tmp_path / "all")
    whole = load_suit(str(tmp_path / "all" / "suit.json"))
    assert set(whole.joints) == set(load_suit("mock-suit").joints)
    assert whole.joints["elbow_flexion"] == load_suit(str(suit)).joints["elbow_flexion"]


def test_interrupted_identification_keeps_the_finished_trials(capsys, tmp_path, monkeypatch):
    monkeypatch.setattr(Bar, "move_to", interrupt)
    arguments = ["--method", "mpso", "--trials", 5, "--workers", 1, "--out", tmp_path, "--json"]
    assert "interrupted" in fails(capsys, "identify", ELBOW, *arguments, shown=True)
    result = json.loads((tmp_path / "result.json").read_text())
    assert result["interrupted"]
    assert 1 <= result["trials"] < 5
    assert load_suit(str(tmp_path / "suit.json")).joints


@pytest.mark.usefixtures("short")
def test_evaluate_prints_a_table_and_writes_the_same(capsys, tmp_path):
    options = ["--policies", "none", "gravity", "--motions", "8", "--out", tmp_path]
    out = run(capsys, "evaluate", *options)
    assert "Scores: ActiveSuit/ArmTracking-v0, earth, mock-suit, level nominal, rigid" in out
    assert "The suit raises the wearer's effort from" in out
    written = json.loads((tmp_path / "result.json").read_text())
    assert list(written["scores"]) == ["unsuited", "suited", "none", "gravity"]
    rows = (tmp_path / "motions.csv").read_text().splitlines()
    assert rows[0].startswith("policy,seed,effort_share,shoulder_abduction_torque_nm")
    assert "fatigued" not in rows[0]
    assert len(rows) == 1 + 4 * 8
    assert rows[-1].startswith("gravity,10007,")
    assert json.loads(run(capsys, "evaluate", *options, "--json", "--force")) == written
    relief = written["scores"]["gravity"]["relief"]
    assert relief["low"] < relief["value"] < relief["high"]
    for name, score in written["scores"].items():
        assert f"{score['relief']['low']:.2f} to {score['relief']['high']:.2f}" in out, name
        assert len(score["effort"]) == 8


@pytest.mark.usefixtures("short")
def test_the_motions_have_what_muscles_have_left(capsys, tmp_path):
    options = ["--policies", "none", "--suit", "none", "--motions", "1", "--fatigue", "true"]
    assert "relief" not in run(capsys, "evaluate", *options, "--out", tmp_path)  # no references
    (row,) = csv.DictReader((tmp_path / "motions.csv").read_text().splitlines())
    score = json.loads((tmp_path / "result.json").read_text())["scores"]["none"]
    for joint in JOINTS:
        columns = {"fatigued_share": "fatigued", "least_strength_nm": "strength_left"}
        for column, name in columns.items():
            assert float(row[f"{joint}_{column}"]) == pytest.approx(score[name][joint][0], rel=1e-5)
    assert any(share[0] > 0 for share in score["fatigued"].values())


@pytest.mark.slow
@pytest.mark.usefixtures("short")
def test_validate_scores_one_suit_on_another(capsys, tmp_path):
    pair = ["published-2022", "--plant", "mock-suit", "--motions", "8"]
    out = run(capsys, "validate", *pair, "--out", tmp_path)
    (cell,) = json.loads((tmp_path / "result.json").read_text())["cells"]
    assert (cell["believed"], cell["plant"]) == ("published-2022", "mock-suit")
    assert cell["torque"]["joints"]["elbow_flexion"]["nrmse"]["high"] < 0.05
    assert f"published-2022: {cell['verdict']} for shoulder_flexion from" in out


@pytest.mark.slow
@pytest.mark.usefixtures("short")
def test_validate_many_suits_makes_a_matrix(capsys, tmp_path):
    suits = ["emu-like", "mock-suit"]
    out = run(capsys, "validate", *suits, "--plant", *suits, "--motions", 8, "--out", tmp_path)
    assert "wears" in out
    cells = json.loads((tmp_path / "result.json").read_text())["cells"]
    verdicts = {(cell["believed"], cell["plant"]): cell["verdict"] for cell in cells}
    assert len(verdicts) == 4
    assert all((verdicts[one, two] is None) == (one == two) for one, two in verdicts)
    assert (tmp_path / "matrix.png").stat().st_size > 10_000


def test_validate_predicts_held_out_curves(capsys):
    result = json.loads(run(capsys, "validate", "mock-suit", "--held-out", ELBOW, "--json"))
    found = result["suits"]["mock-suit"]["elbow_flexion"]
    assert found["verdict"] == "valid"
    assert [one["curve"] for one in found["curves"]] == load_curves(ELBOW).held_out().names
    assert "worst one decides" in run(capsys, "validate", "mock-suit", "--held-out", ELBOW)


@pytest.mark.slow
def test_simulate_writes_the_motion(capsys, tmp_path):
    options = ["--gravity", "moon", "--policy", "oracle", "--out", tmp_path, "--json"]
    out = run(capsys, "simulate", *options)
    assert json.loads(out)["policy"] == "oracle"
    rows = (tmp_path / "trace.csv").read_text().splitlines()
    assert len(rows) == 1001
    assert rows[0].startswith("policy,time_s,shoulder_abduction_angle_rad")
    for figure in ("trajectory", "torques", "motion-loops", "strain"):
        assert (tmp_path / f"{figure}.png").stat().st_size > 10_000
        assert (tmp_path / f"{figure}.svg").read_text().rstrip().endswith("</svg>")


@pytest.mark.slow
@pytest.mark.parametrize("topic", ["hysteresis", "engine", "env", "identify"])
def test_bench_reports_ratios(capsys, monkeypatch, topic, undrawn):
    set_all(monkeypatch, starts, STARTS_PER_REPEAT=1, run_all=in_this_process, ITERATIONS=5)
    monkeypatch.setattr(identify_bench, "sa_pso", partial(identify_bench.sa_pso, max_iterations=5))
    set_all(monkeypatch, engine_bench, STEPS=100, CALLBACK_STEPS=50, SIMULATIONS=64)
    set_all(monkeypatch, env_bench, STEPS=50, SOME=8, MANY=32, WORKERS=2, LONG=640)
    bench(topic, repeats=1, json=True)
    result = json.loads(capsys.readouterr().out)
    assert any(row["ratio"] for row in result["rows"])
    for row in result["rows"]:
        if row["ratio"] is None:  # measured alone, against a limit
            assert row["reference"] is None
            assert row["met"] == (row["ours"] <= row["limit"])
            continue
        assert row["lowest"] <= row["ratio"] <= row["highest"]
        assert row["ratio"] == pytest.approx(row["reference"] / row["ours"])
        assert row["met"] == (row["target"] is None or row["ratio"] >= row["target"])


def test_unknown_and_missing_command_and_option(capsys):
    assert "unknown option --speed" in fails(capsys, "demo", "--speed", 3)
    fails(capsys, "identify")
    assert fails(capsys, "evaluat").endswith("did you mean 'evaluate'?")
    unknown = fails(capsys, "--fly", "list")
    assert "unknown command '--fly': use one of benchmark, demo" in unknown
    assert "give a command: benchmark" in fails(capsys)
    unknown = fails(capsys, "list", "suit")
    assert "unknown part of list 'suit': use one of policies, suits" in unknown


def test_help_lists_every_command_as_its_own_help_begins(capsys):
    listed = run(capsys, "--help")
    assert listed == run(capsys, "-h")
    for name, sentence in COMMANDS.items():
        assert f"  {name} " in listed
        assert sentence in listed
        with pytest.raises(SystemExit) as stop:
            main([*name.split(), "--help"])
        assert stop.value.code == 0
        own = " ".join(capsys.readouterr().out.split())
        assert own.startswith(f"usage: activesuit {name} [-h]")
        assert f" {sentence.removesuffix('.')}" in own


@pytest.mark.parametrize("arguments", [["--help"], ["--version"]])
def test_only_the_command_asked_for_is_imported(arguments):
    command = ("-X", "importtime", "-m", "activesuit.scripts.main", *arguments)
    report = python(*command, check=True).stderr
    loaded = {line.rpartition("|")[2].strip() for line in report.splitlines()}
    assert "activesuit.errors" in loaded
    assert not {"numba", "mujoco", "scipy", "matplotlib", "activesuit.scripts.demo"} & loaded


@pytest.mark.slow
def test_identify_auto_chooses_and_writes(capsys, tmp_path, undrawn):
    out = tmp_path / "auto"
    result = json.loads(run(capsys, "identify", ELBOW, "--method", "auto", "--json"))
    assert result["model_name"] == "jiles-atherton"
    assert "predicts data left out" in result["why"]
    assert result["certificate"]["certified"]
    assert {one["name"] for one in result["candidates"]} > {"bouc-wen", "preisach"}
    assert max(result["prediction_max_error"].values()) < 0.25
    reported = result["ensemble"]
    assert result["model_name"] in {one["name"] for one in reported["members"]}
    assert set(reported["bands"]) == set(result["prediction_max_error"])
    assert min(band["inside"] for band in reported["bands"].values()) > 0.8
    text = run(capsys, "identify", ELBOW, "--method", "auto", "--samples", 0, "--out", out)
    assert "bands of nominal 90 % over kinds of model" in text
    assert result["why"] in text
    assert {path.name for path in out.iterdir()} == FIT_FILES
    assert json.loads((out / "result.json").read_text()) == result
    model = load_suit(out / "suit.json").joints["elbow_flexion"].model
    assert model == model_from_dict(result["model"])


KINDS = "asymmetric bouc-wen hinged-stops prandtl-ishlinskii preisach dahl duhem clipped"


@pytest.mark.slow
@pytest.mark.parametrize("model", KINDS.split())
def test_any_model_goes_from_curves_to_the_closed_loop(capsys, tmp_path, model, undrawn, short):
    joint, chosen = ("shoulder", []) if model == "clipped" else ("elbow", ["--model", model])
    identified(capsys, curves_path(joint), *chosen, "--out", tmp_path)
    suit = tmp_path / "suit.json"
    (entry,) = load_suit(suit).joints.values()
    assert entry.model.name == model
    result = json.loads((tmp_path / "result.json").read_text())
    assert entry.start_torque == result["initial_torque"]
    assert model.rpartition("-")[2] in run(capsys, "list", "suits", suit)
    motion = tmp_path / "motion"
    simulated = run(capsys, "simulate", "--suit", suit, "--out", motion, "--json")
    assert json.loads(simulated)["failures"] == 0
    if model not in ("bouc-wen", "clipped"):
        return
    result = json.loads(run(capsys, "validate", suit, "--plant", suit, *FEW))
    (found,) = result["evaluations"].values()
    assert not any(score["failures"] for score in found["scores"].values())
    assert result["cells"][0]["torque"]["joints"][f"{joint}_flexion"]["nrmse"]["high"] < 0.01


def test_samples_show_how_sure_the_parameters_are(capsys, tmp_path, undrawn):
    arguments = ["identify", ELBOW, "--samples", "3", "--out", tmp_path]
    text = run(capsys, *arguments)
    result = json.loads(run(capsys, *arguments, "--json", "--force"))["uncertainty"]
    assert result["names"] == ["Ms", "a", "alpha", "c", "k"]
    assert f"{result['values'][0]:.5g}" in text
    (entry,) = load_suit(tmp_path / "suit.json").joints.values()
    assert [sample.to_dict() for sample in entry.samples] == result["samples"]
    assert len({sample.Ms for sample in entry.samples}) == 3


def test_options_reach_the_fit(capsys, tmp_path, undrawn):
    options = ["--method", "pso", "--trials", 2, "--objective", "robust", "--json"]
    options += ["--normalize", "curve", "--initial-torque", "identified", "--out", tmp_path]
    result = json.loads(identified(capsys, ELBOW, *options))
    search = Search("pso", trials=2, objective="robust", normalize="curve")
    expected = fit_curves(load_curves(ELBOW), method=search, initial_torque="identified")
    assert result["initial_torque"] == expected.initial_torque
    assert result["model"] == expected.model.to_dict()
    assert len((tmp_path / "trials.csv").read_text().splitlines()) == 3
    result = json.loads(run(capsys, "identify", ELBOW, "--initial-torque", "0.1", "--json"))
    assert result["initial_torque"] == 0.1
