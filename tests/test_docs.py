"""The documentation: its examples run, its links lead somewhere, and the site builds."""

import re
import shlex
import shutil
from importlib import import_module
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path

import matplotlib.pyplot as plt
import pytest
from activesuit.scripts.main import command_of, function_of
from activesuit.scripts.options import parsed
from activesuit.tools import tutorials
from helpers import shorten_tasks

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
PAGES = sorted(path.name for path in DOCS.glob("*.md"))
TUTORIALS = sorted(f"tutorials/{path.name}" for path in (DOCS / "tutorials").glob("*.md"))
NUMBERS = sorted(path.relative_to(DOCS).as_posix() for path in (DOCS / "numbers").glob("**/*.md"))
FIGURES = DOCS / "figures"
NEEDS_MUSCLES = re.compile("activesuit.envs.muscles|myo_sim")  # code that needs that extra
NUMBER = re.compile(r" *-?\d+\.?\d*")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder to run examples in, with the files that they read, and motions of 1 s."""
    shutil.copy(FIGURES / "arm.xml", tmp_path)
    shorten_tasks(monkeypatch, 1.0)
    monkeypatch.chdir(tmp_path)
    plt.switch_backend("agg")
    with plt.rc_context():
        yield tmp_path
    plt.close("all")


def page(name):
    return (DOCS / name).read_text(encoding="utf-8")


def examples(name):
    """The Python blocks of a page that can run, with two trials or updates, on coarser curves."""
    page_with_few = re.sub("^TRIALS = 30 ", "TRIALS = 2 ", page(name), flags=re.MULTILINE)
    page_with_few = page_with_few.replace("angle_step=0.01)", "angle_step=0.02)")
    found = re.findall(r"^```python\n(.*?)^```$", page_with_few, re.DOTALL | re.MULTILINE)
    has_muscles = find_spec("myo_sim") is not None
    return [block for block in found if has_muscles or not NEEDS_MUSCLES.search(block)]


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in PAGES + NUMBERS if examples(name)])
def test_examples_of_a_page_run_in_order(name, folder):
    if name == "gpu.md":
        pytest.importorskip("mujoco_warp", reason="needs the extra gpu: make test-all")
    names = {"__name__": "__main__"}
    for number, block in enumerate(examples(name)):
        exec(compile(block, f"{name}, example {number}", "exec"), names)


@pytest.mark.slow
def test_examples_of_the_readme_print_what_stands_below_them(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    found = r"^```python\n(.*?)^```\n```text\n(.*?)^```$"
    blocks = re.findall(found, text, re.DOTALL | re.MULTILINE)
    assert len(blocks) == text.count("```python") == 4
    for code, shown in blocks:
        if "stable_baselines3" in code:
            pytest.importorskip("stable_baselines3")
        exec(compile(code, "README", "exec"), {"__name__": "__main__"})
        printed = capsys.readouterr().out
        assert NUMBER.sub("#", printed) == NUMBER.sub("#", shown)
        near = 0.5 if "PPO" in code else 0.02  # a short training differs from machine to machine
        pairs = zip(NUMBER.findall(printed), NUMBER.findall(shown), strict=True)
        assert all(abs(float(one) - float(other)) <= near for one, other in pairs)


@pytest.mark.slow
def test_the_learner_in_mujoco_warp_runs(folder, capsys):
    pytest.importorskip("mujoco_warp", reason="needs the extra gpu: make test-all")
    pytest.importorskip("torch")
    program = (DOCS / "learners" / "with_warp.py").read_text(encoding="utf-8")
    for usual, few in (("(4096, 150)", "(8, 2)"), ("(64, 50)", "(8, 2)"), ("5, 4.0", "5, 1.2")):
        assert usual in program
        program = program.replace(usual, few)
    exec(compile(program, "with_warp.py", "exec"), {"__name__": "__main__"})
    assert re.search(r"effort with motors off \d", capsys.readouterr().out)


def test_programs_stand_on_their_pages():
    assert (FIGURES / "three_joints.py").read_text(encoding="utf-8") == examples("robot.md")[0]
    control = (DOCS / "device" / "control.c").read_text(encoding="ascii")
    assert f"```c\n{control}```" in page("device.md")


@pytest.mark.slow
def test_ppo_is_short_and_runs(folder, capsys):
    pytest.importorskip("torch")
    program = (DOCS / "learners" / "ppo.py").read_text(encoding="utf-8")
    assert len(program.splitlines()) <= 100
    assert "PERIODS = 245, 64, 64" in program
    few = program.replace("PERIODS = 245, 64, 64", "PERIODS = 2, 8, 64")
    exec(compile(few, "ppo.py", "exec"), {"__name__": "__main__"})
    assert re.search(r"steps: mean reward \d", capsys.readouterr().out)
    assert (folder / "my-ppo" / "policy.json").exists()


def command_lines(text):
    """The commands of this package in the shell blocks of a page, without what follows a #."""
    shell = "\n".join(re.findall(r"^```bash\n(.*?)^```$", text, re.DOTALL | re.MULTILINE))
    lines = re.findall("^activesuit .+", shell.replace("\\\n", " "), re.MULTILINE)
    return [shlex.split(line, comments=True)[1:] for line in lines]


