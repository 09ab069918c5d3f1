"""`activesuit benchmark`."""

import json
import shutil
import sys
from types import ModuleType

import pytest
from activesuit.envs.benchmark import leaderboard, run_trial
from activesuit.envs.evaluation.run import FIRST_DRAWN
from activesuit.scripts.commands import benchmark as command
from activesuit.scripts.main import main
from helpers import BENCHMARK, fails, panels_of, run, short_benchmark

SMALL = [*BENCHMARK, "--policies", "none", "compensation"]
FILES = ("results.jsonl", "tables.md")


@pytest.fixture(scope="module", autouse=True)
def short():
    with short_benchmark(2.0):
        yield


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole") / "run"
    main([*SMALL, "--out", str(folder)])
    return folder


@pytest.mark.slow
def test_an_interrupted_run_goes_on_to_the_same_bytes(capsys, tmp_path, whole, monkeypatch):
    folder, count = tmp_path / "run", 0

    def killed(*arguments):
        nonlocal count
        count += 1
        if count == 3:
            raise KeyboardInterrupt
        return run_trial(*arguments)

    monkeypatch.setattr(command, "run_trial", killed)
    assert "the finished trials (2 of 5) are kept" in fails(capsys, *SMALL, "--out", folder)
    monkeypatch.setattr(command, "run_trial", run_trial)
    run(capsys, *SMALL, "--out", folder)
    for name in FILES:
        assert (folder / name).read_bytes() == (whole / name).read_bytes()


def test_the_page_has_profiles_and_who_is_better(whole):
    page = (whole / "report.html").read_text()
    assert "nominal: compensation has the most relief" in page
    (profiles,) = panels_of(whole)
    assert {one["name"] for one in profiles["data"]} == {"none", "compensation", "best-known-plan"}


def test_a_damaged_trial_is_named(capsys, tmp_path, whole):
    folder = tmp_path / "run"
    shutil.copytree(whole, folder)
    first, second = sorted((folder / "trials").glob("*.json"))[:2]
    damages = {"": "is not complete JSON", "{}": "is no result of the benchmark"}
    for content, message in (damages | {second.read_text(): "another trial"}).items():
        first.write_text(content)
        reported = fails(capsys, *SMALL, "--out", folder)
        assert message in reported and "delete it" in reported


@pytest.mark.slow
def test_a_policy_of_the_working_folder(capsys, tmp_path, monkeypatch):
    (tmp_path / "my_policies.py").write_text(
        "class Fails:\n"
        "    def __init__(self, arms, *, gain: float = 1.0):\n"
        "        pass\n"
        "    def reset(self):\n"
        "        pass\n"
        "    def act(self, observation):\n"
        "        return 1 / 0\n"
    )
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.delitem(sys.modules, "my_policies", raising=False)
    mine = ["my_policies:Fails:gain=2" if one == "compensation" else one for one in SMALL]
    out = run(capsys, *mine, "--out", tmp_path / "run")
    assert "my_policies:Fails:gain=2.0 failed in ElbowFlexion at nominal" in out
    assert "ZeroDivisionError" in out
    # Its motions are drawn when the folder is begun, and stay.
    config = json.loads((tmp_path / "run" / "config.json").read_text())
    assert config["first_seed"] >= FIRST_DRAWN
    assert f"because of the seeds from {config['first_seed']} these results" in out
    assert run(capsys, *mine, "--out", tmp_path / "run") == out


CANNOT = {"compensation:load=99": "the believed load is 99", "corrected": "cuffs"}


@pytest.mark.parametrize(("policy", "message"), CANNOT.items())
def test_what_cannot_act_is_refused_before_anything_runs(capsys, tmp_path, policy, message):
    wrong = [policy if one == "compensation" else one for one in SMALL]
    assert message in fails(capsys, *wrong, "--out", tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_it_prints_standings(capsys, whole):
    out = run(capsys, "benchmark", "table", whole)
    assert "nominal: all tasks" in out
    assert "compensation" in out
    found = json.loads(run(capsys, "benchmark", "table", whole, "--json"))["trials"]
    assert [one["policy"] for one in found][:2] == ["unsuited", "suited"]


@pytest.mark.slow
def test_results_of_several_people_merge(capsys, tmp_path, whole):
    other = tmp_path / "other"
    changed = ["gravity" if one == "compensation" else one for one in SMALL if one != "none"]
    run(capsys, *changed, "--out", other)
    out = run(capsys, "benchmark", "table", whole, other, "--out", tmp_path / "both")
    assert "gravity" in out
    assert "compensation" in out
    assert (tmp_path / "both" / "profiles.png").stat().st_size > 10_000
    assert "| gravity |" in (tmp_path / "both" / "tables.md").read_text()


def test_names_have_no_markup_in_tables(capsys, tmp_path, whole):
    name = "a|b # pwned <script>alert(1)</script> ![x](http://evil/x.png) `c`"
    text = (whole / "results.jsonl").read_text().replace('"none"', json.dumps(name))
    (tmp_path / "forged.jsonl").write_text(text)
    run(capsys, "benchmark", "table", tmp_path / "forged.jsonl", "--out", tmp_path / "page")
    page = (tmp_path / "page" / "tables.md").read_text()
    assert "pwned" in page
    assert "<script>" not in page
    assert "[x](" not in page
    tables = [part.split("\n") for part in page.split("\n\n") if part.startswith("|")]
    assert tables
    assert all(row.count("|") == table[0].count("|") for table in tables for row in table)


def test_two_policies_are_compared_motion_by_motion(capsys, whole):
    assert "compare needs two policies" in fails(capsys, "benchmark", "compare", whole)
    message = fails(capsys, "benchmark", "compare", whole, "--policies", "none", "mine")
    assert "unknown policy in these results 'mine'" in message
    out = run(capsys, "benchmark", "compare", whole, "--policies", "none", "compensation")
    assert "relief of compensation less that of none" in out


def test_another_benchmark_in_the_folder(capsys, whole):
    changed = ["randomized" if one == "nominal" else one for one in SMALL]
    assert "holds a benchmark whose" in fails(capsys, *changed, "--out", whole)


def test_results_of_a_contract_that_no_suite_has(capsys, tmp_path, whole):
    text = (whole / "results.jsonl").read_text()
    forged = tmp_path / "forged.jsonl"
    contract = json.loads(text.splitlines()[0])["protocol"]["contract"]
    forged.write_text(text.replace(contract, "0" * 12))
    said = run(capsys, "benchmark", "table", forged)
    assert "note: because of other tasks, levels, suits or wearers in their version these" in said
    assert "their contract is '000000000000' (docs/benchmark.md#contract)" in said
    own = text.replace(contract, "0" * 12).replace("emu-like", "mine.json")
    forged.write_text(own.replace('"suite_version": 3', '"suite_version": 2'))
    said = run(capsys, "benchmark", "table", forged)
    assert "because of the suit mine.json and version 2 of the suites these" in said


def test_sensors_of_a_class_of_your_own(monkeypatch):
    mine = ModuleType("my_sensors")
    mine.PD = type("PD", (), {"sensors": ("encoders", "preview")})
    mine.Odd = type("Odd", (), {"sensors": 5})
    monkeypatch.setitem(sys.modules, "my_sensors", mine)
    cases = {"PD:gain=2": "encoders, preview", "PD": "encoders, preview", "Odd": "-", "None": "-"}
    assert {name: leaderboard._sensors(f"my_sensors:{name}") for name in cases} == cases
    assert leaderboard._sensors("never_imported:PD") == "-"
    assert "never_imported" not in sys.modules