LINES = [line for name in PAGES + TUTORIALS for line in command_lines(page(name))]


@pytest.mark.parametrize("line", LINES, ids=" ".join)
def test_a_command_line_has_options_that_there_are(line):
    name, arguments = command_of(line)
    parsed(function_of(name), f"activesuit {name}", arguments)


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_tutorials_print_what_their_pages_show():
    pytest.importorskip("sb3_contrib")
    tutorials.write(check=True)


def test_all_pages_are_in_the_navigation():
    navigation = re.findall(r"^ +- [^:]+: (\S+\.md)$", (ROOT / "mkdocs.yml").read_text(), re.M)
    others = [name for name in NUMBERS if "/examples/" not in name]  # which a hook adds
    assert sorted(navigation) == sorted(PAGES + TUTORIALS + others)


@pytest.mark.parametrize("name", PAGES + TUTORIALS + NUMBERS)
def test_links_to_files_exist(name):
    for target in re.findall(r"\]\((?!https?:|#)([^)#]+)", page(name)):
        assert (DOCS / name).parent.joinpath(target).exists(), target


def test_every_tutorial_leads_to_the_next():
    for name, following in pairwise(TUTORIALS):
        assert f"]({Path(following).name})**" in page(name).rpartition("\n## ")[2], name


MODULES = [
    *("hysteresis", "hysteresis.engine", "identification", "assets", "envs", "envs.model"),
    *("envs.person", "envs.policies", "envs.evaluation", "envs.benchmark", "envs.muscles"),
]
LOADED = re.compile(r'<(?:script|link|img|iframe)[^>]*?(?:src|href)="(https?://[^"]+)"')


@pytest.mark.slow  # as `make docs` does in CI
def test_site_builds_without_a_warning_and_loads_nothing_from_a_network(tmp_path):
    commands = pytest.importorskip("mkdocs.commands.build")
    from mkdocs.config import load_config

    config = load_config(str(ROOT / "mkdocs.yml"), site_dir=str(tmp_path), strict=True)
    config.plugins.on_startup(command="build", dirty=False)
    commands.build(config)
    built = {path.relative_to(tmp_path).as_posix(): path for path in tmp_path.rglob("*.html")}
    assert built.keys() >= {name.replace(".md", ".html") for name in PAGES + TUTORIALS + NUMBERS}
    for name, path in built.items():
        text = path.read_text(encoding="utf-8")
        assert LOADED.findall(text) == [], name
        assert "arithmatex" not in text, name
    assert "--sensing.rate-cutoff" in built["commands.html"].read_text(encoding="utf-8")
    api = built["api.html"].read_text(encoding="utf-8")
    for module in MODULES:
        names = import_module(f"activesuit.{module}").__all__
        assert [name for name in names if not re.search(rf"\b{name}\b", api)] == [], module
    for drawing in (tmp_path / "tutorials/figures").glob("*.svg"):
        loaded = re.findall(r'(?:href|src)="([^#"][^"]*)"', drawing.read_text(encoding="utf-8"))
        assert loaded == [], drawing.name
